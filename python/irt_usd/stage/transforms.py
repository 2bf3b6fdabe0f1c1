# SPDX-License-Identifier: Apache-2.0
"""The hierarchy of prims: world transforms, visibility and purpose, all inherited.

World transforms are composed in double, local times parent, by the one rule for what moves and
what does not, so that a reading of one frame alone gives the same bits as a reading of the shot.
"""

from math import hypot, isfinite
from struct import Struct

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Tf, Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import authored_properties, prim_location, where
from irt_usd.stage.diagnostics import error_lines, unreadable

_AFFINE_TOLERANCE = 1e-9
"""By how much rounding may leave the last column of a matrix; the core's own rule."""

_MIN_INDEPENDENCE = 1e-9
"""Least determinant as a share of the product of the rows' or columns' lengths; the core's rule."""

_MAX_CONDITION = 1e14
"""Largest ratio (entry times cofactor over determinant) at which an inverse has correct digits."""

_UNREADABLE = Gf.Matrix4d(float("nan"))
"""Stands for a local transform that USD cannot read: nothing can be drawn under it."""

SIXTEEN_DOUBLES = Struct("16d")
"""The bytes of a 4x4 matrix."""


class Node:
    """A prim's place in the hierarchy, at the time of the last update."""

    __slots__ = (
        "display_primvars",
        "in_clips",
        "local",
        "moved",
        "moves",
        "needed",
        "own_visible",
        "parent",
        "path",
        "prim",
        "purpose",
        "resets",
        "skinned",
        "visibility_query",
        "visibility_varies",
        "visible",
        "world",
        "xformable",
    )

    def __init__(self, prim: Usd.Prim, path: str, parent: "Node | None") -> None:
        self.prim = prim
        self.path = path
        self.parent = parent
        self.xformable: UsdGeom.Xformable | None = None
        """Set where the local transform varies."""
        self.local: Gf.Matrix4d | None = None
        """None: the identity."""
        self.resets = False
        self.world: Gf.Matrix4d = parent.world if parent else Gf.Matrix4d(1)
        self.moves: bool = parent.moves if parent else False
        self.moved = False
        self.visibility_query: Usd.AttributeQuery | None = None
        self.own_visible = True
        self.visible: bool = parent.visible if parent else True
        self.visibility_varies: bool = parent.visibility_varies if parent else False
        self.purpose: str = parent.purpose if parent else ""
        self.needed = False
        self.display_primvars: bool = parent.display_primvars if parent else False
        self.skinned: bool = parent.skinned if parent else False
        self.in_clips: bool = prim.HasAuthoredMetadata("clips") or (
            parent.in_clips if parent else False
        )
        self._read_authored(authored_properties(prim, self.in_clips))

    def _read_authored(self, authored: frozenset[str]) -> None:
        prim = self.prim
        if "xformOpOrder" in authored and prim.IsA(UsdGeom.Xformable):
            try:
                self._read_transform(UsdGeom.Xformable(prim))
            except Tf.ErrorException:
                self.local = self.world = _UNREADABLE
        if "visibility" in authored and prim.IsA(UsdGeom.Imageable):
            query = Usd.AttributeQuery(prim, "visibility")
            if query.ValueMightBeTimeVarying():
                self.visibility_query = query
                self.visibility_varies = True
            else:
                self.own_visible = query.Get(Usd.TimeCode.EarliestTime()) != "invisible"
                self.visible = self.visible and self.own_visible
        if "purpose" in authored and prim.IsA(UsdGeom.Imageable):
            purpose = prim.GetAttribute("purpose")
            value = purpose.Get(Usd.TimeCode.EarliestTime())
            if purpose.HasAuthoredValue() and isinstance(value, str):
                self.purpose = value
        if "primvars:displayColor" in authored or "primvars:displayOpacity" in authored:
            self.display_primvars = True
        if "primvars:skel:jointIndices" in authored or "skel:blendShapes" in authored:
            self.skinned = True

    def _read_transform(self, xformable: UsdGeom.Xformable) -> None:
        self.resets = xformable.GetResetXformStack()
        if self.resets:
            self.moves = False
            self.world = Gf.Matrix4d(1)
        if xformable.TransformMightBeTimeVarying():
            self.xformable = xformable
            self.moves = True
        else:
            self.local = _local_transform(xformable, Usd.TimeCode.EarliestTime())
            self.world = self.local * self.world

    def update_transform(self, time: Usd.TimeCode) -> None:
        """Composes again where the own or the parent's transform is another than before."""
        parent = None if self.resets else self.parent
        dirty = parent is not None and parent.moved
        if self.xformable is not None:
            local = _local_transform(self.xformable, time)
            if self.local is None or bytes(local) != bytes(self.local):
                self.local = local
                dirty = True
        self.moved = False
        if not dirty:
            return
        world = parent.world if parent else Gf.Matrix4d(1)
        if self.local is not None:
            world = self.local * world
        if bytes(world) != bytes(self.world):
            self.world = world
            self.moved = True

    def update_visibility(self, time: Usd.TimeCode) -> None:
        """Visible if neither it nor an ancestor is `invisible` at `time`."""
        if self.visibility_query is not None:
            self.own_visible = self.visibility_query.Get(time) != "invisible"
        self.visible = self.own_visible and (self.parent is None or self.parent.visible)


def _local_transform(xformable: UsdGeom.Xformable, time: Usd.TimeCode) -> Gf.Matrix4d:
    try:
        return xformable.GetLocalTransformation(time)
    except Tf.ErrorException:
        return _UNREADABLE


