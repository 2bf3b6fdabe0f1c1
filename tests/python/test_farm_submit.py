# SPDX-License-Identifier: Apache-2.0
"""Jobs as they are written, and run: by OpenJD's own runner, and as a script."""

import json
import re
import signal
import subprocess
import sys
import time
import types
from pathlib import Path
from typing import Any

import pytest

from cli_support import FRAMES, SIZE, environment, failure, irt, write_stage

OPENJD = str(Path(sys.executable).with_name("openjd"))
IRT = str(Path(sys.executable).with_name("irt"))


def submit(tmp_path: Path, *options: str) -> str:
    stage = write_stage(tmp_path)
    output = ("--output", str(tmp_path / "out" / "a.####.exr"))
    told = irt("submit", stage, *SIZE, *output, "--irt", IRT, "--tasks", "2", *options)
    assert told.exit_code == 0, told.output
    return stage


def openjd(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [OPENJD, *arguments],
        capture_output=True, text=True, cwd=cwd, env=environment(), timeout=300, check=False,
    )  # fmt: skip


def parameters(bundle: Path) -> list[str]:
    values = json.loads((bundle / "parameter_values.yaml").read_text())["parameterValues"]
    return [word for v in values for word in ("-p", f"{v['name']}={v['value']}")]


def whole(tmp_path: Path, stage: str) -> dict[str, bytes]:
    output = str(tmp_path / "whole" / "a.####.exr")
    assert irt("render", stage, *SIZE, "--output", output).exit_code == 0
    return {path.name: path.read_bytes() for path in (tmp_path / "whole").iterdir()}


def merged(tmp_path: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (tmp_path / "out").glob("*.exr")}


def test_bundle_is_valid_and_runs(tmp_path: Path) -> None:
    bundle = tmp_path / "bundle"
    stage = submit(tmp_path, "--bundle", str(bundle), "--verify-frames", "1", "--name", "A shot")
    checked = openjd("check", str(bundle / "template.yaml"), cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    ran = openjd("run", str(bundle / "template.yaml"), *parameters(bundle), cwd=tmp_path)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "openjd_progress: 100" in ran.stdout
    assert merged(tmp_path) == whole(tmp_path, stage)
    assets = json.loads((bundle / "asset_references.yaml").read_text())["assetReferences"]
    assert assets["inputs"]["filenames"] == [stage]


def test_bundle_cancels_by_notice(tmp_path: Path) -> None:
    bundle = tmp_path / "bundle"
    submit(tmp_path, "--bundle", str(bundle), "--grace", "77", "--timeout", "5000")
    steps = json.loads((bundle / "template.yaml").read_text())["steps"]
    assert [step["name"] for step in steps] == ["Render", "Merge", "Verify"]
    for step in steps:
        action = step["script"]["actions"]["onRun"]
        assert action["timeout"] == 5000
        assert action["cancelation"] == {
            "mode": "NOTIFY_THEN_TERMINATE",
            "notifyPeriodInSeconds": 77,
        }


def test_a_task_that_was_cancelled_is_resumed(tmp_path: Path) -> None:
    """The runner is interrupted as soon as a task renders; a second try ends the job."""
    bundle = tmp_path / "bundle"
    stage = submit(tmp_path, "--bundle", str(bundle), "--verify-frames", "0")
    line = [OPENJD, "run", str(bundle / "template.yaml"), *parameters(bundle)]
    with subprocess.Popen(
        line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment()
    ) as running:
        assert running.stdout is not None
        for text in running.stdout:
            if "openjd_status: frame" in text or "openjd_progress: " in text:
                break
        running.send_signal(signal.SIGTERM)
        rest = running.stdout.read()
    assert running.returncode != 0, rest
    deadline = time.monotonic() + 20
    parts = tmp_path / "out" / "irt_work" / "parts"
    while list(parts.glob("*.tmp")) and time.monotonic() < deadline:
        time.sleep(0.1)
    again = openjd("run", str(bundle / "template.yaml"), *parameters(bundle), cwd=tmp_path)
    assert again.returncode == 0, again.stdout
    assert merged(tmp_path) == whole(tmp_path, stage)


def test_script_runs(tmp_path: Path) -> None:
    script = tmp_path / "job.sh"
    stage = submit(tmp_path, "--script", str(script), "--verify-frames", "2")
    ran = subprocess.run(
        [str(script)], capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert merged(tmp_path) == whole(tmp_path, stage)


def test_outline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run against a stand-in for pyoutline, which has the calls that the outline makes."""
    path = tmp_path / "job.py"
    submit(tmp_path, "--opencue", str(path), "--samples", "2")
    made: list[Any] = []

    class Shell:
        def __init__(self, name: str, command: list[str], range: str) -> None:  # noqa: A002
            self.name, self.command, self.range = name, command, range
            self.after: list[Any] = []

        def depend_all(self, other: Any) -> None:
            self.after.append(other)

    class Outline:
        def __init__(self, name: str) -> None: ...
        def add_layer(self, layer: Shell) -> None:
            made.append(layer)

    outline, modules = types.ModuleType("outline"), types.ModuleType("outline.modules")
    shell, cuerun = types.ModuleType("outline.modules.shell"), types.ModuleType("outline.cuerun")
    vars(outline).update(Outline=Outline, cuerun=cuerun)
    vars(shell).update(Shell=Shell)
    for name, module in (("outline", outline), ("outline.modules", modules),
                         ("outline.modules.shell", shell)):  # fmt: skip
        monkeypatch.setitem(sys.modules, name, module)
    exec(compile(path.read_text(), str(path), "exec"), {"__name__": "job"})
    render, merge, verify = made
    assert render.range == "0-1"
    assert "--samples 2" in render.command[-1]
    assert [layer.after for layer in (merge, verify)] == [[render], [merge]]
    for task in range(2):
        command = [word.replace("#IFRAME#", str(task)) for word in render.command]
        subprocess.run(command, check=True, env=environment(), capture_output=True)
    parts = (tmp_path / "out" / "irt_work" / "parts").glob("*.irtpart")
    assert len(list(parts)) == 2 * FRAMES


def test_bad_jobs(tmp_path: Path) -> None:
    stage = write_stage(tmp_path)
    assert "say what to write" in failure("submit", stage)
    told = irt("submit", stage, "--no-such-option", "--bundle", str(tmp_path / "b"))
    assert told.exit_code == 2
    assert re.search("No such option", told.stderr)
