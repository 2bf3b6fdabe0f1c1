# SPDX-License-Identifier: Apache-2.0
"""`irt` that is killed in a named phase: python killed.py PHASE COUNT ARGUMENTS..."""

import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any


def kill() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def soon(seconds: float) -> Callable[[], None]:
    return lambda: threading.Timer(seconds, kill).start()


def patch(owner: Any, name: str, count: int, before: Any = None, after: Any = None) -> None:
    """Has the call of that number be preceded or followed by the end."""
    original = getattr(owner, name)
    left = [count]

    def patched(*arguments: Any, **more: Any) -> Any:
        left[0] -= 1
        if left[0] == 0 and before is not None:
            before()
        result = original(*arguments, **more)
        if left[0] == 0 and after is not None:
            after()
        return result

    setattr(owner, name, patched)


def start_up(_count: int) -> None:
    kill()


def reading(count: int) -> None:
    from irt_usd.stage import ShotReader

    patch(ShotReader, "read", count, after=kill)


def tracing(count: int) -> None:
    from irt_usd.shot.tracer import ShotTracer

    patch(ShotTracer, "_update", count, before=soon(0.002))


def checkpoint_begun(count: int) -> None:
    from irt_usd.checkpoint.store import CheckpointStore

    patch(CheckpointStore, "save", count, after=kill)


def checkpoint_written(count: int) -> None:
    from irt_usd.checkpoint.store import CheckpointStore

    patch(CheckpointStore, "save", count, after=soon(0.003 * count))


def exr_writing(count: int) -> None:
    from irt_usd.images import exr

    patch(exr, "_write_parts", count, after=kill)


def before_renaming(count: int) -> None:
    patch(Path, "replace", count, before=kill)


def after_renaming(count: int) -> None:
    patch(Path, "replace", count, after=kill)


def part_writing(count: int) -> None:
    from irt_usd.farm import partial

    patch(partial.PartialWriter, "__call__", count, before=soon(0.001))


def merging(count: int) -> None:
    from irt_usd.farm import merge

    patch(merge, "assembled", count, after=kill)


PHASES = {
    f.__name__: f
    for f in (
        start_up, reading, tracing, checkpoint_begun, checkpoint_written, exr_writing,
        before_renaming, after_renaming, part_writing, merging,
    )
}  # fmt: skip


if __name__ == "__main__":
    from irt_usd.cli.main import main

    phase, count, *arguments = sys.argv[1:]
    PHASES[phase](int(count))
    sys.argv = ["irt", *arguments]
    main()
