# SPDX-License-Identifier: Apache-2.0
"""Meshes: topology, normals in every interpolation, and what is wrong with them."""

from typing import Any

import numpy as np
import pytest

from conftest import MakeShot, ReadShot
from irt_usd import _core
from irt_usd.stage import ReadOptions

QUADS = """
int[] faceVertexCounts = [4, 4]
int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2]
point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (2,0,0), (2,1,0)]
"""
PLAIN = 'uniform token subdivisionScheme = "none"\n' + QUADS


def mesh(body: str) -> str:
    return f'def Mesh "M"\n{{\n{body}\n}}'


def attributes(made: ReadShot, time: float = 1) -> dict[str, Any]:
    return dict(made.read(time).objects["/M"].shape.attributes)


def test_polygons_arrive_as_authored(shot: MakeShot) -> None:
    made = shot(mesh(PLAIN))
    values = attributes(made)
    assert values["points"].dtype == np.float32
    assert values["points"].shape == (6, 3)
    assert values["faceVertexCounts"].tolist() == [4, 4]
    assert values["faceVertexIndices"].dtype == np.int32
    assert values["normals"] is None
    assert values["doubleSided"] is None
    assert made.report.notices[0].message.startswith("no lights")
    assert len(made.report.notices) == 1


def test_bad_creases_are_left_out(shot: MakeShot) -> None:
    creases = "int[] creaseIndices = [0, 77]\nint[] creaseLengths = [2]\n"
    body = QUADS + creases + "float[] creaseSharpnesses = [1]"
    made = shot(mesh(body), options=ReadOptions(level=2))
    geometry = made.read().objects["/M"].shape.geometry()
    assert isinstance(geometry, _core.Mesh)
    assert len(geometry.points) == 45
    (text,) = made.notices("skipped")
    assert "subdivided without crease 0: it names point 77, but there are 6" in text


def test_what_cannot_be_subdivided_is_the_control_cage(shot: MakeShot) -> None:
    body = QUADS + 'uniform token subdivisionScheme = "loop"'
    made = shot(mesh(body), options=ReadOptions(level=2))
    geometry = made.read().objects["/M"].shape.geometry()
    assert isinstance(geometry, _core.Mesh)
    assert len(geometry.points) == 6
    (text,) = made.notices("skipped")
    assert "not subdivided, the control cage is rendered: Loop subdivision takes" in text


def test_subdivision_by_level(shot: MakeShot) -> None:
    for level, faces in ((0, 2), (1, 8), (2, 32)):
        made = shot(mesh(QUADS), options=ReadOptions(level=level))
        geometry = made.read().objects["/M"].shape.geometry()
        assert isinstance(geometry, _core.Mesh)
        assert len(geometry.face_vertex_counts) == faces
        assert not made.notices("unsupported")


def normals(count: int, name: str = "normal3f[] normals", interpolation: str = "vertex") -> str:
    values = ", ".join(f"({i},0,1)" for i in range(count))
    return f'{name} = [{values}] (\ninterpolation = "{interpolation}"\n)\n'


@pytest.mark.parametrize("name", ["normal3f[] normals", "normal3f[] primvars:normals"])
@pytest.mark.parametrize(
    ("interpolation", "count", "core_name"),
    [
        ("constant", 1, "constant"),
        ("uniform", 2, "uniform"),
        ("vertex", 6, "vertex"),
        ("varying", 6, "vertex"),
        ("faceVarying", 8, "faceVarying"),
    ],
)
def test_normals(shot: MakeShot, name: str, interpolation: str, count: int, core_name: str) -> None:
    made = shot(mesh(PLAIN + normals(count, name, interpolation)))
    values = attributes(made)
    assert values["normals"].shape == (count, 3)
    assert values["normals:interpolation"] == core_name


def test_primvar_normals_win(shot: MakeShot) -> None:
    both = normals(6) + normals(2, "normal3f[] primvars:normals", "uniform")
    assert attributes(shot(mesh(PLAIN + both)))["normals:interpolation"] == "uniform"


def test_indexed_normals_are_flattened(shot: MakeShot) -> None:
    primvar = normals(3, "normal3f[] primvars:normals", "faceVarying")
    indices = "int[] primvars:normals:indices = [0, 1, 2, 0, 2, 1, 0, 2]"
    values = attributes(shot(mesh(PLAIN + primvar + indices)))
    assert values["normals"][:, 0].tolist() == [0, 1, 2, 0, 2, 1, 0, 2]


@pytest.mark.parametrize(
    "bad",
    [
        normals(5),
        normals(6, interpolation="uniform"),
        "normal3f[] normals = [(0,0,nan), (0,0,1), (0,0,1), (0,0,1), (0,0,1), (0,0,1)]",
        "float[] normals = [1, 2, 3, 4, 5, 6]",
        normals(3, "normal3f[] primvars:normals", "faceVarying")
        + "int[] primvars:normals:indices = [0, 1, 2, 0, 2, 1, 0, 3]",
        normals(3, "normal3f[] primvars:normals", "faceVarying")
        + "float[] primvars:normals:indices = [0, 1, 2, 0, 2, 1, 0, 2]",
    ],
)
def test_broken_normals_give_facets_and_say_so(shot: MakeShot, bad: str) -> None:
    made = shot(mesh(PLAIN + bad))
    assert attributes(made)["normals"] is None
    (text,) = made.notices("skipped")
    assert "facets rendered instead" in text
    assert "/M." in text


