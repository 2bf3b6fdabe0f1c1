# SPDX-License-Identifier: Apache-2.0
"""What updates cost beside full traces when many objects move: the cost model's measurement.

python -m shots.bench.cost_model STAGE: shares of the stage's objects are lifted and lowered again
by 0.05 units; seconds of one thread, of the core alone.
"""

import sys
from dataclasses import replace

import numpy as np

from irt_usd import _core
from irt_usd.changes import diff
from irt_usd.report import Report
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions
from irt_usd.stage import Snapshot

SHARES = (0.02, 0.1, 0.25, 0.5, 1.0)
ROUNDS = 4
LIFT = 0.05


def lifted(snapshot: Snapshot, share: float) -> Snapshot:
    """The snapshot with about `share` of its objects, evenly chosen, moved up."""
    objects = dict(snapshot.objects)
    for index, path in enumerate(sorted(objects)):
        if index % 100 < share * 100:
            matrix = np.array(objects[path].world_from_object)
            matrix[3, 1] += LIFT
            objects[path] = replace(objects[path], world_from_object=matrix)
    return replace(snapshot, objects=objects)


def renderer(shot: Shot, snapshot: Snapshot, history: bool, cost_model: bool) -> _core.Renderer:
    """A renderer that shows the snapshot already."""
    made = _core.Renderer(
        snapshot.camera.core(),
        _core.ViewSettings(*shot.size),
        render_origin=shot.render_origin,
        history=history,
        cost_model=cost_model,
        threads=1,
    )
    made.update(diff(None, snapshot).core)
    return made


def measure(shot: Shot, snapshot: Snapshot, share: float) -> str:
    """One row: update over full trace, and a shot with the model on over full traces."""
    other = lifted(snapshot, share)
    there, back = diff(snapshot, other).core, diff(other, snapshot).core
    updating = renderer(shot, snapshot, history=True, cost_model=False)
    tracing = renderer(shot, snapshot, history=False, cost_model=False)
    choosing = renderer(shot, snapshot, history=True, cost_model=True)
    times: dict[str, list[float]] = {"update": [], "full": [], "shot": []}
    for _ in range(ROUNDS):
        for changes in (there, back):
            times["update"].append(updating.update(changes)["seconds"]["total"])
            times["full"].append(tracing.update(changes)["seconds"]["total"])
            times["shot"].append(choosing.update(changes)["seconds"]["total"])
    update = min(times["update"]) / min(times["full"])
    chosen = sum(times["shot"]) / sum(times["full"])
    return f"{share:6.0%}  update over full {update:5.2f}  shot over full traces {chosen:5.2f}"


if __name__ == "__main__":
    opened = open_shot(ShotOptions(sys.argv[1]), Report())
    first = opened.reader.read(float(opened.frames[0]))
    for moved_share in SHARES:
        print(measure(opened, first, moved_share), flush=True)
