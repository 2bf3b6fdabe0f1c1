# SPDX-License-Identifier: Apache-2.0
"""UsdLux's DistantLight and SphereLight as delta lights.

Emitted luminance is L = intensity * 2^exposure * colour (* the colour temperature's). A distant
light of angular diameter 2θ gives a surface that faces it the irradiance L π sin²θ (of its nearer
half sphere at most), a sphere light of radius r is a point of radiant intensity L π r². With
`normalize`, L is first divided by UsdLux's sizeFactor: what remains is L for a distant light up to
180° and L / 4 for a sphere. A distant light of angle 0 has the sizeFactor 1 either way: its
irradiance is L. Sizes are world-space sizes, and levels are independent of metersPerUnit, as in
UsdLux. `treatAsPoint` changes nothing: all sphere lights are points here.
"""

from math import cbrt, hypot, isfinite, pi, radians, sin

from pxr import Gf, Usd, UsdLux

from irt_usd.images.color import Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.color import StageColors
from irt_usd.stage.snapshot import CameraState, LightState, Vector
from irt_usd.stage.transforms import Node, transform_blame
from irt_usd.stage.values import Value, finite, matrix_array, same_bits

_SIZES = {"DistantLight": "inputs:angle", "SphereLight": "inputs:radius"}

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

ENERGY_ATTRIBUTES = frozenset((*_EMISSION, *_SIZES.values()))
"""Attributes that a light's energy is made of, and nothing else is."""

_NOT_RENDERED: dict[str, Value] = {
    "inputs:diffuse": 1.0,
    "inputs:specular": 1.0,
    "inputs:shaping:focus": 0.0,
    "inputs:shaping:focusTint": (0.0, 0.0, 0.0),
    "inputs:shaping:cone:angle": 90.0,
    "inputs:shaping:cone:softness": 0.0,
    "inputs:shaping:ies:file": "",
    "inputs:shadow:color": (0.0, 0.0, 0.0),
    "inputs:shadow:distance": -1.0,
    "inputs:shadow:falloff": -1.0,
}
"""Attributes that are reported where they are not at their defaults."""

CAMERA_LIGHT = "irt:cameraLight"
"""Name of the light at the camera. Not a prim path."""


class LightSource:
    """Reads one light."""

    def __init__(self, prim: Usd.Prim, node: Node, report: Report, colors: StageColors) -> None:
        self.node = node
        self._prim = prim
        self._report = report
        self._kind = str(prim.GetTypeName())
        self._from_color = colors.to_rendering(prim.GetAttribute("inputs:color"))
        self._from_blackbody = colors.default
        self._size = _SIZES[self._kind]
        self._attributes = Attributes(
            prim, (*_EMISSION, self._size, "inputs:shadow:enable"), report, node.in_clips
        )
        self._state: LightState | None = None
        self._first = True
        self._world = b""
        self._report_unsupported()

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
        for name in (*_EMISSION, self._size):
            value, is_size = values[name], name == self._size
            if value is None or not finite(value) or (is_size and value < 0):  # type: ignore[operator]
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
            **values,
            "typeName": self._kind,
            "world_from_object": world,
        }
        shadows = values["inputs:shadow:enable"] is not False
        attributes["inputs:shadow:enable"] = shadows
        if self._kind == "DistantLight":
            direction = _unit((-world[2, 0], -world[2, 1], -world[2, 2]))
            if direction is None:
                message = "the transform leaves the light no direction; expected a z axis"
                self._report.skipped(*transform_blame(self.node, message, time))
                return None
            factor = _distant_factor(values)
            energy = self._energy(factor, time)
            if energy is None:
                return None
            return LightState(self.node.path, "distant", attributes, direction, energy, shadows)
        position = (float(world[3, 0]), float(world[3, 1]), float(world[3, 2]))
        energy = self._energy(_sphere_factor(values, self.node.world), time)
        if energy is None:
            return None
        return LightState(self.node.path, "point", attributes, position, energy, shadows)

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
        if self._kind == "SphereLight" and factor == 0:
            message = "a sphere light of no size gives no light unless normalized"
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
        for collection, kind in (
            (linking.GetLightLinkCollectionAPI(), "light linking"),
            (linking.GetShadowLinkCollectionAPI(), "shadow linking"),
        ):
            excludes = collection.GetExcludesRel().HasAuthoredTargets()
            if excludes or collection.GetIncludeRootAttr().Get() is False:
                self._report.unsupported(kind, path)
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


def _sphere_factor(values: dict[str, Value], world: Gf.Matrix4d) -> float:
    """Radiant intensity over luminance."""
    if values["inputs:normalize"]:
        return 0.25
    # Seven digits: what a rotation leaves of the determinant's last bits is no change of size.
    scale = float(f"{cbrt(abs(world.GetDeterminant3())):.7g}")
    return pi * (float(values["inputs:radius"]) * scale) ** 2  # type: ignore[arg-type]


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
