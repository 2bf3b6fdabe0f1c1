# SPDX-License-Identifier: Apache-2.0
"""`irt` as a program: signals, full disks, pipes."""

import json
import os
import resource
import signal
import subprocess
from pathlib import Path

import pytest

from cli_support import command, environment, run, write_stage
from irt_usd.images.exr import read_beauty

LONG = ("--size", "320x180", "--samples", "4", "-f", "1:4x0.001")
"""More than anyone waits for."""


def test_render_and_verify(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    rendered = run("render", stage, "--size", "32x18", "--stats", "s.jsonl", cwd=tmp_path)
    assert rendered.returncode == 0, rendered.stderr
    assert len(list((tmp_path / "out").iterdir())) == 4
    verified = run("verify", stage, "--size", "32x18", "--json", "v.json", cwd=tmp_path)
    assert verified.returncode == 0, verified.stderr
    assert json.loads((tmp_path / "v.json").read_text())["differing_pixels"] == 0


def test_more_threads_than_the_machine_has(tmp_path: Path) -> None:
    threads = str(2 * (os.cpu_count() or 1) + 1)
    result = run("verify", write_stage(tmp_path), "--size", "32x18", "--threads", threads)
    assert (result.returncode, result.stderr) == (0, "")


def test_bad_input_is_status_2(tmp_path: Path) -> None:
    result = run("render", str(tmp_path / "gone.usda"))
    assert result.returncode == 2
    assert result.stderr.startswith("irt: error: ")
    assert result.stdout == ""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_signals_leave_whole_frames(tmp_path: Path, signum: signal.Signals) -> None:
    pattern, stats = tmp_path / "out" / "b.####.###.exr", tmp_path / "s.jsonl"
    process = subprocess.Popen(
        command("render", write_stage(tmp_path), *LONG, "-o", str(pattern), "--stats", str(stats)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    assert process.stdout is not None
    for line in process.stdout:
        if " 1.002 " in line:
            break
    process.send_signal(signum)
    process.send_signal(signum)  # the second changes nothing
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 128 + signum
    assert f"stopped by {signum.name}" in errors
    assert "Traceback" not in errors
    frames = sorted((tmp_path / "out").iterdir())
    assert len(frames) >= 3
    for frame in frames:
        assert read_beauty(frame).shape == (180, 320, 3)
    assert len(stats.read_text().splitlines()) == len(frames)


def test_full_disk(tmp_path: Path) -> None:
    """A limit on the size of files stands in for the disk."""
    pattern = tmp_path / "out" / "b.####.exr"
    limit = 20_000
    result = subprocess.run(
        command("render", write_stage(tmp_path), "--size", "640x360", "-o", str(pattern)),
        capture_output=True,
        text=True,
        timeout=120,
        env=environment(),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        check=False,
    )
    assert result.returncode == 1, result.stdout + result.stderr
    assert "b.0001.exr: cannot be written" in result.stderr
    assert "Traceback" not in result.stderr
    assert list(pattern.parent.iterdir()) == []


def test_reader_that_goes_away(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    pattern = str(tmp_path / "out" / "b.#.exr")
    process = subprocess.Popen(
        command("render", stage, "--size", "32x18", "-o", pattern),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=60) == 1
    assert "Traceback" not in errors


def test_help_is_quick() -> None:
    """No library is loaded for it."""
    result = run("render", "--help")
    assert result.returncode == 0
    assert "--require-locked" in result.stdout


def shell(line: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`irt` with its standard output redirected as `line` says."""
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {line}', "sh", *command(*arguments)],
        stderr=subprocess.PIPE,
        text=True,
        timeout=120,
        env=environment(),
        check=False,
    )


def test_full_standard_output(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    pattern = str(tmp_path / "b.#.exr")
    for arguments in (("render", stage, "--size", "32x18", "-o", pattern), ("--help",)):
        result = shell(">/dev/full", *arguments)
        assert result.returncode == 1
        assert result.stderr == "irt: error: standard output: No space left on device\n"


def test_closed_standard_output(tmp_path: Path) -> None:
    pattern = tmp_path / "b.#.exr"
    arguments = ("render", write_stage(tmp_path), "--size", "32x18", "-f", "1", "-o", str(pattern))
    result = shell(">&-", *arguments)
    assert (result.returncode, result.stderr) == (0, "")
    assert read_beauty(tmp_path / "b.1.exr").shape == (18, 32, 3)


def test_verdict_is_said_before_the_disk_is_full(tmp_path: Path) -> None:
    arguments = ("verify", write_stage(tmp_path), "--size", "32x18", "-f", "1")
    result = subprocess.run(
        command(*arguments, "--json", str(tmp_path / "v.json")),
        capture_output=True,
        text=True,
        timeout=120,
        env=environment(),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10, 10)),
        check=False,
    )
    assert result.returncode == 1
    assert "exact: 1 frame, " in result.stdout
    assert "v.json: cannot be written" in result.stderr
