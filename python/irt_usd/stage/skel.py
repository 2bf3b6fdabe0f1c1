# SPDX-License-Identifier: Apache-2.0
"""UsdSkel: where joints and blend shapes take the points, normals and places of what they bind.

Deformed points are kept in the space of the skeleton (UsdSkel's skinning, in the section "Skinning"
of its documentation), so that an object follows the skeleton's transform and not its own. What is
bound as a whole (constant influences) keeps its points and is moved instead.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Tf, Usd, UsdSkel, Vt

from irt_usd.report import Report
from irt_usd.stage.attributes import prim_location, where
from irt_usd.stage.diagnostics import unreadable
from irt_usd.stage.transforms import Hierarchy, Node
from irt_usd.stage.values import same_bits

_UNDEFORMED = "undeformed points rendered"


class Pose:
    """What a skeleton's animation says at the time of the last update; shared by all it moves."""

    def __init__(self, query: UsdSkel.SkeletonQuery) -> None:
        self.query = query
        self._animation = animation = query.GetAnimQuery()
        self.joints_vary = bool(animation) and animation.JointTransformsMightBeTimeVarying()
        self.weights_vary = bool(animation) and animation.BlendShapeWeightsMightBeTimeVarying()
        self.transforms: Vt.Matrix4dArray | None = None
        """From the skeleton's space as bound to it as posed, a joint; None: not to be had."""
        self.weights: Vt.FloatArray | None = None
        """Of the animation's blend shapes."""
        self.transforms_version = 0
        """Grows whenever they change."""
        self.weights_version = 0
        """Grows whenever they change."""
        self._time: Usd.TimeCode | None = None

    def update(self, time: Usd.TimeCode) -> None:
        """Brings the pose to `time`."""
        first = self._time is None
        if time == self._time:
            return
        self._time = time
        if self.joints_vary or first:
            transforms = self.query.ComputeSkinningTransforms(time)
            if not _same(transforms, self.transforms):
                self.transforms = transforms
                self.transforms_version += 1
        if self._animation and (self.weights_vary or first):
            weights = self._animation.ComputeBlendShapeWeights(time)
            if not _same(weights, self.weights):
                self.weights = weights
                self.weights_version += 1


