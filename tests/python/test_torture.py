# SPDX-License-Identifier: Apache-2.0
"""The short version of `make torture`: a kill in each phase."""

import random
from pathlib import Path

import pytest

import killed
import torture


@pytest.fixture(scope="module")
def shot(tmp_path_factory: pytest.TempPathFactory) -> torture.Shot:
    return torture.Shot(tmp_path_factory.mktemp("torture"))


@pytest.mark.parametrize(
    "phase", ["tracing", "checkpoint_begun", "exr_writing", "after_renaming", "merging"]
)
def test_killed(phase: str, shot: torture.Shot, tmp_path: Path) -> None:
    for command in torture.commands(shot, tmp_path, phase):
        merged = command[0] == "merge"
        if merged or phase != "merging":
            assert shot.run(command, phase, "2") != 0
            shot.check(tmp_path / "out", False)
        assert shot.run(command) == 0
    shot.check(tmp_path / "out", True)


def test_random_damage(shot: torture.Shot) -> None:
    torture.corrupt(shot, 60, random.Random(5))


def test_phases_are_all_there() -> None:
    assert set(killed.PHASES) >= {"start_up", "reading", "merging"}
