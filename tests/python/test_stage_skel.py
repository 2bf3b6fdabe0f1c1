# SPDX-License-Identifier: Apache-2.0
"""UsdSkel: what is skinned lies where UsdSkel bakes it, and changes only if it moved."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from cli_support import irt
from conftest import CAMERA, MakeShot
from irt_usd.report import Report
from irt_usd.stage import ObjectState, ReadOptions, ShotReader, open_stage

JOINTS = "int[] primvars:skel:jointIndices = {} (\n elementSize = {}\n interpolation = {}\n)\n"
WEIGHTS = "float[] primvars:skel:jointWeights = {} (\n elementSize = {}\n interpolation = {}\n)\n"


def influences(
    indices: str = "[0,1, 0,1, 1,0, 1,0]",
    weights: str = "[1,0, 0.75,0.25, 1,0, 0.5,0.5]",
    per_point: int = 2,
    interpolation: str = '"vertex"',
) -> str:
    return JOINTS.format(indices, per_point, interpolation) + WEIGHTS.format(
        weights, per_point, interpolation
    )


SHAPES = """
    uniform token[] skel:blendShapes = ["swell", "lean"]
    rel skel:blendShapeTargets = [</R/M/Swell>, </R/M/Lean>]
    def BlendShape "Swell"
    {
        uniform vector3f[] offsets = [(0, 0, 1), (0, 0, 2)]
        uniform vector3f[] normalOffsets = [(1, 0, 0), (0, 1, 0)]
        uniform int[] pointIndices = [1, 3]
        uniform vector3f[] inbetweens:half = [(0, 1, 0), (0, 2, 0)] (
            weight = 0.5
        )
    }
    def BlendShape "Lean"
    {
        uniform vector3f[] offsets = [(1, 0, 0), (1, 0, 0), (2, 0, 0), (2, 0, 0)]
    }
"""

BIND = "matrix4d primvars:skel:geomBindTransform = ((2,0,0,0),(0,1,0,0),(0,0,1,0),(1,0,0,1))\n"
MOVED = (
    "double3 xformOp:translate.timeSamples = { 1: (5, 5, 5), 9: (6, 5, 5) }\n"
    'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
)
NORMALS = "normal3f[] normals = [(0,0,1), (0,0,1), (0.6,0,0.8), (0.6,0,0.8)]\n"
CORNER_NORMALS = NORMALS.replace("\n", ' (\n interpolation = "faceVarying"\n)\n')

ANIMATION = """
    def SkelAnimation "Anim"
    {
        uniform token[] joints = ["A/B", "A"]
        float3[] translations = [(0, 2, 0), (0, 0, 0)]
        quatf[] rotations.timeSamples = {
            1: [(1, 0, 0, 0), (1, 0, 0, 0)],
            2: [(0.6, 0.8, 0, 0), (0.6, 0, 0.8, 0)],
            3: [(0.8, 0, 0, 0.6), (0.96, 0, 0.28, 0)],
            4: [(0.8, 0, 0, 0.6), (0.96, 0, 0.28, 0)],
        }
        half3[] scales = [(1, 1, 1), (1, 1.5, 1)]
        uniform token[] blendShapes = ["lean", "swell"]
        float[] blendShapeWeights.timeSamples = { 1: [0, 0], 2: [0.25, 0.3], 3: [0, 0.75] }
    }
"""


def skeleton(
    rest: str = "restTransforms", bind: str = "bindTransforms", inner: str = "animationSource"
) -> str:
    one = "(1,0,0,0),(0,1,0,0),(0,0,1,0)"
    return f"""
    def Skeleton "Skel" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 0), 4: (0, 0, 0), 5: (1, 0, 0) }}
        uniform token[] xformOpOrder = ["xformOp:translate"]
        uniform token[] joints = ["A", "A/B"]
        uniform matrix4d[] {bind} = [({one},(0,0,0,1)), ({one},(0,2,0,1))]
        uniform matrix4d[] {rest} = [({one},(0,0,0,1)), ({one},(0,2,0,1))]
        rel skel:{inner} = </R/Anim>
    }}
"""


def mesh(body: str, name: str = "M") -> str:
    return f"""
    def Mesh "{name}" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform token subdivisionScheme = "none"
        point3f[] points = [(0,0,0), (1,0,0), (1,4,0), (0,4,0)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [3, 0, 1, 2]
        {body}
    }}
"""


def rooted(*parts: str, binding: str = "rel skel:skeleton = </R/Skel>") -> str:
    return f"""