class Deformation:
    """What joints and blend shapes make of the points of one prim, or of native instances alike."""

    def __init__(
        self,
        prim: Usd.Prim,
        skeleton: Usd.Prim,
        pose: Pose,
        query: UsdSkel.SkinningQuery,
        report: Report,
    ) -> None:
        self._prim = prim
        self._skeleton = skeleton
        self._pose = pose
        self._query = query
        self._report = report
        self.jointed = bool(query.HasJointInfluences())
        self.rigid = self.jointed and query.IsRigidlyDeformed() and not query.HasBlendShapes()
        """Whether it is moved as a whole, not deformed."""
        self._binding_varies = self.jointed and any(
            attribute.ValueMightBeTimeVarying() for attribute in _binding(query)
        )
        shaped = query.HasBlendShapes() and pose.weights_vary
        self.varies = self._binding_varies or (self.jointed and pose.joints_vary) or shaped
        """Whether the deformation can differ between frames."""
        self.version = 0
        """Grows whenever the deformation does differ."""
        self.placed = Gf.Matrix4d(1)
        """From the prim's points to the skeleton's space; the identity unless it is rigid."""
        self._posed = True
        """Whether the joints can move it at all."""
        self.broken = False
        """Whether what was last drawn is undeformed for a fault."""
        self._seen: tuple[int, int, float] | None = None
        self._time = Usd.TimeCode.EarliestTime()

    def update(self, time: Usd.TimeCode) -> None:
        """Brings the deformation to `time`."""
        self._pose.update(time)
        seen = (
            self._pose.transforms_version if self.jointed else 0,
            self._pose.weights_version if self._query.HasBlendShapes() else 0,
            time.GetValue() if self._binding_varies else 0.0,
        )
        if seen == self._seen:
            return
        self._seen = seen
        self._time = time
        self.version += 1
        fault = self._fault(time) if self.jointed else None
        self._posed = fault is None
        self.broken = False
        if fault is not None:
            self._break(*fault)
        elif self.rigid:
            self.placed = self._query.ComputeSkinnedTransform(self._pose.transforms, time)

    def points(self, points: NDArray[np.float32]) -> NDArray[np.float32]:
        """`points` (n, 3) as authored, deformed."""
        self.broken = not self._posed
        if self.rigid or self.broken:
            return points
        deformed = Vt.Vec3fArray.FromNumpy(points)
        try:
            self._apply_shapes(deformed, self._shape_offsets)
            if self.jointed and not self._skin(points, deformed):
                return points
        except Tf.ErrorException as error:
            self._break(unreadable(error), "primvars:skel:jointIndices")
            return points
        result = np.asarray(deformed)
        if not np.isfinite(result).all():
            message = "the skinned points hold a NaN or an infinity; expected finite transforms"
            self._break(message, "skel:skeleton")
            return points
        return result

    def normals(
        self, normals: NDArray[np.float32], point_of: NDArray[np.int32] | None
    ) -> NDArray[np.float32]:
        """`normals` (n, 3) deformed; `point_of` names each one's point, None: of point i."""
        if self.rigid or self.broken:
            return normals
        if self._query.HasBlendShapes():
            count = len(normals) if point_of is None else int(point_of.max()) + 1
            offsets = Vt.Vec3fArray(count)
            self._apply_shapes(offsets, self._normal_offsets)
            moved = np.asarray(offsets)
            normals = normals + (moved if point_of is None else moved[point_of])
        if not self.jointed:
            return normals
        indices, weights = self._query.ComputeJointInfluences(self._time)
        per_point = self._query.GetNumInfluencesPerComponent()
        if self._query.IsRigidlyDeformed():
            indices, weights = (
                Vt.IntArray(list(indices) * len(normals)),
                Vt.FloatArray(list(weights) * len(normals)),
            )
        elif point_of is not None:
            indices = Vt.IntArray.FromNumpy(_rows(indices, per_point)[point_of].ravel())
            weights = Vt.FloatArray.FromNumpy(_rows(weights, per_point)[point_of].ravel())
        turned = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals, dtype=np.float32))
        UsdSkel.SkinNormals(
            self._query.GetSkinningMethod(),
            _normal_matrix(self._query.GetGeomBindTransform(self._time)),
            Vt.Matrix3dArray([_normal_matrix(matrix) for matrix in self._mapped_transforms()]),
            indices,
            weights,
            per_point,
            turned,
        )
        return np.asarray(turned)

    def _skin(self, points: NDArray[np.float32], deformed: Vt.Vec3fArray) -> bool:
        indices = self._query.ComputeJointInfluences(self._time)[0]
        per_point = self._query.GetNumInfluencesPerComponent()
        wanted = per_point if self._query.IsRigidlyDeformed() else per_point * len(points)
        if len(indices) != wanted:
            message = (
                f"there are {len(indices)} joint influences, {per_point} a point; expected {wanted}"
                f" for {len(points)} points"
            )
            self._break(message, "primvars:skel:jointIndices")
            return False
        if self._query.ComputeSkinnedPoints(self._pose.transforms, deformed, self._time):
            return True
        self._break("UsdSkel cannot skin it", "primvars:skel:jointIndices")
        return False

    def _fault(self, time: Usd.TimeCode) -> tuple[str, str] | None:
        """What keeps the joints from moving the prim, and the attribute that is to blame."""
        if not self._pose.transforms or not self._pose.query.HasBindPose():
            skeleton = prim_location(self._skeleton)
            wanted = "as many bindTransforms and restTransforms (or animated ones) as joints"
            return f"the skeleton {skeleton} has no pose; expected {wanted}", "skel:skeleton"
        influences = self._query.ComputeJointInfluences(time)
        if not influences:
            return (
                "there are not as many joint weights as joint indices; expected as many",
                "primvars:skel:jointWeights",
            )
        indices = np.asarray(influences[0])
        joints = len(self._mapped_transforms())
        if len(indices) and (indices.min() < 0 or indices.max() >= joints):
            worst = indices.min() if indices.min() < 0 else indices.max()
            return (
                f"index {worst} names none of the {joints} joints; expected 0 to {joints - 1}",
                "primvars:skel:jointIndices",
            )
        if not np.isfinite(np.asarray(influences[1])).all():
            return "a joint weight is not finite", "primvars:skel:jointWeights"
        if not np.isfinite(np.asarray(self._pose.transforms)).all():
            return "the joints' transforms hold a NaN or an infinity", "skel:skeleton"
        return None

    def _break(self, message: str, attribute: str) -> None:
        self.broken = True
        place = where(self._prim, attribute, self._time)
        self._report.skipped(f"{message}; {_UNDEFORMED}", place)

    def _mapped_transforms(self) -> Vt.Matrix4dArray:
        """The skinning transforms in the order of the prim's own joints."""
        mapper = self._query.GetJointMapper()
        transforms = self._pose.transforms
        return mapper.RemapTransforms(transforms, Vt.Matrix4dArray()) if mapper else transforms

    @cached_property
    def _shapes(self) -> UsdSkel.BlendShapeQuery:
        return UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(self._prim))

    @cached_property
    def _shape_offsets(self) -> list[Vt.Vec3fArray]:
        """Of the points, by shape, those in between included."""
        return list(self._shapes.ComputeSubShapePointOffsets())

    @cached_property
    def _normal_offsets(self) -> list[Vt.Vec3fArray]:
        offsets = []
        for index, of_points in enumerate(self._shape_offsets):
            between = self._shapes.GetInbetween(index)
            if not of_points:
                found = None
            elif between:
                found = between.GetNormalOffsets()
            else:
                shape = self._shapes.GetBlendShape(self._shapes.GetBlendShapeIndex(index))
                found = shape.GetNormalOffsetsAttr().Get()
            offsets.append(found or Vt.Vec3fArray())
        return offsets

    @cached_property
    def _shape_points(self) -> list[Vt.IntArray]:
        """Which points each blend shape moves; none: all of them, in order."""
        return list(self._shapes.ComputeBlendShapePointIndices())

    def _apply_shapes(self, values: Vt.Vec3fArray, offsets: list[Vt.Vec3fArray]) -> None:
        """Adds to `values` what the blend shapes at the weights of the pose do."""
        if not self._query.HasBlendShapes() or not self._pose.weights:
            return
        weights = self._query.GetBlendShapeMapper().Remap(self._pose.weights)
        for weight, shape, index in zip(*self._shapes.ComputeSubShapeWeights(weights), strict=True):
            moved, points = offsets[index], self._shape_points[shape]
            if not moved:
                continue
            fault = _shape_fault(len(moved), points, len(values))
            if fault is None:
                UsdSkel.ApplyBlendShape(weight, moved, points, values)
            else:
                prim = self._shapes.GetBlendShape(shape).GetPrim()
                message = f"{fault}; the shape is not applied"
                self._report.skipped(message, where(prim, "offsets", self._time))


