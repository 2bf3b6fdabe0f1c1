# SPDX-License-Identifier: Apache-2.0
"""Point instancers and native instances: what is read of them, shared, left out and told."""

from typing import Any

import numpy as np
import pytest

from conftest import MakeShot, ReadShot
from irt_usd import _core
from irt_usd.changes import diff
from irt_usd.stage import ObjectState, Snapshot

PROTOTYPES = """
    def Xform "P0" {
        double3 xformOp:translate = (0, 2, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Sphere "ball" {
double radius = 0.5
}
        def Cube "guide" {
uniform token purpose = "guide"
}
        def Cube "away" {
token visibility = "invisible"
}
    }
    def Cube "P1" {
double size = 1
}
"""


def instancer(arrays: str, prototypes: str = PROTOTYPES, rel: str = "</I/P0>, </I/P1>") -> str:
    return f"""
def PointInstancer "I" {{
    rel prototypes = [{rel}]
    {arrays}
    {prototypes}
}}
"""


ROW = """
    int[] protoIndices = [0, 1, 0, 1]
    point3f[] positions = [(0, 0, 0), (2, 0, 0), (4, 0, 0), (6, 0, 0)]
"""


def instances(snapshot: Snapshot, path: str = "/I") -> ObjectState:
    return snapshot.objects[path]


def values_of(snapshot: Snapshot) -> dict[str, Any]:
    return instances(snapshot).attributes


def keys(snapshot: Snapshot) -> list[int]:
    return list(values_of(snapshot)["keys"])


def test_an_instancer_is_one_object(shot: MakeShot) -> None:
    read = shot(instancer(ROW)).read()
    assert list(read.objects) == ["/I"]
    values = values_of(read)
    assert values["typeName"] == "PointInstancer"
    assert keys(read) == [0, 1, 2, 3]
    assert list(values["protoIndices"]) == [0, 1, 0, 1]
    rows = values["array_from_prototype"]
    assert rows.dtype == np.float64
    assert rows.shape == (4, 4, 3)
    assert rows[2].tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [4, 0, 0]]
    # Only what is drawn, in the space of the prototype's parent: its own transform counts.
    assert values["/I/P0/ball.radius"] == 0.5
    assert not any("guide" in name or "away" in name for name in values)
    assert values["/I/P0/ball.world_from_object"][3].tolist() == [0, 2, 0, 1]


def test_orientations_and_scales_compose_as_usd_does(shot: MakeShot) -> None:
    arrays = (
        ROW
        + """
    quath[] orientations = [(1, 0, 0, 0), (0.6, 0, 0, 0.8), (0, 1, 0, 0), (0.5, 0.5, 0.5, 0.5)]
    float3[] scales = [(1, 1, 1), (2, 1, 0.5), (1, -1, 1), (3, 3, 3)]
    """
    )
    rows = values_of(shot(instancer(arrays)).read())["array_from_prototype"]
    # A turn by twice 53.13 degrees about z, after the scale.
    half = np.float16(0.6), np.float16(0.8)
    c, s = float(half[0]) ** 2 - float(half[1]) ** 2, 2 * float(half[0]) * float(half[1])
    np.testing.assert_allclose(rows[1, :3], [[2 * c, 2 * s, 0], [-s, c, 0], [0, 0, 0.5]], atol=2e-3)
    np.testing.assert_allclose(rows[2, :3], [[1, 0, 0], [0, 1, 0], [0, 0, -1]], atol=1e-6)


def test_ids_name_entries_wherever_they_stand(shot: MakeShot) -> None:
    arrays = """
    int[] protoIndices = [0, 0, 0]
    point3f[] positions.timeSamples = {
        1: [(0, 0, 0), (2, 0, 0), (4, 0, 0)], 2: [(4, 0, 0), (0, 0, 0), (2, 0, 1)] }
    int64[] ids.timeSamples = { 1: [7, 3, 5], 2: [5, 7, 3] }
    """
    opened = shot(instancer(arrays), frames=(1.0, 2.0))
    first, second = opened.read(1.0), opened.read(2.0)
    assert keys(first) == keys(second) == [3, 5, 7]
    changes = diff(first, second)
    assert [(c.path, c.attribute) for c in changes.changes] == [("/I[3]", "array_from_prototype")]
    assert changes.summary() == "1 rearranged"


