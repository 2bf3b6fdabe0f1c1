# SPDX-License-Identifier: Apache-2.0
"""The exhibits of shots/features that show a kind of geometry. Each stands at its own prim."""

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

from shots.kit.motion import ease, ramp
from shots.kit.stage import Vec3, bind, set_keys

Looks = dict[str, UsdShade.Material]


def points(values: np.ndarray | Sequence[Vec3]) -> Vt.Vec3fArray:
    """Return positions as USD's array type; (n, 3)."""
    return Vt.Vec3fArray.FromNumpy(np.asarray(values, dtype=np.float32))


def mesh(
    stage: Usd.Stage,
    path: str,
    at: Sequence[Vec3] | np.ndarray,
    faces: list[list[int]],
    scheme: str = "none",
) -> UsdGeom.Mesh:
    """Define a mesh."""
    prim = UsdGeom.Mesh.Define(stage, path)
    prim.CreatePointsAttr(points(at))
    prim.CreateFaceVertexCountsAttr([len(face) for face in faces])
    prim.CreateFaceVertexIndicesAttr([vertex for face in faces for vertex in face])
    prim.CreateSubdivisionSchemeAttr(scheme)
    return prim


CUBE: list[Vec3] = [(x, y, z) for z in (-0.5, 0.5) for y in (0.0, 1.0) for x in (-0.5, 0.5)]
CUBE_FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def star(stage: Usd.Stage, path: str, looks: Looks) -> None:
    """A left-handed prism over a concave polygon of ten corners, one of its sides a hole."""
    angle = np.arange(10) * np.pi / 5 + np.pi / 10
    radius = np.where(np.arange(10) % 2 == 0, 0.6, 0.28)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle) + 0.6], axis=1)
    front = [(x, y, 0.2) for x, y in ring]
    back = [(x, y, -0.2) for x, y in ring]
    faces = [list(range(10)), list(range(19, 9, -1))]
    faces += [[i, 10 + i, 10 + (i + 1) % 10, (i + 1) % 10] for i in range(10)]
    prim = mesh(stage, path, front + back, [face[::-1] for face in faces])
    prim.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    prim.CreateHoleIndicesAttr([4])
    prim.CreateDoubleSidedAttr(True)
    bind(prim.GetPrim(), looks["red"])


def subsets(stage: Usd.Stage, path: str, looks: Looks) -> None:
    """A cube with a material of its own on two of its faces, and normals by corner, indexed."""
    prim = mesh(stage, path, CUBE, CUBE_FACES)
    bind(prim.GetPrim(), looks["blue"])
    normals = [(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)]
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        "normals", Sdf.ValueTypeNames.Normal3fArray, UsdGeom.Tokens.faceVarying
    )
    primvar.Set(points(normals))
    primvar.SetIndices(Vt.IntArray([face for face in range(6) for _ in range(4)]))
    binding = UsdShade.MaterialBindingAPI(prim)
    for name, faces, look in (("front", [1], "varnish"), ("top", [3], "gold")):
        part = binding.CreateMaterialBindSubset(name, Vt.IntArray(faces))
        bind(part.GetPrim(), looks[look])


def creased(stage: Usd.Stage, path: str, looks: Looks, keys: tuple[int, int]) -> None:
    """A Catmull-Clark cube with a sharp ring and a sharp corner, whose top is pulled up."""
    prim = mesh(stage, path, CUBE, CUBE_FACES, "catmullClark")
    prim.CreateCreaseIndicesAttr([0, 1, 5, 4, 0])
    prim.CreateCreaseLengthsAttr([5])
    prim.CreateCreaseSharpnessesAttr([10.0])
    prim.CreateCornerIndicesAttr([7])
    prim.CreateCornerSharpnessesAttr([3.0])
    for frame, share in ease(*keys).items():
        top = [(x, y * (1 + 0.4 * share), z) for x, y, z in CUBE]
        prim.GetPointsAttr().Set(points(top), frame)
    bind(prim.GetPrim(), looks["green"])


def loop(stage: Usd.Stage, path: str, looks: Looks) -> None:
    """A Loop tetrahedron."""
    at = [(0, 1.3, 0), (-0.7, 0, 0.5), (0.7, 0, 0.5), (0, 0, -0.8)]
    prim = mesh(stage, path, at, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], "loop")
    bind(prim.GetPrim(), looks["plum"])


