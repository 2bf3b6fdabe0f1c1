# SPDX-License-Identifier: Apache-2.0
"""Small and large scenes, far places, and both in one picture."""

import numpy as np
import pytest

import scenes
from extremes import views
from extremes.rows import NewRow

SIZE = (480, 400)
MOVE = [("shift", "/b", (0.25, 0.0, 0.0))]


def apart() -> scenes.State:
    """A crowd of which no two surfaces coincide: where they do, rounding decides between them."""
    state = scenes.crowd()
    for name in ("/c", "/cloud"):
        state.apply([("remove", name)])
    state.apply([("move", "/d", scenes.floor(2.4)), ("move", "/leaves", scenes.floor(0.55))])
    return state


def test_scenes_of_any_unit(row: NewRow, full: bool) -> None:
    seen = row("a scene of 10^-6 to 10^9 units beside that of 1", "share of pixels", 1e-4)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    here = views.film(apart(), SIZE)
    for power in range(-6, 10, 1 if full else 5):
        scale = 10.0**power
        there = views.transformed(apart(), scale)
        cause = f"10^{power}"
        seen.see(views.share_differing(here, views.film(there, SIZE)), cause)
        edit = [("shift", "/b", (0.25 * scale, 0.0, 0.0))]
        exact.see(views.update_differs(there, edit), cause)


@pytest.mark.parametrize(("power", "bound"), [(7, 1e-4)])
def test_scenes_far_away(row: NewRow, power: int, bound: float) -> None:
    seen = row(f"camera and scene 10^{power} from the origin", "share of pixels", bound)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    here = views.film(apart(), SIZE)
    for way in ((1, 0, 0), (0, -1, 0), (0, 0, 1), (1, -1, 1), (-0.3, 0.7, 0.1)):
        offset = np.array(way) * 10.0**power
        there = views.transformed(apart(), 1.0, offset)
        view = views.camera(offset)
        seen.see(views.share_differing(here, views.film(there, SIZE, view)), f"moved along {way}")
        exact.see(views.update_differs(there, MOVE, view=view), f"moved along {way}")


def test_places_that_doubles_round(row: NewRow) -> None:
    """At 10^10 a double's step is 1.9e-6 units: everything stands up to half of that beside its
    place, in every coordinate. So do the surfaces here: on a grid of that step, exactly."""
    seen = row("10^10 from the origin, against a scene rounded alike", "share of pixels", 1e-4)
    step = 2.0**-19
    here = apart()
    for name, (shape, matrix, *rest) in here.objects.items():
        rounded = np.array(matrix, float)
        rounded[3, :3] = np.round(rounded[3, :3] / step) * step
        here.objects[name] = (shape, rounded, *rest)
    offset = np.array((1e10, -1e10, 1e10))
    there = views.transformed(here, 1.0, offset)
    films = views.film(here, SIZE), views.film(there, SIZE, views.camera(offset))
    seen.see(views.share_differing(*films), "moved by 10^10 (1, -1, 1)")


def test_depths_over_twelve_decades(row: NewRow) -> None:
    """Cards at depths 10^-6 to 10^6, each a tenth of the picture beside the one before."""
    depth = row("cards at depths 10^-6 to 10^6 in one picture", "relative error of depth", 2e-7)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    powers = range(-6, 7)
    state = scenes.State()
    state.apply([("material", "/matt", views.MATT)])
    for i, power in enumerate(powers):
        z = 10.0**power
        where = views.placed((z * ((i + 0.5) / 6.5 - 1), 0, -z))
        state.apply([("object", f"/{i}", ("plane", z / 7, 2 * z), where, "/matt")])
    state.apply([("light", "/sun", ("distant", (0, 0, -1), (3, 3, 3), True))])
    made = views.renderer((len(powers), 1), views.camera(window=(-1, 1, -0.1, 0.1)))
    made.update(state.fresh())
    for power, found in zip(powers, made.aov("depth")[0], strict=True):
        depth.see(abs(float(found) / 10.0**power - 1), f"depth 10^{power}")
    view = views.camera(window=(-1, 1, -0.1, 0.1))
    for i, power in enumerate(powers):
        edit = [("shift", f"/{i}", (0.02 * 10.0**power, 0, 0))]
        exact.see(views.update_differs(state, edit, view=view), f"the card at 10^{power} moves")


def test_small_and_large_in_one_picture(row: NewRow) -> None:
    """A ball of 10^-5 before one of 10^5, each where its closed form says."""
    area = row("balls of 10^-5 and 10^5 in one picture", "relative error of their areas", 2e-3)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    small, large = 1e-5, 1e5
    state = scenes.State()
    state.apply(
        [
            ("material", "/matt", views.MATT),
            ("material", "/glow", views.GLOW),
            ("object", "/far", ("sphere", large), views.placed((0, 0, -4e5)), "/matt"),
            ("object", "/near", ("sphere", small), views.placed((0, 0, -1e-4)), "/glow"),
        ]
    )
    size = 1024
    view = views.camera(window=(-0.3, 0.3, -0.3, 0.3))
    image = views.film(state, (size, size), view)
    found = {"far": image[..., 3].sum(), "near": image[..., 0].sum()}
    pixel = (0.6 / size) ** 2
    for name, radius, distance in (("far", large, 4e5), ("near", small, 1e-4)):
        expected = np.pi * radius**2 / (distance**2 - radius**2)
        area.see(abs(found[name] * pixel / expected - 1), f"the {name} one")
    for name, radius in (("/far", large), ("/near", small)):
        edit = [("shift", name, (radius / 8, 0, 0))]
        exact.see(views.update_differs(state, edit, view=view), f"{name} moves")
