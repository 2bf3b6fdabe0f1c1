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
directions, spread evenly over the sphere, which share its irradiance.
"""

from collections.abc import Iterable
from math import cbrt, cos, hypot, isfinite, pi, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdLux

from irt_usd.images.color import Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.color import StageColors
from irt_usd.stage.ies import IesError, read_ies
from irt_usd.stage.snapshot import CameraState, LightState, Vector
from irt_usd.stage.transforms import Node, transform_blame
from irt_usd.stage.values import Value, finite, matrix_array, same_bits

_SIZES: dict[str, tuple[str, ...]] = {
    "DistantLight": ("inputs:angle",),
    "SphereLight": ("inputs:radius",),
    "RectLight": ("inputs:width", "inputs:height"),
    "DiskLight": ("inputs:radius",),
    "CylinderLight": ("inputs:radius", "inputs:length"),
    "DomeLight": (),
    "DomeLight_1": (),
}

DOMES = frozenset(("DomeLight", "DomeLight_1"))

KINDS = frozenset(_SIZES)
"""The prim types that are rendered."""

_EMISSION = (
    "inputs:intensity",
    "inputs:exposure",
    "inputs:color",
    "inputs:enableColorTemperature",
    "inputs:colorTemperature",
    "inputs:normalize",
)

_MODIFIERS = (
    "inputs:diffuse",
    "inputs:specular",
    "inputs:shaping:focus",
    "inputs:shaping:focusTint",
    "inputs:shaping:cone:angle",
    "inputs:shaping:cone:softness",
    "inputs:shaping:ies:file",
    "inputs:shaping:ies:normalize",
    "inputs:shadow:enable",
    "inputs:shadow:color",
    "inputs:shadow:distance",
)

ENERGY_ATTRIBUTES = frozenset((*_EMISSION, *(name for sizes in _SIZES.values() for name in sizes)))
"""Attributes that a light's energy is made of, and nothing else is."""

