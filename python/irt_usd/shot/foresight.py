# SPDX-License-Identifier: Apache-2.0
"""What a shot says beforehand: which prims, materials and lights ever change, and where."""

from collections.abc import Sequence

from irt_usd import _core, interrupt
from irt_usd.changes import diff
from irt_usd.errors import InputError
from irt_usd.shot.frames import Frame
from irt_usd.shot.session import Shot


def foresee(shot: Shot, frames: Sequence[Frame]) -> _core.Foreseen | None:
    """Walks through the change sets of `frames`, in the order in which they will be rendered.

    Every frame is read for that, so that it is read twice in all. None where there is nothing to
    foresee: fewer than two frames, or one that cannot be read, which will be told when its turn
    comes.
    """
    if len(frames) < 2:
        return None
    reader = shot.reread()
    try:
        previous = reader.read(float(frames[0]))
        foreseen = _core.Foreseen(diff(None, previous).core)
        for frame in frames[1:]:
            interrupt.check()
            snapshot = reader.read(float(frame))
            foreseen.add(diff(previous, snapshot).core)
            previous = snapshot
    except (InputError, ValueError):
        return None
    return foreseen
