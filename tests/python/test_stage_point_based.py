# SPDX-License-Identifier: Apache-2.0
"""Points and curves: widths, counts and topology that vary, and what is wrong with them."""

from typing import Any

import numpy as np
import pytest
from pxr import UsdGeom

from conftest import MakeShot, ReadShot
from irt_usd import _core as core

POINTS = "point3f[] points = [(0,0,0), (1,0,0), (1,1,0)]\n"
CURVES = """
int[] curveVertexCounts = [4, 4]
point3f[] points = [(0,0,0), (1,0,0), (1,1,0), (0,1,0), (2,0,0), (2,1,0), (3,1,0), (3,2,1)]
"""


def points(body: str) -> str:
    return f'def Points "P"\n{{\n{body}\n}}'


def curves(body: str) -> str:
    return f'def BasisCurves "P"\n{{\n{body}\n}}'


def widths(values: str, interpolation: str = "", name: str = "widths") -> str:
    metadata = f' (\ninterpolation = "{interpolation}"\n)' if interpolation else ""
    return f"float[] {name} = [{values}]{metadata}\n"


def attributes(made: ReadShot, time: float = 1) -> dict[str, Any]:
    return dict(made.read(time).objects["/P"].shape.attributes)


def test_points_arrive_as_authored(shot: MakeShot) -> None:
    made = shot(points(POINTS + widths("1, 2, 3")))
    values = attributes(made)
    assert values["points"].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert values["widths"].tolist() == [1, 2, 3]
    assert isinstance(made.read().objects["/P"].shape.geometry(), core.Spheres)
    made.read().objects["/P"].add_to(core.ChangeSet())
    assert len(made.report.notices) == 1  # no lights


@pytest.mark.parametrize(("text", "expected"), [(widths("2", "constant"), [2]), (widths("5"), [5])])
def test_one_width_serves_all(shot: MakeShot, text: str, expected: list[float]) -> None:
    assert attributes(shot(points(POINTS + text)))["widths"].tolist() == expected


def test_no_widths_means_one_unit_and_is_mentioned(shot: MakeShot) -> None:
    for body in (points(POINTS), curves(CURVES)):
        made = shot(body)
        assert attributes(made)["widths"].tolist() == [1]
        assert any("without widths" in text for text in made.notices("mentioned"))


def test_primvar_widths_come_first(shot: MakeShot) -> None:
    name = "primvars:widths"
    indexed = widths("1, 4", "vertex", name) + "int[] primvars:widths:indices = [1, 0, 1]"
    values = attributes(shot(points(POINTS + widths("9", "constant") + indexed)))
    assert values["widths"].tolist() == [4, 1, 4]


def test_widths_points_and_topology_vary(shot: MakeShot) -> None:
    made = shot(
        points(
            "point3f[] points.timeSamples = {1: [(0,0,0)], 2: [(0,0,0)], 3: [(0,0,1), (1,1,1)]}\n"
            'float[] widths (\ninterpolation = "vertex"\n)\n'
            "float[] widths.timeSamples = {1: [1], 2: [2], 3: [2, 3]}"
        )
    )
    first, second, third = (attributes(made, time) for time in (1, 2, 3))
    assert first["widths"].tolist() == [1]
    assert second["widths"].tolist() == [2]
    assert third["points"].shape == (2, 3)
    assert made.read(3).objects["/P"] is made.read(4).objects["/P"]


BAD_WIDTHS = [
    ("1, -1, 1", "vertex", "width 1 is -1"),
    ("1, 2, nan", "vertex", "width 2 is nan"),
    ("inf", "constant", "width 0 is inf"),
    ("1, 2", "vertex", "2 widths, but 3 are expected"),
    ("1, 2, 3, 4", "", "4 widths, but 3 are expected"),
    ("1, 2, 3", "constant", "3 widths, but 1 are expected"),
]


@pytest.mark.parametrize(("values", "interpolation", "message"), BAD_WIDTHS)
def test_bad_widths_are_skipped_and_located(
    shot: MakeShot, values: str, interpolation: str, message: str
) -> None:
    made = shot(points(POINTS + widths(values, interpolation)) + '\ndef Cube "C"\n{\n}')
    assert list(made.read().objects) == ["/C"]
    (text,) = made.notices("skipped")
    assert message in text
    assert "/P.widths in " in text
    assert "shot.usda" in text


