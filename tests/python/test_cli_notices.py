# SPDX-License-Identifier: Apache-2.0
"""What is said of a shot beside its table: where, in which order, and what `--strict` does."""

import io
import sys
from decimal import Decimal
from pathlib import Path

import pytest
from rich.console import Console

from cli_support import CAMERA, LAMP, SCENE, SHOT, SIZE, failure, irt, run, stage_of, write_stage
from irt_usd.shot.progress import LiveProgress

FADING = """def Sphere "Fading"
{
    double radius.timeSamples = {
        1: 1,
        2: nan,
        3: nan,
        4: 1,
    }
}

"""


@pytest.fixture
def fading(tmp_path: Path) -> str:
    return write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP, FADING))


@pytest.mark.parametrize("quiet", [(), ("-q",)])
@pytest.mark.parametrize("command", ["render", "verify", "changes"])
def test_notices_go_to_standard_error(
    fading: str, tmp_path: Path, command: str, quiet: tuple[str, ...]
) -> None:
    output = ("-o", str(tmp_path / "out" / "b.#.exr")) if command == "render" else ()
    result = irt(command, fading, *SIZE, *output, *quiet)
    assert result.exit_code == 0, result.output
    (line,) = result.stderr.splitlines()
    assert line.startswith("irt: skipped: the radius is nan")
    assert f"/Fading.radius in {fading} at frame 2" in line
    assert "skipped" not in result.stdout


def test_a_notice_stands_before_its_own_frames_row(fading: str, tmp_path: Path) -> None:
    result = irt("render", fading, *SIZE, "-o", str(tmp_path / "out" / "b.#.exr"))
    said = [line for line in result.output.splitlines() if "%  " in line or "skipped" in line]
    assert ["skipped" in line for line in said] == [False, True, False, False, False]


def test_strict_says_at_once_and_once_what_no_frame_can_have(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, SHOT + 'def Volume "Dust"\n{\n}\n')
    pattern = tmp_path / "out" / "b.#.exr"
    for arguments in (("render", stage, *SIZE, "-o", str(pattern)), ("verify", stage, *SIZE)):
        result = irt(*arguments, "--strict")
        assert result.exit_code == 2
        assert result.output.count("/Dust") == 1, result.output
        assert "nothing was rendered" in result.output
    assert not pattern.parent.exists()


def test_strict_says_what_became_of_the_frames(fading: str, tmp_path: Path) -> None:
    pattern = str(tmp_path / "out" / "b.#.exr")
    message = failure("render", fading, *SIZE, "-o", pattern, "--strict")
    assert "--strict: frame 2 cannot be rendered whole" in message
    assert "those before it stay" in message
    assert message.count("/Fading.radius") == 1
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["b.1.exr"]
    first = failure("render", fading, *SIZE, "-o", pattern, "--strict", "-f", "2:3")
    assert "frame 2 cannot be rendered whole; nothing was rendered" in first


def test_the_live_bar_leaves_notices_to_standard_error(monkeypatch: pytest.MonkeyPatch) -> None:
    table, errors = io.StringIO(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", errors)
    console = Console(file=table, force_terminal=True, width=80)
    for shared in (False, True):
        monkeypatch.setattr(errors, "isatty", lambda shared=shared: shared)
        with LiveProgress(2, "head", console) as progress:
            progress.tracing(Decimal(1), 0.5)
            progress.message("irt: note")
            progress.finished("row")
    assert errors.getvalue() == "irt: note\n" * 2
    assert "note" not in table.getvalue()
    assert table.getvalue().count("row") == 2


def test_usd_leaks_nothing(tmp_path: Path) -> None:
    odd = CAMERA.replace("float focal", 'token projection = "fisheye"\n    float focal')
    result = run("render", write_stage(tmp_path, stage_of(odd, SCENE, LAMP)), *SIZE)
    assert result.returncode == 2
    (line,) = result.stderr.splitlines()
    assert "/Cam.projection" in line


def test_no_camera_to_list(tmp_path: Path) -> None:
    result = irt("render", write_stage(tmp_path, stage_of(SCENE)), "--list-cameras")
    assert (result.exit_code, result.stdout) == (0, "")
    assert "no camera" in result.stderr


@pytest.mark.parametrize(("end", "what"), [("-3", "empty"), ("nan", "empty"), ("1e30", "1000000")])
def test_ranges_of_the_stage_name_its_file(tmp_path: Path, end: str, what: str) -> None:
    stage = write_stage(tmp_path, SHOT.replace("endTimeCode = 4", f"endTimeCode = {end}"))
    message = failure("render", stage, *SIZE, "-o", str(tmp_path / "b.#.exr"))
    assert stage in message
    assert what in message
