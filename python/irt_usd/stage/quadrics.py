# SPDX-License-Identifier: Apache-2.0
"""UsdGeom's exact solids: Sphere, Cube, Cylinder, Cone, Capsule, Plane, and those of two radii."""

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.primvars import Primvars, PrimvarValue, constant_only, primvar_attributes
from irt_usd.stage.snapshot import Shape
from irt_usd.stage.transforms import Node
from irt_usd.stage.values import Value

if TYPE_CHECKING:
    from irt_usd import _core

LENGTHS: dict[str, tuple[str, ...]] = {
    "Sphere": ("radius",),
    "Cube": ("size",),
    "Cylinder": ("radius", "height"),
    "Cone": ("radius", "height"),
    "Capsule": ("radius", "height"),
    "Plane": ("width", "length"),
    "Cylinder_1": ("radiusBottom", "radiusTop", "height"),
    "Capsule_1": ("radiusBottom", "radiusTop", "height"),
}
"""The attributes that give each solid its size, in object units."""

_ROW_OF_CORE_AXIS = {"X": (1, 2, 0, 3), "Y": (2, 0, 1, 3), "Z": (0, 1, 2, 3)}
"""Where the core's x, y and z axes point, by a solid's axis: cyclic, so that hands are kept."""


class QuadricShape(Shape):
    """A solid of UsdGeom. The core's lie along z; `place` turns them, by a permutation of axes."""

    def __init__(
        self, attributes: Mapping[str, Value], primvars: Mapping[str, PrimvarValue]
    ) -> None:
        self.attributes = {**attributes, **primvar_attributes(primvars)}
        self.primvars = primvars
        self._axis = str(attributes.get("axis", "Z"))

    def geometry(self) -> "_core.Quadric":
        """The core's solid, along z."""
        from irt_usd import _core

        kind = str(self.attributes["typeName"])
        lengths = [cast("float", self.attributes[name]) for name in LENGTHS[kind]]
        if kind == "Capsule_1" and self.attributes["height"] == 0:
            return _core.Quadric.sphere(max(lengths[:2]))
        if kind == "Sphere":
            return _core.Quadric.sphere(*lengths)
        if kind == "Capsule" and self.attributes["height"] == 0:
            return _core.Quadric.sphere(lengths[0])
        if kind == "Cube":
            return _core.Quadric.cube(*lengths)
        if kind == "Plane":
            # Along X and Y, UsdGeomPlane's width is where the permutation takes the core's y.
            return _core.Quadric.plane(*(lengths if self._axis == "Z" else reversed(lengths)))
        if kind == "Cylinder_1":
            return _core.Quadric.frustum(*lengths)
        if kind == "Capsule_1":
            return _core.Quadric.round_cone(*lengths)
        make = {
            "Cylinder": _core.Quadric.cylinder,
            "Cone": _core.Quadric.cone,
            "Capsule": _core.Quadric.capsule,
        }[kind]
        return make(*lengths)

    def place(self, world_from_object: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where the solid along z goes: rows of `world_from_object` in another order."""
        return world_from_object[list(_ROW_OF_CORE_AXIS[self._axis])]


class QuadricSource:
    """Reads one solid, and of its primvars those that are `wanted` (without "primvars:")."""

    def __init__(self, node: Node, report: Report, wanted: frozenset[str]) -> None:
        self._report = report
        self._kind = str(node.prim.GetTypeName())
        names = LENGTHS[self._kind]
        if self._kind not in ("Sphere", "Cube"):
            names = (*names, "axis")
        if self._kind == "Plane":
            names = (*names, "doubleSided")
        self._attributes = Attributes(node.prim, names, report, node.in_clips)
        self._primvars = Primvars(node.prim, wanted, report)
        self._shape: Shape | None = None
        self._first = True

    @property
    def varies(self) -> bool:
        """Whether the shape can differ between frames."""
        return self._attributes.vary or self._primvars.vary

    def read(self, time: Usd.TimeCode) -> Shape | None:
        """The shape at `time` (the same object while nothing changes); None: nothing to draw."""
        changed = self._attributes.update(time)
        if self._primvars.update(time) or changed or self._first:
            self._first = False
            self._shape = self._build(time)
        return self._shape

    def _may_be_zero(self, length: str) -> bool:
        """Of capsules the spine, of two radii one."""
        if length == "height":
            return self._kind.startswith("Capsule")
        other = {"radiusTop": "radiusBottom", "radiusBottom": "radiusTop"}.get(length)
        return other is not None and self._attributes.values[other] != 0

    def _build(self, time: Usd.TimeCode) -> Shape | None:
        prim, values = self._attributes.prim, self._attributes.values
        for name in LENGTHS[self._kind]:
            length = values[name]
            if not isinstance(length, float) or not isfinite(length) or length < 0:
                wanted = f"the {name} is {length}; expected a positive finite number"
                self._report.skipped(wanted, where(prim, name, time))
                return None
            if length == 0 and not self._may_be_zero(name):
                self._report.mentioned("of no size, so not there", where(prim, name, time))
                return None
        if values.get("axis", "Z") not in _ROW_OF_CORE_AXIS:
            message = f"the axis is {values['axis']}; expected X, Y or Z"
            self._report.skipped(message, where(prim, "axis", time))
            return None
        if values.get("doubleSided", True) is False:
            self._report.unsupported(
                "single-sided planes (both sides rendered)", str(prim.GetPath())
            )
        primvars = self._primvars.checked(constant_only, time)
        return QuadricShape({"typeName": self._kind, **values}, primvars)