class Skin:
    """How one prim is bound to a skeleton: what deforms it, and where the deformed points are."""

    def __init__(self, node: Node, skeleton: Node, deformation: Deformation) -> None:
        self._node = node
        self._skeleton = skeleton
        self.deformation = deformation

    @property
    def moves(self) -> bool:
        """Whether `world` can differ between frames."""
        moved = self.deformation.rigid and self.deformation.varies
        return self._skeleton.moves or self._node.moves or moved

    @property
    def world(self) -> Gf.Matrix4d:
        """World from the points' space."""
        if self.blamed is self._node:
            return self._node.world
        return self.deformation.placed * self._skeleton.world

    @property
    def blamed(self) -> Node:
        """Whose transform is behind `world`."""
        deformation = self.deformation
        return self._node if deformation.broken or not deformation.jointed else self._skeleton


class Skins:
    """The bindings of a stage."""

    def __init__(self, hierarchy: Hierarchy, report: Report) -> None:
        self._hierarchy = hierarchy
        self._report = report
        self._cache = UsdSkel.Cache()
        self._roots: dict[Sdf.Path, dict[Sdf.Path, UsdSkel.Skeleton]] = {}
        self._poses: dict[Sdf.Path, Pose] = {}
        self._deformations: dict[tuple[str, ...], Deformation] = {}
        self._nodes: dict[str, list[Node]] = {}
        self._nodes_read = 0

    def skin(self, node: Node) -> Skin | None:
        """What deforms `node`; None if nothing does. A binding that is broken is reported."""
        if not node.skinned:
            return None
        root = UsdSkel.Root.Find(node.prim)
        if not root:
            message = "skinned, but in no SkelRoot, so not deformed"
            self._report.mentioned(message, prim_location(node.prim))
            return None
        skeleton = self._skeletons(root).get(node.prim.GetPath())
        query = self._cache.GetSkinningQuery(node.prim)
        if not skeleton or not query:
            message = f"no skeleton is bound to it; {_UNDEFORMED}"
            self._report.skipped(message, where(node.prim, "skel:skeleton", _ANY_TIME))
            return None
        if not query.HasJointInfluences() and not query.HasBlendShapes():
            return None
        place = self._place(skeleton, node)
        if place is None:
            message = f"its skeleton is not drawn along with it; {_UNDEFORMED}"
            self._report.skipped(message, where(node.prim, "skel:skeleton", _ANY_TIME))
            return None
        self._hierarchy.require(place)
        pose = self._poses.get(skeleton.GetPath())
        if pose is None:
            pose = self._poses[skeleton.GetPath()] = Pose(self._cache.GetSkelQuery(skeleton))
        return Skin(node, place, self._deformation(node.prim, skeleton, pose, query))

    def _deformation(
        self, prim: Usd.Prim, skeleton: UsdSkel.Skeleton, pose: Pose, query: UsdSkel.SkinningQuery
    ) -> Deformation:
        """That of `prim`; one for all native instances which deform alike."""
        animation = pose.query.GetAnimQuery()
        shared = (
            prim,
            skeleton.GetPrim(),
            *((animation.GetPrim(),) if animation else ()),
            *(attribute.GetPrim() for attribute in _binding(query)),
        )
        key = tuple(str(_in_prototype(source).GetPath()) for source in shared)
        if key not in self._deformations:
            self._deformations[key] = Deformation(
                prim, skeleton.GetPrim(), pose, query, self._report
            )
        return self._deformations[key]

    def _place(self, skeleton: UsdSkel.Skeleton, node: Node) -> Node | None:
        """The node of `skeleton`, in the tree of `node` if it is in several."""
        if self._nodes_read != len(self._hierarchy.nodes):
            self._nodes.clear()
            for known in self._hierarchy.nodes:
                self._nodes.setdefault(known.path, []).append(known)
            self._nodes_read = len(self._hierarchy.nodes)
        places = self._nodes.get(str(skeleton.GetPath()), [])
        return next((p for p in places if _top(p) is _top(node)), places[0] if places else None)

    def _skeletons(self, root: UsdSkel.Root) -> dict[Sdf.Path, UsdSkel.Skeleton]:
        """Under `root`, the skeleton of each prim that has one."""
        path = root.GetPath()
        if path not in self._roots:
            everything = Usd.TraverseInstanceProxies()
            self._cache.Populate(root, everything)
            self._roots[path] = {
                target.GetPrim().GetPath(): binding.GetSkeleton()
                for binding in self._cache.ComputeSkelBindings(root, everything)
                for target in binding.GetSkinningTargets()
            }
        return self._roots[path]


