# SPDX-License-Identifier: Apache-2.0
"""Windows on the full frame, clipping, and several views of one scene."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import edits
import scenes
from irt_usd import _core

FRAME = (32, 24)
WINDOW = (-0.5, 0.5, -0.375, 0.375)
AOVS = scenes.AOVS


def camera(x: float = 0.0, **options: Any) -> _core.Camera:
    world = np.eye(4)
    world[3, 0] = x
    return _core.Camera(world, WINDOW, **options)


def view(start: tuple[int, int], size: tuple[int, int], samples: int = 2) -> _core.ViewSettings:
    return _core.ViewSettings(*size, samples=samples, aovs=AOVS, start=start, frame=FRAME)


def bits(renderer: _core.Renderer, number: int = 0) -> list[bytes]:
    films = [renderer.beauty(number), *(renderer.aov(name, number) for name in AOVS)]
    return [film.tobytes() for film in films]


@pytest.mark.parametrize(
    ("start", "size"),
    [((0, 0), (32, 24)), ((3, 5), (9, 11)), ((-5, -3), (42, 31)), ((31, 0), (1, 1))],
)
def test_a_pixel_is_the_same_in_every_window(start: tuple[int, int], size: tuple[int, int]) -> None:
    whole = _core.Renderer(camera(), view((-8, -8), (48, 40)), render_origin=(0, 0, 0))
    part = _core.Renderer(camera(), view(start, size), render_origin=(0, 0, 0))
    for renderer in (whole, part):
        renderer.update(edits.start("crowd").fresh())
        renderer.validate()
    left, top = start[0] + 8, start[1] + 8
    for name in (None, *AOVS):
        films = [r.beauty() if name is None else r.aov(name) for r in (whole, part)]
        cropped = films[0][top : top + size[1], left : left + size[0]]
        assert np.array_equal(cropped, films[1])


def follows(shot: edits.Shot, cameras: list[_core.Camera], start: tuple[int, int]) -> None:
    """Several views, each of which must show what a renderer of its own shows."""
    state = edits.start(shot.start)
    views = [view(start, (20, 13)), view((0, 0), FRAME, 1)]
    renderer = _core.Renderer(cameras[0], views[0], render_origin=(0, 0, 0), cost_model=False)
    renderer.add_view(cameras[1], views[1])
    changes = state.fresh()
    for number in range(len(shot.frames) + 1):
        done = renderer.update(changes, more_views=[(None, True)])
        renderer.validate()
        assert done["restart"] is None
        assert done["more_views"][0]["restart"] is None
        for index in (0, 1):
            judge = _core.Renderer(
                cameras[index], views[index], render_origin=(0, 0, 0), history=False
            )
            judge.update(state.fresh())
            assert bits(renderer, index) == bits(judge), f"frame {number}, view {index}"
        if number < len(shot.frames):
            changes = state.apply(shot.frames[number])


@settings(max_examples=40, deadline=None)
@given(
    edits.shots(),
    st.sampled_from([(0, 0), (-3, 5)]),
    st.sampled_from([0.0, 3.0, 4.5]),
    st.sampled_from([5.0, 6.0, float("inf")]),
)
def test_views_of_one_scene_are_exact(
    shot: edits.Shot, start: tuple[int, int], near: float, far: float
) -> None:
    follows(shot, [camera(clipping=(near, far)), camera(0.5)], start)


@pytest.mark.parametrize("orthographic", [False, True])
def test_clipping_keeps_what_lies_between(orthographic: bool) -> None:
    """A plane seen askew: near and far cut its depths, and nothing else changes its place."""
    changes = _core.ChangeSet()
    tilted = np.eye(4)
    tilted[:3, :3] = np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])
    tilted[3, :3] = (0, 0, -5)
    changes.set_material("m", _core.Material(emissive_color=(1, 1, 1)))
    changes.set_object("/p", _core.Quadric.plane(100, 100), tilted, "m")
    window = (-3.0, 3.0, -3.0, 3.0) if orthographic else WINDOW
    films = []
    for clipping in ((0.0, np.inf), (4.0, 6.0)):
        seen = _core.Camera(np.eye(4), window, orthographic, clipping)
        settings = _core.ViewSettings(24, 24, aovs=("depth",))
        renderer = _core.Renderer(seen, settings)
        renderer.update(changes)
        renderer.validate()
        films.append(renderer.aov("depth").copy())
        twin = renderer.brute_force_pixel(12, 3)["depth"]
        assert twin[0] == films[-1][3, 12]
    inside = (films[0] > 4) & (films[0] < 6)
    assert 0 < np.count_nonzero(inside) < np.count_nonzero(films[0])
    np.testing.assert_array_equal(films[1] > 0, inside)
    np.testing.assert_allclose(films[1][inside], films[0][inside], rtol=1e-6)


def test_moved_camera_of_one_view_leaves_the_other_alone() -> None:
    renderer = _core.Renderer(camera(), view((0, 0), FRAME), render_origin=(0, 0, 0))
    renderer.add_view(camera(0.5), view((0, 0), FRAME))
    renderer.update(edits.start("plain").fresh(), more_views=[(None, True)])
    done = renderer.update(_core.ChangeSet(), more_views=[(camera(0.25), True)])
    assert done["restart"] is None
    assert sum(done["rays"].values()) == 0
    assert done["more_views"][0]["restart"] == "camera changed"
    judge = _core.Renderer(camera(0.25), view((0, 0), FRAME), render_origin=(0, 0, 0))
    judge.update(edits.start("plain").fresh())
    assert bits(renderer, 1) == bits(judge)


@pytest.mark.parametrize("clipping", [(-1.0, 2.0), (2.0, 2.0), (np.nan, 1.0), (np.inf, np.inf)])
def test_clipping_that_shows_nothing_is_refused(clipping: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="near"):
        _core.Renderer(camera(clipping=clipping), view((0, 0), FRAME))
