# SPDX-License-Identifier: Apache-2.0
"""A shot at one time, as records. States are immutable, and shared by the snapshots that agree."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import NDArray

from irt_usd.stage.graph import Surface, TextureSource, core_material
from irt_usd.stage.primvars import PrimvarValue
from irt_usd.stage.values import Value

if TYPE_CHECKING:
    from irt_usd import _core
    from irt_usd.stage.dome import Sky

Vector = tuple[float, float, float]
Geometry = Union[
    "_core.Quadric", "_core.Mesh", "_core.Spheres", "_core.Curves", "_core.InstanceArray"
]
Part = tuple[
    str,
    Geometry,
    NDArray[np.float64],
    str,
    "_core.Primvars",
    Sequence[str],
    "_core.PassRole",
]
"""As _core.Prototype takes it: name, geometry, place, material, constant primvars, materials of
faces, role in the render pass."""


class Shape(ABC):
    """Geometry in object space. `attributes` are USD's names and values, "typeName" among them."""

    attributes: Mapping[str, Value]
    primvars: Mapping[str, PrimvarValue] = MappingProxyType({})
    """Of shapes without vertices: primvars of one element."""
    face_materials: tuple[str, ...] = ()
    """Keys of Snapshot.materials: those that faces wear instead of the object's."""

    @abstractmethod
    def geometry(self) -> "Geometry":
        """The core's record, made at the first call and shared by later ones."""

    def prototype(self, material: str) -> "_core.Prototype":
        """The shape alone as a prototype, one for each material that it wears."""
        from irt_usd import _core

        made = self._prototypes.get(material)
        if made is None:
            identity = np.eye(4)
            state = ObjectState("", self, identity, material)
            made = self._prototypes[material] = _core.Prototype([state.part("shape")])
        return made

    @cached_property
    def _prototypes(self) -> dict[str, "_core.Prototype"]:
        return {}

    def place(self, world_from_object: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where the record goes when the prim is at `world_from_object`; (4, 4), row vectors."""
        return world_from_object


@dataclass(frozen=True, eq=False, slots=True)
class ObjectState:
    """A visible object."""

    path: str
    shape: Shape
    world_from_object: NDArray[np.float64]
    """(4, 4) float64, `p_world = p_object @ m`, as the prim's ops compose it."""
    material: str
    """Key of Snapshot.materials; of an instancer, whose prototypes' parts name theirs, empty."""
    instanced: bool = False
    """Whether the shape is shared by the objects of a native instance's prototype."""
    role: tuple[bool, bool] = (True, False)
    """In the render pass: whether the camera sees it, whether it is matte."""

    @property
    def attributes(self) -> dict[str, Value]:
        """All that a change is looked for in, by USD attribute name.

        What the render pass makes of it is there where that is anything.
        """
        found: dict[str, Value] = {
            **self.shape.attributes,
            "world_from_object": self.world_from_object,
            "material:binding": self.material,
        }
        if self.role != (True, False):
            found["irt:cameraVisible"], found["irt:matte"] = self.role
        return found

    def add_to(self, changes: "_core.ChangeSet") -> None:
        """Sets the whole record in `changes`."""
        if self.instanced:
            from irt_usd import _core

            prototype, role = self.shape.prototype(self.material), _core.PassRole(*self.role)
            changes.set_object(self.path, prototype, self.world_from_object, role=role)
            return
        _, geometry, placed, material, primvars, faces, role = self.part("")
        changes.set_object(self.path, geometry, placed, material, primvars, faces, role)

    def part(self, name: str) -> "Part":
        """The object as a part of a prototype whose space is this one's world."""
        from irt_usd import _core

        placed = self.shape.place(self.world_from_object)
        primvars = {key: value.single.core for key, value in self.shape.primvars.items()}
        faces = self.shape.face_materials
        role = _core.PassRole(*self.role)
        return name, self.shape.geometry(), placed, self.material, primvars, faces, role


@dataclass(frozen=True, eq=False, slots=True)
class MaterialState:
    """A material.

    `attributes` decide all of it: inputs by name, without "inputs:", and what its other shaders
    say by whole paths, such as "/M/T.inputs:scale". A connected input's value is the text
    "</M/T.outputs:rgb>".
    """

    path: str
    attributes: Mapping[str, Value]
    surface: Surface
    textures: TextureSource | None = None
    """Where the texels of the surface's textures come from."""

    def core(self) -> "_core.Material":
        """The core's record."""
        return core_material(self.surface, self.textures)

    def add_to(self, changes: "_core.ChangeSet") -> None:
        """Sets the whole record in `changes`."""
        changes.set_material(self.path, self.core())


@dataclass(frozen=True, eq=False, slots=True)
class LightState:
    """A visible light, reduced to a delta light, or a dome to several."""

    path: str
    kind: Literal["distant", "point", "dome"]
    attributes: Mapping[str, Value]
    aim: Vector
    """World space: the unit direction in which a distant light travels, or a point's position."""
    energy: Vector
    """Scene-linear RGB: irradiance at normal incidence, a point's greatest radiant intensity or a
    dome's radiance."""
    casts_shadows: bool
    modifiers: Mapping[str, Any] = field(default_factory=dict)
    """Of the core's record, as _core.Light has them."""
    directions: int = 0
    """That a dome lights from."""
    camera_visible: bool = True
    """Whether the camera sees a dome in the render pass."""
    up: Vector = (0.0, 1.0, 0.0)
    """The axis of a dome's directions."""
    sky: "Sky | None" = None
    """A dome's picture."""

    def core(self) -> dict[str, "_core.Light"]:
        """The core's records, by name: of a dome the sky, and the lights that stand for it."""
        from irt_usd import _core

        shaped = dict(self.modifiers)
        if self.kind == "point":
            light = _core.Light.point(self.aim, self.energy, self.casts_shadows, modifiers=shaped)
            return {self.path: light}
        if self.kind == "distant":
            light = _core.Light.distant(self.aim, self.energy, self.casts_shadows, modifiers=shaped)
            return {self.path: light}
        directions = _core.sky_directions(self.directions, self.up)
        seen = self.camera_visible
        if self.sky is None:
            shares = [(4 * pi / self.directions,) * 3] * self.directions
            sky = _core.Light.environment(self.energy, seen)
        else:
            shares = self.sky.irradiances(directions)
            sky = _core.Light.environment(self.energy, seen, self.sky.texture, self.sky.axes)
        lights = {self.path: sky}
        for name, direction, share in zip(self.names()[1:], directions, shares, strict=True):
            red, green, blue = (e * s for e, s in zip(self.energy, share, strict=True))
            lights[name] = _core.Light.distant(
                direction, (red, green, blue), self.casts_shadows, modifiers=shaped
            )
        return lights

    def names(self) -> list[str]:
        """Of the core's records."""
        return [self.path, *(f"{self.path}#{i:04d}" for i in range(self.directions))]

    def add_to(self, changes: "_core.ChangeSet") -> None:
        """Sets the whole record in `changes`."""
        for name, light in self.core().items():
            changes.set_light(name, light)


@dataclass(frozen=True, eq=False, slots=True)
class CameraState:
    """The shot's camera."""

    path: str
    attributes: Mapping[str, Value]
    world_from_camera: NDArray[np.float64]
    """(4, 4) float64, row vectors; camera space looks along -z, y up."""
    window: tuple[float, float, float, float]
    """Left, right, bottom, top: on the plane z = -1 (perspective) or in camera units."""
    orthographic: bool
    clipping: tuple[float, float]
    """Near and far, as depths."""
    pixel_aspect: float
    """Width over height of a pixel."""
    exposure: float
    """What written radiances are multiplied by."""

    def core(self) -> "_core.Camera":
        """The core's record."""
        from irt_usd import _core

        return _core.Camera(self.world_from_camera, self.window, self.orthographic, self.clipping)


State = ObjectState | MaterialState | LightState | CameraState


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """Everything that reaches pixels, at one time.

    States that did not change since the reader's previous snapshot are the same objects as there;
    a dictionary without changes is, too.
    """

    time: float
    objects: Mapping[str, ObjectState]
    materials: Mapping[str, MaterialState]
    lights: Mapping[str, LightState]
    cameras: tuple[CameraState, ...]
    """By view."""
    hidden: frozenset[str] = field(default_factory=frozenset)
    """Objects and lights that are invisible at this time."""

    @property
    def camera(self) -> CameraState:
        """The first view's."""
        return self.cameras[0]
