# SPDX-License-Identifier: Apache-2.0
"""`irt changes`, `speedup`, `contact-sheet`, `fingerprint`, `--version` and help."""

import json
from pathlib import Path

import pytest

from cli_support import MOVING_SHOT, SIZE, irt, write_stage
from irt_usd.images.exr import read_retraced


def test_changes_as_json(tmp_path: Path) -> None:
    result = irt("changes", write_stage(tmp_path), "--json")
    assert result.exit_code == 0
    frames = json.loads(result.stdout)
    assert [frame["frame"] for frame in frames] == [1, 2, 3, 4]
    assert [len(frame["changes"]) for frame in frames] == [0, 1, 0, 2]
    (moved,) = frames[1]["changes"]
    assert (moved["prim"], moved["attribute"]) == ("/Ball", "world_from_object")
    assert moved["old"][3] == [0, 1, 0, 1]
    assert moved["new"][3] == [0.5, 1, 0, 1]
    assert moved["invalidates"] == "visibility and shading"
    dimmed = next(change for change in frames[3]["changes"] if change["prim"] == "/Lamp")
    assert dimmed == {
        "prim": "/Lamp",
        "attribute": "inputs:intensity",
        "old": 60,
        "new": 30,
        "invalidates": "light energy only (no rays)",
    }


def test_changes_as_text(tmp_path: Path) -> None:
    result = irt("changes", write_stage(tmp_path), "-f", "3:4")
    lines = result.stdout.splitlines()
    assert lines[0] == "3: first frame"
    assert "  /Lamp.inputs:intensity: 60.0 -> 30.0  [light energy only (no rays)]" in lines


def test_changes_of_a_moving_camera(tmp_path: Path) -> None:
    frames = json.loads(irt("changes", write_stage(tmp_path, MOVING_SHOT), "--json").stdout)
    assert [frame["camera"] for frame in frames] == [False, False, True, False]
    assert frames[2]["changes"][0]["invalidates"] == "everything (restart)"


def test_fingerprint() -> None:
    result = irt("fingerprint")
    assert result.exit_code == 0
    assert len(result.output.strip()) == 16
    int(result.output, 16)


def test_versions() -> None:
    result = irt("--version")
    assert result.exit_code == 0
    names = [line.split(" ")[0] for line in result.output.splitlines()]
    wanted = {"irt", "OpenUSD", "OpenImageIO", "OpenColorIO", "NumPy", "Python"}
    assert names[0] == "irt"
    assert wanted <= set(names)
    assert {"embree", "tbb", "imath"} <= {name.lower() for name in names}


def test_contact_sheet(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    assert irt("render", stage, *SIZE, "-o", str(tmp_path / "b.#.exr")).exit_code == 0
    frames = [str(tmp_path / f"b.{frame}.exr") for frame in range(1, 5)]
    sheet = tmp_path / "sheets" / "sheet.png"
    assert irt("contact-sheet", str(sheet), *frames).exit_code == 0
    assert sheet.read_bytes().startswith(b"\x89PNG")
    assert irt("contact-sheet", str(sheet), str(tmp_path / "gone.exr")).exit_code == 2


def test_heat_map(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    name = str(tmp_path / "b.#.exr")
    assert irt("render", stage, *SIZE, "-o", name, "--aov", "irt.retraced").exit_code == 0
    frames = [str(tmp_path / f"b.{frame}.exr") for frame in range(1, 5)]
    sheet = tmp_path / "heat.png"
    assert irt("contact-sheet", "--retraced", str(sheet), *frames).exit_code == 0
    assert sheet.read_bytes().startswith(b"\x89PNG")
    retraced = [float(read_retraced(Path(frame)).sum()) for frame in frames]
    assert retraced[0] > 0
    assert retraced[2] == 0  # nothing changes in frame 3
    assert irt("render", stage, *SIZE, "-o", name).exit_code == 0
    without = irt("contact-sheet", "--retraced", str(sheet), *frames)
    assert without.exit_code == 2
    assert "--aov irt.retraced" in without.output


def test_speedup(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    stats, full = tmp_path / "s.jsonl", tmp_path / "f.jsonl"
    out = ("-o", str(tmp_path / "b.#.exr"))
    assert irt("render", stage, *SIZE, *out, "--stats", str(stats)).exit_code == 0
    none = ("--history", "none", "--stats", str(full))
    assert irt("render", stage, *SIZE, *out, *none).exit_code == 0
    table = irt("speedup", str(stats), str(full))
    assert table.exit_code == 0
    assert len(table.output.splitlines()) == 6  # a header, four frames, the shot
    assert table.output.splitlines()[-1].split()[0] == "shot"
    for frame in map(json.loads, full.read_text().splitlines()):
        assert frame["seconds"]["trace"] > 0
    full.write_text("{}\n")
    refused = irt("speedup", str(stats), str(full))
    assert refused.exit_code == 2
    assert "line 1" in refused.output


@pytest.mark.parametrize(
    "command",
    [
        (), ("render",), ("verify",), ("changes",), ("speedup",), ("contact-sheet",),
        ("fingerprint",),
    ],
)  # fmt: skip
def test_help(command: tuple[str, ...]) -> None:
    assert irt(*command, "--help").exit_code == 0
