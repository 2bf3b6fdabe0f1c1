# SPDX-License-Identifier: Apache-2.0
"""`irt bench open` and `irt bench changes`: that they measure what they say."""

import json
from pathlib import Path

from cli_support import failure, irt, write_stage
from irt_usd.bench.reading import shot_text
from irt_usd.changes import diff
from irt_usd.report import Report
from irt_usd.shot.session import open_shot
from irt_usd.shot.settings import ShotOptions


def test_changes(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    result = irt("bench", "changes", "--prims", "250", "--moving", "3", "--json", str(path))
    assert result.exit_code == 0, result.output
    assert "250 prims, 3 of them moving" in result.output
    found = json.loads(path.read_text())
    assert (found["prims"], found["moving"], found["frames"]) == (250, 3, 59)
    assert 0 < found["milliseconds"]["low"] <= found["milliseconds"]["median"]
    assert "--moving" in failure("bench", "changes", "--prims", "2", "--moving", "3")


def test_the_shot_moves_as_many_as_it_says(tmp_path: Path) -> None:
    shot = open_shot(ShotOptions(write_stage(tmp_path, shot_text(250, 7))), Report())
    first, second = (shot.reader.read(float(frame)) for frame in shot.frames[:2])
    assert len(first.objects) == 250
    assert len(diff(first, second).changes) == 7


def test_open(tmp_path: Path) -> None:
    path = tmp_path / "o.json"
    result = irt("bench", "open", write_stage(tmp_path), "--repeats", "2", "--json", str(path))
    assert result.exit_code == 0, result.output
    assert "USD opens the stage" in result.output
    found = json.loads(path.read_text())
    assert len(found["seconds"]) == 4
    assert found["own"]["median"] < found["total"]["median"]