def topology(stage: Usd.Stage, path: str, keys: tuple[int, int]) -> None:
    """A fan that gains a face a key, with a colour a face."""
    first, last = keys
    prim = UsdGeom.Mesh.Define(stage, path)
    prim.CreateSubdivisionSchemeAttr("none")
    prim.CreateDoubleSidedAttr(True)
    colors = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.uniform
    )
    for frame in range(first, last + 1):
        count = 3 + frame - first
        angle = np.linspace(0, np.pi, count + 1)
        rim = np.stack([0.7 * np.cos(angle), 0.7 * np.sin(angle), 0 * angle], axis=1)
        prim.GetPointsAttr().Set(points(np.vstack([[(0, 0, 0)], rim])), frame)
        prim.GetFaceVertexCountsAttr().Set([3] * count, frame)
        faces = [v for i in range(count) for v in (0, 1 + i, 2 + i)]
        prim.GetFaceVertexIndicesAttr().Set(faces, frame)
        share = np.arange(count) / count
        colors.Set(points(np.stack([share, 0.5 + 0 * share, 1 - share], axis=1) * 0.8), frame)


def cloud(stage: Usd.Stage, path: str, keys: tuple[int, int]) -> None:
    """Points on a spiral, of many widths, the highest of which rises."""
    turn = np.linspace(0, 4 * np.pi, 60)
    at = np.stack([0.5 * np.cos(turn), 0.1 + turn * 0.09, 0.5 * np.sin(turn)], axis=1)
    prim = UsdGeom.Points.Define(stage, path)
    prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy((0.06 + 0.1 * turn / turn[-1]).astype("f4")))
    for frame, share in ease(*keys).items():
        moved = at.copy()
        moved[-1, 1] += 0.25 * share
        prim.CreatePointsAttr().Set(points(moved), frame)
    prim.CreateDisplayColorAttr([Gf.Vec3f(0.75, 0.4, 0.1)])


def curves(stage: Usd.Stage, path: str, looks: Looks) -> None:
    """One curve of each basis, its width varying along it."""
    UsdGeom.Xform.Define(stage, path)
    kinds = ("linear", "bezier", "bspline", "catmullRom")
    for i, basis in enumerate(kinds):
        prim = UsdGeom.BasisCurves.Define(stage, f"{path}/{basis}")
        linear = basis == "linear"
        prim.CreateTypeAttr("linear" if linear else "cubic")
        if not linear:
            prim.CreateBasisAttr(basis)
        if basis in ("bspline", "catmullRom"):
            prim.CreateWrapAttr("pinned")
        at = [(-0.6 + 0.4 * i + 0.12 * (-1) ** k, 0.2 * k, 0.1 * (k % 3)) for k in range(7)]
        prim.CreatePointsAttr(points(at))
        prim.CreateCurveVertexCountsAttr([7])
        spans = {"linear": 7, "bezier": 3, "bspline": 7, "catmullRom": 7}[basis]
        widths = np.linspace(0.16, 0.04, spans)
        prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(widths.astype("f4")))
        prim.SetWidthsInterpolation("varying")
        bind(prim.GetPrim(), looks[("red", "green", "blue", "plum")[i]])


def instancers(stage: Usd.Stage, path: str, looks: Looks, keys: tuple[int, int]) -> None:
    """A ring of rings: an instancer whose prototype is an instancer. One outer ring climbs."""
    outer = UsdGeom.PointInstancer.Define(stage, path)
    ring = UsdGeom.PointInstancer.Define(stage, f"{path}/ring")
    ball = UsdGeom.Sphere.Define(stage, f"{path}/ring/ball")
    ball.CreateRadiusAttr(0.07)
    bind(ball.GetPrim(), looks["gold"])
    block = UsdGeom.Cube.Define(stage, f"{path}/ring/block")
    block.CreateSizeAttr(0.1)
    bind(block.GetPrim(), looks["blue"])
    angle = np.arange(8) * np.pi / 4
    around = np.stack([0.25 * np.cos(angle), 0.25 * np.sin(angle), 0 * angle], axis=1)
    ring.CreatePrototypesRel().SetTargets([ball.GetPath(), block.GetPath()])
    ring.CreateProtoIndicesAttr([i % 2 for i in range(8)])
    ring.CreatePositionsAttr(points(around))
    outer.CreatePrototypesRel().SetTargets([ring.GetPath()])
    outer.CreateProtoIndicesAttr([0, 0, 0, 0])
    outer.CreateIdsAttr([10, 11, 12, 13])
    outer.CreateInvisibleIdsAttr([13])
    half = [Gf.Quath(Gf.Rotation(Gf.Vec3d(0, 1, 0), 45.0 * i).GetQuat()) for i in range(4)]
    outer.CreateOrientationsAttr(Vt.QuathArray(half))
    for frame, share in ease(*keys).items():
        at = [(-0.4, 0.4, 0), (0.4, 0.4, 0), (0, 1.0 + 0.3 * share, 0), (0, 2, 0)]
        outer.CreatePositionsAttr().Set(points(at), frame)


