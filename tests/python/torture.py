# SPDX-License-Identifier: Apache-2.0
"""Runs that are killed, starved and lied to, until they are done: the files are those of
undisturbed ones, and nothing damaged is ever used. `make torture`; tests run a short version."""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import cli_support
import killed
from irt_usd.checkpoint.container import RefusedError, read
from irt_usd.checkpoint.store import KIND, checkpoints_in

AOVS = ("--aov", "depth", "--aov", "objectId")
CELLS = ("0-20", "21-63")
_MERGED = ("merging", "part_writing")


class Shot:
    """A stage and the files of an undisturbed run of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.stage = cli_support.write_stage(folder)
        self.run(self.render(folder / "whole"))
        self.whole = {path.name: path.read_bytes() for path in (folder / "whole").iterdir()}

    def render(self, output: Path, *options: str) -> list[str]:
        pattern = str(output / "a.####.exr") if "--cells" not in options else str(output)
        sized = ("render", self.stage, *cli_support.SIZE, *AOVS, "--quiet", "--output", pattern)
        return [*sized, *options]

    def run(self, arguments: list[str], *before: str) -> int:
        line = cli_support.command(*arguments)
        if before:
            line = [*line[:1], str(Path(killed.__file__)), *before, *arguments]
        done = subprocess.run(
            line, env=cli_support.environment(), capture_output=True, text=True, check=False
        )
        if done.returncode not in (0, -signal.SIGKILL, 1):
            raise AssertionError(f"{arguments}: status {done.returncode}: {done.stderr}")
        return done.returncode

    def check(self, folder: Path, all_there: bool) -> None:
        """Every file there is one of the undisturbed run's."""
        found = {path.name: path.read_bytes() for path in folder.glob("*.exr")}
        for name, contents in found.items():
            assert contents == self.whole[name], f"{folder / name} differs"
        assert not all_there or found.keys() == self.whole.keys(), f"{folder}: files are missing"


def commands(shot: Shot, folder: Path, phase: str) -> list[list[str]]:
    """What makes the shot's files in the folder `out`, one after the other."""
    kept = ("--checkpoint-every", "1", "--checkpoint")
    if phase not in _MERGED:
        return [shot.render(folder / "out", *kept, str(folder / "kept"))]
    tasks = [
        shot.render(folder / "parts", "--cells", cells, *kept, str(folder / f"kept{cells}"))
        for cells in CELLS
    ]
    output = str(folder / "out" / "a.####.exr")
    return [*tasks, ["merge", str(folder / "parts"), "--output", output, "--quiet"]]


def kill_in_phase(shot: Shot, phase: str, source: random.Random) -> int:
    """One job, killed up to three times in `phase`; returns how often it was."""
    kills = 0
    with tempfile.TemporaryDirectory(dir=shot.folder) as name:
        folder = Path(name)
        for command in commands(shot, folder, phase):
            for _ in range(source.randint(1, 3)):
                status = shot.run(command, phase, str(source.randint(1, 4)))
                kills += status != 0
                shot.check(folder / "out", False)
            assert shot.run(command) == 0
        shot.check(folder / "out", True)
    return kills


def kill_at_random(shot: Shot, source: random.Random) -> int:
    kills = 0
    with tempfile.TemporaryDirectory(dir=shot.folder) as name:
        folder = Path(name)
        (command,) = commands(shot, folder, "")
        for _ in range(2):
            with subprocess.Popen(
                cli_support.command(*command),
                env=cli_support.environment(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            ) as running:
                try:
                    running.wait(source.uniform(0.2, 4))
                except subprocess.TimeoutExpired:
                    running.kill()
                    kills += 1
            shot.check(folder / "out", False)
        assert shot.run(command) == 0
        shot.check(folder / "out", True)
    return kills


def corrupt(shot: Shot, trials: int, source: random.Random) -> None:
    """Flips, cuts, additions and swapped blocks: each is found."""
    with tempfile.TemporaryDirectory(dir=shot.folder) as name:
        folder = Path(name)
        shot.run(shot.render(folder / "out", "--checkpoint", str(folder / "kept")))
        (path,) = checkpoints_in(folder / "kept")
        whole = path.read_bytes()
        for trial in range(trials):
            damaged = bytearray(whole)
            where = source.randrange(len(whole))
            if trial % 4 == 0:
                damaged = damaged[:where]
            elif trial % 4 == 1:
                damaged[where] ^= 1 << source.randrange(8)
            elif trial % 4 == 2:
                end = min(len(whole), where + source.randrange(1, 5000))
                damaged[where:end] = bytes(255 - byte for byte in damaged[where:end])
            else:
                damaged[where % 4096] ^= 1 << source.randrange(8)
            path.write_bytes(damaged)
            try:
                read(path, KIND).verify()
            except RefusedError:
                continue
            raise AssertionError(f"trial {trial}: damage at byte {where} was not found")


def fill_disk(shot: Shot, source: random.Random) -> None:
    """On a small file system: what is there is whole; with room again the run ends."""
    with tempfile.TemporaryDirectory(dir=shot.folder) as name:
        folder = Path(name)
        mounted = ["mount", "-t", "tmpfs", "-o", "size=1M", "tmpfs", str(folder)]
        if os.geteuid() != 0 or subprocess.run(mounted, check=False).returncode != 0:
            print("full disk: left out, for it takes root to mount a small file system")
            return
        try:
            for size in [source.randrange(8, 2000) for _ in range(8)]:
                subprocess.run(["rm", "-rf", f"{folder}/out", f"{folder}/kept"], check=True)
                resize = ["mount", "-o", f"remount,size={size}k", str(folder)]
                subprocess.run(resize, check=True)
                (command,) = commands(shot, folder, "")
                line = cli_support.command(*command)
                status = subprocess.run(
                    line, env=cli_support.environment(), capture_output=True, check=False
                ).returncode
                assert status in (0, 1, 2), status
                shot.check(folder / "out", status == 0)
                for path in checkpoints_in(folder / "kept") if status != 2 else ():
                    read(path, KIND).verify()
                subprocess.run(["mount", "-o", "remount,size=8M", str(folder)], check=True)
                assert shot.run(command) == 0
                shot.check(folder / "out", True)
        finally:
            subprocess.run(["umount", str(folder)], check=True)


def torture(runs: int, trials: int, seed: int) -> int:
    """At least `runs` kills; returns how many there were."""
    source = random.Random(seed)
    kills = 0
    with tempfile.TemporaryDirectory() as name:
        shot = Shot(Path(name))
        corrupt(shot, trials, source)
        fill_disk(shot, source)
        phases = [*killed.PHASES, "random"]
        turn = 0
        while kills < runs:
            phase = phases[turn % len(phases)]
            turn += 1
            random_time = phase == "random"
            found = (
                kill_at_random(shot, source) if random_time else kill_in_phase(shot, phase, source)
            )
            kills += found
            print(f"{phase}: {found} killed, done and the same; {kills} of {runs}", flush=True)
    return kills


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    torture(given.runs, given.trials, given.seed)
    sys.exit(0)
