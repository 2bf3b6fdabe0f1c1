# SPDX-License-Identifier: Apache-2.0
"""Primvars: every interpolation and type, indices, inheritance, change, and what is wrong."""

from collections.abc import Mapping

import numpy as np
import pytest
from pxr import Usd

from irt_usd.report import Report
from irt_usd.stage.mesh import MeshSource
from irt_usd.stage.primvars import PrimvarValue
from irt_usd.stage.quadrics import QuadricSource
from irt_usd.stage.transforms import Node

MESH = """
uniform token subdivisionScheme = "none"
int[] faceVertexCounts = [4, 4]
int[] faceVertexIndices = [0, 1, 2, 3, 1, 4, 5, 2]
point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (2,0,0), (2,1,0)]
"""


def stage(body: str) -> Usd.Stage:
    made = Usd.Stage.CreateInMemory()
    made.GetRootLayer().ImportFromString("#usda 1.0\n" + body)
    return made


def read(
    body: str, wanted: str = "st", kind: str = "Mesh", around: str = ""
) -> tuple[Mapping[str, PrimvarValue], Report]:
    made = stage(f'def Xform "W"\n{{\n{around}\ndef {kind} "P"\n{{\n{body}\n}}\n}}')
    report = Report()
    node = Node(made.GetPrimAtPath("/W/P"), "/W/P", None)
    source = (MeshSource if kind == "Mesh" else QuadricSource)(
        node, report, frozenset(wanted.split())
    )
    shape = source.read(Usd.TimeCode(1))
    assert shape is not None
    shape.geometry()
    return shape._primvars if kind == "Mesh" else shape.primvars, report  # type: ignore[attr-defined]


def values(count: int, width: int = 2) -> str:
    if width == 1:
        return str(list(range(count)))
    return "[" + ", ".join(str(tuple(range(i, i + width))) for i in range(count)) + "]"


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
def test_interpolations(interpolation: str, count: int, core_name: str) -> None:
    body = f'texCoord2f[] primvars:st = {values(count)} (interpolation = "{interpolation}")'
    found, report = read(MESH + body)
    assert found["st"].interpolation == core_name
    assert found["st"].values.tolist() == [[i, i + 1] for i in range(count)]
    assert found["st"].values.dtype == np.float32
    assert found["st"].indices is None
    assert not report.notices


@pytest.mark.parametrize(
    ("kind", "width"),
    [
        ("int[]", 1), ("half[]", 1), ("double[]", 1), ("int64[]", 1), ("half3[]", 3), ("int2[]", 2),
        ("double2[]", 2), ("color4f[]", 4), ("vector3d[]", 3), ("texCoord3h[]", 3),
    ],
)  # fmt: skip
def test_types_are_narrowed(kind: str, width: int) -> None:
    body = f'{kind} primvars:st = {values(6, width)} (interpolation = "vertex")'
    found, report = read(MESH + body)
    assert found["st"].values.tolist() == [list(range(i, i + width)) for i in range(6)]
    assert found["st"].values.dtype == np.float32
    assert not report.notices


def test_single_values_are_constant() -> None:
    found, _ = read(MESH + "float2 primvars:st = (3, 4)\nfloat primvars:w = 2", "st w")
    assert found["st"].values.tolist() == [[3, 4]]
    assert found["w"].values.tolist() == [[2]]
    assert found["w"].interpolation == "constant"


def test_indices() -> None:
    body = f'float2[] primvars:st = {values(3)} (interpolation = "faceVarying")'
    found, report = read(MESH + body + "\nint[] primvars:st:indices = [0, 1, 2, 0, 0, 1, 2, 0]")
    assert found["st"].indices is not None
    assert found["st"].indices.tolist() == [0, 1, 2, 0, 0, 1, 2, 0]
    assert not report.notices