def ancestry(prim: Usd.Prim) -> list[Node]:
    """Nodes of `prim`'s ancestors and its own, parents first, apart from any hierarchy."""
    nodes: list[Node] = []
    for path in prim.GetPath().GetPrefixes():
        ancestor = prim.GetStage().GetPrimAtPath(path)
        nodes.append(Node(ancestor, str(path), nodes[-1] if nodes else None))
    return nodes


class Hierarchy:
    """All nodes, parents before children; `update` touches only those that can vary."""

    def __init__(self, report: Report) -> None:
        self.nodes: list[Node] = []
        self._report = report
        self._moving: list[Node] | None = None
        self._blinking: list[Node] = []

    def require(self, node: Node) -> None:
        """Has `node` and its ancestors kept up to date. Only before the first update."""
        ancestor: Node | None = node
        while ancestor is not None and not ancestor.needed:
            ancestor.needed = True
            ancestor = ancestor.parent

    def update(self, time: Usd.TimeCode) -> None:
        """Brings every required node to `time`."""
        if self._moving is None:
            self._moving = [node for node in self.nodes if node.needed and node.moves]
            self._blinking = [n for n in self.nodes if n.needed and n.visibility_varies]
        for node in self._moving:
            node.update_transform(time)
        for node in self._blinking:
            try:
                node.update_visibility(time)
            except Tf.ErrorException as error:
                node.own_visible = node.visible = False
                self._report.skipped(unreadable(error), prim_location(node.prim))


def transform_fault(matrix: Gf.Matrix4d) -> str | None:
    """Why nothing can be drawn under `matrix`, or None if something can."""
    entries = SIXTEEN_DOUBLES.unpack(bytes(matrix))
    if not all(map(isfinite, entries)):
        return "the transform holds a NaN or an infinity; expected finite numbers"
    a, b, c, w0, d, e, f, w1, g, h, i, w2, _, _, _, w3 = entries
    if max(abs(w0), abs(w1), abs(w2), abs(w3 - 1)) > _AFFINE_TOLERANCE:
        return "the transform is projective; expected a last column of 0 0 0 1"
    cofactors = (
        *(e * i - f * h, f * g - d * i, d * h - e * g),
        *(h * c - i * b, i * a - g * c, g * b - h * a),
        *(b * f - c * e, c * d - a * f, a * e - b * d),
    )
    determinant = a * cofactors[0] + b * cofactors[1] + c * cofactors[2]
    if determinant == 0 or not isfinite(determinant):
        return "the transform is singular; expected one with an inverse (no scale of 0)"
    rows = hypot(a, b, c) * hypot(d, e, f) * hypot(g, h, i)
    columns = hypot(a, d, g) * hypot(b, e, h) * hypot(c, f, i)
    largest = max(map(abs, (a, b, c, d, e, f, g, h, i)))
    if abs(determinant) < _MIN_INDEPENDENCE * min(rows, columns) or largest * max(
        map(abs, cofactors)
    ) > _MAX_CONDITION * abs(determinant):
        return "the transform is singular to working precision; expected one with an inverse"
    return None


_CHUNK = 1 << 15
"""Matrices checked at once, so that a million take little memory."""


def regular_transforms(rows: NDArray[np.float64], world: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of the affine matrices `rows` (n, 4, 3), followed by `world` (4, 4), have an inverse.

    By the rule of `transform_fault`.
    """
    regular = np.empty(len(rows), np.bool_)
    linear = world[:3, :3]
    with np.errstate(all="ignore"):
        for start in range(0, len(rows), _CHUNK):
            part = rows[start : start + _CHUNK]
            placed = part @ linear
            m = placed[:, :3]
            cofactors = np.cross(m[:, [1, 2, 0]], m[:, [2, 0, 1]])
            determinant = np.abs((m[:, 0] * cofactors[:, 0]).sum(axis=1))
            lengths = np.linalg.norm(m, axis=2).prod(axis=1)
            widths = np.linalg.norm(m, axis=1).prod(axis=1)
            largest = np.abs(m).max(axis=(1, 2)) * np.abs(cofactors).max(axis=(1, 2))
            regular[start : start + _CHUNK] = (
                np.isfinite(placed).all(axis=(1, 2))
                & (determinant > 0)
                & (determinant >= 2 * _MIN_INDEPENDENCE * np.minimum(lengths, widths))
                & (2 * largest <= _MAX_CONDITION * determinant)
            )
    return regular


def transform_blame(node: Node, fault: str, time: Usd.TimeCode) -> tuple[str, str]:
    """Of a world transform with `fault`: what is wrong, and the op or prim to blame, with file."""
    ancestor: Node | None = node
    while ancestor is not None:
        if ancestor.local is not None and transform_fault(ancestor.local):
            return _blame_op(ancestor.prim, fault, time)
        ancestor = None if ancestor.resets else ancestor.parent
    return fault, prim_location(node.prim)


def _blame_op(prim: Usd.Prim, fault: str, time: Usd.TimeCode) -> tuple[str, str]:
    place = where(prim, "xformOpOrder", time)
    try:
        for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
            place = where(prim, str(op.GetAttr().GetName()), time)
            if transform_fault(op.GetOpTransform(time)):
                return fault, place
    except Tf.ErrorException as error:
        reason = "; ".join(error_lines(error)).replace(". Returning identity matrix.", "")
        return f"the transform cannot be read: {reason}; expected a value of the op's type", place
    return fault, where(prim, "xformOpOrder", time)
