# SPDX-License-Identifier: Apache-2.0
"""What each structure is worth: the paper's edits with one of them away (`make ablation`).

Prints a table of docs/measurements.md. Counts are of one update; times are the median over repeated
updates of the processor's, one thread. Of what is away only the edits are shown that it changes.
"""

import argparse
import itertools
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
EDITS = {2: "move 1", 4: "move 7", 6: "resize", 8: "light moved", 10: "colour", 12: "light dimmed"}
LAST = 13
COUNTS = ("flagged_rays", "tested_rays", "retraced_rays", "nodes_traversed", "intersections",
          "shadings")  # fmt: skip
STILL = 1.25
"""Ratio of times from which a difference is shown where the counts are the same."""


def measured(scene: str, size: str, repeats: int) -> dict[str, dict[str, Any]]:
    """Counts and milliseconds of each edit; to be run in a process of its own."""
    from pxr import Sdf

    import core_of_test_build  # noqa: F401  first
    from irt_usd import _core
    from irt_usd.changes import diff
    from irt_usd.report import Report
    from irt_usd.shot.session import open_shot
    from irt_usd.shot.settings import ShotOptions

    layer = Sdf.Layer.FindOrOpen(scene)
    for light in layer.GetPrimAtPath("/World/lights").nameChildren:
        intensity = light.attributes["inputs:intensity"]
        for frame in range(1, LAST + 1):
            dimmed = 0.8 if frame == 12 else 1.0
            layer.SetTimeSample(intensity.path, frame, intensity.default * dimmed)
    width, height = (int(n) for n in size.split("x"))
    options = ShotOptions(stage=scene, frames=f"1-{LAST}", size=(width, height))
    shot = open_shot(options, Report())
    snapshots = [shot.reader.read(float(frame)) for frame in range(1, LAST + 1)]

    renderer = _core.Renderer(
        snapshots[0].camera.core(),
        _core.ViewSettings(width, height),
        render_origin=shot.render_origin,
        threads=1,
        cost_model=False,
    )
    renderer.update(diff(None, snapshots[0]).core)
    times: dict[str, list[float]] = {name: [] for name in EDITS.values()}
    counts: dict[str, dict[str, int]] = {}
    for _ in range(repeats):
        for before, after in itertools.pairwise(snapshots):
            changes = diff(before, after).core
            start = time.process_time()
            done = renderer.update(changes)
            seconds = time.process_time() - start
            assert done["restart"] is None
            number = snapshots.index(after) + 1
            if number in EDITS:
                times[EDITS[number]].append(1e3 * seconds)
                counts.setdefault(EDITS[number], {name: done[name] for name in COUNTS})
    return {name: {**counts[name], "ms": statistics.median(times[name])} for name in EDITS.values()}


def in_a_process(scene: str, size: str, repeats: int, without: str) -> dict[str, dict[str, Any]]:
    command = [sys.executable, __file__, "--scene", scene, "--size", size, "--measure"]
    done = subprocess.run(
        [*command, "--repeats", str(repeats)],
        env={**os.environ, "IRT_WITHOUT": without},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    result: dict[str, dict[str, Any]] = json.loads(done.stdout)
    return result


def structures() -> list[str]:
    import core_of_test_build  # noqa: F401  first
    from irt_usd import _core

    names: list[str] = _core.STRUCTURES  # type: ignore[attr-defined]
    return names


def row(name: str, edit: str, figures: dict[str, Any]) -> str:
    numbers = [f"{figures[count]:,}" for count in COUNTS]
    return f"| {name} | {edit} | {' | '.join(numbers)} | {figures['ms']:.2f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default=str(ROOT / "shots/paper/chess.usda"))
    parser.add_argument("--size", default="512x384")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--measure", action="store_true", help="one row's figures, as JSON")
    arguments = parser.parse_args()
    parameters = (arguments.scene, arguments.size, arguments.repeats)
    if arguments.measure:
        print(json.dumps(measured(*parameters)))
        return
    print("| away | edit | flagged | tested | retraced | nodes | intersections | shadings | ms |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    whole = in_a_process(*parameters, "")
    for edit, figures in whole.items():
        print(row("nothing", edit, figures))
    for name in structures():
        for edit, figures in in_a_process(*parameters, name).items():
            same = all(figures[count] == whole[edit][count] for count in COUNTS)
            if not same or figures["ms"] > STILL * whole[edit]["ms"]:
                print(row(name, edit, figures), flush=True)


if __name__ == "__main__":
    main()
