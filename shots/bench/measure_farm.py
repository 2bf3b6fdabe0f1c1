# SPDX-License-Identifier: Apache-2.0
"""What farm jobs cost, as Markdown tables: python -m shots.bench.measure_farm KIND STAGE OPTIONS...

checkpoints   saving and loading against plain copying of the same file, and what rendering loses
splits        1 to 64 tasks by cells against as many by frames: processor seconds and makespan,
              as the longest task that ran alone (hosts are simulated: tasks run one after another)
retakes       a new version (given as `--new STAGE`) from a checkpoint against a whole new render
"""

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from irt_usd.checkpoint.container import read
from irt_usd.checkpoint.store import KIND, newest
from irt_usd.farm.cells import format_cells
from irt_usd.farm.plan import split_cells
from irt_usd.shot.frames import format_frames, parse_frames


def irt(*arguments: str) -> tuple[float, float]:
    """Seconds by the clock and of processors."""
    start = time.perf_counter()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "irt_usd", *arguments, "--quiet"], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.perf_counter() - start, used


def checkpoints(stage: str, options: Sequence[str], folder: Path) -> None:
    """One save a second is far more often than anyone would ask for."""
    output = ("--output", str(folder / "a.####.exr"))
    kept = ("--checkpoint", str(folder / "kept"))
    print("| run | seconds | processor seconds |\n| --- | --- | --- |")
    for name, more in (
        ("without checkpoints", ()),
        ("one at the end", (*kept, "--resume", "never")),
        ("one every 10 s", (*kept, "--resume", "never", "--checkpoint-every", "10s")),
        ("one a second", (*kept, "--resume", "never", "--checkpoint-every", "1s")),
    ):
        clock, used = irt("render", stage, *options, *output, *more)
        print(f"| {name} | {clock:.2f} | {used:.2f} |")
    path = newest(folder / "kept")
    size = path.stat().st_size
    start = time.perf_counter()
    shutil.copyfile(path, folder / "copy")
    with (folder / "copy").open("rb") as copy:
        os.fsync(copy.fileno())
    copied = time.perf_counter() - start
    from irt_usd import _core

    container = read(path, KIND)
    arrays = _core.ArrayWriter()
    for name in container.entries:
        arrays.add(name, container.array(name))
    start = time.perf_counter()
    arrays.write(str(folder / "again"), "{}")
    saved = time.perf_counter() - start
    start = time.perf_counter()
    read(path, KIND).verify()
    proven = time.perf_counter() - start
    print(f"\n{size / 2**20:.1f} MiB: copied and synced {copied:.3f} s, saved {saved:.3f} s"
          f" ({copied / saved:.2f} of the speed of copying), proven {proven:.3f} s")  # fmt: skip


def splits(stage: str, frames: str, options: Sequence[str], folder: Path) -> None:
    """The same number of tasks, by cells and by frames."""
    numbers = parse_frames(frames)
    print("| tasks | by | processor s | makespan s |\n| --- | --- | --- | --- |")
    for tasks in (1, 2, 4, 8, 64):
        by_cells = [
            irt("render", stage, *options, "--frames", frames, "--threads", "1",
                "--cells", format_cells(cells), "--output", str(folder / "parts"))
            for cells in split_cells(tasks)
        ]  # fmt: skip
        merged = irt("merge", str(folder / "parts"), "--output", str(folder / "m.####.exr"))
        shutil.rmtree(folder / "parts")
        used = sum(u for _, u in by_cells) + merged[1]
        longest = max(c for c, _ in by_cells) + merged[0]
        print(f"| {tasks} | cells, and the merge | {used:.1f} | {longest:.1f} |")
        edges = [i * len(numbers) // tasks for i in range(tasks + 1)]
        ranges = [numbers[a:b] for a, b in pairwise(edges) if a < b]
        by_frames = [
            irt("render", stage, *options, "--frames", format_frames(own), "--threads", "1",
                "--output", str(folder / "f.####.exr"))
            for own in ranges
        ]  # fmt: skip
        used, longest = sum(u for _, u in by_frames), max(c for c, _ in by_frames)
        print(f"| {len(ranges)} | frames | {used:.1f} | {longest:.1f} |", flush=True)


def retakes(stage: str, new: str, options: Sequence[str], folder: Path) -> None:
    """Disk used beside time saved."""
    output = ("--output", str(folder / "a.####.exr"))
    kept = ("--history", "any", "--checkpoint", str(folder / "kept"))
    old, _ = irt("render", stage, *options, *output, *kept, "--checkpoint-every", "1h")
    whole, _ = irt("render", new, *options, "--output", str(folder / "b.####.exr"))
    start = ("--from", str(folder / "kept"))
    retake, _ = irt("render", new, *options, "--output", str(folder / "c.####.exr"), *start)
    again = (*start, "--reuse-output")
    reused, _ = irt("render", new, *options, "--output", str(folder / "d.####.exr"), *again)
    size = newest(folder / "kept").stat().st_size
    print("| render | seconds |\n| --- | --- |")
    for name, seconds in (("old version, with its checkpoint", old), ("new version, whole", whole),
                          ("new version, --from", retake),
                          ("new version, --from --reuse-output", reused)):  # fmt: skip
        print(f"| {name} | {seconds:.2f} |")
    print(f"\ncheckpoint: {size / 2**20:.1f} MiB")


def main() -> None:
    """Runs one of them in a temporary folder below --work."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=["checkpoints", "splits", "retakes"])
    parser.add_argument("stage")
    parser.add_argument("--new", default="", help="retakes: the new version's stage")
    parser.add_argument("--frames", default="", help="splits: which frames")
    parser.add_argument("--work", default=None, help="a folder on the disk that is meant")
    given, options = parser.parse_known_args()
    with tempfile.TemporaryDirectory(dir=given.work) as name:
        folder = Path(name)
        if given.kind == "splits":
            splits(given.stage, given.frames, options, folder)
            return
        ranged = [*(["--frames", given.frames] if given.frames else []), *options]
        if given.kind == "checkpoints":
            checkpoints(given.stage, ranged, folder)
        else:
            retakes(given.stage, given.new, ranged, folder)


if __name__ == "__main__":
    main()
