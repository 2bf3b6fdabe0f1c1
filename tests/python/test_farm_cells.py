# SPDX-License-Identifier: Apache-2.0
"""Shots split by cells and merged: the same files as unsplit ones, and nothing less is accepted."""

import random
import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from cli_support import FRAMES, SIZE, failure, irt, write_stage
from irt_usd.errors import InputError
from irt_usd.farm.cells import CELLS, format_cells, parse_cells
from irt_usd.farm.plan import split_cells

AOVS = ("--aov", "depth", "--aov", "normal", "--aov", "objectId")


@pytest.mark.parametrize(
    ("text", "cells"),
    [
        ("5", (5,)),
        ("0-3", (0, 1, 2, 3)),
        ("0-2,40-46:2", (0, 1, 2, 40, 42, 44, 46)),
        ("40-40, 3", (3, 40)),
        ("8,9,20-24", (8, 9, 20, 21, 22, 23, 24)),
    ],
)
def test_ranges(text: str, cells: tuple[int, ...]) -> None:
    assert parse_cells(text) == cells
    assert parse_cells(format_cells(cells)) == cells


@pytest.mark.parametrize("text", ["", "64", "3-1", "1-5:0", "a", "1,,2", "0-5,5", "-1", "1.5"])
def test_bad_ranges(text: str) -> None:
    with pytest.raises(InputError, match="--cells"):
        parse_cells(text)


def test_any_set_reads_back() -> None:
    source = random.Random(2)
    for _ in range(200):
        cells = tuple(sorted(source.sample(range(CELLS), source.randint(1, CELLS))))
        assert parse_cells(format_cells(cells)) == cells


def test_groups_have_every_cell_once() -> None:
    for tasks in range(1, CELLS + 1):
        groups = split_cells(tasks)
        assert len(groups) == tasks
        assert sorted(cell for group in groups for cell in group) == list(range(CELLS))
        assert max(map(len, groups)) - min(map(len, groups)) <= 1


def part(stage: str, cells: str, folder: Path, *options: str) -> Any:
    return irt("render", stage, *SIZE, *AOVS, "--cells", cells, "--output", str(folder), *options)


@pytest.fixture
def split(tmp_path: Path) -> tuple[str, Path]:
    """A stage, and a folder with the parts of two tasks."""
    stage = write_stage(tmp_path)
    for cells in ("0-30,40-60:2", "31-39,41-59:2,61-63"):
        told = part(stage, cells, tmp_path / "parts")
        assert told.exit_code == 0, told.output
    return stage, tmp_path / "parts"


def merge(folder: Path, to: Path) -> Any:
    return irt("merge", str(folder), "--output", str(to / "a.####.exr"))


def test_merged_is_unsplit(split: tuple[str, Path], tmp_path: Path) -> None:
    stage, parts = split
    whole = ("--output", str(tmp_path / "whole" / "a.####.exr"))
    assert irt("render", stage, *SIZE, *AOVS, *whole).exit_code == 0
    told = merge(parts, tmp_path / "merged")
    assert told.exit_code == 0, told.output
    for frame in range(1, FRAMES + 1):
        name = f"a.{frame:04d}.exr"
        same = (tmp_path / "merged" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
        assert same, name


def test_any_split(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    window = ("--region=-0.1,0.2,0.7,1.1", "--frames", "1:2", "--samples", "3")
    whole = ("--output", str(tmp_path / "whole" / "a.####.exr"))
    assert irt("render", stage, *SIZE, *AOVS, *window, *whole).exit_code == 0
    source = random.Random(3)
    cells = source.sample(range(CELLS), CELLS)
    edges = [0, *sorted(source.sample(range(1, CELLS), 2)), CELLS]
    for index, (a, b) in enumerate(pairwise(edges)):
        own = format_cells(sorted(cells[a:b]))
        assert part(stage, own, tmp_path / "parts" / str(index), *window).exit_code == 0
    folders = [str(path) for path in (tmp_path / "parts").iterdir()]
    output = ("--output", str(tmp_path / "merged" / "a.####.exr"))
    told = irt("merge", *folders, *output)
    assert told.exit_code == 0, told.output
    for path in (tmp_path / "whole").iterdir():
        assert (tmp_path / "merged" / path.name).read_bytes() == path.read_bytes()


def test_a_task_resumes(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    kept = ("--checkpoint", str(tmp_path / "checkpoint"))
    assert part(stage, "0-7", tmp_path / "parts", *kept).exit_code == 0
    assert "4 frames kept" in part(stage, "0-7", tmp_path / "parts", *kept).stderr
    refused = part(stage, "0-8", tmp_path / "parts", *kept, "--resume", "require")
    assert refused.exit_code == 5
    assert "cells: [0, 1, 2, 3, 4, 5, 6, 7] then" in refused.stderr


def test_a_lost_cell(split: tuple[str, Path], tmp_path: Path) -> None:
    _, parts = split
    next(parts.glob("*0003*cells31*")).unlink()
    told = failure("merge", str(parts), "--output", str(tmp_path / "m" / "a.####.exr"))
    assert "frame 3: cells 31-39,41-61:2,62-63 are missing" in told
    assert not (tmp_path / "m").exists()


def test_a_cell_twice(split: tuple[str, Path], tmp_path: Path) -> None:
    stage, parts = split
    part(stage, "5", parts)
    told = failure("merge", str(parts), "--output", str(tmp_path / "a.####.exr"))
    assert "frame 1: cells 5 are both in" in told


def test_parts_of_another_job(split: tuple[str, Path], tmp_path: Path) -> None:
    stage, parts = split
    shutil.rmtree(parts)
    part(stage, "0-31", parts)
    part(stage, "32-63", parts, "--samples", "2")
    told = failure("merge", str(parts), "--output", str(tmp_path / "a.####.exr"))
    assert "setting samples: 1 then, 2 now" in told


def test_parts_of_an_edited_stage(split: tuple[str, Path], tmp_path: Path) -> None:
    stage, parts = split
    Path(stage).write_text(Path(stage).read_text().replace("radius = 1", "radius = 1.25"))
    part(stage, "31-39,41-59:2,61-63", parts)
    told = failure("merge", str(parts), "--output", str(tmp_path / "a.####.exr"))
    assert "file shot.usda: another than" in told


def test_a_damaged_part(split: tuple[str, Path], tmp_path: Path) -> None:
    _, parts = split
    path = next(parts.glob("*0002*"))
    path.write_bytes(path.read_bytes()[:-3])
    told = failure("merge", str(parts), "--output", str(tmp_path / "a.####.exr"))
    assert path.name in told
    assert "render it again" in told


def test_nothing_to_merge(tmp_path: Path) -> None:
    assert "no partial frames" in failure("merge", str(tmp_path), "--output", "a.####.exr")
    assert "no such folder" in failure("merge", "nowhere", "--output", "a.####.exr")
