# SPDX-License-Identifier: Apache-2.0
"""Shots that are stopped and resumed: the same files, and every reason not to resume by name."""

import fcntl
import json
import random
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cli_support import FRAMES, SHOT, SIZE, command, environment, irt, write_stage
from irt_usd import _core
from irt_usd.checkpoint import container, keeper, provenance, store
from irt_usd.shot.writer import FrameJob, FrameWriter

AOVS = ("--aov", "irt.age", "--aov", "irt.retraced", "--aov", "depth")
Render = Callable[..., Any]


@pytest.fixture
def render(tmp_path: Path) -> Render:
    stage = write_stage(tmp_path)

    def run(*options: str, to: str = "out", checkpoint: str = "checkpoints") -> Any:
        output = ("--output", str(tmp_path / to / "a.####.exr"))
        kept = ("--checkpoint", str(tmp_path / checkpoint)) if checkpoint else ()
        return irt("render", stage, *SIZE, *output, *AOVS, *kept, *options)

    return run


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.exr")}


def stop_at(monkeypatch: pytest.MonkeyPatch, count: int, signum: signal.Signals) -> None:
    """The next run gets a signal as its frame of that number is traced; later ones get none."""
    submit = FrameWriter.submit
    left = [count]

    def submit_and_signal(writer: FrameWriter, job: FrameJob) -> None:
        submit(writer, job)
        left[0] -= 1
        if left[0] == 0:
            signal.raise_signal(signum)

    monkeypatch.setattr(FrameWriter, "submit", submit_and_signal)


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
@pytest.mark.parametrize("history", ["shot", "any", "none"])
def test_stopped_and_resumed(
    signum: signal.Signals,
    history: str,
    render: Render,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options = ("--history", history)
    stats = ("--stats", str(tmp_path / "stats.jsonl"))
    assert render(*options, to="whole", checkpoint="").exit_code == 0
    stop_at(monkeypatch, 2, signum)
    stopped = render(*options, *stats)
    assert stopped.exit_code == 75, stopped.output
    assert "to be resumed from" in stopped.stderr
    assert len(files(tmp_path / "out")) == 2
    resumed = render(*options, *stats, "--resume", "require")
    assert resumed.exit_code == 0, resumed.output
    assert "resumed after frame 2" in resumed.stderr
    assert files(tmp_path / "out") == files(tmp_path / "whole")
    told = [json.loads(line) for line in (tmp_path / "stats.jsonl").read_text().splitlines()]
    assert [frame["frame"] for frame in told] == [1, 2, 3, 4]
    assert history == "none" or [frame["restart"] for frame in told] == [None] * FRAMES
    again = render(*options, "--resume", "require")
    assert "4 frames kept" in again.stderr
    assert files(tmp_path / "out") == files(tmp_path / "whole")


def test_without_a_checkpoint_the_status_tells_the_signal(
    render: Render, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop_at(monkeypatch, 2, signal.SIGHUP)
    assert render(checkpoint="").exit_code == 128 + signal.SIGHUP


def test_asked_for(render: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stop_at(monkeypatch, 2, signal.SIGUSR1)
    assert render("--checkpoint-every", "1h").exit_code == 0
    first, last = store.checkpoints_in(tmp_path / "checkpoints")
    assert container.read(first, store.KIND).header["frame"] == "2"
    assert container.read(last, store.KIND).header["frame"] == "4"


def test_files_that_are_gone_are_made_again(render: Render, tmp_path: Path) -> None:
    render()
    whole = files(tmp_path / "out")
    (tmp_path / "out" / "a.0002.exr").unlink()
    (tmp_path / "out" / "a.0004.exr").write_bytes(b"damaged")
    told = render()
    assert "made again: 2, 4" in told.stderr
    # Layers irt.* tell of the update that made them; the others are the same.
    assert set(files(tmp_path / "out")) == set(whole)
    assert irt("verify", str(tmp_path / "shot.usda"), *SIZE).exit_code == 0


def edit_stage(folder: Path) -> None:
    path = folder / "shot.usda"
    path.write_text(path.read_text().replace("radius = 1", "radius = 1.1"))


def older(monkeypatch: pytest.MonkeyPatch) -> None:
    versions = _core.versions()
    monkeypatch.setattr(_core, "versions", lambda: {**versions, "irt": "0.0.9"})


@pytest.mark.parametrize(
    ("options", "change", "reason"),
    [
        (("--samples", "2"), None, "setting samples: 1 then, 2 now"),
        (("--isa", "avx"), None, "instruction set: avx2 then, avx now"),
        (("--size", "40x27"), None, "option size: [48, 27] then, [40, 27] now"),
        (("--exr-type", "float"), None, "output type: half then, float now"),
        (("--history", "any"), None, "history: shot then, any now"),
        (("--frames", "1:3"), None, "frames: 1:4 then, 1:3 now"),
        ((), edit_stage, "file shot.usda: has changed"),
        ((), older, "program version: 0.1.0 then, 0.0.9 now"),
    ],
)
def test_another_job_is_refused_by_name(
    options: tuple[str, ...],
    change: Any,
    reason: str,
    render: Render,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    render()
    if change is not None:
        change(monkeypatch if change is older else tmp_path)
    refused = render(*options, "--resume", "require")
    assert refused.exit_code == 5, refused.output
    assert reason in refused.stderr
    again = render(*options)
    assert again.exit_code == 0
    assert reason in again.stderr
    assert "the shot starts again" in again.stderr


def test_a_texture_under_the_same_name(render: Render, tmp_path: Path) -> None:
    import numpy as np

    from irt_usd.images.exr import Film, write_exr

    def paint(value: float) -> None:
        write_exr(tmp_path / "t.exr", Film(np.full((4, 4, 4), value, np.float32), {}), {})

    paint(0.5)
    textured = SHOT.replace(
        'def Plane "Floor"\n{',
        """def Material "Look"
{
    token outputs:surface.connect = </Look/S.outputs:surface>
    def Shader "S"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </Look/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @t.exr@
        float3 outputs:rgb
    }
}

def Plane "Floor" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    rel material:binding = </Look>""",
    )
    write_stage(tmp_path, textured)
    assert render().exit_code == 0
    paint(0.25)
    assert "file t.exr: has changed" in render("--resume", "require").stderr
    (tmp_path / "t.exr").unlink()
    gone = render("--missing-asset", "fallback", "--resume", "require")
    assert "file t.exr: is gone" in gone.stderr


def test_no_checkpoint(render: Render, tmp_path: Path) -> None:
    assert render("--resume", "require").exit_code == 5
    assert files(tmp_path / "out") == {}
    assert "--resume require" in irt("render", "x.usda", "--resume", "require").stderr


def test_never_starts_again(render: Render) -> None:
    render()
    again = render("--resume", "never")
    assert again.exit_code == 0
    assert "resumed" not in again.stderr


def test_old_ones_are_pruned(render: Render, tmp_path: Path) -> None:
    for _ in range(3):
        render("--resume", "never", "--keep", "2")
    names = [path.name for path in store.checkpoints_in(tmp_path / "checkpoints")]
    assert names == ["checkpoint.000002.irt", "checkpoint.000003.irt"]


def test_an_older_one_where_the_newest_is_damaged(render: Render, tmp_path: Path) -> None:
    render()
    render("--resume", "never")
    newest = store.checkpoints_in(tmp_path / "checkpoints")[-1]
    damaged = bytearray(newest.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    newest.write_bytes(damaged)
    told = render("--resume", "require")
    assert told.exit_code == 0
    assert "is damaged" in told.stderr
    assert "checkpoint.000001.irt: 4 frames kept" in told.stderr


def test_every_damage_is_detected(render: Render, tmp_path: Path) -> None:
    render()
    (path,) = store.checkpoints_in(tmp_path / "checkpoints")
    whole = path.read_bytes()
    source = random.Random(1)
    for trial in range(100):
        damaged = bytearray(whole)
        where = source.randrange(len(whole)) if trial % 4 else source.randrange(200)
        if trial % 5 == 0:
            damaged = damaged[:where]
        elif trial % 5 == 1:
            damaged += bytes(source.randrange(1, 5000))
        else:
            damaged[where] ^= 1 << source.randrange(8)
        path.write_bytes(damaged)
        with pytest.raises(container.RefusedError):
            container.read(path, store.KIND).verify()
    path.write_bytes(whole)
    assert irt("checkpoint", "verify", str(path)).exit_code == 0
    path.write_bytes(whole[:-1])
    assert irt("checkpoint", "verify", str(path)).exit_code == 5


def test_info(render: Render, tmp_path: Path) -> None:
    render()
    told = irt("checkpoint", "info", "--json", str(tmp_path / "checkpoints"))
    found = json.loads(told.stdout)
    assert found["frame"] == "4"
    assert found["setting samples"] == 1
    assert set(found["files"]) == {"shot.usda"}
    assert irt("checkpoint", "info", str(tmp_path / "checkpoints")).exit_code == 0
    assert irt("checkpoint", "info", str(tmp_path / "nothing")).exit_code == 2


def test_two_runs_at_once(render: Render, tmp_path: Path) -> None:
    render()
    with (tmp_path / "checkpoints" / "lock").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        refused = render()
    assert refused.exit_code == 1
    assert "another run has it (process" in refused.stderr


def test_a_folder_that_is_none(render: Render, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    refused = render(checkpoint="file")
    assert refused.exit_code == 2
    assert "--checkpoint" in refused.stderr


def test_full_disk_keeps_the_last_one_and_renders_on(render: Render, tmp_path: Path) -> None:
    assert render().exit_code == 0
    whole = files(tmp_path / "out")
    output = ("--output", str(tmp_path / "out" / "a.####.exr"))
    line = command("render", str(tmp_path / "shot.usda"), *SIZE, *output, *AOVS)
    line += ["--checkpoint", str(tmp_path / "checkpoints"), "--resume", "never"]
    told = subprocess.run(
        ["bash", "-c", 'ulimit -f 100; exec "$@"', "bash", *line],
        capture_output=True, text=True, env=environment(), timeout=120, check=False,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    assert "no checkpoint after frame 4" in told.stderr
    assert "File too large" in told.stderr
    assert files(tmp_path / "out") == whole
    assert irt("checkpoint", "verify", str(tmp_path / "checkpoints")).exit_code == 0
    assert not list((tmp_path / "checkpoints").glob("*.tmp"))


def test_schemas_are_upgraded(
    render: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    render()
    (path,) = store.checkpoints_in(tmp_path / "checkpoints")
    monkeypatch.setattr(container, "SCHEMA", 2)
    with pytest.raises(container.RefusedError, match="of schema 1"):
        container.read(path, store.KIND)
    upgrades = {1: lambda header: {**header, "schema": 2, "new": True}}
    monkeypatch.setattr(container, "UPGRADES", upgrades)
    assert container.read(path, store.KIND).header["new"]


def test_the_notice_period(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENJD_SESSION_WORKING_DIR", str(tmp_path))
    kept = object.__new__(keeper.Keeper)
    kept._options = keeper.CheckpointOptions(tmp_path, grace=7)
    assert kept._notice() == 7
    info = tmp_path / "cancel_info.json"
    for text in ("", "{}", '{"NotifyEnd": 3}', '{"NotifyEnd": "2000-01-01T00:00:00Z"}',
                 '{"NotifyEnd": "2999-01-01T00:00:00Z"}'):  # fmt: skip
        info.write_text(text)
        assert kept._notice() == 7
    from datetime import UTC, datetime, timedelta

    end = datetime.now(UTC) + timedelta(seconds=100)
    info.write_text(json.dumps({"NotifyEnd": end.strftime("%Y-%m-%dT%H:%M:%SZ")}))
    monkeypatch.setattr("irt_usd.interrupt.noted_since", lambda: 0.0)
    assert 90 < kept._notice() <= 100


def test_values_digest_by_bits() -> None:
    import numpy as np

    texts = {
        provenance._text(value)
        for value in (0, 0.0, -0.0, "0", False, None, (0,), (0.0,), ((0,),),
                      np.zeros(2), np.zeros((2, 1)), -np.zeros(2), np.zeros(2, np.float32))
    }  # fmt: skip
    assert len(texts) == 13
