# SPDX-License-Identifier: Apache-2.0
"""Contracts C1 and C2 over random scenes and edits: the film is that of a fresh renderer, whatever
the edits, threads, order of cells, trees and floating-point state of the host."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import edits
import scenes
from irt_usd import _core


@given(shot=edits.shots())
@settings(max_examples=1000, deadline=None)
def test_film_after_edits_is_that_of_a_fresh_renderer(shot: edits.Shot) -> None:
    edits.play(shot)


@given(shot=edits.shots())
@settings(max_examples=60, deadline=None)
def test_every_pixel_is_that_of_the_brute_force_twin(shot: edits.Shot) -> None:
    state = edits.start(shot.start)
    for frame in shot.frames:
        state.apply(frame)
    renderer = scenes.renderer(12, 10)
    renderer.update(state.fresh())
    for y in range(10):
        for x in range(12):
            twin = renderer.brute_force_pixel(x, y)
            assert twin["beauty"].tobytes() == renderer.beauty()[y, x].tobytes()
            for name in scenes.AOVS:
                assert twin[name].tobytes() == renderer.aov(name)[y, x].tobytes()


@given(shot=edits.shots(), order=st.permutations(range(64)))
@settings(max_examples=30, deadline=None)
def test_threads_and_cell_order_do_not_show(shot: edits.Shot, order: list[int]) -> None:
    films = set()
    for options in ({"threads": 1}, {"threads": 2}, {"threads": 3}, {"threads": 7},
                    {"cell_order": order}, {"history": False}):  # fmt: skip
        state = edits.start(shot.start)
        renderer = scenes.renderer(**options)
        renderer.update(state.fresh())
        for frame in shot.frames:
            renderer.update(state.apply(frame))
        films.add(scenes.film_bits(renderer))
    assert len(films) == 1


def test_instruction_set_does_not_show() -> None:
    state = scenes.initial()
    films = set()
    for isa in ("sse2", "sse4.2", "avx", "avx2"):
        renderer = scenes.renderer(96, 80, isa=isa)
        renderer.update(state.fresh())
        films.add(scenes.film_bits(renderer))
    assert len(films) == 1


def test_nothing_changed_costs_no_ray() -> None:
    state = scenes.initial()
    renderer = scenes.renderer()
    first = renderer.update(state.fresh())
    again = renderer.update(state.fresh())
    assert first["restart"] is None
    assert again["restart"] is None
    assert again["retraced_rays"] == 0
    assert again["shadings"] == 0
    assert again["all_rays"] == first["all_rays"] != 0


GLASS = _core.Material(opacity=0.1, roughness=0.0, ior=1.5)
OPAQUE = _core.Material(diffuse_color=(0.2, 0.4, 0.8))


@pytest.mark.parametrize(("before", "after"), [(GLASS, OPAQUE), (OPAQUE, GLASS)])
def test_rebinding_from_a_material_that_changes_in_the_same_frame(
    before: _core.Material, after: _core.Material
) -> None:
    """The new material's tint equals the old one's new tint, not the tint that was."""
    state = scenes.glass_before_floor()
    state.apply([("material", "/glass", before)])
    renderer = scenes.renderer()
    renderer.update(state.fresh())
    edits = [("material", "/glass", after), ("material", "/red", after), ("bind", "/b", "/red")]
    renderer.update(state.apply(edits))
    judge = scenes.renderer(history=False)
    judge.update(state.fresh())
    assert scenes.film_bits(renderer) == scenes.film_bits(judge)


def test_a_refused_camera_leaves_everything_as_it_was() -> None:
    state = scenes.initial()
    renderer = scenes.renderer()
    renderer.update(state.fresh())
    changes = state.apply([("move", "/a", scenes.floor(2.0))])
    with pytest.raises(ValueError, match="camera"):
        renderer.update(changes, _core.Camera(np.eye(4), (0, 0, 0, 0)))
    renderer.update(changes)
    judge = scenes.renderer(history=False)
    judge.update(state.fresh())
    assert scenes.film_bits(renderer) == scenes.film_bits(judge)


def test_removed_materials_bind_nothing() -> None:
    state = scenes.initial()
    renderer = scenes.renderer()
    renderer.update(state.fresh())
    gone = _core.ChangeSet()
    gone.remove_material("/lamp")
    renderer.update(gone)
    with pytest.raises(ValueError, match="/lamp"):
        renderer.update(scenes.State(objects=state.objects).apply([("bind", "/a", "/lamp")]))


def test_a_material_of_empty_name_casts_shadows() -> None:
    films = []
    for name in ("", "/plain"):
        state = scenes.initial()
        state.apply([("material", name, _core.Material())])
        state.apply([("object", "/b", _core.Quadric.plane(3, 3), scenes.floor(1.5), name)])
        renderer = scenes.renderer()
        renderer.update(state.fresh())
        films.append(scenes.film_bits(renderer, but="CryptoMaterial"))
    assert films[0] == films[1]


def test_updates_cost_what_changed() -> None:
    """A small object that moves a little retraces a small part; a light that dims, nothing."""
    state = scenes.initial()
    renderer = scenes.renderer(160, 120)
    renderer.update(state.fresh())
    moved = renderer.update(state.apply([("move", "/a", scenes.floor(1.01))]))
    assert 0 < moved["retraced_rays"] < 0.3 * moved["all_rays"]
    assert moved["flagged_rays"] < moved["all_rays"]
    dimmer = _core.Light.distant((0.3, -1, -0.2), (0.5, 0.5, 0.4))
    dimmed = renderer.update(state.apply([("light", "/key", dimmer)]))
    assert dimmed["restart"] is None
    assert dimmed["retraced_rays"] == dimmed["intersections"] == sum(dimmed["rays"].values()) == 0
    recolored = _core.Material(diffuse_color=(0.1, 0.8, 0.1))
    shaded = renderer.update(state.apply([("material", "/red", recolored)]))
    assert shaded["intersections"] == shaded["retraced_rays"] == 0
    assert shaded["shadings"] > 0


def test_an_update_within_an_update_is_refused() -> None:
    state = scenes.initial()
    renderer = scenes.renderer(400, 400, samples=16)
    refusals: list[int] = []

    def again(_part: float) -> None:
        if refusals:
            return  # the update may have ended by now
        with pytest.raises(RuntimeError, match="running already"):
            renderer.update(state.fresh())
        refusals.append(1)

    renderer.update(state.fresh(), on_progress=again)
    assert refusals


def test_scene_far_from_the_origin_renders_as_at_the_origin() -> None:
    """10^7 units away, for all but 0.01 % of pixels."""
    here = scenes.initial()
    away = np.array([1e7, -1e7, 1e7])
    there = scenes.State(materials=here.materials, lights=here.lights)
    for name, (shape, matrix, *others) in here.objects.items():
        moved = np.array(matrix, float)
        moved[3, :3] += away
        there.objects[name] = (shape, moved, *others)
    films = []
    for state, origin in ((here, np.zeros(3)), (there, away)):
        matrix = np.eye(4)
        matrix[3, :3] = origin
        camera = _core.Camera(matrix, (-0.6, 0.6, -0.5, 0.5))
        renderer = _core.Renderer(camera, _core.ViewSettings(480, 400))
        renderer.update(state.fresh())
        films.append(renderer.beauty().copy())
    differing = np.any(films[0] != films[1], axis=2)
    assert differing.mean() <= 1e-4


def test_a_camera_sees_from_where_it_is_whatever_the_render_origin() -> None:
    """A camera that moves leaves the render origin, which is where it was first."""
    state = scenes.initial()
    place = np.eye(4)
    place[3, :3] = (0.75, 0.25, 0.5)
    camera = _core.Camera(place, (-0.6, 0.6, -0.5, 0.5))
    settings = _core.ViewSettings(240, 200, aovs=("position",))
    renderers = [
        _core.Renderer(camera, settings, render_origin=origin)
        for origin in ((0.75, 0.25, 0.5), (0.0, 0.0, 0.0))
    ]
    renderers.append(_core.Renderer(_core.Camera(np.eye(4), (-0.6, 0.6, -0.5, 0.5)), settings))
    for renderer in renderers:
        renderer.update(state.fresh())
    assert renderers[2].update(_core.ChangeSet(), camera)["restart"] == "camera changed"
    films = [np.concatenate([r.beauty(), r.aov("position")], axis=2) for r in renderers]
    for film in films[1:]:
        differing = np.any(np.abs(film - films[0]) > 1e-4, axis=2)
        assert differing.mean() <= 1e-3


HOST_STATE = """
import ctypes, sys
import scenes
from irt_usd import _core
FLUSH_TO_ZERO_AND_TOWARDS_ZERO = 0x1F80 | 0x8040 | 0x6000
class Environment(ctypes.Structure):
    _fields_ = [("x87", ctypes.c_uint8 * 28), ("mxcsr", ctypes.c_uint32)]
