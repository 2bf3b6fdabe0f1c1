# SPDX-License-Identifier: Apache-2.0
"""Lights of any power, anywhere."""

from typing import Any

import numpy as np

import scenes
from extremes import views
from extremes.rows import NewRow


def wall(light: tuple[Any, ...]) -> scenes.State:
    """A white Lambert wall at z = -1 under one light."""
    state = scenes.State()
    state.apply(
        [
            ("material", "/matt", views.MATT),
            ("object", "/wall", ("plane", 1e3, 1e3), views.placed((0, 0, -1)), "/matt"),
            ("light", "/lamp", light),
        ]
    )
    return state


def test_powers_over_24_decades(row: NewRow) -> None:
    """The film is linear in a light's energy, so that powers of two leave every digit as it is."""
    seen = row("lights of 2^-40 to 2^40 (10^-12 to 10^12)", "share of channels not scaled alike", 0)
    exact = row("a light keyed over that range, update beside full trace", "share of pixels", 0)
    state = scenes.crowd()
    for other in ("/fill", "/key"):
        state.apply([("dark", other)])
    one = ("point", (0.5, 2.0, -3.0), (8.0, 4.0, 4.0), True)
    state.apply([("light", "/lamp", one), ("remove", "/lantern"), ("bind", "/e", "/red")])
    state.apply([("look", "/lamp", {"emissive_color": (0.0, 0.0, 0.0)})])
    base = views.film(state)
    for power in (-40, -20, -1, 1, 20, 40):
        energy = tuple(np.array(one[2]) * 2.0**power)
        edit = [("light", "/lamp", (*one[:2], energy, True))]
        exact.see(views.update_differs(state, edit), f"2^{power}")
        scaled = base[..., :3] * np.float32(2.0**power)
        found = views.film(state)[..., :3]
        seen.see(float((scaled.view(np.uint32) != found.view(np.uint32)).mean()), f"2^{power}")


def test_distances_from_the_surface(row: NewRow) -> None:
    """A lamp straight before a white wall gives intensity / (pi distance^2) at its foot."""
    seen = row("a lamp 10^-9 to 10^9 from a wall", "relative error", 1e-6)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    for power in range(-9, 10):
        distance = 10.0**power
        position = (0.0, 0.0, -1 + distance)
        real = position[2] + 1
        lamp = ("point", position, (np.pi * real**2,) * 3, True)
        view = views.camera(window=(-1e-13, 1e-13, -1e-13, 1e-13))
        state = wall(lamp)
        level = float(views.film(state, (1, 1), view)[0, 0, 0])
        seen.see(abs(level - 1), f"10^{power}")
        edit = [("aim", "/lamp", (1e-3 * distance, 0, position[2]))]
        exact.see(views.update_differs(state, edit), f"10^{power}")


def test_lights_on_and_in_things(row: NewRow) -> None:
    """Inside a ball, on its surface, on the wall, at the camera, where a shadow ray has no
    direction: numbers all the same."""
    finite = row("lamps on surfaces, in objects, at the camera", "share of pixels not finite", 0)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    places = {
        "in the ball": (0, 0, -5),
        "on its surface": (0, 0, -4.5),
        "on the floor": (1.0, -1.0, -5.0),
        "on the floor's edge": (4.0, -1.0, -5.0),
        "at the camera": (0, 0, 0),
        "on a ray": (0.006, 0.006, -1.0),
        "10^300 away": (0, 1e300, 0),
    }
    state = scenes.crowd()
    for name, place in places.items():
        light = ("light", "/fill", ("point", tuple(map(float, place)), (8.0, 4.0, 4.0), True))
        exact.see(views.update_differs(state, [light]), name)
        finite.see(float(1 - np.isfinite(views.film(state)).mean()), name)


def test_directions(row: NewRow) -> None:
    """Suns along the axes, with signed zeros, along the floor and from under it."""
    finite = row("suns along axes and in the floor's plane", "share of pixels not finite", 0)
    exact = row("the same, update beside full trace", "share of pixels", 0)
    state = scenes.crowd()
    for direction in (
        (1.0, 0.0, 0.0), (-1.0, -0.0, 0.0), (0.0, -1.0, -0.0), (-0.0, 1.0, 0.0), (0.0, 0.0, -1.0),
        (1e-30, -1.0, 1e-300), (1e-5, -1e-12, -1.0), (3e200, -4e200, 0.0), (1e-320, -1e-320, 0.0),
    ):  # fmt: skip
        sun = ("light", "/key", ("distant", direction, (1.0, 1.0, 0.9), True))
        exact.see(views.update_differs(state, [sun]), str(direction))
        finite.see(float(1 - np.isfinite(views.film(state)).mean()), str(direction))
