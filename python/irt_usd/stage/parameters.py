# SPDX-License-Identifier: Apache-2.0
"""A shader's input that has a value: read at a time, checked, and where it comes from."""

from pxr import Ar, Sdf, Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.values import Value, coerced, finite, plain, same_bits

_UNBOUNDED = float("inf")
Range = tuple[float, float]
ANY: Range = (-_UNBOUNDED, _UNBOUNDED)


class Parameter:
    """An input's value, `default` where there is none.

    `attribute` is where the value is found, the input's own or one that it is connected to. Values
    of another type, numbers that are not finite and tokens that are none of `allowed` are reported
    and give way to the default; those outside `bounds` are clamped, which is mentioned.
    """

    def __init__(
        self,
        name: str,
        attribute: Usd.Attribute | None,
        default: Value,
        report: Report,
        bounds: Range = ANY,
        allowed: tuple[str, ...] = (),
    ) -> None:
        self.name = name
        self.attribute = attribute
        self._default = default
        self._report = report
        self._bounds = bounds
        self._allowed = allowed
        self._query = Usd.AttributeQuery(attribute) if attribute is not None else None
        self.varies = self._query is not None and bool(self._query.ValueMightBeTimeVarying())
        """Whether the value can differ between frames."""

    def read(self, time: Usd.TimeCode) -> Value:
        """The value at `time`; asset paths as `resolved_asset` has them."""
        authored = self._query.Get(time) if self._query is not None else None
        if authored is None:
            return self._default
        if isinstance(authored, Sdf.AssetPath):
            assert self.attribute is not None
            value: Value = resolved_asset(self.attribute, authored, time)
        else:
            value = plain(authored)
        value = coerced(value, self._default)
        if value is None or not finite(value):
            message = (
                f"{self.name} is {plain(authored)}; expected {_wanted(self._default)};"
                " its default is rendered"
            )
            self._report.skipped(message, self.location(time))
            return self._default
        if self._allowed and value not in self._allowed:
            expected = f"expected {', '.join(self._allowed)}; {self._default} is rendered"
            message = f"{self.name} is {value}; {expected}"
            self._report.skipped(message, self.location(time))
            return self._default
        bounded = _clamped(value, *self._bounds)
        if not same_bits(bounded, value):
            low, high = self._bounds
            message = f"{self.name} outside {low:g} to {high:g}, clamped"
            self._report.mentioned(message, self.location(time))
        return bounded

    def all_values(self) -> dict[Value, Usd.TimeCode]:
        """Every value that it can ever have and the first time of each, where values are held."""
        times = [Usd.TimeCode.EarliestTime()]
        if self.varies:
            assert self._query is not None
            times += map(Usd.TimeCode, self._query.GetTimeSamples())
        values: dict[Value, Usd.TimeCode] = {}
        for time in times:
            values.setdefault(self.read(time), time)
        return values

    def location(self, time: Usd.TimeCode) -> str:
        """The attribute that the value comes from, and its file."""
        assert self.attribute is not None
        return where(self.attribute.GetPrim(), self.attribute.GetName(), time)


def resolved_asset(attribute: Usd.Attribute, path: Sdf.AssetPath, time: Usd.TimeCode) -> str:
    """Where the resolver finds the asset that `attribute` names; anchored to its layer if nowhere.

    Of a set of UDIM tiles, the path still with <UDIM> in it.
    """
    if path.resolvedPath or not path.path:
        return str(path.resolvedPath)
    opinions = attribute.GetPropertyStack(time)
    layer = opinions[0].layer if opinions else attribute.GetStage().GetRootLayer()
    found = ""
    if UsdShade.UdimUtils.IsUdimIdentifier(path.path):
        with Ar.ResolverContextBinder(attribute.GetStage().GetPathResolverContext()):
            found = UsdShade.UdimUtils.ResolveUdimPath(path.path, layer)
    return str(found or layer.ComputeAbsolutePath(path.path))


def _clamped(value: Value, low: float, high: float) -> Value:
    if isinstance(value, tuple):
        return tuple(_clamped(v, low, high) for v in value)
    if isinstance(value, float) and not low <= value <= high:
        return low if value < low else high
    return value


def _wanted(default: Value) -> str:
    if isinstance(default, tuple):
        return f"{len(default)} finite numbers"
    if isinstance(default, str):
        return "a text"
    return "a finite number" if isinstance(default, float) else "an integer"