def SkelRoot "R" (
    prepend apiSchemas = ["SkelBindingAPI"]
)
{{
    {binding}
    {"".join(parts)}
}}
"""


def rigged(body: str) -> str:
    return rooted(skeleton(), ANIMATION, mesh(body))


CUBE = f"""
    def Cube "M" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        {BIND}
        {influences("[1, 0]", "[0.5, 0.5]", 2, '"constant"')}
    }}
"""


def world_points(state: ObjectState) -> NDArray[np.float64]:
    points = np.asarray(state.shape.attributes["points"], np.float64)
    homogeneous = np.hstack([points, np.ones((len(points), 1))])
    return (homogeneous @ state.world_from_object)[:, :3]


def baked(path: Path, time: float) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Points and normals of /R/M in world space, as UsdSkel.BakeSkinning has them."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(Sdf.Layer.FindOrOpen(str(path)))
    stage = Usd.Stage.Open(layer)
    assert UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetPrimAtPath("/R")), Gf.Interval(1, 9))
    prim = UsdGeom.Mesh(stage.GetPrimAtPath("/R/M"))
    world = np.array(prim.ComputeLocalToWorldTransform(time))
    points = np.asarray(prim.GetPointsAttr().Get(time), np.float64)
    placed = np.hstack([points, np.ones((len(points), 1))]) @ world
    normals = prim.GetNormalsAttr().Get(time)
    return placed[:, :3], None if normals is None else np.asarray(normals, np.float64)


BODIES = pytest.mark.parametrize(
    "body",
    [
        influences(),
        influences() + SHAPES,
        influences() + BIND + MOVED,
        influences() + SHAPES + BIND + MOVED + NORMALS,
        influences() + CORNER_NORMALS,
        influences() + 'uniform token primvars:skel:skinningMethod = "dualQuaternion"\n',
        influences() + 'uniform token[] skel:joints = ["A/B", "A"]\n',
        influences("[1, 0]", "[0.5, 0.5]", 2, '"constant"'),
        influences("[1, 0]", "[0.5, 0.5]", 2, '"constant"') + SHAPES,
        SHAPES + MOVED,
    ],
)


@BODIES
@pytest.mark.parametrize("time", [1, 2, 3])
def test_as_baked(shot: MakeShot, body: str, time: float) -> None:
    made = shot(rigged(body))
    state = made.read(time).objects["/R/M"]
    points, normals = baked(made.path, time)
    np.testing.assert_allclose(world_points(state), points, atol=1e-5)
    if normals is not None and "normals" in body:
        ours = np.asarray(state.shape.attributes["normals"], np.float64)
        ours = ours / np.linalg.norm(ours, axis=1, keepdims=True)
        if "BlendShape" not in body:  # BakeSkinning leaves their normal offsets out
            np.testing.assert_allclose(ours, normals, atol=1e-5)
    assert not made.notices("skipped")


@BODIES
def test_one_frame_alone_is_the_same_bits(shot: MakeShot, body: str) -> None:
    made = shot(rigged(body), frames=[1.0, 2.0, 3.0])
    for time in (1.0, 2.0, 3.0, 2.0):
        state = made.read(time).objects["/R/M"]
        reader = ShotReader(open_stage(str(made.path)), ReadOptions(), Report(), [time])
        fresh = reader.read(time).objects["/R/M"]
        assert state.world_from_object.tobytes() == fresh.world_from_object.tobytes()
        for name, value in state.shape.attributes.items():
            assert np.array_equal(np.asarray(value), np.asarray(fresh.shape.attributes[name])), name


def test_bent_by_a_right_angle(shot: MakeShot) -> None:
    """In closed form: the outer joint turns by 90 degrees about z, at (0, 2, 0)."""
    turn = ANIMATION.replace("(0.8, 0, 0, 0.6), (0.96, 0, 0.28, 0)", "(1, 0, 0, 1), (1, 0, 0, 0)")
    turn = turn.replace("(1, 0, 0, 1)", "(0.70710678, 0, 0, 0.70710678)").replace("1.5", "1")
    body = influences("[0, 0, 1, 1]", "[1, 1, 1, 1]", 1)
    state = shot(rooted(skeleton(), turn, mesh(body))).read(3).objects["/R/M"]
    expected = [(0, 0, 0), (1, 0, 0), (-2, 3, 0), (-2, 2, 0)]
    np.testing.assert_allclose(world_points(state), expected, atol=1e-6)


def test_a_solid_is_moved_as_a_whole(shot: MakeShot) -> None:
    made = shot(rooted(skeleton(), ANIMATION, CUBE))
    first, bent = (made.read(t).objects["/R/M"] for t in (1, 3))
    assert first.shape is bent.shape
    np.testing.assert_allclose(first.world_from_object[3], (1, 0, 0, 1), atol=1e-6)
    cache = UsdSkel.Cache()
    root = UsdSkel.Root(made.stage.GetPrimAtPath("/R"))
    cache.Populate(root, Usd.PrimDefaultPredicate)
    skeletons = cache.GetSkelQuery(UsdSkel.Skeleton(made.stage.GetPrimAtPath("/R/Skel")))
    query = cache.GetSkinningQuery(made.stage.GetPrimAtPath("/R/M"))
    posed = query.ComputeSkinnedTransform(skeletons.ComputeSkinningTransforms(3), 3)
    np.testing.assert_allclose(bent.world_from_object, np.array(posed), atol=1e-12)


def test_frames_without_motion_are_no_change(shot: MakeShot) -> None:
    made = shot(rigged(influences() + SHAPES), frames=[1, 2, 3, 4])
    second, third, fourth = (made.read(t).objects["/R/M"] for t in (2, 3, 4))
    assert second is not third
    assert third is fourth


def test_the_skeletons_place_moves_without_deforming(shot: MakeShot) -> None:
    made = shot(rigged(influences()), frames=[4, 5])
    before, after = (made.read(t).objects["/R/M"] for t in (4, 5))
    assert before.shape is after.shape
    assert after.world_from_object[3, 0] == before.world_from_object[3, 0] + 1


def test_the_animation_is_inherited(shot: MakeShot) -> None:
    binding = "rel skel:skeleton = </R/Skel>\nrel skel:animationSource = </R/Anim>"
    alone = rooted(skeleton(inner="other"), ANIMATION, mesh(influences()), binding=binding)
    inherited = shot(alone, name="a.usda").read(3).objects["/R/M"]
    direct = shot(rigged(influences()), name="b.usda").read(3).objects["/R/M"]
    np.testing.assert_array_equal(world_points(inherited), world_points(direct))


def test_without_animation_it_rests(shot: MakeShot) -> None:
    made = shot(rooted(skeleton(), mesh(influences())))
    assert world_points(made.read(3).objects["/R/M"])[2].tolist() == [1, 4, 0]
    assert not made.notices("skipped")


BROKEN_SHAPE = SHAPES.replace("pointIndices = [1, 3]", "pointIndices = [1, 4]")


@pytest.mark.parametrize(
    ("scene", "what"),
    [
        (rigged(influences(indices="[0,1, 0,1, 1,0, 1,2]")), "index 2 names none of the 2 joints"),
        (rigged(influences(indices="[0,1, 0,1, 1,0, 1,-1]")), "index -1 names none of the 2"),
        (rigged(influences("[0, 1, 0]", "[1, 1, 1]", 1)), "3 joint influences"),
        (rigged(influences(weights="[1, 0]")), "joint"),
        (rigged(influences(weights="[1,0, nan,0.25, 1,0, 0.5,0.5]")), "not finite"),
        (rooted(skeleton(), mesh(influences()), binding=""), "no skeleton is bound"),
        (
            rooted(skeleton(), mesh(influences()), binding="rel skel:skeleton = </R/None>"),
            "no skeleton is bound",
        ),
        (rooted(skeleton(bind="others"), ANIMATION, mesh(influences())), "has no pose"),
        (rooted(skeleton(rest="others"), mesh(influences())), "has no pose"),
    ],
)
def test_broken_bindings(
    shot: MakeShot, scene: str, what: str, capfd: pytest.CaptureFixture[str]
) -> None:
    made = shot(scene)
    state = made.read(3).objects["/R/M"]
    assert world_points(state).tolist() == [[0, 0, 0], [1, 0, 0], [1, 4, 0], [0, 4, 0]]
    (notice,) = made.notices("skipped")
    assert what in notice
    assert "undeformed points rendered" in notice
    assert "/R/M" in notice
    assert capfd.readouterr() == ("", "")


def test_infinite_joints(shot: MakeShot) -> None:
    animation = ANIMATION.replace("(0, 2, 0), (0, 0, 0)", "(0, inf, 0), (0, 0, 0)")
    made = shot(rooted(skeleton(), animation, mesh(influences())))
    assert world_points(made.read(3).objects["/R/M"])[1].tolist() == [1, 0, 0]
    assert "NaN or an infinity" in made.notices("skipped")[0]


def test_a_broken_blend_shape_is_left_out(shot: MakeShot) -> None:
    made = shot(rigged(influences() + BROKEN_SHAPE))
    broken = world_points(made.read(3).objects["/R/M"])
    plain = world_points(shot(rigged(influences()), name="p.usda").read(3).objects["/R/M"])
    np.testing.assert_array_equal(broken, plain)
    assert "/R/M/Swell" in made.notices("skipped")[0]


def test_outside_a_root_nothing_is_skinned(shot: MakeShot) -> None:
    made = shot(rigged(influences()).replace("def SkelRoot", "def Xform"))
    assert world_points(made.read(3).objects["/R/M"])[2].tolist() == [1, 4, 0]
    assert any("SkelRoot" in text for text in made.notices("mentioned"))


def test_inside_native_instances(shot: MakeShot, tmp_path: Path) -> None:
    (tmp_path / "rig.usda").write_text(f"#usda 1.0\n{rigged(influences())}")
    instance = (
        'def "{}" (\n instanceable = true\n references = @./rig.usda@</R>\n)\n{{\n'
        " double3 xformOp:translate = ({}, 0, 0)\n"
        ' uniform token[] xformOpOrder = ["xformOp:translate"]\n}}\n'
    )
    made = shot(instance.format("I", 0) + instance.format("J", 7))
    objects = made.read(3).objects
    alone = world_points(shot(rigged(influences()), name="r.usda").read(3).objects["/R/M"])
    np.testing.assert_allclose(world_points(objects["/I/M"]), alone, atol=1e-6)
    moved = alone + np.array([7, 0, 0])
    np.testing.assert_allclose(world_points(objects["/J/M"]), moved, atol=1e-6)
    assert objects["/I/M"].shape is objects["/J/M"].shape


def test_native_instances_of_other_poses_are_their_own(shot: MakeShot, tmp_path: Path) -> None:
    unbound = rigged(influences()).replace("rel skel:animationSource", "custom rel ignored")
    (tmp_path / "rig.usda").write_text(f"#usda 1.0\n{unbound}")
    pose = (
        'def SkelAnimation "{0}Pose"\n{{\n uniform token[] joints = ["A"]\n'
        " float3[] translations = [(0, 0, 0)]\n quatf[] rotations = [{1}]\n"
        ' half3[] scales = [(1, 1, 1)]\n}}\ndef "{0}" (\n instanceable = true\n'
        ' references = @./rig.usda@</R>\n prepend apiSchemas = ["SkelBindingAPI"]\n)\n{{\n'
        " rel skel:animationSource = </{2}Pose>\n}}\n"
    )
    still, turned = "(1, 0, 0, 0)", "(0.6, 0.8, 0, 0)"
    made = shot(
        pose.format("I", still, "I") + pose.format("J", turned, "J") + pose.format("K", still, "J")
    )
    objects = made.read(3).objects
    shapes = [objects[f"/{name}/M"].shape for name in "IJK"]
    assert shapes[1] is shapes[2]
    assert shapes[0] is not shapes[1]
    different = world_points(objects["/I/M"]) - world_points(objects["/J/M"])
    assert np.abs(different).max() > 0.1


def test_updates_are_exact(tmp_path: Path) -> None:
    path = tmp_path / "shot.usda"
    head = "#usda 1.0\n(\n startTimeCode = 1\n endTimeCode = 5\n)\n"
    path.write_text(head + rigged(influences() + SHAPES + NORMALS) + CAMERA)
    result = irt("verify", str(path), "--size", "40x40", "-q")
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("kind", ["Points", "BasisCurves"])
def test_points_and_curves_are_skinned_as_meshes_are(shot: MakeShot, kind: str) -> None:
    body = influences() + BIND + SHAPES
    own = "float[] widths = [1, 1, 1, 1]\nint[] curveVertexCounts = [4]\n"
    skinned = rigged(body + own).replace('def Mesh "M"', f'def {kind} "M"')
    of_mesh, of_kind = shot(rigged(body), name="mesh.usda"), shot(skinned)
    for time in (1, 2, 3, 5):
        expected = world_points(of_mesh.read(time).objects["/R/M"])
        assert (world_points(of_kind.read(time).objects["/R/M"]) == expected).all()
    assert not of_kind.notices("skipped")
