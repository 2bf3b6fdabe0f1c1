# SPDX-License-Identifier: Apache-2.0
"""UsdLux's lights as delta lights.

Emitted radiance is L = intensity * 2^exposure * colour (* the colour temperature's). A distant
light of angular diameter 2θ gives a surface that faces it the irradiance L π sin²θ (of its nearer
half sphere at most). An area light is a point at its centre that sends what the whole light sends
far away: radiant intensity L π r² all around for a sphere, L area cos(angle to -z) for a rectangle
or a disk, 2 L radius length sin(angle to x) for a cylinder, whose ends do not shine. With
`normalize`, L is first divided by UsdLux's sizeFactor: the area, or for a distant light the
irradiance over L, up to 180°. A distant light of angle 0 has the sizeFactor 1 either way: its
irradiance is L. Sizes are world-space sizes, and levels are independent of metersPerUnit, as in
UsdLux. `treatAsPoint` changes nothing: all area lights are points here.

A dome is what rays see that meet nothing, and lights by distant lights from a fixed set of
directions, spread evenly over the sphere, which share its irradiance. A picture on a rectangle
scales its power by its mean, for the delta light carries all of it.
"""

from collections.abc import Iterable
from math import isfinite, pi
from typing import Any

from pxr import Gf, Usd, UsdLux, UsdShade

from irt_usd.images.color import Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.color import StageColors
from irt_usd.stage.dome import FORMATS, Sky, picture_axes, up_axis
from irt_usd.stage.graph import AUTO_COLOR, TextureReference, TextureSource
from irt_usd.stage.ies import IesError, Web, read_ies
from irt_usd.stage.light_links import unlinked
from irt_usd.stage.light_shape import SIZES, area_factor, directions, distant_factor, unit
from irt_usd.stage.parameters import Parameter
from irt_usd.stage.snapshot import CameraState, LightState, Vector
from irt_usd.stage.transforms import Node, transform_blame
from irt_usd.stage.values import Value, finite, matrix_array, plain

DOMES = frozenset(("DomeLight", "DomeLight_1"))

MESH = "Mesh"

KINDS = frozenset(SIZES) - {MESH}
"""The prim types that are rendered, besides meshes that are lights."""

_EMISSION = (
    "inputs:intensity",
    "inputs:exposure",
    "inputs:color",
    "inputs:enableColorTemperature",
    "inputs:colorTemperature",
    "inputs:normalize",
)

_SHAPING: dict[str, Value] = {
    "inputs:shaping:focus": 0.0,
    "inputs:shaping:focusTint": (0.0, 0.0, 0.0),
    "inputs:shaping:cone:angle": None,
    "inputs:shaping:cone:softness": 0.0,
    "inputs:shaping:ies:angleScale": 0.0,
    "inputs:shaping:ies:normalize": False,
}
"""What is shaped by nothing."""

_MODIFIERS: dict[str, Value] = {
    "inputs:diffuse": 1.0,
    "inputs:specular": 1.0,
    "inputs:shadow:enable": True,
    "inputs:shadow:color": (0.0, 0.0, 0.0),
    "inputs:shadow:distance": -1.0,
    "inputs:shadow:falloff": -1.0,
    "inputs:shadow:falloffGamma": 1.0,
    **_SHAPING,
}
"""Attributes beside its energy and size, and what changes nothing."""

_NAMES = {
    "diffuse": "inputs:diffuse",
    "specular": "inputs:specular",
    "shadow_color": "inputs:shadow:color",
    "shadow_distance": "inputs:shadow:distance",
    "shadow_falloff": "inputs:shadow:falloff",
    "shadow_falloff_gamma": "inputs:shadow:falloffGamma",
    "focus": "inputs:shaping:focus",
    "focus_tint": "inputs:shaping:focusTint",
    "cone_softness": "inputs:shaping:cone:softness",
}
"""The core's names of those that are handed on as they are."""

_AT_LEAST_0 = frozenset(("inputs:diffuse", "inputs:specular", "inputs:shadow:falloffGamma"))

_TEXTURE = "inputs:texture:file"
_PROFILE = "inputs:shaping:ies:file"

ENERGY_ATTRIBUTES = frozenset(
    (*_EMISSION, _TEXTURE, *(n for sizes in SIZES.values() for n in sizes))
)
"""Attributes that a light's energy is made of, and nothing else is."""

DOME_SAMPLES = 32
"""Directions that a dome lights from."""

CAMERA_LIGHT = "irt:cameraLight"
"""Name of the light at the camera. Not a prim path."""


