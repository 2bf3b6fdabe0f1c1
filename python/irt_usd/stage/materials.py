# SPDX-License-Identifier: Apache-2.0
"""UsdPreviewSurface's constants, its connected inputs followed to where the constants are."""

from functools import partial

from pxr import Sdf, Tf, Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.diagnostics import attempt
from irt_usd.stage.graph import DEFAULTS, Surface
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.values import Value, coerced, finite, plain, same_bits

_UNBOUNDED = float("inf")
_LATER = frozenset(("clearcoat", "clearcoatRoughness", "normal"))

_OWN_DEFAULTS = {name: DEFAULTS[name] for name in DEFAULTS if name not in _LATER}

_RANGES: dict[str, tuple[float, float]] = {
    "diffuseColor": (0.0, _UNBOUNDED),
    "emissiveColor": (0.0, _UNBOUNDED),
    "specularColor": (0.0, _UNBOUNDED),
    "metallic": (0.0, 1.0),
    "roughness": (0.0, 1.0),
    "opacity": (0.0, 1.0),
    "opacityThreshold": (0.0, 1.0),
    "ior": (1e-3, _UNBOUNDED),
}
"""What a value is clamped to, and said to have been. Mirrors what the specification allows."""

_NOT_RENDERED: dict[str, Value] = {
    "clearcoat": 0.0,
    "displacement": 0.0,
    "normal": (0.0, 0.0, 1.0),
    "occlusion": 1.0,
    "opacityMode": "transparent",
}
"""Inputs that are reported where they are not at their defaults."""

_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3}


def preview_surface(material: UsdShade.Material, report: Report) -> UsdShade.Shader | None:
    """The UsdPreviewSurface shader of `material`; None, reported, if it has none."""
    path = str(material.GetPath())
    shader = material.ComputeSurfaceSource()[0]
    if shader:
        identifier = shader.GetIdAttr().Get()
        if identifier == "UsdPreviewSurface":
            return shader
        kind = f"surface shader {identifier or 'without an info:id'}"
        report.unsupported(f"{kind} (displayColor rendered instead)", path)
        return None
    others = [o.GetBaseName() for o in material.GetSurfaceOutputs() if o.HasConnectedSource()]
    if others:
        kind = f"materials for other renderers alone ({', '.join(sorted(others))})"
        report.unsupported(f"{kind} (displayColor rendered instead)", path)
    else:
        report.mentioned("material without a surface, displayColor rendered instead", path)
    return None


class MaterialSource:
    """Reads one material."""

    def __init__(self, path: str, shader: UsdShade.Shader, report: Report) -> None:
        self.path = path
        self._report = report
        self._inputs = {name: _Input(shader, name, report) for name in _OWN_DEFAULTS}
        self._state: MaterialState | None = None
        for name, default in _NOT_RENDERED.items():
            unused = _Input(shader, name, None)
            differs = not same_bits(unused.read(Usd.TimeCode.EarliestTime()), default)
            if unused.connected or unused.varies or (unused.authored and differs):
                report.unsupported(f"UsdPreviewSurface {name}", path)

    @property
    def varies(self) -> bool:
        """Whether any input can differ between frames."""
        return any(i.varies for i in self._inputs.values())

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        if self._state is not None and not self.varies:
            return self._state
        values: dict[str, Value] = {}
        for name, item in self._inputs.items():
            values[name] = self._checked(name, item, time)
        if self._state is None or not all(
            same_bits(values[name], self._state.attributes[name]) for name in values
        ):
            self._state = MaterialState(self.path, {**DEFAULTS, **values}, Surface(values))
        return self._state

    def _checked(self, name: str, item: "_Input", time: Usd.TimeCode) -> Value:
        authored, default = item.read(time), DEFAULTS[name]
        value = coerced(authored, default)
        if value is None or not finite(value):
            message = f"{name} is {authored}; expected {_wanted(default)}; its default is rendered"
            self._report.skipped(message, item.location(time))
            return default
        bounded = _clamped(value, *_RANGES.get(name, (-_UNBOUNDED, _UNBOUNDED)))
        if not same_bits(bounded, value):
            low, high = _RANGES[name]
            message = f"{name} outside {low:g} to {high:g}, clamped"
            self._report.mentioned(message, item.location(time))
        return bounded