def test_masked_entries_are_not_there(shot: MakeShot) -> None:
    arrays = ROW + "int64[] invisibleIds.timeSamples = { 1: [], 2: [1], 3: [1, 2] }"
    opened = shot(instancer(arrays), frames=(1.0, 2.0, 3.0))
    first, second, third = (opened.read(t) for t in (1.0, 2.0, 3.0))
    assert (keys(first), keys(second), keys(third)) == ([0, 1, 2, 3], [0, 2, 3], [0, 3])
    told = [(c.path, c.attribute) for c in diff(first, second).changes]
    assert told == [("/I[1]", "(removed)")]
    inactive = instancer(ROW).replace('"I" {', '"I" (\n inactiveIds = [0, 3]\n) {')
    assert keys(shot(inactive, name="inactive.usda").read()) == [1, 2]


def test_many_changes_are_counted(shot: MakeShot) -> None:
    points = ", ".join(f"({i}, 0, 0)" for i in range(40))
    later = ", ".join(f"({i}, 1, 0)" for i in range(39))
    arrays = f"""
    int[] protoIndices.timeSamples = {{ 1: {[0] * 40}, 2: {[0] * 39} }}
    point3f[] positions.timeSamples = {{ 1: [{points}], 2: [{later}] }}
    """
    opened = shot(instancer(arrays), frames=(1.0, 2.0))
    (change,) = diff(opened.read(1.0), opened.read(2.0)).changes
    assert (change.path, change.attribute) == ("/I", "instances")
    assert change.new == "39 moved, 1 removed"


def test_what_cannot_be_drawn_is_left_out_and_counted(shot: MakeShot) -> None:
    arrays = """
    int[] protoIndices = [0, 5, 0, -1, 1]
    point3f[] positions = [(0, 0, 0), (2, 0, 0), (nan, 0, 0), (6, 0, 0), (8, 0, 0)]
    float3[] scales = [(1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 0, 1)]
    """
    opened = shot(instancer(arrays))
    assert keys(opened.read()) == [0]
    skipped = "\n".join(opened.notices("skipped"))
    assert "2 of 5 instances are left out: no prototype of that index; expected 0 to 1" in skipped
    assert "2 of 5 instances are left out: a transform that is singular" in skipped
    assert "/I.protoIndices" in skipped
    assert "/I.scales" in skipped


def test_arrays_that_do_not_fit_are_reported(shot: MakeShot) -> None:
    for extra, text in (
        ("float3[] scales = [(1, 1, 1)]", "there are 1 scales; expected 4"),
        ("quath[] orientations = [(1, 0, 0, 0)]", "there are 1 orientations; expected 4"),
    ):
        opened = shot(instancer(ROW + extra), name=f"{len(text)}.usda")
        assert not opened.read().objects
        assert text in opened.notices("skipped")[0]
    for rel, text in (("", "without prototypes"), ("</None>", "a prototype does not exist")):
        opened = shot(instancer(ROW, rel=rel), name=f"rel{len(rel)}.usda")
        assert not opened.read().objects
        assert text in opened.notices("skipped")[0]
    opened = shot(instancer(ROW + "int64[] ids = [1, 1, 2, 3]"), name="ids.usda")
    assert keys(opened.read()) == [0, 1, 2, 3]
    assert "name two instances" in opened.notices("skipped")[0]


def test_prototypes_elsewhere_and_of_every_specifier(shot: MakeShot) -> None:
    body = """
over "Shelf" {
 def Sphere "ball" {}
}
class "Kind" {
 def Cube "cube" {}
}
def Sphere "shown" {}
""" + instancer(ROW.replace("[0, 1, 0, 1]", "[0, 1, 2, 1]"), "", "</Shelf>, </Kind>, </shown>")
    read = shot(body).read()
    assert sorted(read.objects) == ["/I", "/shown"]
    values = values_of(read)
    assert values["/Shelf/ball.typeName"] == "Sphere"
    assert values["/shown.typeName"] == "Sphere"