class LightSource:
    """Reads one light."""

    def __init__(
        self,
        prim: Usd.Prim,
        node: Node,
        report: Report,
        colors: StageColors,
        textures: TextureSource,
        dome_samples: int = DOME_SAMPLES,
    ) -> None:
        self.node = node
        self._dome_samples = dome_samples
        self._textures = textures
        self._linking: dict[str, Any] = {}
        self.camera_visible = True
        """Whether the camera sees a dome in the render pass."""
        self._prim = prim
        self._report = report
        self._kind = str(prim.GetTypeName())
        self._colors = colors
        self._from_color = colors.to_rendering(prim.GetAttribute("inputs:color"))
        self._sizes = SIZES[self._kind]
        self._names = (*_EMISSION, *self._sizes, *_MODIFIERS)
        # What a mesh has of a light comes from API schemas, which are no prim types.
        schema = "SphereLight" if self._kind == MESH else None
        self._attributes = Attributes(prim, self._names, report, node.in_clips, schema)
        self._files = {
            name: Parameter(name, prim.GetAttribute(name), "", report)
            for name in (_TEXTURE, _PROFILE)
            if prim.GetAttribute(name).HasAuthoredValue() and self._uses(name)
        }
        self._paths: dict[str, Value] = {}
        self._state: LightState | None = None
        self._first = True
        self._world = b""
        self._report_unsupported()

    def link(self, objects: Iterable[str]) -> None:
        """Finds out which of `objects`, by path, the light does not light or cast shadows of."""
        unlit, shadowless = unlinked(self._prim, objects)
        self._set_linking(unlit, shadowless)

    def _set_linking(self, unlit: set[str], shadowless: set[str]) -> None:
        named = {"unlit": unlit, "shadowless": shadowless}
        self._linking = {key: tuple(sorted(paths)) for key, paths in named.items() if paths}

    def textures(self) -> dict[TextureReference, str]:
        """The images that it can show, and the attribute that names each, in its file."""
        if _TEXTURE not in self._files:
            return {}
        parameter = self._files[_TEXTURE]
        return {
            self._reference(str(file)): parameter.location(time)
            for file, time in parameter.all_values().items()
            if file
        }

    def profiles(self) -> dict[str, str]:
        """The IES files that it can be shaped by, and the attribute that names each."""
        if _PROFILE not in self._files:
            return {}
        parameter = self._files[_PROFILE]
        return {
            str(file): parameter.location(time)
            for file, time in parameter.all_values().items()
            if file
        }

    @property
    def varies(self) -> bool:
        """Whether the light, its place or its visibility can differ between frames."""
        files = any(parameter.varies for parameter in self._files.values())
        return files or self._attributes.vary or self.node.moves or self.node.visibility_varies

    def read(self, time: Usd.TimeCode) -> LightState | None:
        """The light at `time`, seen or not: the same object while nothing changes.

        None, and reported, if it cannot be rendered.
        """
        changed = self._attributes.update(time) or self._first
        for name, parameter in self._files.items():
            if self._first or parameter.varies:
                path = parameter.read(time)
                changed = changed or path != self._paths[name]
                self._paths[name] = path
        world = bytes(self.node.world)
        if changed or world != self._world:
            self._first = False
            self._world = world
            self._state = self._build(time)
        return self._state

    def _uses(self, name: str) -> bool:
        """Whether the light reads a file that `name` says."""
        if name == _PROFILE:
            return self._kind != "DistantLight" and self._kind not in DOMES
        if self._kind in DOMES:
            form = self._prim.GetAttribute("inputs:texture:format").Get()
            if form not in FORMATS:
                self._report.unsupported(
                    f"domes with texture:format {form} (rendered without their texture)",
                    self.node.path,
                )
            return form in FORMATS
        return self._kind == "RectLight"

    def _reference(self, file: str) -> TextureReference:
        space = self._colors.space_of(self._prim.GetAttribute(_TEXTURE)) or AUTO_COLOR
        return TextureReference(file, space, UsdShade.UdimUtils.IsUdimIdentifier(file))

    def _picture(self) -> TextureReference | None:
        """The image on the light at present; None: it has none, or none that can be had."""
        file = self._paths.get(_TEXTURE)
        reference = self._reference(str(file)) if file else None
        usable = reference is not None and self._textures.picture(reference) is not None
        return reference if usable else None

    def _build(self, time: Usd.TimeCode) -> LightState | None:
        if not self._check(time):
            return None
        values = self._attributes.values
        world = matrix_array(self.node.world)
        if not finite(world):
            message = "the transform holds a NaN or an infinity; expected finite numbers"
            self._report.skipped(*transform_blame(self.node, message, time))
            return None
        attributes: dict[str, Value] = {
            **{name: value for name, value in values.items() if value is not None},
            **self._paths,
            "typeName": self._kind,
            "world_from_object": world,
        }
        shadows = values["inputs:shadow:enable"] is not False
        attributes["inputs:shadow:enable"] = shadows
        shaped = self._modifiers()
        if self._kind in DOMES:
            return self._dome(attributes, shadows, shaped, time)
        axis = unit((-world[2, 0], -world[2, 1], -world[2, 2]))
        turned = self._kind not in ("SphereLight", MESH) or self._is_shaped()
        if axis is None and turned:
            message = "the transform leaves the light no direction; expected a z axis"
            self._report.skipped(*transform_blame(self.node, message, time))
            return None
        if self._kind == "DistantLight":
            assert axis is not None
            energy = self._energy(distant_factor(values), time)
            if energy is None:
                return None
            return LightState(self.node.path, "distant", attributes, axis, energy, shadows, shaped)
        if axis is not None and turned:
            shaped = {**directions(self._kind, world, axis), **shaped}
        return self._area_light(attributes, shadows, shaped, time)

    def _area_light(
        self,
        attributes: dict[str, Value],
        shadows: bool,
        shaped: dict[str, Any],
        time: Usd.TimeCode,
    ) -> LightState | None:
        """The point light that stands for an area light."""
        m = self.node.world
        factor = area_factor(self._kind, self._attributes.values, m)
        picture = self._picture()
        tint = self._textures.mean(picture) if picture is not None else (1.0, 1.0, 1.0)
        energy = self._energy(factor, time, tint)
        if energy is None:
            return None
        x, y, z = m.ExtractTranslation()
        return LightState(self.node.path, "point", attributes, (x, y, z), energy, shadows, shaped)

    def _check(self, time: Usd.TimeCode) -> bool:
        """Whether the values can be rendered; those of modifiers that cannot give way."""
        values = self._attributes.values
        for name in self._names:
            value, is_size = values[name], name in self._sizes
            missing = value is None and name not in _MODIFIERS
            below = (is_size or name in _AT_LEAST_0) and value is not None and value < 0  # type: ignore[operator]
            if not missing and finite(value) and not below:
                continue
            wanted = "a finite number from 0" if is_size or below else "finite numbers"
            message = f"{name} is {value}; expected {wanted}"
            if name in _MODIFIERS:
                message += "; its default is rendered"
                values[name] = _MODIFIERS[name]
            self._report.skipped(message, where(self._prim, name, time))
            if name not in _MODIFIERS:
                return False
        return True

    def _dome(
        self,
        attributes: dict[str, Value],
        shadows: bool,
        shaped: dict[str, Any],
        time: Usd.TimeCode,
    ) -> LightState | None:
        radiance = self._energy(1.0, time)
        if radiance is None:
            return None
        attributes["irt:domeSamples"] = self._dome_samples
        if not self.camera_visible:
            attributes["irt:cameraVisible"] = False
        picture, sky = self._picture(), None
        if picture is not None:
            axes = picture_axes(self._prim, matrix_array(self.node.world))
            if axes is None:
                message = "the transform leaves the dome's picture no orientation"
                self._report.skipped(*transform_blame(self.node, message, time))
                return None
            sky = Sky(picture, axes, self._textures)
        return LightState(
            self.node.path,
            "dome",
            attributes,
            (0.0, 0.0, 0.0),
            radiance,
            shadows,
            shaped,
            self._dome_samples,
            self.camera_visible,
            up_axis(self._prim.GetStage()),
            sky,
        )

    def _is_shaped(self) -> bool:
        """Whether the light sends other things in other directions, its own shape apart."""
        values = self._attributes.values
        plain = all(
            values[name] is None or values[name] == default for name, default in _SHAPING.items()
        )
        return not plain or self._prim.HasAPI(UsdLux.ShapingAPI) or bool(self._paths.get(_PROFILE))

    def _modifiers(self) -> dict[str, Any]:
        """What differs from a light that sends the same all around.

        The cone is the schema's 90° where the shaping API is applied and says nothing else.
        """
        values = self._attributes.values
        shaped: dict[str, Any] = dict(self._linking)
        shapes = self._kind != "DistantLight" and self._kind not in DOMES
        for key, name in _NAMES.items():
            value = values[name]
            if value is None or value == _MODIFIERS[name] or (name in _SHAPING and not shapes):
                continue
            shaped[key] = value
        if shaped.get("shadow_distance", -1.0) < 0 or shaped.get("shadow_falloff", 0.0) <= 0:
            shaped.pop("shadow_falloff", None)
            shaped.pop("shadow_falloff_gamma", None)
        if not shapes:
            return shaped
        angle = values["inputs:shaping:cone:angle"]
        if angle is None and self._prim.HasAPI(UsdLux.ShapingAPI):
            angle = 90.0
        if angle is not None and angle < 180:  # type: ignore[operator]
            shaped["cone_angle"] = max(angle, 0.0)
        web = self._web()
        if web is not None:
            shaped["ies"] = web
        return shaped

    def _web(self) -> Web | None:
        """The light's profile; None: it has none, or, as was said before, none that can be had."""
        values = self._attributes.values
        normalize = bool(values["inputs:shaping:ies:normalize"])
        scale = float(values["inputs:shaping:ies:angleScale"] or 0.0)  # type: ignore[arg-type]
        file = self._paths.get(_PROFILE)
        try:
            return read_ies(str(file), normalize, scale) if file else None
        except IesError:
            return None

    def _energy(
        self, factor: float, time: Usd.TimeCode, tint: Vector = (1.0, 1.0, 1.0)
    ) -> Vector | None:
        """Luminance times `factor` and `tint` (of the rendering space), per channel."""
        values = self._attributes.values
        try:
            scale = values["inputs:intensity"] * 2.0 ** values["inputs:exposure"] * factor  # type: ignore[operator]
        except OverflowError:
            scale = float("inf")
        color = Gf.Vec3d(*_converted(self._from_color, values["inputs:color"]))  # type: ignore[arg-type]
        color = Gf.CompMult(color, Gf.Vec3d(*tint))
        if values["inputs:enableColorTemperature"]:
            temperature = UsdLux.BlackbodyTemperatureAsRgb(values["inputs:colorTemperature"])
            color = Gf.CompMult(color, Gf.Vec3d(*_converted(self._colors.default, temperature)))
        energy = (color[0] * scale, color[1] * scale, color[2] * scale)
        if not all(map(_single, energy)):
            message = "the light's energy exceeds single precision; lower intensity and exposure"
            self._report.skipped(message, where(self._prim, "inputs:intensity", time))
            return None
        if min(energy) < 0:
            self._report.mentioned("a light that takes light away", self.node.path)
        if factor == 0:
            message = "a light of no size gives no light unless normalized"
            self._report.mentioned(message, self.node.path)
        return energy

    def _shapes(self, name: str) -> bool:
        """Whether the shaping attribute `name` says anything that a shaped light would heed."""
        attribute = self._prim.GetAttribute(name)
        if not attribute.HasAuthoredValue():
            return False
        value = plain(attribute.Get(Usd.TimeCode.EarliestTime()))
        wide = name == "inputs:shaping:cone:angle" and isinstance(value, float) and value >= 180
        nothing = value is None or value == "" or value == _SHAPING.get(name) or wide
        return bool(attribute.ValueMightBeTimeVarying()) or not nothing

    def _report_unsupported(self) -> None:
        path = self.node.path
        authored = self._prim.GetAuthoredPropertyNames()
        for name in ENERGY_ATTRIBUTES.intersection(authored):
            if self._prim.GetAttribute(name).HasAuthoredConnections():
                self._report.unsupported("connected light inputs (own value rendered)", path)
        flat = self._kind == "DistantLight" or self._kind in DOMES
        if flat and any(map(self._shapes, (_PROFILE, *_SHAPING))):
            self._report.unsupported("shaping of distant lights and domes", path)
        if self._prim.GetRelationship("portals").HasAuthoredTargets():
            self._report.unsupported("dome portals", path)
        if "guideRadius" in authored:
            self._report.mentioned("the guideRadius of domes is a viewport's, and not read", path)
        if UsdLux.LightAPI(self._prim).GetFiltersRel().HasAuthoredTargets():
            self._report.unsupported("light filters", path)


def camera_light(camera: CameraState) -> LightState:
    """A white distant light along the view: a white Lambert surface that faces it returns 1.

    It casts no shadows: nearly all would lie hidden behind what casts them.
    """
    m = camera.world_from_camera
    direction = unit((-m[2, 0], -m[2, 1], -m[2, 2]))
    assert direction is not None, "a camera's transform is checked to be regular"
    return LightState(
        CAMERA_LIGHT,
        "distant",
        {"typeName": "DistantLight", "world_from_object": m},
        direction,
        (pi, pi, pi),
        casts_shadows=False,
    )


def _converted(conversion: Conversion | None, color: Vector) -> Vector:
    return color if conversion is None else conversion.color(color)


def _single(value: float) -> bool:
    return isfinite(value) and abs(value) <= 3.4e38
