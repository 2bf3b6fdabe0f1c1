# SPDX-License-Identifier: Apache-2.0
"""Bad usage and bad input: one clear message, the right status, nothing half written."""

import re
from pathlib import Path

import pytest

from cli_support import (
    CAMERA,
    LAMP,
    SCENE,
    SHOT,
    SIDE_CAMERA,
    SIZE,
    failure,
    irt,
    stage_of,
    write_stage,
)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def refused(stage: str, out: Path, *options: str) -> str:
    """The message of a rendering that must be refused before anything is written."""
    message = failure("render", stage, *SIZE, "-o", str(out / "b.####.exr"), *options)
    assert not out.exists() or not list(out.iterdir())
    return message


def test_no_such_file(tmp_path: Path, out: Path) -> None:
    assert "nowhere.usda" in refused(str(tmp_path / "nowhere.usda"), out)


def test_not_usd(tmp_path: Path, out: Path) -> None:
    (tmp_path / "a.usdc").write_bytes(bytes(range(256)))
    assert "a.usdc" in refused(str(tmp_path / "a.usdc"), out)
    (tmp_path / "notes.txt").write_text("hello")
    assert "notes.txt" in refused(str(tmp_path / "notes.txt"), out)


def test_layer_that_does_not_parse(tmp_path: Path, out: Path) -> None:
    message = refused(write_stage(tmp_path, SHOT + "def {"), out)
    assert re.search(r"shot\.usda:\d+:\d+", message)


def test_missing_reference(tmp_path: Path, out: Path) -> None:
    text = stage_of(CAMERA, 'def "A" (references = @gone.usda@)\n{\n}\n')
    assert "gone.usda" in refused(write_stage(tmp_path, text), out)


def test_no_camera(tmp_path: Path, out: Path) -> None:
    assert "no camera" in refused(write_stage(tmp_path, stage_of(SCENE, LAMP)), out)


def test_several_cameras_are_listed(tmp_path: Path, out: Path) -> None:
    stage = write_stage(tmp_path, stage_of(CAMERA, SIDE_CAMERA, SCENE))
    message = refused(stage, out)
    assert "/Cam" in message
    assert "/Side" in message
    assert "--camera" in message
    assert "/Wrong" in refused(stage, out, "--camera", "/Wrong")


@pytest.mark.parametrize("frames", ["", "x", "1:", "4:1x0", "1:4x-1"])
def test_empty_or_wrong_range(tmp_path: Path, out: Path, frames: str) -> None:
    assert "--frames" in refused(write_stage(tmp_path), out, "--frames", frames)


def test_empty_range_of_the_stage(tmp_path: Path, out: Path) -> None:
    stage = write_stage(tmp_path, SHOT.replace("endTimeCode = 4", "endTimeCode = 0"))
    assert "startTimeCode 1, endTimeCode 0" in refused(stage, out)


@pytest.mark.parametrize(
    "size", ["0x0", "0x540", "960x0", "-4x4", "70000x10", "65536x65536", "wide", "9x", "9", "9x9x9"]
)
def test_sizes(tmp_path: Path, out: Path, size: str) -> None:
    assert f"--size {size}" in refused(write_stage(tmp_path), out, "--size", size)


def test_date_that_is_none(tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    assert "SOURCE_DATE_EPOCH" in refused(write_stage(tmp_path), out)


def test_range_into_one_file(tmp_path: Path) -> None:
    path = tmp_path / "b.exr"
    message = failure("render", write_stage(tmp_path), *SIZE, "-o", str(path))
    assert "4 frames but no frame token" in message
    assert not path.exists()


def test_output_that_cannot_be_written(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    (tmp_path / "file").write_text("")
    below_a_file = str(tmp_path / "file" / "b.####.exr")
    assert "cannot write in" in failure("render", stage, *SIZE, "-o", below_a_file)
    (tmp_path / "b.0002.exr").mkdir()
    in_the_way = str(tmp_path / "b.####.exr")
    assert "is a folder" in failure("render", stage, *SIZE, "-o", in_the_way)
    assert not (tmp_path / "b.0001.exr").exists()
    stats = str(tmp_path / "file" / "s.jsonl")
    pattern = str(tmp_path / "c.####.exr")
    assert "--stats" in failure("render", stage, *SIZE, "-o", pattern, "--stats", stats)


@pytest.mark.parametrize(
    "options",
    [
        ("--samples", "0"),
        ("--samples", "4097"),
        ("--samples", "two"),
        ("--max-depth", "-1"),
        ("--throughput-cutoff", "0"),
        ("--throughput-cutoff", "nan"),
        ("--mirror-roughness", "1.5"),
        ("--threads", "-1"),
        ("--isa", "mmx"),
        ("--aov", "beauty"),
        ("--history", "some"),
        ("--exr-type", "double"),
        ("--no-such-option",),
    ],
)
def test_usage(tmp_path: Path, out: Path, options: tuple[str, ...]) -> None:
    refused(write_stage(tmp_path), out, *options)


def test_camera_transform_that_is_not_a_number(tmp_path: Path, out: Path) -> None:
    stage = write_stage(tmp_path, SHOT.replace("(0, 1, 8)", "(0, nan, 8)"))
    assert "/Cam" in refused(stage, out)


BROKEN = """def Mesh "Broken"
{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 7]
}

"""


def test_broken_mesh_is_skipped_and_said(tmp_path: Path, out: Path) -> None:
    stage = write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP, BROKEN))
    result = irt("render", stage, *SIZE, "-f", "1", "-o", str(out / "b.####.exr"))
    assert result.exit_code == 0, result.output
    assert "skipped" in result.output
    assert "/Broken" in result.output
    quiet = irt("render", stage, *SIZE, "-f", "1", "-o", str(out / "q.####.exr"), "-q")
    assert "/Broken" in quiet.stderr


def test_broken_mesh_is_fatal_when_strict(tmp_path: Path, out: Path) -> None:
    stage = write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP, BROKEN))
    assert "/Broken" in refused(stage, out, "--strict")


@pytest.mark.parametrize("command", ["verify", "changes"])
def test_other_commands_refuse_alike(tmp_path: Path, command: str) -> None:
    assert "nowhere.usda" in failure(command, str(tmp_path / "nowhere.usda"))
    assert "--frames" in failure(command, write_stage(tmp_path), "-f", "x")


def test_missing_argument_and_unknown_command() -> None:
    assert irt("render").exit_code == 2
    assert irt("no-such-command").exit_code == 2


def test_defects_are_one_line_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_arguments: object) -> None:
        raise RuntimeError("boom")

    monkeypatch.setattr("irt_usd.shot.session.open_stage", broken)
    stage = write_stage(tmp_path)
    message = failure("changes", stage, status=1)
    assert message.startswith("irt: error: internal: RuntimeError: boom")
    assert "Traceback" in irt("changes", stage, "-v").stderr
