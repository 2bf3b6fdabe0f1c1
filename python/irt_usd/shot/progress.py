# SPDX-License-Identifier: Apache-2.0
"""How a running shot shows itself: a live bar over a table, plain lines, or nothing.

Plain lines are whole and flushed, the percentage first and never falling, so that farm managers
can read them.
"""

import sys
import time
from types import TracebackType
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from irt_usd.shot.frames import Frame, format_frame

_PLAIN_INTERVAL = 10.0
"""Seconds between plain lines within one frame."""


class ShotProgress(Protocol):
    """What the frame loops tell."""

    def message(self, text: str) -> None:
        """A line of its own, on standard error."""

    def tracing(self, frame: Frame, fraction: float) -> None:
        """`fraction` of `frame` is traced."""

    def finished(self, row: str) -> None:
        """One more frame is done; `row` is its line in the table."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...


class QuietProgress:
    """Says messages, and nothing else."""

    def message(self, text: str) -> None:
        """Prints it."""
        print(text, file=sys.stderr, flush=True)

    def tracing(self, frame: Frame, fraction: float) -> None:
        """Nothing."""

    def finished(self, row: str) -> None:
        """Nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        pass


class PlainProgress(QuietProgress):
    """One line a frame, and one now and then within long frames."""

    def __init__(self, total: int, header: str) -> None:
        self._total = total
        self._done = 0
        self._header = header
        self._last_line = time.monotonic()

    def tracing(self, frame: Frame, fraction: float) -> None:
        """Prints a line if none was for a while."""
        if fraction < 1.0 and time.monotonic() - self._last_line >= _PLAIN_INTERVAL:
            self._print(f"{self._percent():3d}%  {format_frame(frame)}: {fraction:.0%} traced")

    def finished(self, row: str) -> None:
        """Prints the row behind its percentage."""
        self._done += 1
        self._print(f"{self._percent():3d}%  {row}")

    def __enter__(self) -> Self:
        self._print(f"      {self._header}")
        return self

    def _percent(self) -> int:
        return self._done * 100 // self._total

    def _print(self, line: str) -> None:
        self._last_line = time.monotonic()
        print(line, flush=True)


class LiveProgress:
    """A table that grows above a bar, on a terminal."""

    def __init__(self, total: int, header: str, console: Console) -> None:
        self._header = header
        self._console = console
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("frames"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            redirect_stderr=False,
        )
        self._frames = self._bar.add_task("", total=total)

    def message(self, text: str) -> None:
        """Prints it; where that is a terminal, the bar makes room for it."""
        shared = sys.stderr.isatty()
        if shared:
            self._bar.stop()
        print(text, file=sys.stderr, flush=True)
        if shared:
            self._bar.start()

    def tracing(self, frame: Frame, fraction: float) -> None:
        """Names the frame and how far it is."""
        text = f"frame {format_frame(frame)} {fraction:4.0%}"
        self._bar.update(self._frames, description=text)

    def finished(self, row: str) -> None:
        """Adds the row."""
        self._console.print(row, markup=False, highlight=False, soft_wrap=True)
        self._bar.advance(self._frames)

    def __enter__(self) -> Self:
        self._console.print(self._header, markup=False, highlight=False, style="bold")
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bar.stop()


def shot_progress(total: int, header: str, quiet: bool) -> ShotProgress:
    """The one that suits standard output."""
    if quiet:
        return QuietProgress()
    if sys.stdout.isatty():
        return LiveProgress(total, header, Console())
    return PlainProgress(total, header)