libm = ctypes.CDLL("libm.so.6")
def mxcsr():
    environment = Environment()
    libm.fegetenv(ctypes.byref(environment))
    return environment
state = scenes.initial()
changes = state.fresh()  # made by the host's own arithmetic
if sys.argv[1] == "hostile":
    environment = mxcsr()
    environment.mxcsr = FLUSH_TO_ZERO_AND_TOWARDS_ZERO
    libm.fesetenv(ctypes.byref(environment))
renderer = scenes.renderer(48, 40)
renderer.update(changes)
bits = scenes.film_bits(renderer)
left = mxcsr().mxcsr & 0xFFC0
assert left == ((FLUSH_TO_ZERO_AND_TOWARDS_ZERO if sys.argv[1] == "hostile" else 0x1F80) & 0xFFC0)
import hashlib
print(hashlib.sha256(bits).hexdigest(), _core.numeric_fingerprint())
"""


def test_floating_point_state_of_the_host_neither_shows_nor_is_lost() -> None:
    """A host that left flush-to-zero and rounding towards zero on gets the same image and
    fingerprint, and finds its state as it was."""
    outputs = {
        subprocess.run(
            [sys.executable, "-c", HOST_STATE, mode],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for mode in ("plain", "hostile")
    }
    assert len(outputs) == 1


def test_a_tint_that_changes_as_its_object_goes() -> None:
    """What the object let through is not what its material now says."""
    state = scenes.glass_before_floor()
    renderer = scenes.renderer()
    renderer.update(state.fresh())
    dark = _core.Material(diffuse_color=(0, 0, 0), opacity=0.0, roughness=0.0, ior=1.0)
    renderer.update(state.apply([("remove", "/b"), ("material", "/glass", dark)]))
    judge = scenes.renderer(history=False)
    judge.update(state.fresh())
    assert scenes.film_bits(renderer) == scenes.film_bits(judge)


def test_retraced_rays_are_told_by_pixel() -> None:
    state = scenes.glass_before_floor()
    films = {}
    for threads in (1, 2):
        renderer = scenes.renderer(40, 30, samples=4, threads=threads, aovs=("irt.retraced",))
        counts: list[bytes] = []
        for frame in ([], [("move", "/a", scenes.floor(1.2))], []):
            done = renderer.update(state.fresh() if not counts else state.apply(frame))
            rays = renderer.aov("irt.retraced")
            assert rays.sum() == done["retraced_rays"]
            counts.append(rays.tobytes())
        films[threads] = counts
        state = scenes.glass_before_floor()
    assert films[1] == films[2]


@given(shot=edits.shots())
@settings(max_examples=60, deadline=None)
def test_the_cost_model_does_not_show(shot: edits.Shot) -> None:
    edits.play(replace(shot, size=(40, 32)), cost_model=True)


def test_restarts_wait_longer_each_time() -> None:
    """Everything moves in every frame: few of them record, and none twice in a row."""
    state = scenes.initial()
    state.apply([("object", "/b", _core.Quadric.sphere(2.5), scenes.floor(1.0), "/mirror")])
    renderer = scenes.renderer(64, 48, cost_model=True)
    renderer.update(state.fresh())
    recorded = []
    for frame in range(40):
        done = renderer.update(state.apply([("move", "/b", scenes.floor(1.1 - 0.1 * (frame % 2)))]))
        assert done["restart"].startswith("cost")
        recorded.append(done["history"]["all_bytes"] > 0)
    assert recorded[0] is False
    assert 2 <= sum(recorded) <= 4


def test_what_was_not_foreseen_starts_again() -> None:
    still = scenes.initial()
    foreseen = _core.Foreseen(still.fresh())
    foreseen.add(still.apply([("move", "/a", scenes.floor(1.1))]))
    unforeseen: list[list[scenes.Edit]] = [
        [("move", "/a", scenes.floor(1.2))],
        [("move", "/floor", scenes.floor(0.1))],
        [("bind", "/floor", "/mirror")],
        [("material", "/red", _core.Material())],
        [("dark", "/key")],
        [("light", "/key", _core.Light.distant((0, -1, 0), (1, 1, 0.9)))],
    ]
    for frame in unforeseen:
        state = scenes.initial()
        renderer = scenes.renderer(foreseen=foreseen)
        renderer.update(state.fresh())
        assert renderer.update(state.apply([("move", "/a", scenes.floor(1.1))]))["restart"] is None
        done = renderer.update(state.apply(frame))
        assert "foreseen" in done["restart"]
        judge = scenes.renderer(history=False)
        judge.update(state.fresh())
        assert scenes.film_bits(renderer) == scenes.film_bits(judge)


def test_what_nothing_can_reach_is_not_kept() -> None:
    state = scenes.initial()
    foreseen = _core.Foreseen(state.fresh())
    dim = ("light", "/key", _core.Light.distant((0.3, -1, -0.2), (0.5, 0.5, 0.4)))
    frames: list[list[scenes.Edit]] = [[("move", "/a", scenes.floor(1.01))], [dim]]
    for frame in frames:
        foreseen.add(state.apply(frame))
    kept = []
    for known in (None, foreseen):
        state = scenes.initial()
        renderer = scenes.renderer(160, 120, foreseen=known)
        kept.append(renderer.update(state.fresh())["history"]["nodes"])
        for frame in frames:
            assert renderer.update(state.apply(frame))["restart"] is None
        judge = scenes.renderer(160, 120, history=False)
        judge.update(state.fresh())
        assert scenes.film_bits(renderer) == scenes.film_bits(judge)
    assert kept[1] < 0.5 * kept[0]
