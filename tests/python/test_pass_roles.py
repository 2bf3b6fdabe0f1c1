# SPDX-License-Identifier: Apache-2.0
"""What the camera does not see, and hold-outs, in the core: against scenes without them."""

from typing import Any

import numpy as np
import pytest

import edits
import scenes
from irt_usd import _core
from scenes import Edit

WIDTH, HEIGHT = 40, 32


def film(state: scenes.State, **options: Any) -> _core.Renderer:
    renderer = scenes.renderer(WIDTH, HEIGHT, history=False, **options)
    renderer.update(state.fresh())
    return renderer


def room(*more: Edit) -> scenes.State:
    """A ball over a mirror floor, under a lamp that casts its shadow."""
    state = scenes.initial()
    ball = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0.3, 0.2, -5, 1))
    state.apply(
        [
            ("bind", "/floor", "/mirror"),
            ("remove", "/a"),
            ("object", "/ball", ("sphere", 0.5), ball, "/red"),
            ("object", "/wall", ("plane", 6.0, 6.0), ((*ball[:3], (0, 0, -8, 1))), "/red"),
            *more,
        ]
    )
    return state


def ids(renderer: _core.Renderer) -> Any:
    return np.array(renderer.aov("objectId"))


def test_the_camera_sees_past_what_is_hidden_from_it() -> None:
    seen = film(room())
    unseen = film(room(("role", "/ball", (False, False))))
    absent = film(room(("remove", "/ball")))
    ball = ids(seen) != ids(absent)
    assert ball.sum() > 20
    np.testing.assert_array_equal(ids(unseen), ids(absent))
    for name in ("depth", "normal", "position"):
        np.testing.assert_array_equal(unseen.aov(name), absent.aov(name))
    # Elsewhere its mirror image and its shadow stay, to the bit.
    np.testing.assert_array_equal(unseen.beauty()[~ball], seen.beauty()[~ball])
    assert (unseen.beauty()[~ball] != absent.beauty()[~ball]).any()


def test_cut_outs_do_not_show_what_the_camera_does_not_see() -> None:
    pane = (*edits.PLAIN[0], 0), (*edits.PLAIN[1], 0), (*edits.PLAIN[2], 0), (0, 0, -3.5, 1)
    leaf: Edit = ("object", "/leaf", ("plane", 3.0, 3.0), pane, "/leaf")
    unseen = film(room(leaf, ("role", "/ball", (False, False))))
    absent = film(room(leaf, ("remove", "/ball")))
    np.testing.assert_array_equal(ids(unseen), ids(absent))


def test_hold_outs_are_black_and_cover_nothing() -> None:
    seen = film(room())
    held = film(room(("role", "/ball", (True, True))))
    absent = film(room(("remove", "/ball")))
    ball = ids(seen) != ids(absent)
    assert (held.beauty()[ball] == 0).all()
    np.testing.assert_array_equal(held.beauty()[~ball], seen.beauty()[~ball])
    for name in ("depth", "objectId"):  # what holds out is told by what it hides
        np.testing.assert_array_equal(held.aov(name), seen.aov(name))


def test_alpha_of_hold_outs_is_by_sample() -> None:
    held = film(room(("role", "/wall", (True, True)), ("role", "/floor", (True, True))), samples=16)
    alpha = held.beauty()[..., 3]
    assert 0 < alpha.max() <= 1
    assert ((alpha > 0) & (alpha < 1)).any()


@pytest.mark.parametrize("camera_visible", [True, False])
def test_skies_hidden_from_the_camera(camera_visible: bool) -> None:
    state = room(("remove", "/wall"))
    sky = _core.Light.environment((0.25, 0.5, 1.0), camera_visible)
    state.apply([("light", "/sky", sky)])
    renderer = film(state)
    nothing = ids(renderer) == 0
    assert nothing.any()
    expected = (0.25, 0.5, 1.0) if camera_visible else (0, 0, 0)
    np.testing.assert_array_equal(renderer.beauty()[nothing][:, :3], [expected] * nothing.sum())
    state.apply([("dark", "/sky")])
    floor = ids(renderer) == ids(renderer)[-1, WIDTH // 2]
    assert (renderer.beauty()[floor] > film(state).beauty()[floor]).any()  # in the mirror it shows


def test_a_sky_that_the_camera_sees_no_more_is_an_update() -> None:
    state = room(("remove", "/wall"))
    state.apply([("light", "/sky", _core.Light.environment((0.25, 0.5, 1.0), True))])
    renderer = scenes.renderer(WIDTH, HEIGHT)
    renderer.update(state.fresh())
    for seen in (False, True):
        edit: Edit = ("light", "/sky", _core.Light.environment((0.25, 0.5, 1.0), seen))
        done = renderer.update(state.apply([edit]))
        assert done["restart"] is None
        renderer.validate()
        assert scenes.film_bits(renderer) == scenes.film_bits(film(state))


def test_parts_of_prototypes_have_roles_of_their_own() -> None:
    def pair(*role: bool) -> Any:
        ball: Any = ("q", scenes.geometry(("sphere", 0.5)), np.eye(4), "/red", {}, ())
        apart = np.eye(4)
        apart[3, 0] = 1.5
        cube, kind = scenes.geometry(("cube", 0.8)), _core.PassRole(*role)
        box: Any = ("m", cube, apart, "/lamp", {}, (), kind)
        return _core.Prototype([ball, box])

    where = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (-0.8, 0.2, -5, 1))
    state = room(("remove", "/ball"), ("object", "/pair", pair(True, False), where, ""))
    renderer = scenes.renderer(WIDTH, HEIGHT)
    renderer.update(state.fresh())
    plain = np.array(renderer.beauty())
    for role in ((True, True), (False, False), (False, True), (True, False)):
        done = renderer.update(state.apply([("object", "/pair", pair(*role), where, "")]))
        assert done["restart"] is None
        renderer.validate()
        assert scenes.film_bits(renderer) == scenes.film_bits(film(state))
        assert (np.array(renderer.beauty()) == plain).all() == (role == (True, False))
        for x, y in ((26, 14), (28, 15), (20, 20)):
            assert (renderer.brute_force_pixel(x, y)["beauty"] == renderer.beauty()[y, x]).all()


def test_roles_of_an_array_are_those_of_all_its_entries() -> None:
    array = (("array", edits.SWARM, 1.0), scenes.floor(1.0), "")
    state = room(("object", "/swarm", *array))
    renderer = scenes.renderer(WIDTH, HEIGHT)
    renderer.update(state.fresh())
    absent = film(room())
    for role in ((False, False), (True, True), (True, False), (False, True)):
        done = renderer.update(state.apply([("role", "/swarm", role)]))
        assert done["restart"] is None
        renderer.validate()
        assert scenes.film_bits(renderer) == scenes.film_bits(film(state))
        assert (ids(renderer) == ids(absent)).all() == (not role[0])


def test_what_passed_a_cut_out_may_pass_glass_then() -> None:
    """The ray is the same, and no camera ray any more: it sees what the camera does not."""
    hide: list[Edit] = [("bind", "/d", "/leaf"), ("role", "/b", (False, False))]
    hide += [("role", name, (False, False)) for name in ("/a", "/c", "/e", "/floor")]
    clear = {"opacity": 0.2, "opacity_threshold": 0.0, "ior": 1.0, "roughness": 0.0}
    glass: list[Edit] = [("look", "/leaf", clear)]
    back: list[Edit] = [("look", "/leaf", {"opacity_threshold": 0.5})]
    edits.play(edits.Shot("crowd", [hide, glass, back, glass, back], samples=4))