@pytest.mark.parametrize("kind", ["Points", "BasisCurves"])
def test_empty_prims_and_widths_of_zero_are_mentioned(shot: MakeShot, kind: str) -> None:
    for body in ("", "point3f[] points = []\n", CURVES + widths("0", "constant")):
        made = shot(f'def {kind} "P"\n{{\n{body}\n}}')
        assert not made.read().objects
        assert not made.notices("skipped")
        assert any("/P" in text for text in made.notices("mentioned"))


def test_nan_points_are_skipped(shot: MakeShot) -> None:
    made = shot(points("point3f[] points = [(0, nan, 0)]\n" + widths("1")))
    assert not made.read().objects
    assert "NaN" in made.notices("skipped")[0]


def test_absurd_sizes_are_skipped(shot: MakeShot) -> None:
    made = shot(points(POINTS + widths("3e38", "constant")))
    assert not made.read().objects
    assert "exceed single precision" in made.notices("skipped")[0]


LAYOUTS = [
    ("linear", "bezier", "nonperiodic", [2, 5]),
    ("linear", "bezier", "periodic", [3, 4]),
    ("linear", "bspline", "pinned", [2, 3]),
    ("cubic", "bezier", "nonperiodic", [4, 7]),
    ("cubic", "bezier", "periodic", [3, 6]),
    ("cubic", "bezier", "pinned", [4, 7]),
    ("cubic", "bspline", "nonperiodic", [4, 5]),
    ("cubic", "bspline", "periodic", [3, 5]),
    ("cubic", "bspline", "pinned", [2, 6]),
    ("cubic", "catmullRom", "nonperiodic", [4, 9]),
    ("cubic", "catmullRom", "periodic", [3, 4]),
    ("cubic", "catmullRom", "pinned", [2, 4]),
]


def basis_curves(kind: str, basis: str, wrap: str, counts: list[int], rest: str = "") -> str:
    values = ", ".join(f"({i},{i * i % 5},{i % 3})" for i in range(sum(counts)))
    return curves(
        f'uniform token type = "{kind}"\nuniform token basis = "{basis}"\n'
        f'uniform token wrap = "{wrap}"\nint[] curveVertexCounts = {counts}\n'
        f"point3f[] points = [{values}]\n{rest}"
    )


@pytest.mark.parametrize(("kind", "basis", "wrap", "counts"), LAYOUTS)
@pytest.mark.parametrize("interpolation", ["constant", "uniform", "varying", "vertex"])
def test_curves_take_the_widths_that_usd_says(
    shot: MakeShot, kind: str, basis: str, wrap: str, counts: list[int], interpolation: str
) -> None:
    made = shot(basis_curves(kind, basis, wrap, counts))
    usd = UsdGeom.BasisCurves(made.stage.GetPrimAtPath("/P"))
    sizes = {
        "constant": 1,
        "uniform": usd.ComputeUniformDataSize(1),
        "varying": usd.ComputeVaryingDataSize(1),
        "vertex": usd.ComputeVertexDataSize(1),
    }
    authored = widths(", ".join("1" for _ in range(sizes[interpolation])), interpolation)
    made = shot(basis_curves(kind, basis, wrap, counts, authored))
    made.read().objects["/P"].add_to(core.ChangeSet())
    assert not made.notices("skipped")


BAD_CURVES = [
    ("cubic", "bezier", "nonperiodic", [5], "takes 4, 7, 10 and so on"),
    ("cubic", "bezier", "periodic", [4], "takes 3, 6, 9 and so on"),
    ("cubic", "bspline", "nonperiodic", [3], "takes 4 or more"),
    ("linear", "bezier", "nonperiodic", [1], "takes 2 or more"),
    ("linear", "bezier", "periodic", [2], "takes 3 or more"),
    ("linear", "bezier", "nonperiodic", [-2, 4], "takes 2 or more"),
    ("cubic", "hermite", "nonperiodic", [4], "expected bezier, bspline, catmullRom"),
    ("wavy", "bezier", "nonperiodic", [4], "expected linear or cubic"),
    ("cubic", "bezier", "open", [4], "expected nonperiodic, periodic, pinned"),
]