def test_instancers_nest_but_not_in_themselves(shot: MakeShot) -> None:
    inner = """
    def PointInstancer "P0" {
        rel prototypes = [</I/P0/B>]
        int[] protoIndices = [0, 0]
        point3f[] positions.timeSamples = { 1: [(0, 0, 0), (0, 1, 0)], 2: [(0, 0, 0), (0, 2, 0)] }
        def Sphere "B" {}
    }
    def Cube "P1" {}
    """
    opened = shot(instancer(ROW, inner), frames=(1.0, 2.0))
    first, second = opened.read(1.0), opened.read(2.0)
    assert list(first.objects) == ["/I"]
    assert instances(first) is not instances(second)
    looped = shot(instancer(ROW, PROTOTYPES, "</I>, </I/P1>"), name="loop.usda")
    looped.read()
    assert "holds the instancer itself" in looped.notices("skipped")[0]


COLORS = "color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0)]"


def colors(interpolation: str = "vertex", declared: str = COLORS) -> str:
    return f'{declared} (interpolation = "{interpolation}")\n'


@pytest.mark.parametrize("interpolation", ["vertex", "varying", "faceVarying"])
def test_primvars_by_instance(shot: MakeShot, interpolation: str) -> None:
    opened = shot(instancer(ROW + colors(interpolation) + "int64[] ids = [9, 7, 5, 3]"))
    values = values_of(opened.read())
    assert list(values["keys"]) == [3, 5, 7, 9]
    shown = values["primvars:displayColor"].tolist()
    assert shown == [[1, 1, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]]
    assert not opened.notices("skipped")
    assert not opened.notices("unsupported")


def test_masked_entries_have_no_primvars(shot: MakeShot) -> None:
    indexed = (
        COLORS + ' (interpolation = "vertex")\nint[] primvars:displayColor:indices = [3, 2, 1, 0]\n'
    )
    opened = shot(instancer(ROW + indexed + "int64[] invisibleIds = [1]"))
    values = values_of(opened.read())
    taken = values["primvars:displayColor"][values["primvars:displayColor:indices"]]
    assert taken.tolist() == [[1, 1, 0], [0, 1, 0], [1, 0, 0]]


@pytest.mark.parametrize("interpolation", ["constant", "uniform"])
def test_primvars_of_all_instances(shot: MakeShot, interpolation: str) -> None:
    one = colors(interpolation, "color3f[] primvars:displayColor = [(1, 0, 0)]")
    body = 'def Sphere "B" {}' + instancer(ROW.replace("1", "0"), "", "</B>").replace(
        "rel prototypes", one + "rel prototypes"
    )
    values = values_of(shot(body).read())
    assert values["primvars:displayColor"].tolist() == [[1, 0, 0]]
    assert values["primvars:displayColor:interpolation"] == "constant"


def test_primvars_of_the_wrong_size_are_reported(shot: MakeShot) -> None:
    wrong = colors("vertex", "color3f[] primvars:displayColor = [(1, 0, 0)]")
    opened = shot(instancer(ROW + wrong))
    assert "primvars:displayColor" not in values_of(opened.read())
    assert "it has 1 elements, expected 4" in opened.notices("skipped")[0]


def seen(opened: ReadShot, time: float = 1.0) -> np.ndarray:
    """The colours at the centres of the instances of ROW, lit from the camera."""
    camera = _core.Camera(translated(3, 0.5, 20), (-4, 4, -1, 1), True)
    view = _core.ViewSettings(80, 20, aovs=("albedo",))
    renderer = _core.Renderer(camera, view, history=False)
    renderer.update(diff(None, opened.read(time)).core)
    albedo = renderer.aov("albedo")
    return np.array([albedo[14, 9 + 20 * i] for i in range(4)]).round(5)


