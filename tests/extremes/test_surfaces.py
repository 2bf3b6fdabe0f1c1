# SPDX-License-Identifier: Apache-2.0
"""Triangles, transforms and radii at their limits."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import scenes
from extremes import views
from extremes.rows import NewRow
from irt_usd import _core

SUN = ("light", "/sun", ("distant", (0.1, -0.2, -1), (3, 3, 3), True))


def lit(*edits: scenes.Edit) -> scenes.State:
    """A scene of Lambert without red, glowing and glass materials under a sun."""
    state = scenes.State()
    cyan = {**views.MATT, "diffuse_color": (0, 1, 1)}
    materials = {"matt": cyan, "glow": views.GLOW, "glass": views.GLASS}
    state.apply([("material", "/" + name, values) for name, values in materials.items()])
    state.apply([SUN, *edits])
    return state


def mesh(points: Any, triangles: Any) -> _core.Mesh:
    indices = np.array(triangles, np.int32)
    return _core.Mesh(
        np.array(points, np.float32), np.full(len(indices), 3, np.int32), indices.reshape(-1)
    )


def leaks(state: scenes.State, size: tuple[int, int], **options: Any) -> int:
    """Pixels in which something behind a closed surface glows."""
    return int((views.film(state, size, **options)[..., 0] > 0.5).sum())


def slivers(ratio: float, count: int) -> _core.Mesh:
    """A square of side 2 cut into triangles `ratio` times longer than wide."""
    x = np.linspace(0, 2 / ratio * count, count + 1) - 1
    points = [(a, side, 0) for a in x for side in (-1, 1)]
    points += [(1, -1, 0), (1, 1, 0)]
    quads = np.arange(count + 1)[:, None] * 2 + [0, 2, 3, 0, 3, 1]
    return mesh(points, quads.reshape(-1, 3))


def test_thin_triangles(row: NewRow) -> None:
    """A fan of slivers and one rest, before a wall that glows: none shows through."""
    seen = row("triangles 1 to 10^4 ... 10^8 before a wall that glows", "pixels through", 0)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    for power in range(4, 9):
        sheet = slivers(10.0**power, 200)
        state = lit(
            ("object", "/sheet", sheet, views.placed((0, 0, -2)), "/matt"),
            ("object", "/wall", ("plane", 3.9, 3.9), views.placed((0, 0, -4)), "/glow"),
        )
        width = 2 / 10.0**power * 200 / 2  # as much as the slivers take
        for name, window in (
            ("all", (-0.48, 0.48, -0.48, 0.48)),
            ("the slivers alone", (-0.5 + width / 8, -0.5 + width, -0.4, 0.4)),
        ):
            cause = f"1 to 10^{power}, {name}"
            view = views.camera(window=window)
            seen.see(leaks(state, (200, 200), view=view), cause)
            edit = [("shift", "/wall", (0.01, 0, 0)), ("shift", "/sheet", (0, 1e-3, 0))]
            exact.see(views.update_differs(state, edit, view=view, size=(64, 64)), cause)


def test_coincident_surfaces(row: NewRow) -> None:
    """Eight squares in one place: of equal ones the first by path is seen; of quadrics and meshes
    mixed, rounding decides, the same way in an update."""
    seen = row("equal coincident surfaces: the first by path is seen", "share of pixels", 0)
    exact = row("coincident surfaces, update beside full trace", "share of pixels", 0)
    for angle in (0.0, 0.3, np.pi / 4):
        turn = np.array(views.placed((0, 0, -3)))
        turn[:3, :3] = [
            (np.cos(angle), 0, np.sin(angle)),
            (0, 1, 0),
            (-np.sin(angle), 0, np.cos(angle)),
        ]
        place = scenes.as_tuples(turn)
        kinds = {"planes": ("plane", 2.0, 2.0), "meshes": ("sheet", 2.0, 1.0)}
        for name, shape in kinds.items():
            made = views.renderer((80, 80))
            objects = [("object", f"/{i}", shape, place, "/matt") for i in range(8)]
            made.update(lit(*objects).fresh())
            ids = made.aov("objectId")
            alone = views.renderer((80, 80))
            alone.update(lit(objects[0]).fresh())
            cause = f"{name} turned by {angle:.2f}"
            seen.see(float((ids != alone.aov("objectId")).mean()), cause)
        state = lit()
        for i in range(8):
            shape = kinds["planes" if i % 2 else "meshes"]
            state.apply([("object", f"/{i}", shape, place, "/matt")])
        for edit in (("remove", "/0"), ("shift", "/1", (0.1, 0, 0)), ("bind", "/0", "/glass")):
            exact.see(views.update_differs(state, [edit]), f"turned by {angle:.2f}, {edit}")


def test_many_triangles_through_one_point(row: NewRow, full: bool) -> None:
    """A closed double cone whose triangles all share its tips, over a wall that glows."""
    count, size = (2_000_000, 11) if full else (2_000, 31)
    seen = row(
        f"closed cone of {2 * count:,} triangles that meet in two points", "pixels through", 0
    )
    angle = np.arange(count) * (2 * np.pi / count)
    points = np.concatenate([[(0, 0, 1), (0, 0, -1)], np.zeros((count, 3))]).astype(np.float32)
    points[2:, 0], points[2:, 1] = np.cos(angle), np.sin(angle)
    around = np.arange(count, dtype=np.int32)
    after = np.roll(around, -1)
    upper = np.stack([np.zeros_like(around), around + 2, after + 2], axis=1)
    lower = np.stack([np.ones_like(around), after + 2, around + 2], axis=1)
    cone = mesh(points, np.concatenate([upper, lower]))
    state = lit(
        ("object", "/cone", cone, views.placed((0, 0, -3)), "/matt"),
        ("object", "/wall", ("plane", 2.0, 2.0), views.placed((0, 0, -5)), "/glow"),
    )
    for half in (1e-1, 1e-3, 1e-6, 1e-8):
        view = views.camera(window=(-half, half, -half, half))
        seen.see(leaks(state, (size, size), view=view), f"a window of {half:g} at the tip")


def rotation(axis: int, angle: float) -> NDArray[np.float64]:
    turn = np.eye(4)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turn[a, a] = turn[b, b] = np.cos(angle)
    turn[a, b], turn[b, a] = np.sin(angle), -np.sin(angle)
    return turn


def matrices() -> list[tuple[str, NDArray[np.float64]]]:
    """Stretches, mirrorings and shears, up to nearly singular ones."""
    tilt = rotation(0, 0.7) @ rotation(1, 0.4)
    shear = np.eye(4)
    shear[1, 0] = 3.0
    flat = [(f"squeezed to 10^-{n}", np.diag([1, 1, 10.0**-n, 1])) for n in (1, 3, 6)]
    return [
        ("stretched 1 to 1000", np.diag([1, 1000.0, 1, 1]) @ np.diag([1, 1e-3, 1, 1]) * 1.0),
        ("stretched by (3, 1, 0.2)", np.diag([3.0, 1, 0.2, 1])),
        ("mirrored", np.diag([-1.0, 1, 1, 1])),
        ("mirrored in all axes", np.diag([-1.0, -1, -1, 1])),
        ("sheared by 3", shear),
        *flat,
        *[(f"{name}, tilted", m @ tilt) for name, m in flat],
    ]


def test_stretched_spheres(row: NewRow) -> None:
    """A sphere's silhouette under any affine map is the ellipsoid's: the set of rays o + s d whose
    image under the inverse map meets the unit sphere, decided in long double."""
    seen = row("spheres under affine maps, silhouette against the conic", "share of pixels", 1e-4)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    size = 200
    view = views.camera(window=(-0.5, 0.5, -0.5, 0.5))
    at = (np.arange(size) + 0.5) / size - 0.5
    x, y = np.meshgrid(at, -at)
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1).astype(np.longdouble)
    for name, matrix in matrices():
        moved = matrix.copy()
        moved[3, :3] += (0, 0, -6)
        state = lit(("object", "/ball", ("sphere", 1.0), scenes.as_tuples(moved), "/matt"))
        alpha = views.film(state, (size, size), view)[..., 3]
        inverse = np.linalg.inv(moved).astype(np.longdouble)
        o, d = inverse[3, :3], rays @ inverse[:3, :3]
        b, a, c = d @ o, (d * d).sum(-1), o @ o - 1
        discriminant = b * b - a * c
        # Pixels whose ray is tangent to within the matrix's own rounding decide either way.
        decided = np.abs(discriminant) > 1e-9 * (b * b + np.abs(a * c))
        wrong = (alpha > 0) != (discriminant > 0)
        seen.see(float((wrong & decided).mean()), name)
        edit = [("shift", "/ball", (0.05, 0, 0))]
        exact.see(views.update_differs(state, edit, view=view, size=(64, 64)), name)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(row: NewRow, bad: float) -> None:
    taken = row(f"radii, sizes, points and matrices with {bad}", "taken without a word", 0)
    shapes: list[tuple[str, Any]] = [
        *[(kind, (kind, bad)) for kind in ("sphere", "cube")],
        *[(kind, (kind, bad, 1.0)) for kind in ("cylinder", "cone", "capsule", "plane")],
        ("height", ("cylinder", 1.0, bad)),
        ("points", ("box", False, ((bad, 0, 0), *scenes.BOX[1:]))),
    ]
    matrix = np.array(views.placed((0, 0, -3)))
    holed = matrix.copy()
    holed[1, 1] = bad
    cases = [(name, shape, matrix) for name, shape in shapes]
    cases.append(("matrix", ("sphere", 1.0), holed))
    for name, shape, place in cases:
        made = views.renderer((8, 8))
        try:
            state = lit(("object", "/bad", shape, place, "/matt"))
            made.update(state.fresh())
            taken.see(1, name)
        except ValueError as error:
            taken.see(0 if "/bad" in str(error) else 1, name)


def test_nothing_has_no_surface(row: NewRow) -> None:
    """Sizes of zero, and those that no float tells from it, are refused by name."""
    taken = row("radii and sizes of 0 and 10^-300", "neither refused by name nor finite", 0)
    for kind, sizes in (("sphere", 1), ("cube", 1), ("cylinder", 2), ("cone", 2), ("capsule", 2)):
        for size in (0.0, 1e-300, 1e-40):
            state = lit(("object", "/o", (kind, *[size] * sizes), scenes.floor(1), "/matt"))
            cause = f"{kind} of {size:g}"
            try:
                taken.see(float(1 - np.isfinite(views.film(state)).mean()), cause)
            except ValueError as error:
                taken.see(0 if "/o" in str(error) else 1, cause)