@pytest.mark.parametrize(("kind", "basis", "wrap", "counts", "message"), BAD_CURVES)
def test_bad_curves_are_skipped_and_located(
    shot: MakeShot, kind: str, basis: str, wrap: str, counts: list[int], message: str
) -> None:
    made = shot(basis_curves(kind, basis, wrap, counts, widths("1", "constant")))
    assert not made.read().objects
    (text,) = made.notices("skipped")
    assert message in text
    assert "/P." in text


def test_counts_must_add_up(shot: MakeShot) -> None:
    made = shot(curves(CURVES.replace("[4, 4]", "[4]") + widths("1", "constant")))
    assert not made.read().objects
    assert "sum to 4, but there are 8 points" in made.notices("skipped")[0]


@pytest.mark.parametrize(
    ("values", "interpolation"),
    [
        ("(0,0,1)", "constant"),
        ("(0,0,1), (0,1,0)", "uniform"),
        (", ".join(["(0,0,1)"] * 4), "varying"),
        (", ".join(["(0,0,1)"] * 8), "vertex"),
    ],
)
@pytest.mark.parametrize("name", ["normals", "primvars:normals"])
def test_curves_with_normals_are_ribbons(
    shot: MakeShot, name: str, values: str, interpolation: str
) -> None:
    normal = f'normal3f[] {name} = [{values}] (\ninterpolation = "{interpolation}"\n)\n'
    made = shot(curves(CURVES + normal + widths("1", "constant")))
    geometry = made.read().objects["/P"].shape.geometry()
    assert isinstance(geometry, core.Mesh)
    assert len(geometry.face_vertex_counts) == 2 * 8
    assert not made.notices("unsupported")
    assert not made.notices("skipped")


def test_ribbons_whose_normals_do_not_fit_are_tubes(shot: MakeShot) -> None:
    normal = 'normal3f[] normals = [(0,0,1), (0,0,1), (0,1,0)] (\ninterpolation = "vertex"\n)\n'
    made = shot(curves(CURVES + normal + widths("1", "constant")))
    assert isinstance(made.read().objects["/P"].shape.geometry(), core.Curves)
    assert "there are 3 normals; expected 8" in made.notices("skipped")[0]
    assert "round tubes" in made.notices("skipped")[0]


@pytest.mark.parametrize("kind", ["NurbsCurves", "HermiteCurves"])
def test_other_curves_are_reported(shot: MakeShot, kind: str) -> None:
    made = shot(f'def {kind} "P"\n{{\n}}')
    assert not made.read().objects
    assert "/P" in made.notices("unsupported")[0]


def test_a_chain_is_what_a_capsule_is() -> None:
    """The same solid by two ways: a segment of a curve, and Capsule."""
    from scenes import film_bits, renderer

    def film(geometry: Any) -> np.ndarray:
        changes = core.ChangeSet()
        changes.set_material("/m", core.Material(diffuse_color=(0.5, 0.5, 0.5)))
        place = np.eye(4)
        place[3, 2] = -5
        changes.set_object("/o", geometry, place, "/m")
        changes.set_light("/l", core.Light.distant((0.3, -1, -0.6), (1, 1, 1)))
        made = renderer(64, 64)
        made.update(changes)
        assert film_bits(made)
        return np.asarray(made.beauty())

    ends = np.array([[0, 0, -0.5], [0, 0, 0.5]], np.float32)
    width = np.array([0.5], np.float32)
    chain = film(core.Curves(ends, np.array([2], np.int32), width))
    assert chain.any()
    assert np.allclose(chain, film(core.Quadric.capsule(0.25, 1.0)), atol=1e-6)
    assert np.allclose(chain, film(core.Quadric.round_cone(0.25, 0.25, 1.0)), atol=1e-6)
    ball = film(core.Spheres(ends[:1] * 0, width))
    assert np.allclose(ball, film(core.Quadric.sphere(0.25)), atol=1e-6)