def translated(*offset: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[3, :3] = offset
    return matrix


def test_instances_are_seen_in_their_colours(shot: MakeShot) -> None:
    balls = 'def Sphere "P0" {\ndouble radius = 0.5\n}\ndef Cube "P1" {\ndouble size = 1\n}\n'
    by_entry = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]]
    assert seen(shot(instancer(ROW + colors(), balls))).tolist() == by_entry
    # What a prim has itself comes first, be it inherited within the prototype.
    own = balls.replace("= 0.5", "= 0.5\ncolor3f[] primvars:displayColor = [(0.5, 0.5, 0.5)]")
    grey = [[0.5] * 3, by_entry[1], [0.5] * 3, by_entry[3]]
    assert seen(shot(instancer(ROW + colors(), own), name="own.usda")).tolist() == grey
    # Animated, it moves nothing.
    declared = 'color3f[] primvars:displayColor (interpolation = "vertex")\n'
    first, second = COLORS.split(" = ")[1].replace("(1, 0, 0)", "(0, 0, 1)"), COLORS.split(" = ")[1]
    keyed = f"color3f[] primvars:displayColor.timeSamples = {{ 1: {first}, 2: {second} }}\n"
    opened = shot(instancer(ROW + declared + keyed, balls), name="keyed.usda", frames=(1.0, 2.0))
    assert seen(opened, 1.0).tolist() == [[0, 0, 1], *by_entry[1:]]
    assert seen(opened, 2.0).tolist() == by_entry
    (change,) = diff(opened.read(1.0), opened.read(2.0)).changes
    assert (change.attribute, change.invalidates) == ("primvars:displayColor", "spawned rays")


def test_the_inner_instancer_gives_first(shot: MakeShot) -> None:
    inner = """
    def PointInstancer "P0" {
        rel prototypes = [</I/P0/B>]
        int[] protoIndices = [0]
        point3f[] positions = [(0, 0, 0)]
        COLOR
        def Sphere "B" {
double radius = 0.5
}
    }
    def Cube "P1" {
double size = 1
}
    """
    outer = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]]
    opened = shot(instancer(ROW + colors(), inner.replace("COLOR", "")))
    assert seen(opened).tolist() == outer
    white = colors("vertex", "color3f[] primvars:displayColor = [(1, 1, 1)]")
    opened = shot(instancer(ROW + colors(), inner.replace("COLOR", white)), name="inner.usda")
    assert seen(opened).tolist() == [[1] * 3, outer[1], [1] * 3, outer[3]]


def test_materials_read_primvars_by_instance(shot: MakeShot) -> None:
    looks = """
def Material "M" {
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/R.outputs:result>
        token outputs:surface
    }
    def Shader "R" {
        uniform token info:id = "UsdPrimvarReader_float3"
        string inputs:varname = "dye"
        float3 outputs:result
    }
}
"""
    bound = """
    def Sphere "P0" (
prepend apiSchemas = ["MaterialBindingAPI"]
) {
double radius = 0.5
rel material:binding = </M>
}
    """
    dyes = COLORS.replace("displayColor", "dye")
    body = looks + instancer(ROW.replace("1", "0") + colors("varying", dyes), bound, "</I/P0>")
    assert seen(shot(body)).tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]]


def test_a_moving_instancer_keeps_its_entries(shot: MakeShot) -> None:
    arrays = (
        ROW
        + """
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (0, 5, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    """
    )
    opened = shot(instancer(arrays), frames=(1.0, 2.0))
    first, second = opened.read(1.0), opened.read(2.0)
    assert instances(first).shape is instances(second).shape
    assert [c.attribute for c in diff(first, second).changes] == ["world_from_object"]


def test_native_instances_share_their_shapes(shot: MakeShot) -> None:
    body = """
class "Tree" {
    def Sphere "crown" {
double radius.timeSamples = { 1: 1, 2: 2 }
}
    def Mesh "trunk" {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        uniform token subdivisionScheme = "none"
    }
}
def Xform "A" (
instanceable = true
inherits = </Tree>
) {
    double3 xformOp:translate = (3, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Xform "B" (
instanceable = true
inherits = </Tree>
) {}
def Xform "C" (
inherits = </Tree>
) {}
"""
    opened = shot(body, frames=(1.0, 2.0))
    read = opened.read(1.0)
    a, b, c = (read.objects[f"/{name}/trunk"] for name in "ABC")
    assert a.shape is b.shape
    assert a.shape is not c.shape
    assert (a.instanced, b.instanced, c.instanced) == (True, True, False)
    assert a.shape.prototype(a.material) is b.shape.prototype(b.material)
    later = opened.read(2.0)
    assert later.objects["/A/crown"].shape is later.objects["/B/crown"].shape
    assert {c.path for c in diff(read, later).changes} == {f"/{n}/crown" for n in "ABC"}
