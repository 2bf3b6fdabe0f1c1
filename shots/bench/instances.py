# SPDX-License-Identifier: Apache-2.0
"""What a million instances take, and what moving one of them does: `python instances.py`."""

from pathlib import Path

import numpy as np

from irt_usd import _core

COUNT = 1_000_000


def resident_bytes() -> int:
    """Of this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmRSS"))


def change(ball: _core.Prototype, count: int, moved: int | None = None) -> _core.ChangeSet:
    """Balls of diameter 1 in a cube of side 1000; `moved` is in front of all others."""
    rows = np.zeros((count, 4, 3))
    rows[:, :3] = np.eye(3)
    rows[:, 3] = np.random.default_rng(1).uniform(-500, 500, (count, 3))
    if moved is not None:
        rows[moved, 3] = (0.0, 0.0, 1190.0)
    changes = _core.ChangeSet()
    changes.set_material("/m", _core.Material())
    changes.set_light("/l", _core.Light.distant((0, 0, -1), (1, 1, 1)))
    changes.set_object("/I", _core.InstanceArray([ball], rows), np.eye(4))
    return changes


def main() -> None:
    """Prints bytes an instance, and the counts and seconds of the update."""
    ball = _core.Prototype([("ball", _core.Quadric.sphere(0.5), np.eye(4), "/m", {}, ())])
    place = np.eye(4)
    place[3, 2] = 1200.0
    renderer = _core.Renderer(
        _core.Camera(place, (-0.5, 0.5, -0.5, 0.5)),
        _core.ViewSettings(64, 64),
        threads=1,
        cost_model=False,
    )
    before = resident_bytes()
    renderer.update(change(ball, COUNT))
    print(f"{(resident_bytes() - before) / COUNT:.0f} bytes an instance")
    done = renderer.update(change(ball, COUNT, moved=5))
    for name in ("all_rays", "flagged_rays", "tested_rays", "retraced_rays", "changed_rays"):
        print(f"{name} {done[name]}")
    print({phase: round(seconds, 4) for phase, seconds in done["seconds"].items()})


if __name__ == "__main__":
    main()