@pytest.mark.parametrize("widths", [(0.5, 0.5), (0.7, 0.1)])
def test_joints_neither_show_nor_refract_nor_tint(widths: tuple[float, float]) -> None:
    """A straight tube of glass, of one piece and of sixteen, with its shadow."""
    import scenes

    def film(pieces: int) -> np.ndarray:
        along = np.linspace(0, 1, pieces + 1)[:, None]
        ends = np.array([[-1, -0.5, 0, widths[0]], [1, 0.7, -0.4, widths[1]]])
        balls = (ends[:1] * (1 - along) + ends[1:] * along).astype(np.float32)
        counts = np.array([pieces + 1], np.int32)
        changes = core.ChangeSet()
        changes.set_material("/glass", core.Material(opacity=0.3, ior=1.5, roughness=0.0))
        changes.set_material("/floor", core.Material())
        place = np.eye(4)
        place[3, 2] = -4
        tube = core.Curves(balls[:, :3], counts, balls[:, 3], "vertex")
        changes.set_object("/tube", tube, place, "/glass")
        floor = np.array(scenes.floor(), float)
        changes.set_object("/floor", core.Quadric.plane(12, 12), floor, "/floor")
        changes.set_light("/l", core.Light.distant((0.3, -1, -0.6), (1, 1, 1)))
        made = scenes.renderer(120, 100)
        made.update(changes)
        return np.asarray(made.beauty())

    assert np.allclose(film(1), film(16), atol=1e-4)


def test_primvars_of_points_and_curves_reach_their_material(shot: MakeShot) -> None:
    """displayColor by point, by curve and by vertex, as the pixels show it."""

    def colors(values: str, interpolation: str) -> str:
        return f'color3f[] primvars:displayColor = [{values}] (interpolation = "{interpolation}")\n'

    def albedo(body: str, pixels: list[tuple[int, int]]) -> list[list[float]]:
        import scenes

        made = shot(body).read()
        changes = core.ChangeSet()
        for material in made.materials.values():
            material.add_to(changes)
        made.objects["/P"].add_to(changes)
        camera = core.Camera(np.eye(4), (-1, 1, -1, 1), True)
        settings = core.ViewSettings(64, 64, aovs=scenes.AOVS)
        renderer = core.Renderer(camera, settings)
        renderer.update(changes)
        found = np.asarray(renderer.aov("albedo"))
        return [[round(float(c), 2) for c in found[y, x]] for x, y in pixels]

    points_body = "point3f[] points = [(-0.5,0,-5), (0.5,0,-5)]\n" + widths("0.5", "constant")
    red, green = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]
    by_point = points(points_body + colors("(1,0,0), (0,1,0)", "vertex"))
    assert albedo(by_point, [(16, 32), (48, 32)]) == [red, green]
    one = points(points_body + colors("(0,1,0)", "uniform"))
    assert albedo(one, [(16, 32), (48, 32)]) == [green, green]
    lines = (
        'uniform token type = "linear"\nint[] curveVertexCounts = [2, 2]\n'
        "point3f[] points = [(-0.9,0.5,-5), (0.9,0.5,-5), (-0.9,-0.5,-5), (0.9,-0.5,-5)]\n"
        + widths("0.2", "constant")
    )
    by_curve = curves(lines + colors("(1,0,0), (0,1,0)", "uniform"))
    assert albedo(by_curve, [(32, 16), (32, 48)]) == [red, green]
    by_vertex = curves(lines + colors("(1,0,0), (0,1,0), (0,0,0), (1,1,1)", "vertex"))
    ((r, g, b),) = albedo(by_vertex, [(32, 16)])
    assert [r, g, b] == pytest.approx([0.5, 0.5, 0.0], abs=0.02)


def test_complexity_cuts_cubic_spans(shot: MakeShot, monkeypatch: pytest.MonkeyPatch) -> None:
    from irt_usd.stage import ReadOptions

    segments = []
    monkeypatch.setattr(core, "Curves", lambda *arguments: segments.append(arguments[6]))
    for level in range(4):
        made = shot(curves(CURVES + widths("1", "constant")), options=ReadOptions(level=level))
        made.read().objects["/P"].shape.geometry()
    assert segments == [8, 16, 32, 64]