class _Input:
    """One input of a shader, and the attribute that gives it its value."""

    def __init__(self, shader: UsdShade.Shader, name: str, report: Report | None) -> None:
        self._default = _NOT_RENDERED.get(name, DEFAULTS.get(name))
        self._query: Usd.AttributeQuery | None = None
        self._channel: str | None = None
        self.connected = False
        """To a shader, not to a constant."""
        self.shader_path = f"{shader.GetPath()}.inputs:{name}"
        source = shader.GetInput(name)
        if not source:
            return
        producers = UsdShade.Utils.GetValueProducingAttributes(source)
        if producers and _is_output(producers[0]):
            self.connected = True
            producers = self._behind_shader(producers[0], report)
        if producers:
            self._query = Usd.AttributeQuery(producers[0])

    @property
    def authored(self) -> bool:
        """Whether a value, its own or a connected one, is there at all."""
        return self._query is not None

    @property
    def varies(self) -> bool:
        """Whether the value can differ between frames."""
        return self._query is not None and bool(self._query.ValueMightBeTimeVarying())

    def read(self, time: Usd.TimeCode) -> Value:
        """The value at `time`, or the default."""
        value = None if self._query is None else plain(self._query.Get(time))
        if value is None:
            return self._default
        if self._channel is None or not isinstance(value, tuple):
            return value
        if self._channel == "rgb":
            return value[:3]
        channel = _CHANNELS.get(self._channel, 0)
        return value[channel] if channel < len(value) else self._default

    def location(self, time: Usd.TimeCode) -> str:
        """The attribute that the value comes from, and its file."""
        if self._query is None:
            return self.shader_path
        attribute = self._query.GetAttribute()
        return where(attribute.GetPrim(), attribute.GetName(), time)

    def _behind_shader(self, output: Usd.Attribute, report: Report | None) -> list[Usd.Attribute]:
        """What stands in for a connected shader: the `fallback` of a texture or primvar reader."""
        node = UsdShade.Shader(output.GetPrim())
        identifier = str(node.GetIdAttr().Get() if node else "") or "shader without an info:id"
        if report:
            kind = "textures" if identifier == "UsdUVTexture" else f"shader node {identifier}"
            report.unsupported(f"{kind} (fallback value rendered)", self.shader_path)
        fallback = node.GetInput("fallback") if node else None
        if not fallback:
            return []
        if identifier == "UsdUVTexture":
            self._channel = UsdShade.Utils.GetBaseNameAndType(output.GetName())[0]
        found = UsdShade.Utils.GetValueProducingAttributes(fallback)
        return [a for a in found if not _is_output(a)][:1]


def _is_output(attribute: Usd.Attribute) -> bool:
    return bool(UsdShade.Utils.GetType(attribute.GetName()) == UsdShade.AttributeType.Output)


def _clamped(value: Value, low: float, high: float) -> Value:
    if isinstance(value, tuple):
        return tuple(_clamped(v, low, high) for v in value)
    if isinstance(value, float) and not low <= value <= high:
        return low if value < low else high
    return value


def _wanted(default: Value) -> str:
    if isinstance(default, tuple):
        return f"{len(default)} finite numbers"
    return "a finite number" if isinstance(default, float) else "an integer"


def bound_materials(
    prims: list[Usd.Prim], report: Report
) -> list[tuple[Sdf.Path, UsdShade.Material | None]]:
    """For each prim the material that its binding resolves to, and its path.

    By UsdShade's rules for the full-quality purpose, inherited and collection bindings included.
    Missing ones are reported.
    """
    found = []
    try:
        materials, relationships = _compute_bound(prims)
    except Tf.ErrorException:
        one_by_one = [attempt(partial(_compute_bound, [p]), p, report) for p in prims]
        materials = [found[0][0] if found else None for found in one_by_one]
        relationships = [found[1][0] if found else None for found in one_by_one]
    for material, relationship in zip(materials, relationships, strict=True):
        if material:
            found.append((material.GetPath(), material))
            continue
        found.append((Sdf.Path.emptyPath, None))
        if relationship:
            targets = ", ".join(f"<{t}>" for t in relationship.GetTargets())
            message = "the bound material does not exist, displayColor rendered instead"
            place = where(relationship.GetPrim(), relationship.GetName(), Usd.TimeCode.Default())
            report.skipped(message, f"{targets} of {place}")
    return found


def _compute_bound(
    prims: list[Usd.Prim],
) -> tuple[list[UsdShade.Material], list[Usd.Relationship]]:
    materials, relationships = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(
        prims, UsdShade.Tokens.full
    )
    return materials, relationships
