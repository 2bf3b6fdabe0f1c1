# SPDX-License-Identifier: Apache-2.0
"""Lines that farm managers read."""

import json
import re
from pathlib import Path

import pytest

from cli_support import SIZE, irt, run, write_stage


def lines(tmp_path: Path, kind: str, *options: str) -> list[str]:
    output = ("--output", str(tmp_path / "out" / "a.####.exr"))
    told = run("render", write_stage(tmp_path), *SIZE, *output, "--progress", kind, *options)
    assert told.returncode == 0, told.stderr
    assert "\r" not in told.stdout + told.stderr
    assert "Error:" not in told.stdout + told.stderr
    return told.stdout.splitlines()


def test_alf(tmp_path: Path) -> None:
    found = [line for line in lines(tmp_path, "alf") if line.startswith("ALF")]
    assert all(re.fullmatch(r"ALF_PROGRESS [0-9]{2}%", line) for line in found)
    percents = [int(line.split()[1][:2]) for line in found]
    assert percents == sorted(set(percents))
    assert percents[-1] == 99


def test_openjd(tmp_path: Path) -> None:
    found = lines(tmp_path, "openjd", "--quiet")
    percents = [int(line[17:]) for line in found if line.startswith("openjd_progress: ")]
    assert percents == sorted(set(percents))
    assert percents[-1] == 100
    assert all(line.startswith("openjd_") for line in found)


def test_json(tmp_path: Path) -> None:
    found = [json.loads(line) for line in lines(tmp_path, "json")]
    assert found[-1] == {"event": "done"}
    percents = [entry["percent"] for entry in found if entry["event"] == "progress"]
    assert percents == sorted(set(percents))
    assert percents[-1] == 100


def test_bar_off_a_terminal_is_plain_lines(tmp_path: Path) -> None:
    found = [line for line in lines(tmp_path, "bar") if "%" in line]
    assert [int(line.split("%")[0]) for line in found] == [25, 50, 75, 100]


def test_none(tmp_path: Path) -> None:
    assert lines(tmp_path, "none") == []


@pytest.mark.parametrize(("kind", "line"), [("openjd", "openjd_fail: "), ("alf", "Error: ")])
def test_failures_are_told(tmp_path: Path, kind: str, line: str) -> None:
    stage = write_stage(tmp_path)
    told = irt(
        "render", stage, *SIZE, "--output", str(tmp_path / "a.####.exr"), "--progress", kind,
        "--checkpoint", str(tmp_path / "c"), "--resume", "require",
    )  # fmt: skip
    assert told.exit_code == 5
    assert [text for text in told.stdout.splitlines() if text.startswith(line)]
