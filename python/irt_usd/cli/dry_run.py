# SPDX-License-Identifier: Apache-2.0
"""`irt render --dry-run`: what a render would do, without tracing a ray or writing a file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from irt_usd.changes import ChangeList
    from irt_usd.shot.frames import Frame
    from irt_usd.shot.session import Shot

_NO_RAY = frozenset(("light energy only (no rays)", "what is written (no rays)"))


def dry_run(shot: "Shot", wanted: Sequence[tuple["Frame", tuple[Path, ...]]], history: str) -> None:
    """Prints for each frame what changes, what is traced for it, and its files.

    Raises InputError where a frame cannot be read.
    """
    from irt_usd import interrupt
    from irt_usd.changes import diff
    from irt_usd.cli.log import say, say_notices
    from irt_usd.shot.frames import format_frame

    say(f"{'frame':>8}  {'changed':<44}  {'traced':<10}  files")
    previous = None
    for frame, files in wanted:
        interrupt.check()
        snapshot = shot.reader.read(float(frame))
        name = format_frame(frame)
        shot.report.enforce(f"frame {name} cannot be rendered whole")
        say_notices(shot.report.take_new())
        changes = diff(previous if history != "none" else None, snapshot)
        previous = snapshot
        traced = _traced(changes)
        listed = ", ".join(_file(path) for path in files)
        say(f"{name:>8}  {changes.summary():<44}  {traced:<10}  {listed}")
    folders = dict.fromkeys(file.parent for _, files in wanted for file in files)
    for folder in folders:
        if not folder.exists():
            say(f"would create {folder}")
    say("dry run: nothing was traced or written")


def _traced(changes: "ChangeList") -> str:
    """How much is traced: by view where the views differ."""
    if changes.initial:
        return "everything"
    kinds = {change.invalidates for change in changes.changes}
    update = "update" if kinds - _NO_RAY - {"everything (restart)"} else "nothing"
    by_view = ["everything" if moved else update for moved in changes.cameras]
    return by_view[0] if len(set(by_view)) == 1 else ", ".join(by_view)


def _file(path: Path) -> str:
    return f"{path} (exists)" if path.exists() else str(path)