def test_holes_are_taken_out_with_their_normals(shot: MakeShot) -> None:
    holes = "int[] holeIndices = [0]\n"
    values = attributes(shot(mesh(PLAIN + holes + normals(8, interpolation="faceVarying"))))
    assert values["faceVertexIndices"].tolist() == [1, 4, 5, 2]
    assert values["normals"][:, 0].tolist() == [4, 5, 6, 7]
    values = attributes(shot(mesh(PLAIN + holes + normals(2, interpolation="uniform"))))
    assert values["normals"][:, 0].tolist() == [1]


def test_sides_and_orientation(shot: MakeShot) -> None:
    single = 'uniform bool doubleSided = 0\nuniform token orientation = "leftHanded"\n'
    values = attributes(shot(mesh(PLAIN + single)))
    assert values["doubleSided"] is False
    assert values["orientation"] == "leftHanded"


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("[4, 4]", "[4, 5]", "/M.faceVertexCounts"),
        ("[4, 4]", "[9, -1]", "/M.faceVertexCounts"),
        ("1, 4, 5, 2]", "1, 4, 6, 2]", "/M.faceVertexIndices"),
        ("1, 4, 5, 2]", "1, 4, -1, 2]", "/M.faceVertexIndices"),
        (
            "int[] faceVertexIndices = [0",
            "int64[] faceVertexIndices = [4294967296",
            "/M.faceVertexI",
        ),
        ("(2,1,0)]", "(2,nan,0)]", "/M.points"),
        ("(2,1,0)]", "(2,inf,0)]", "/M.points"),
        ("point3f[] points = [", 'token[] points = ["a"]\nint[] rest = [1]\n#', "/M.points"),
        ("int[] faceVertexCounts", "float[] faceVertexCounts", "/M.faceVertexCounts"),
        ("int[] faceVertexCounts", "int[] holeIndices = [2]\nint[] faceVertexCounts", "/M.holeI"),
    ],
)
def test_broken_mesh_is_skipped_and_located(shot: MakeShot, old: str, new: str, where: str) -> None:
    made = shot(mesh(PLAIN.replace(old, new)) + '\ndef Sphere "S"\n{\n}')
    assert list(made.read().objects) == ["/S"]
    (text,) = made.notices("skipped")
    assert where in text
    assert "shot.usda" in text


def test_points_beyond_single_precision(shot: MakeShot) -> None:
    scale = "double3 xformOp:scale = (1e30, 1e30, 1e30)\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:scale"]\n'
    made = shot(mesh(PLAIN.replace("(2,1,0)", "(2e20,1,0)") + scale + order))
    assert not made.read().objects
    assert "single precision" in made.notices("skipped")[0]


@pytest.mark.parametrize("body", ["", "point3f[] points = []", QUADS.split("point3f")[0]])
def test_empty_mesh_is_mentioned(shot: MakeShot, body: str) -> None:
    made = shot(mesh(body))
    assert not made.read().objects
    assert "note: empty mesh: /M" in made.notices("mentioned")
    assert not made.notices("skipped")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("1, 4, 5, 2]", "1, 1, 5, 2]"),
        ("[4, 4]\n", "[4, 2, 2]\n"),
        ("(2,0,0), (2,1,0)", "(1,2,0), (1,3,0)"),
    ],
)
def test_degenerate_faces(shot: MakeShot, old: str, new: str) -> None:
    made = shot(mesh(PLAIN.replace(old, new)))
    assert made.read().objects
    said = any("degenerate" in text for text in made.notices("mentioned"))
    assert said == ("1, 1, 5" not in new)  # a quad with a doubled corner is a triangle


def test_points_that_vary(shot: MakeShot) -> None:
    first_line, at_rest = PLAIN.rstrip().rsplit("\n", 1)
    points = at_rest.split(" = ")[1]
    raised = points.replace("(0,0,0)", "(0,0,1)")
    keys = f"point3f[] points.timeSamples = {{\n1: {points},\n2: {raised},\n5: {raised},\n}}"
    made = shot(mesh(f"{first_line}\n{keys}"))
    first, second = attributes(made, 1), attributes(made, 2)
    assert first["points"][0].tolist() == [0, 0, 0]
    assert second["points"][0].tolist() == [0, 0, 1]
    assert made.read(3).objects["/M"] is made.read(4).objects["/M"]


def test_topology_that_varies(shot: MakeShot) -> None:
    body = """
uniform token subdivisionScheme = "none"
int[] faceVertexCounts.timeSamples = {
1: [3],
2: [3, 3],
3: [3, 3, 3],
}
int[] faceVertexIndices.timeSamples = {
1: [0, 1, 2],
2: [0, 1, 2, 0, 2, 3],
3: [0, 1, 2],
}
point3f[] points.timeSamples = {
1: [(0,0,0), (1,0,0), (1,1,0)],
2: [(0,0,0), (1,0,0), (1,1,0), (0,1,0)],
}
"""
    made = shot(mesh(body))
    assert len(attributes(made, 1)["faceVertexCounts"]) == 1
    assert len(attributes(made, 2)["faceVertexCounts"]) == 2
    assert not made.read(3).objects
    assert len(attributes(made, 1)["points"]) == 3


def test_core_record_is_shared_while_only_the_place_changes(shot: MakeShot) -> None:
    from irt_usd import _core as core

    ops = "double3 xformOp:translate.timeSamples = {1: (0,0,0), 2: (1,0,0)}\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    made = shot(mesh(PLAIN + normals(8, interpolation="faceVarying") + ops + order))
    first, second = (made.read(t).objects["/M"] for t in (1, 2))
    assert first is not second
    assert isinstance(first.shape.geometry(), core.Mesh)
    assert first.shape.geometry() is second.shape.geometry()
