# SPDX-License-Identifier: Apache-2.0
"""A renderer restored from a file goes on as the one that was saved: films, histories, counts."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import edits
import scenes
from irt_usd import _core
from irt_usd.checkpoint.container import compose, read

COUNTS = ("restart", "all_rays", "retraced_rays", "changed_rays", "new_rays")
SIZES = ("nodes", "points")


def save(renderer: _core.Renderer, path: Path) -> None:
    arrays = _core.ArrayWriter()
    renderer.save(arrays)
    arrays.write(str(path), compose({"kind": "test"}, arrays))


def fresh(**options: Any) -> _core.Renderer:
    return scenes.renderer(aovs=(*scenes.AOVS, "irt.retraced"), **options)


def restored(state: scenes.State, path: Path, **options: Any) -> _core.Renderer:
    renderer = fresh(**options)
    container = read(path, "test")
    container.verify()
    renderer.restore(state.fresh(), container.file, container.places())
    return renderer


@given(shot=edits.shots(), data=st.data())
@settings(max_examples=80, deadline=None)
def test_restored_goes_on_as_saved(shot: edits.Shot, data: st.DataObject) -> None:
    state = edits.start(shot.start)
    renderer = fresh()
    renderer.update(state.fresh())
    stop = data.draw(st.integers(0, len(shot.frames)))
    for frame in shot.frames[:stop]:
        renderer.update(state.apply(frame))
    with tempfile.TemporaryDirectory() as folder:
        save(renderer, Path(folder, "saved"))
        twin = restored(state, Path(folder, "saved"))
    twin.validate()
    assert scenes.film_bits(twin) == scenes.film_bits(renderer)
    for frame in shot.frames[stop:]:
        changes = state.apply(frame)
        told, again = renderer.update(changes), twin.update(changes)
        assert {name: told[name] for name in COUNTS} == {name: again[name] for name in COUNTS}
        assert all(told["history"][name] == again["history"][name] for name in SIZES)
        assert scenes.film_bits(twin) == scenes.film_bits(renderer)
        assert twin.aov("irt.retraced").tobytes() == renderer.aov("irt.retraced").tobytes()
        twin.validate()
    moved = _core.Camera(np.eye(4), (-0.5, 0.7, -0.5, 0.5))
    for each in (renderer, twin):
        assert each.update(_core.ChangeSet(), moved)["restart"] == "camera changed"
        each.update(state.fresh())
        each.validate()
    assert scenes.film_bits(twin) == scenes.film_bits(renderer)


def test_an_update_after_restoring_is_no_restart(tmp_path: Path) -> None:
    state = scenes.initial()
    renderer = fresh(cost_model=True)
    renderer.update(state.fresh())
    save(renderer, tmp_path / "saved")
    twin = restored(state, tmp_path / "saved", cost_model=True)
    told = twin.update(_core.ChangeSet())
    assert told["restart"] is None
    assert told["retraced_rays"] == 0


def test_another_scene_is_refused(tmp_path: Path) -> None:
    state = scenes.initial()
    renderer = fresh()
    renderer.update(state.fresh())
    save(renderer, tmp_path / "saved")
    container = read(tmp_path / "saved", "test")
    other = scenes.crowd()
    with pytest.raises(RuntimeError, match="of another scene"):
        fresh().restore(other.fresh(), container.file, container.places())
    places = container.places()
    del places["view0.cell07.nodes"]
    with pytest.raises(RuntimeError, match=r"view0\.cell07\.nodes: is not there"):
        fresh().restore(state.fresh(), container.file, places)
    with pytest.raises(RuntimeError, match="of another film"):
        fresh(width=48).restore(state.fresh(), container.file, container.places())