_NOT_RENDERED: dict[str, Value] = {
    "inputs:shaping:ies:angleScale": 0.0,
    "inputs:shadow:falloff": -1.0,
    "inputs:texture:file": "",
}
"""Attributes that are reported where they are not at their defaults."""

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
        dome_samples: int = DOME_SAMPLES,
    ) -> None:
        self.node = node
        self._dome_samples = dome_samples
        self._unlit: tuple[str, ...] = ()
        self.camera_visible = True
        """Whether the camera sees a dome in the render pass."""
        self._prim = prim
        self._report = report
        self._kind = str(prim.GetTypeName())
        self._from_color = colors.to_rendering(prim.GetAttribute("inputs:color"))
        self._from_blackbody = colors.default
        self._sizes = _SIZES[self._kind]
        self._attributes = Attributes(
            prim, (*_EMISSION, *self._sizes, *_MODIFIERS), report, node.in_clips
        )
        self._state: LightState | None = None
        self._first = True
        self._world = b""
        self._report_unsupported()

    def link(self, objects: Iterable[str]) -> None:
        """Finds out which of `objects`, by path, the light does not light.

        A collection names prims, and an instance of an array is its instancer's.
        """
        collection = UsdLux.LightAPI(self._prim).GetLightLinkCollectionAPI()
        excludes = collection.GetExcludesRel().HasAuthoredTargets()
        if not excludes and collection.GetIncludeRootAttr().Get() is not False:
            return
        query = collection.ComputeMembershipQuery()
        self._unlit = tuple(
            sorted(path for path in objects if not query.IsPathIncluded(path.split("[", 1)[0]))
        )

    @property
    def varies(self) -> bool:
        """Whether the light, its place or its visibility can differ between frames."""
        return self._attributes.vary or self.node.moves or self.node.visibility_varies

    def read(self, time: Usd.TimeCode) -> LightState | None:
        """The light at `time`, seen or not: the same object while nothing changes.

        None, and reported, if it cannot be rendered.
        """
        changed = self._attributes.update(time)
        world = bytes(self.node.world)
        if changed or self._first or world != self._world:
            self._first = False
            self._world = world
            self._state = self._build(time)
        return self._state

    def _build(self, time: Usd.TimeCode) -> LightState | None:
        values = self._attributes.values
        for name in (*_EMISSION, *self._sizes, *_MODIFIERS):
            value, is_size = values[name], name in self._sizes
            missing = value is None and name not in _MODIFIERS
            if missing or not finite(value) or (is_size and value < 0):  # type: ignore[operator]
                wanted = "a finite number from 0" if is_size else "finite numbers"
                message = f"{name} is {value}; expected {wanted}"
                self._report.skipped(message, where(self._prim, name, time))
                return None
        world = matrix_array(self.node.world)
        if not finite(world):
            message = "the transform holds a NaN or an infinity; expected finite numbers"
            self._report.skipped(*transform_blame(self.node, message, time))
            return None
        attributes: dict[str, Value] = {
            **{name: value for name, value in values.items() if value is not None},
            "typeName": self._kind,
            "world_from_object": world,
        }
        shadows = values["inputs:shadow:enable"] is not False
        attributes["inputs:shadow:enable"] = shadows
        if self._kind in DOMES:
            return self._dome(attributes, shadows, time)
        axis = _unit((-world[2, 0], -world[2, 1], -world[2, 2]))
        shaped = self._modifiers(time)
        if shaped is None:
            return None
        turned = self._kind != "SphereLight" or shaped.keys() - {"unlit", "diffuse", "specular"}
        if axis is None and turned:
            message = "the transform leaves the light no direction; expected a z axis"
            self._report.skipped(*transform_blame(self.node, message, time))
            return None
        if self._kind == "DistantLight":
            assert axis is not None
            energy = self._energy(_distant_factor(values), time)
            if energy is None:
                return None
            return LightState(self.node.path, "distant", attributes, axis, energy, shadows, shaped)
        position = (float(world[3, 0]), float(world[3, 1]), float(world[3, 2]))
        energy = self._energy(_area_factor(self._kind, values, self.node.world), time)
        if energy is None:
            return None
        if axis is not None and turned:
            shaped.update(_directions(self._kind, world, axis))
        return LightState(self.node.path, "point", attributes, position, energy, shadows, shaped)

    def _dome(
        self, attributes: dict[str, Value], shadows: bool, time: Usd.TimeCode
    ) -> LightState | None:
        radiance = self._energy(1.0, time)
        if radiance is None:
            return None
        attributes["irt:domeSamples"] = self._dome_samples
        if not self.camera_visible:
            attributes["irt:cameraVisible"] = False
        shaped: dict[str, Any] = {"unlit": self._unlit} if self._unlit else {}
        for key in ("diffuse", "specular"):
            if self._attributes.values[f"inputs:{key}"] not in (None, 1.0):
                shaped[key] = self._attributes.values[f"inputs:{key}"]
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
        )

    def _modifiers(self, time: Usd.TimeCode) -> dict[str, Any] | None:
        """What differs from a light that sends the same all around; None, reported, if it cannot.

        The cone is the schema's 90° where the shaping API is applied and says nothing else.
        """
        values = self._attributes.values
        shaped: dict[str, Any] = {"unlit": self._unlit} if self._unlit else {}
        for key, name, default in (
            ("diffuse", "inputs:diffuse", 1.0),
            ("specular", "inputs:specular", 1.0),
            ("focus", "inputs:shaping:focus", 0.0),
            ("focus_tint", "inputs:shaping:focusTint", (0.0, 0.0, 0.0)),
            ("cone_softness", "inputs:shaping:cone:softness", 0.0),
            ("shadow_color", "inputs:shadow:color", (0.0, 0.0, 0.0)),
            ("shadow_distance", "inputs:shadow:distance", -1.0),
        ):
            value = values[name]
            if value is not None and value != default:
                shaped[key] = value
        if self._kind == "DistantLight":
            for key in ("focus", "focus_tint", "cone_softness"):
                shaped.pop(key, None)
            return shaped
        angle = values["inputs:shaping:cone:angle"]
        if angle is None and self._prim.HasAPI(UsdLux.ShapingAPI):
            angle = 90.0
        if angle is not None and angle < 180:  # type: ignore[operator]
            shaped["cone_angle"] = max(angle, 0.0)
        file = values["inputs:shaping:ies:file"]
        if file:
            attribute = self._prim.GetAttribute("inputs:shaping:ies:file")
            path = attribute.Get(time).resolvedPath
            try:
                web = read_ies(path or str(file), bool(values["inputs:shaping:ies:normalize"]))
            except IesError as error:
                message = f"the IES file cannot be used: {error}"
                place = where(self._prim, "inputs:shaping:ies:file", time)
                self._report.skipped(message, place)
                return None
            shaped["ies"] = web
        return shaped

    def _energy(self, factor: float, time: Usd.TimeCode) -> Vector | None:
        """Luminance times `factor`, per channel."""
        values = self._attributes.values
        try:
            scale = values["inputs:intensity"] * 2.0 ** values["inputs:exposure"] * factor  # type: ignore[operator]
        except OverflowError:
            scale = float("inf")
        color = Gf.Vec3d(*_converted(self._from_color, values["inputs:color"]))  # type: ignore[arg-type]
        if values["inputs:enableColorTemperature"]:
            temperature = UsdLux.BlackbodyTemperatureAsRgb(values["inputs:colorTemperature"])
            color = Gf.CompMult(color, Gf.Vec3d(*_converted(self._from_blackbody, temperature)))
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

    def _report_unsupported(self) -> None:
        path = self.node.path
        authored = self._prim.GetAuthoredPropertyNames()
        for name, default in _NOT_RENDERED.items():
            if name not in authored:
                continue
            attributes = Attributes(self._prim, (name,), self._report)
            attributes.update(Usd.TimeCode.EarliestTime())
            value = attributes.values[name]
            if attributes.vary or (value is not None and not same_bits(value, default)):
                self._report.unsupported(f"{name} of lights", path)
        for name in ENERGY_ATTRIBUTES.intersection(authored):
            if self._prim.GetAttribute(name).HasAuthoredConnections():
                self._report.unsupported("connected light inputs (own value rendered)", path)
        linking = UsdLux.LightAPI(self._prim)
        collection = linking.GetShadowLinkCollectionAPI()
        excludes = collection.GetExcludesRel().HasAuthoredTargets()
        if excludes or collection.GetIncludeRootAttr().Get() is False:
            self._report.unsupported("shadow linking (everything casts shadows)", path)
        if self._prim.GetRelationship("portals").HasAuthoredTargets():
            self._report.unsupported("dome portals", path)
        if linking.GetFiltersRel().HasAuthoredTargets():
            self._report.unsupported("light filters", path)


