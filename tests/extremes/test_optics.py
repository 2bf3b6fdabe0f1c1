# SPDX-License-Identifier: Apache-2.0
"""Rays that graze, are reflected totally, or go on and on."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import scenes
from extremes import views
from extremes.rows import NewRow
from irt_usd import _core


def looking(angle: float, position: tuple[float, float, float]) -> NDArray[np.float64]:
    """A camera's matrix: from -z turned about y by `angle`."""
    turned = np.eye(4)
    turned[0, :3] = (math.cos(angle), 0, -math.sin(angle))
    turned[2, :3] = (math.sin(angle), 0, math.cos(angle))
    turned[3, :3] = position
    return turned


def glowing_beyond_glass(ior: float) -> scenes.State:
    """The inside of a block of glass, a wall that glows behind its far face."""
    state = scenes.State()
    block = scenes.as_tuples(np.diag([1e7, 1e7, 20, 1]))
    state.apply(
        [
            ("material", "/glass", {**views.GLASS, "ior": ior, "roughness": 0.5}),
            ("material", "/glow", views.GLOW),
            ("object", "/block", ("cube", 1.0), block, "/glass"),
            ("object", "/sky", ("plane", 1e9, 1e9), views.placed((0, 0, -30)), "/glow"),
        ]
    )
    return state


def through(angle: float, ior: float) -> float:
    """How much of the sky a ray inside the block sees that meets its face at `angle`."""
    view = _core.Camera(looking(angle, (0, 0, -5)), (-1e-12, 1e-12, -1e-12, 1e-12))
    return float(views.film(glowing_beyond_glass(ior), (1, 1), view, max_depth=1)[0, 0, 0])


def test_total_reflection_begins_at_the_critical_angle(row: NewRow) -> None:
    """By bisection: where the sky vanishes. Rays are float, so that their angle is known to
    about 10^-7."""
    seen = row("the critical angle, indices 1.0001 to 100", "radians", 2e-6)
    for ior in (1.0001, 1.01, 1.1, 1.33, 1.5, 2.4, 10.0, 100.0):
        critical = math.asin(1 / ior)
        low, high = critical * 0.9, min(critical * 1.1, math.pi / 2 - 1e-3)
        if high <= critical:
            high = math.pi / 2 - 1e-5
        assert through(low, ior) > 0
        if through(high, ior) > 0:
            seen.see(abs(high - critical), f"index {ior}: no reflection before {high}")
            continue
        for _ in range(40):
            middle = (low + high) / 2
            low, high = (middle, high) if through(middle, ior) > 0 else (low, middle)
        # Near index 1 the sine is flat there: an error of its argument counts by its slope.
        slope = math.cos(critical)
        seen.see(abs(low - critical) * slope, f"index {ior}")


def test_index_of_one_is_not_there(row: NewRow) -> None:
    """Glass of index 1 bends nothing, and reflects but what Schlick's formula gives at grazing
    incidence, whatever the index: here nothing, for rays are within 3 degrees of the normal."""
    seen = row("glass of index 1, seen straight on", "largest difference of a channel", 1e-6)
    near = row("glass of index 1 + 10^-7 beside one of 1", "share of pixels", 1e-2)
    exact = row("index keyed through 1, update beside full trace", "share of pixels", 0)
    state = scenes.initial()
    state.apply([("remove", "/a")])
    view = views.camera(window=(-0.05, 0.05, -0.05, 0.05))
    bare = views.film(state, view=view)
    clear = {"opacity": 0.0, "roughness": 0.0, "ior": 1.0, "diffuse_color": (1, 1, 1)}
    state.apply(
        [
            ("material", "/clear", clear),
            ("object", "/pane", ("plane", 9.0, 9.0), views.placed((0, 0, -2)), "/clear"),
            ("object", "/block", ("cube", 2.0), views.placed((0, 0, -4)), "/clear"),
        ]
    )
    full = views.film(state, view=view)
    seen.see(float(np.abs(full[..., :3] - bare[..., :3]).max()), "a pane and a block")
    state.apply([("look", "/clear", {"ior": 1 + 1e-7})])
    near.see(views.share_differing(full, views.film(state, view=view)), "a pane and a block")
    state.apply([("object", "/ball", ("sphere", 0.5), views.placed((0.1, 0, -3)), "/clear")])
    for ior in (1 - 1e-7, 1.0, 1 + 1e-7, 0.5, 2.0, 1.0):
        edit = [("look", "/clear", {"ior": ior})]
        exact.see(views.update_differs(state, edit), f"to {ior!r}")