_ANY_TIME = Usd.TimeCode.EarliestTime()


def _binding(query: UsdSkel.SkinningQuery) -> list[Usd.Attribute]:
    """The attributes that bind joints."""
    if not query.HasJointInfluences():
        return []
    attributes = (
        query.GetGeomBindTransformAttr(),
        query.GetJointIndicesPrimvar().GetAttr(),
        query.GetJointWeightsPrimvar().GetAttr(),
    )
    return [attribute for attribute in attributes if attribute]


def _in_prototype(prim: Usd.Prim) -> Usd.Prim:
    return prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim


def _top(node: Node) -> Node:
    while node.parent is not None:
        node = node.parent
    return node


def _same(a: Vt.Matrix4dArray | Vt.FloatArray, b: Vt.Matrix4dArray | Vt.FloatArray) -> bool:
    if a is None or b is None:
        return a is b
    return same_bits(np.asarray(a), np.asarray(b))


def _rows(values: Vt.IntArray | Vt.FloatArray, width: int) -> NDArray[np.generic]:
    return np.asarray(values).reshape(-1, width)


def _normal_matrix(matrix: Gf.Matrix4d) -> Gf.Matrix3d:
    return matrix.ExtractRotationMatrix().GetInverse().GetTranspose()


def _shape_fault(offsets: int, points: Vt.IntArray, count: int) -> str | None:
    indices = np.asarray(points)
    if len(indices) == 0:
        return None if offsets == count else f"there are {offsets} offsets; expected {count}"
    if offsets != len(indices):
        return f"there are {offsets} offsets for {len(indices)} pointIndices; expected as many"
    if indices.min() < 0 or indices.max() >= count:
        return f"a point index names none of the {count} points"
    return None