def camera_light(camera: CameraState) -> LightState:
    """A white distant light along the view: a white Lambert surface that faces it returns 1.

    It casts no shadows: nearly all would lie hidden behind what casts them.
    """
    m = camera.world_from_camera
    direction = _unit((-m[2, 0], -m[2, 1], -m[2, 2]))
    assert direction is not None, "a camera's transform is checked to be regular"
    return LightState(
        CAMERA_LIGHT,
        "distant",
        {"typeName": "DistantLight", "world_from_object": m},
        direction,
        (pi, pi, pi),
        casts_shadows=False,
    )


def _distant_factor(values: dict[str, Value]) -> float:
    """Irradiance over luminance."""
    angle = min(float(values["inputs:angle"]), 360.0)  # type: ignore[arg-type]
    if angle == 0:
        return 1.0
    half = radians(angle) / 2
    if not values["inputs:normalize"]:
        return pi * sin(half) ** 2 if angle < 180 else pi
    return 1.0 if angle <= 180 else 1 / (2 - sin(half) ** 2)


def _area_factor(kind: str, values: dict[str, Value], world: Gf.Matrix4d) -> float:
    """The greatest radiant intensity over luminance."""
    normalized = bool(values["inputs:normalize"])
    x, y, z = (world.GetRow3(row) for row in range(3))
    # Seven digits: what a rotation leaves of the last bits is no change of size.
    across = _rounded(Gf.Cross(x, y).GetLength())
    if kind == "RectLight":
        width, height = float(values["inputs:width"]), float(values["inputs:height"])  # type: ignore[arg-type]
        return 1.0 if normalized else width * height * across
    radius = float(values["inputs:radius"])  # type: ignore[arg-type]
    if kind == "DiskLight":
        return 1.0 if normalized else pi * radius**2 * across
    if kind == "CylinderLight":
        if normalized:
            return 1 / pi
        length = float(values["inputs:length"])  # type: ignore[arg-type]
        thick = (y.GetLength() * z.GetLength()) ** 0.5
        return 2 * radius * length * _rounded(x.GetLength() * thick)
    if normalized:
        return 0.25
    return pi * (radius * _rounded(cbrt(abs(world.GetDeterminant3())))) ** 2


def _rounded(scale: float) -> float:
    return float(f"{scale:.7g}")


def _directions(kind: str, world: NDArray[np.float64], axis: Vector) -> dict[str, Any]:
    """Profile, axis and side of a point light that stands for a light of `kind`."""
    x, y = world[0, :3], world[1, :3]
    normal = np.cross(x, y)
    if kind in ("RectLight", "DiskLight"):
        facing = _unit(tuple(normal if np.dot(normal, axis) > 0 else -normal))
        axis = facing or axis
    along = _unit(tuple(x)) if kind == "CylinderLight" else None
    if along is None:
        crosswise = x - np.dot(x, axis) * np.asarray(axis)
        along = _unit(tuple(crosswise)) or _unit(tuple(np.cross(axis, (0.0, 1.0, 0.0))))
    profile = {"RectLight": "facing", "DiskLight": "facing", "CylinderLight": "round"}
    return {
        "profile": profile.get(kind, "uniform"),
        "axis": axis,
        "side": along or (1.0, 0.0, 0.0),
    }


def dome_directions(count: int) -> list[Vector]:
    """Unit directions in which light travels, spread evenly over the sphere (Fibonacci's)."""
    golden = pi * (3 - 5**0.5)
    directions = []
    for i in range(count):
        z = 1 - (2 * i + 1) / count
        r = (1 - z * z) ** 0.5
        directions.append((r * cos(golden * i), z, r * sin(golden * i)))
    return directions


def _converted(conversion: Conversion | None, color: Vector) -> Vector:
    return color if conversion is None else conversion.color(color)


def _unit(v: Vector) -> Vector | None:
    largest = max(map(abs, v))
    if largest == 0:
        return None
    x, y, z = (float(c / largest) for c in v)
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)


def _single(value: float) -> bool:
    return isfinite(value) and abs(value) <= 3.4e38
