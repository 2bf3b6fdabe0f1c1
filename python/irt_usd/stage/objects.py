# SPDX-License-Identifier: Apache-2.0
"""An object: its shape, its place and its material."""

from pxr import Usd

from irt_usd.report import Report
from irt_usd.stage.attributes import prim_location
from irt_usd.stage.curves import CurvesShape
from irt_usd.stage.mesh import MeshShape, MeshSource
from irt_usd.stage.point_based import PointBasedSource
from irt_usd.stage.points import PointsShape
from irt_usd.stage.quadrics import QuadricSource
from irt_usd.stage.skel import Skin
from irt_usd.stage.snapshot import ObjectState, Shape
from irt_usd.stage.transforms import SIXTEEN_DOUBLES, Node, transform_blame, transform_fault
from irt_usd.stage.values import matrix_array

ShapeSource = MeshSource | PointBasedSource | QuadricSource

_SINGLE_RANGE = 1e38
"""World coordinates beyond it may leave the range of single precision."""


class ObjectSource:
    """Reads one object."""

    def __init__(
        self,
        node: Node,
        shape: ShapeSource,
        material: str,
        report: Report,
        skin: Skin | None = None,
        role: tuple[bool, bool] = (True, False),
        primvars: frozenset[str] = frozenset(),
    ) -> None:
        """`role`: as ObjectState has it. `primvars`: names of those that its materials read."""
        self.node = node
        self._role = role
        self.primvars = primvars
        self._skin = skin
        self._place: Node | Skin = skin or node
        self._shape = shape
        self._material = material
        self._instanced = node.prim.IsInstanceProxy()
        self._report = report
        self._world = b""
        self._faulty = False
        self._state: ObjectState | None = None

    @property
    def varies(self) -> bool:
        """Whether its shape, place or visibility can differ between frames."""
        return self._shape.varies or self._place.moves or self.node.visibility_varies

    def read(self, time: Usd.TimeCode) -> ObjectState | None:
        """The object at `time`, seen or not: the same one while nothing changes.

        None, and reported, if it cannot be drawn.
        """
        if self._skin is not None:
            self._skin.deformation.update(time)
        shape = self._shape.read(time)
        world = bytes(self._place.world)
        if world != self._world:
            self._world = world
            self._faulty = self._check_transform(time)
            self._state = None
        if shape is None or self._faulty:
            self._state = None
        elif self._state is None or self._state.shape is not shape:
            self._state = self._build(shape)
        return self._state

    def _build(self, shape: Shape) -> ObjectState | None:
        world = matrix_array(self._place.world)
        if isinstance(shape, (MeshShape, PointsShape, CurvesShape)):
            largest = max(map(abs, SIXTEEN_DOUBLES.unpack(self._world)))
            reach = largest * (3 * shape.extent + 1)
            if reach > _SINGLE_RANGE:
                message = "in world space the points exceed single precision; scale the scene down"
                self._report.skipped(message, prim_location(self.node.prim))
                return None
        instanced = self._instanced
        return ObjectState(self.node.path, shape, world, self._material, instanced, self._role)

    def _check_transform(self, time: Usd.TimeCode) -> bool:
        fault = transform_fault(self._place.world)
        if fault:
            blamed = self._skin.blamed if self._skin is not None else self.node
            self._report.skipped(*transform_blame(blamed, fault, time))
        return fault is not None