def test_only_what_is_wanted_is_read() -> None:
    found, report = read(MESH + f"float2[] primvars:uv = {values(3)}\nfloat primvars:w = 1", "w")
    assert list(found) == ["w"]
    assert not report.notices


def test_constant_ones_are_inherited_and_others_are_not() -> None:
    around = (
        "color3f primvars:c = (1, 2, 3)\nfloat primvars:own = 1\n"
        'float[] primvars:v = [1, 2, 3, 4, 5, 6] (interpolation = "vertex")'
    )
    found, _ = read(MESH + "float primvars:own = 2", "c own v", around=around)
    assert found["c"].values.tolist() == [[1, 2, 3]]
    assert found["own"].values.tolist() == [[2]]
    assert "v" not in found


def test_holes_take_their_elements_along() -> None:
    holes = "int[] holeIndices = [0]\n"
    uniform = 'float[] primvars:st = [5, 6] (interpolation = "uniform")\n'
    corners = f'float2[] primvars:uv = {values(8)} (interpolation = "faceVarying")'
    found, _ = read(MESH + holes + uniform + corners, "st uv")
    assert found["st"].values.tolist() == [[6]]
    assert found["uv"].values[:, 0].tolist() == [4, 5, 6, 7]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (f'float2[] primvars:st = {values(5)} (interpolation = "vertex")',
         "there are 5 elements; expected 6, the interpolation being vertex"),
        (f'float2[] primvars:st = {values(2)} (interpolation = "faceVarying")',
         "there are 2 elements; expected 8, the interpolation being faceVarying"),
        ('string primvars:st = "name"', "its type is string; expected 1 to 4 numbers"),
        ("matrix4d primvars:st = ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))",
         "its type is matrix4d; expected 1 to 4 numbers"),
        ("double primvars:st = 1e300", "it holds a NaN, or a number beyond single precision;"),
        ("float primvars:st = nan", "it holds a NaN, or a number beyond single precision;"),
        ('float2[] primvars:st = [(1,2)] (elementSize = 2\ninterpolation = "constant")',
         "its elementSize is 2; expected 1"),
        ("""float[] primvars:st = [1] (interpolation = "uniform")
         int[] primvars:st:indices = [0, 1]""",
         "index 1 names none of its 1 values"),
        ('float[] primvars:st = [] (interpolation = "vertex")',
         "there are 0 elements; expected 6, the interpolation being vertex"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_named_and_left_out(body: str, message: str) -> None:
    found, report = read(MESH + body)
    assert not found
    (notice,) = report.notices
    assert notice.severity == "skipped"
    assert notice.message.startswith(f"primvars:st is not used: {message}")
    assert notice.paths[0].startswith("/W/P.primvars:st in anon")


def test_shapes_without_vertices_take_single_elements() -> None:
    body = (
        'color3f[] primvars:c = [(1,0,0)] (interpolation = "vertex")\n'
        'float[] primvars:st = [1, 2] (interpolation = "uniform")'
    )
    found, report = read(body, "c st", kind="Sphere")
    assert list(found) == ["c"]
    assert found["c"].single.interpolation == "constant"
    (notice,) = report.notices
    assert "expected one, the shape having no vertices" in notice.message


def test_time_samples() -> None:
    body = MESH + (
        "float[] primvars:st.timeSamples = { 1: [1, 2], 2: [1, 2], 3: [1, 3] }\n"
        'float[] primvars:st ( interpolation = "uniform" )'
    )
    made = stage(f'def Mesh "P"\n{{\n{body}\n}}')
    node = Node(made.GetPrimAtPath("/P"), "/P", None)
    source = MeshSource(node, Report(), frozenset(["st"]))
    assert source.varies
    shapes = [source.read(Usd.TimeCode(t)) for t in (1, 2, 3)]
    assert shapes[0] is shapes[1]
    assert shapes[2] is not shapes[0]
    assert shapes[2] is not None
    assert np.asarray(shapes[2].attributes["primvars:st"]).tolist() == [[1], [3]]