def test_glass_in_glass(row: NewRow) -> None:
    """Nested, touching and coincident shells of glass, sphere in sphere in cube."""
    finite = row("nested, touching and coincident glass", "share of pixels not finite", 0)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    base = scenes.initial()
    base.apply([("material", "/dense", {**views.GLASS, "ior": 2.4})])
    for inner in (0.25, 0.4999999, 0.5, 0.5000001):
        state = scenes.State(dict(base.objects), dict(base.materials), dict(base.lights))
        state.apply(
            [
                ("object", "/a", ("sphere", 0.5), scenes.floor(1), "/glass"),
                ("object", "/b", ("sphere", inner), scenes.floor(1), "/dense"),
                ("object", "/c", ("cube", 1.0), scenes.floor(1), "/glass"),
                ("object", "/d", ("cube", 2 * inner), scenes.floor(2), "/dense"),
            ]
        )
        cause = f"radius {inner!r} in 0.5"
        image = views.film(state, max_depth=12, throughput_cutoff=1e-30)
        finite.see(float(1 - np.isfinite(image).mean()), cause)
        for edit in (("shift", "/b", (1e-7, 0, 0)), ("shift", "/d", (0, -0.5, 0))):
            exact.see(views.update_differs(state, [edit], max_depth=12), f"{cause}, {edit[1]}")


def test_grazing_rays(row: NewRow) -> None:
    """A camera a hair above a large floor: its lower half sees the floor, its upper half none."""
    seen = row("a floor seen from 10^-3 ... 10^-12 above it", "share of pixels", 1e-3)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    size = (200, 200)
    for power in (3, 6, 9, 12):
        state = scenes.State()
        ground = np.array(scenes.floor())
        ground[3, :3] = (0, -(10.0**-power), 0)
        state.apply(
            [
                ("material", "/matt", views.MATT),
                ("light", "/sun", ("distant", (0, -1, -1), (3, 3, 3), True)),
                ("object", "/floor", ("plane", 100.0, 100.0), scenes.as_tuples(ground), "/matt"),
            ]
        )
        alpha = views.film(state, size)[..., 3]
        # The floor ends 50 units away: its horizon lies 10^-power / 50 under the middle.
        down = (np.arange(size[1]) + 0.5) / size[1] - 0.5 > 10.0**-power / 50
        seen.see(float((alpha.mean(axis=1) != down).mean()), f"10^-{power}")
        edit = [("object", "/ball", ("sphere", 0.1), views.placed((0, 0, -2)), "/matt")]
        exact.see(views.update_differs(state, edit), f"10^-{power}")


def test_mirrors_that_face_each_other(row: NewRow, full: bool) -> None:
    """Between two perfect mirrors a ray goes on to the depth that is asked."""
    depth = 10_000
    seen = row("mirrors facing mirrors, rays of a pixel to depth 10,000", "rays missing", 0)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    state = scenes.State()
    half = 200_000.0 if full else 20_000.0
    state.apply(
        [
            ("material", "/mirror", {**views.MIRROR, "specular_color": (1, 1, 1)}),
            ("material", "/matt", views.MATT),
            ("object", "/ahead", ("plane", half, half), views.placed((0, 0, -1)), "/mirror"),
            ("object", "/behind", ("plane", half, half), views.placed((0, 0, 1)), "/mirror"),
            ("light", "/sun", ("distant", (0, -1, -1), (3, 3, 3), True)),
        ]
    )
    view = views.camera(window=(-0.1, 0.1, -0.1, 0.1))
    settings: dict[str, Any] = {"max_depth": depth, "throughput_cutoff": 1e-3}
    made = views.renderer((2, 2), view, **settings)
    statistics = made.update(state.fresh())
    seen.see(4 * depth - statistics["rays"]["reflected"], "4 pixels")
    speck = ("object", "/speck", ("sphere", 0.01), views.placed((0.5, 0.5, 0)), "/matt")
    for edit in (speck, ("bind", "/ahead", "/matt"), ("bind", "/ahead", "/mirror")):
        exact.see(views.update_differs(state, [edit], view=view, size=(2, 2), **settings), edit[1])