def solids(stage: Usd.Stage, path: str, looks: Looks) -> None:
    """A tapered capsule and a tapered cylinder."""
    UsdGeom.Xform.Define(stage, path)
    capsule = UsdGeom.Capsule_1.Define(stage, f"{path}/capsule")
    capsule.CreateRadiusBottomAttr(0.3)
    capsule.CreateRadiusTopAttr(0.15)
    capsule.CreateHeightAttr(0.6)
    capsule.CreateAxisAttr("Y")
    capsule.AddTranslateOp().Set(Gf.Vec3d(-0.4, 0.6, 0))
    bind(capsule.GetPrim(), looks["green"])
    cylinder = UsdGeom.Cylinder_1.Define(stage, f"{path}/cylinder")
    cylinder.CreateRadiusBottomAttr(0.35)
    cylinder.CreateRadiusTopAttr(0.12)
    cylinder.CreateHeightAttr(1.0)
    cylinder.CreateAxisAttr("Y")
    cylinder.AddTranslateOp().Set(Gf.Vec3d(0.4, 0.5, 0))
    bind(cylinder.GetPrim(), looks["specular"])


def arm(stage: Usd.Stage, path: str, looks: Looks, keys: tuple[int, int]) -> None:
    """A post of two joints that bends, and a blend shape that swells it."""
    root = UsdSkel.Root.Define(stage, path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/skeleton")
    skeleton.CreateJointsAttr(["lower", "lower/upper"])
    bind_pose = [Gf.Matrix4d(1), Gf.Matrix4d().SetTranslate(Gf.Vec3d(0, 0.8, 0))]
    skeleton.CreateBindTransformsAttr(bind_pose)
    skeleton.CreateRestTransformsAttr(bind_pose)
    motion = UsdSkel.Animation.Define(stage, f"{path}/motion")
    motion.CreateJointsAttr(["lower", "lower/upper"])
    motion.CreateBlendShapesAttr(["swell"])
    motion.SetTransforms(bind_pose, Usd.TimeCode.Default())
    for frame, share in ease(*keys).items():
        turn = Gf.Rotation(Gf.Vec3d(0, 0, 1), 50.0 * share).GetQuat()
        motion.GetRotationsAttr().Set(Vt.QuatfArray([Gf.Quatf(1), Gf.Quatf(turn)]), frame)
        motion.CreateBlendShapeWeightsAttr().Set([share], frame)
    levels = np.linspace(0, 1.6, 9)
    at = [(x * 0.2, y, z * 0.2) for y in levels for x, z in ((-1, 1), (1, 1), (1, -1), (-1, -1))]
    faces = [
        [4 * k + i, 4 * k + (i + 1) % 4, 4 * k + 4 + (i + 1) % 4, 4 * k + 4 + i]
        for k in range(8)
        for i in range(4)
    ]
    skin = mesh(stage, f"{path}/skin", at, [*faces, [3, 2, 1, 0], [32, 33, 34, 35]], "catmullClark")
    bind(skin.GetPrim(), looks["plum"])
    binding = UsdSkel.BindingAPI.Apply(skin.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
        [motion.GetPath()]
    )
    upper = np.clip((np.repeat(levels, 4) - 0.5) / 0.6, 0, 1)
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * len(at))
    weights = np.stack([1 - upper, upper], axis=1).ravel().astype("f4")
    binding.CreateJointWeightsPrimvar(False, 2).Set(Vt.FloatArray.FromNumpy(weights))
    shape = UsdSkel.BlendShape.Define(stage, f"{path}/skin/swell")
    bulge = np.exp(-((np.repeat(levels, 4) - 0.4) ** 2) / 0.03)[:, None]
    shape.CreateOffsetsAttr(points(np.array(at) * (0.8, 0, 0.8) * bulge))
    binding.CreateBlendShapesAttr(["swell"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    root.GetPrim()


def hidden(stage: Usd.Stage, path: str, keys: tuple[int, int]) -> None:
    """A proxy that is not rendered, and a sphere whose radius grows."""
    proxy = UsdGeom.Cube.Define(stage, f"{path}/proxy")
    proxy.CreateSizeAttr(5.0)
    proxy.CreatePurposeAttr(UsdGeom.Tokens.proxy)
    ball = UsdGeom.Sphere.Define(stage, f"{path}/ball")
    ball.AddTranslateOp().Set(Gf.Vec3d(0, 0.5, 0))
    set_keys(ball.CreateRadiusAttr(), ramp(*keys, 0.3, 0.5))
    ball.CreateDisplayColorAttr([Gf.Vec3f(0.2, 0.5, 0.6)])
