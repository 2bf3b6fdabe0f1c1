# SPDX-License-Identifier: Apache-2.0
"""The material of what has none: displayColor and displayOpacity, in every interpolation."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from pxr import Usd, UsdGeom

from irt_usd.images.color import Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.color import StageColors
from irt_usd.stage.graph import DEFAULTS, Node, Surface, TextureReference
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.values import Value, finite, same_bits

DEFAULT_MATERIAL = "irt:default"
"""Name of UsdPreviewSurface's defaults: no binding, no displayColor. Not a prim path."""

_INPUTS = {"displayColor": "diffuseColor", "displayOpacity": "opacity"}
DISPLAY_PRIMVARS = frozenset(_INPUTS)

INSTANCE_COLOR = "irt:displayColor"
"""Name of a point instancer's displayColor, taken to the rendering space."""


def default_material() -> MaterialState:
    """UsdPreviewSurface with nothing authored: grey, 0.18."""
    return MaterialState(DEFAULT_MATERIAL, DEFAULTS, Surface())


class DisplayColorSource:
    """Reads the display primvars of one prim, its own or inherited, into a material of its own.

    Constant ones, and those of a single value, are the material's constants; the shape reads the
    others, as it reads any primvar. Of a prim in a prototype, what it lacks comes from its
    instance, where that may be `given` there.
    """

    def __init__(
        self,
        prim: Usd.Prim,
        report: Report,
        colors: StageColors,
        given: frozenset[str] = frozenset(),
    ) -> None:
        self.path = f"{prim.GetPath()}.primvars:displayColor"
        self._report = report
        api = UsdGeom.PrimvarsAPI(prim)
        found = {name: api.FindPrimvarWithInheritance(name) for name in _INPUTS}
        authored = {n: p for n, p in found.items() if p and p.HasAuthoredValue()}
        self._links = {n: n for n, p in authored.items() if _varies_over_surface(p)}
        self._constant = {n: p for n, p in authored.items() if n not in self._links}
        for name in given - authored.keys():
            self._links[name] = INSTANCE_COLOR if name == "displayColor" else name
        self.primvars = frozenset(self._links.values())
        """Names of the primvars that the shape, or its instance, has to have."""
        color = authored.get("displayColor")
        self._conversion = colors.to_rendering(color.GetAttr()) if color else None
        self._state: MaterialState | None = None
        self.varies = any(p.ValueMightBeTimeVarying() for p in self._constant.values())
        """Whether the material can differ between frames."""

    def textures(self) -> Mapping[TextureReference, str]:
        """None."""
        return MappingProxyType({})

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        if self._state is not None and not self.varies:
            return self._state
        values = {
            _INPUTS[name]: self._value(primvar, DEFAULTS[_INPUTS[name]], time)
            for name, primvar in self._constant.items()
        }
        links = {
            _INPUTS[name]: f"<{self.path.split('.')[0]}.primvars:{name}>" for name in self._links
        }
        attributes: dict[str, Value] = {**DEFAULTS, **values, **links}
        if self._state is None or not all(
            same_bits(attributes[name], self._state.attributes[name]) for name in attributes
        ):
            self._state = MaterialState(self.path, attributes, self._surface(values))
        return self._state

    def _surface(self, values: Mapping[str, Value]) -> Surface:
        constants = dict(values)
        color = constants.get("diffuseColor")
        if self._conversion is not None and isinstance(color, tuple):
            constants["diffuseColor"] = self._conversion.color(color)
        nodes: list[Node] = []
        connected = {}
        if "displayColor" in self._links:
            nodes.append(self._primvar("displayColor"))
            nodes += _converted(self._conversion)
            connected["diffuseColor"] = (len(nodes) - 1, "rgb")
        if "displayOpacity" in self._links:
            nodes.append(self._primvar("displayOpacity"))
            connected["opacity"] = (len(nodes) - 1, "r")
        return Surface(constants, tuple(nodes), connected)

    def _primvar(self, name: str) -> Node:
        default = DEFAULTS[_INPUTS[name]]
        assert isinstance(default, (float, tuple))
        return Node("primvar", (-1,), (default,), primvar=self._links[name])

    def _value(self, primvar: UsdGeom.Primvar, default: Value, time: Usd.TimeCode) -> Value:
        authored = primvar.ComputeFlattened(time)
        if authored is None:
            return default
        array = np.asarray(authored)
        shape = (3,) if isinstance(default, tuple) else ()
        prim, name = primvar.GetAttr().GetPrim(), str(primvar.GetAttr().GetName())
        if array.ndim == len(shape):
            array = array[np.newaxis]
        if array.dtype.kind != "f" or array.shape[1:] != shape:
            self._report.skipped(f"{name} is of the wrong type", where(prim, name, time))
            return default
        if len(array) == 0:
            return default
        value: Value = tuple(array[0].tolist()) if shape else float(array[0])
        opaque = float("inf") if shape else 1.0
        if not finite(value) or np.min(array[0]) < 0 or np.max(array[0]) > opaque:
            message = f"{name} is {value}; expected finite numbers from 0"
            self._report.skipped(f"{message}; its default is rendered", where(prim, name, time))
            return default
        return value


def given_by_instancers(stage: Usd.Stage) -> frozenset[str]:
    """Which of the display primvars some point instancer of `stage` has for its instances."""
    ranges = [
        Usd.PrimRange.AllPrims(root) for root in (stage.GetPseudoRoot(), *stage.GetPrototypes())
    ]
    instancers = [p for prims in ranges for p in prims if p.GetTypeName() == "PointInstancer"]
    apis = [UsdGeom.PrimvarsAPI(prim) for prim in instancers]
    found = ((name, api.FindPrimvarWithInheritance(name)) for api in apis for name in _INPUTS)
    return frozenset(name for name, primvar in found if primvar and primvar.HasAuthoredValue())


def _varies_over_surface(primvar: UsdGeom.Primvar) -> bool:
    """Whether it is not constant, and has several values at some time."""
    if primvar.GetInterpolation() == UsdGeom.Tokens.constant:
        return False
    times = [Usd.TimeCode.EarliestTime(), *map(Usd.TimeCode, primvar.GetTimeSamples())]
    return any(len(primvar.ComputeFlattened(time) or ()) > 1 for time in times)


def _converted(conversion: Conversion | None) -> list[Node]:
    """Nodes that take the colour of the node 0 to the rendering space."""
    if conversion is None or conversion.matrix is None:
        return []
    rows = [Node("dot", (0, -1), (0.0, tuple(row))) for row in conversion.matrix.tolist()]
    return [*rows, Node("combine", (1, 2, 3, -1), (0.0, 0.0, 0.0, 1.0))]
