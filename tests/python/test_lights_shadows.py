# SPDX-License-Identifier: Apache-2.0
"""Shadow linking and shadow falloff: closed forms, and edits of them."""

from typing import Any

import numpy as np
import pytest

import edits
import scenes
from irt_usd import _core
from test_lights_core import FLOOR, HEIGHT, floor_levels, point


def shade(height: float) -> list[Any]:
    """A small plate under the light, that high above the floor."""
    place = FLOOR.copy()
    place[3, 1] = height
    return [("/shade", _core.Quadric.plane(1, 1), place)]


def under(levels: Any, positions: Any) -> Any:
    """Points of the floor in the middle of the plate's shadow, which the camera sees beside it."""
    reach = np.abs(positions[..., [0, 2]]).max(axis=-1)
    return (np.abs(positions[..., 1]) < 1e-6) & (reach > 0.6) & (reach < 0.74)


@pytest.mark.parametrize("height", [1.0, 1.25, 1.5, 1.75])
@pytest.mark.parametrize("gamma", [1.0, 2.0])
def test_shadows_fade_with_the_distance_of_what_casts_them(height: float, gamma: float) -> None:
    bare, _ = floor_levels(point())
    fading = point(shadow_distance=2.0, shadow_falloff=1.0, shadow_falloff_gamma=gamma)
    levels, positions = floor_levels(fading, objects=shade(height))
    dark = under(levels, positions)
    assert np.count_nonzero(dark) > 4
    way = np.sqrt((positions[dark] ** 2).sum(axis=-1) + HEIGHT**2)
    away = way * height / HEIGHT
    strength = np.clip(2.0 - away, 0, 1) ** gamma
    np.testing.assert_allclose(levels[dark], bare[dark] * (1 - strength), rtol=5e-4, atol=1e-6)


def test_a_falloff_longer_than_the_distance_begins_at_the_point() -> None:
    bare, _ = floor_levels(point())
    fading = point(shadow_distance=2.0, shadow_falloff=9.0)
    levels, positions = floor_levels(fading, objects=shade(1.0))
    dark = under(levels, positions)
    way = np.sqrt((positions[dark] ** 2).sum(axis=-1) + HEIGHT**2) / HEIGHT
    np.testing.assert_allclose(levels[dark], bare[dark] * way / 2, rtol=5e-4)


def test_what_is_not_linked_casts_no_shadow_of_that_light_alone() -> None:
    other = _core.Light.distant((0.0, -1.0, 0.1), (1, 1, 1))
    plate = shade(1.0)
    both, positions = floor_levels(point(), other, objects=plate)
    linked, _ = floor_levels(point(shadowless=["/shade", "/nowhere"]), other, objects=plate)
    alone, _ = floor_levels(other, objects=plate)
    bare, _ = floor_levels(point())
    floor = np.abs(positions[..., 1]) < 1e-6
    np.testing.assert_allclose(linked[floor], (alone + bare)[floor], rtol=1e-5)
    assert (both[floor] < linked[floor] * 0.99).any()


# ---- edits


def lamp(**modifiers: Any) -> Any:
    return ("point", (0.5, 3.0, -4.0), (9.0, 9.0, 9.0), True, modifiers)


START: list[scenes.Edit] = [("light", "/fill", lamp())]


def played(*frames: list[scenes.Edit], start: str = "crowd", foreseen: bool = False) -> Any:
    return edits.play(edits.Shot(start, [START, *frames], samples=2, foreseen=foreseen))


def linked(*names: str) -> list[scenes.Edit]:
    return [("light", "/fill", lamp(shadowless=names))]


@pytest.mark.parametrize("name", ["/a", "/b", "/d", "/cloud", "/e", "/lock"])
def test_linking_shadows_retraces_those_that_may_have_met_the_object(name: str) -> None:
    off, on = played(linked(name), START)[2:4]
    for update in (off, on):
        rays = update["rays"]
        assert rays["primary"] == rays["reflected"] == rays["refracted"] == 0
        assert update["new_rays"] == 0
        assert rays["shadow"] < update["all_rays"] / 2


@pytest.mark.parametrize("foreseen", [False, True])
def test_linked_shadows_of_what_moves_comes_and_goes(foreseen: bool) -> None:
    move: list[scenes.Edit] = [("shift", "/a", (0.25, 0.0, 0.0))]
    played(
        linked("/a"),
        move,
        [("hide", "/a"), *linked("/a", "/d")],
        [("show", "/a"), ("shift", "/d", (0.0, -0.5, 0.0))],
        linked("/e"),
        [("bind", "/a", "/red"), *linked("/a")],
        [("look", "/glass", {"opacity": 0.5})],
        [("undo", 3)],
        foreseen=foreseen,
    )


def test_an_array_is_linked_as_one() -> None:
    entry: list[scenes.Edit] = [("entry", "/swarm", 1, (2, (0.5, 0.25, 0.0), 0.5))]
    update = played(linked("/swarm"), entry, START, entry, start="swarm")[2]
    assert update["new_rays"] == 0
    assert update["rays"]["primary"] == 0
    unlit: list[scenes.Edit] = [("light", "/fill", lamp(unlit=("/swarm",)))]
    played(unlit, entry, START, start="swarm")


@pytest.mark.parametrize("foreseen", [False, True])
def test_fading_shadows_follow_edits(foreseen: bool) -> None:
    fading: list[scenes.Edit] = [
        ("light", "/fill", lamp(shadow_distance=3.0, shadow_falloff=2.0, shadow_falloff_gamma=0.5))
    ]
    played(
        fading,
        [("shift", "/a", (0.25, 0.0, 0.0))],
        [("bind", "/d", "/red")],
        [("shine", "/fill", (1.0, 2.0, 3.0))],
        [("light", "/fill", lamp(shadow_distance=3.0, shadow_falloff=1.0))],
        [("remove", "/d")],
        foreseen=foreseen,
    )
