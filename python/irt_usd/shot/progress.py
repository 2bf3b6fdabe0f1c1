# SPDX-License-Identifier: Apache-2.0
"""How a running shot shows itself: a live bar over a table, plain lines, a farm manager's, nothing.

Lines are whole and flushed, and percentages integers that never fall.
"""

import json
import sys
import time
from types import TracebackType
from typing import Any, Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from irt_usd.choices import ProgressFormat
from irt_usd.interrupt import Interrupted
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

    def resumed(self, count: int) -> None:
        """So many frames were done before."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...


class QuietProgress:
    """Says messages, and nothing else."""

    def resumed(self, count: int) -> None:
        """Nothing."""

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

    def resumed(self, count: int) -> None:
        """Counts them."""
        self._done += count

    def __enter__(self) -> Self:
        self._print(f"      {self._header}")
        return self

    def _percent(self) -> int:
        return self._done * 100 // self._total

    def _print(self, line: str) -> None:
        self._last_line = time.monotonic()
        print(line, flush=True)


class FarmProgress(QuietProgress):
    """Lines for a program to read; one for each percent at most."""

    def __init__(self, total: int, rows: bool) -> None:
        self._total = max(total, 1)
        self._rows = rows
        self._done = 0
        self._percent = -1

    def message(self, text: str) -> None:
        """Prints it, without what farm managers take for a failure."""
        super().message(_harmless(text))

    def tracing(self, frame: Frame, fraction: float) -> None:
        """Tells the percentage where it has risen."""
        self._tell((self._done + fraction) / self._total, frame)

    def finished(self, row: str) -> None:
        """Tells the row, if that is wanted, and the percentage."""
        self._done += 1
        if self._rows:
            print(_harmless(row), flush=True)
        self._tell(self._done / self._total, None)

    def resumed(self, count: int) -> None:
        """Counts them."""
        self._done += count
        self._tell(self._done / self._total, None)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is None:
            self.ended()
        elif not isinstance(error, Interrupted):
            self.failed(str(error).replace("\n", " "))

    def _tell(self, share: float, frame: Frame | None) -> None:
        percent = min(int(share * 100), 100)
        if percent > self._percent:
            self._percent = percent
            self.progress(percent, frame)

    def progress(self, percent: int, frame: Frame | None) -> None:
        """Prints a percentage."""

    def ended(self) -> None:
        """Prints what ends a shot that is done."""

    def failed(self, text: str) -> None:
        """Prints what ends one that is not."""


class AlfProgress(FarmProgress):
    """Tractor's and Houdini's lines. Some readers take two characters alone: so two digits."""

    def progress(self, percent: int, _frame: Frame | None) -> None:
        """With two digits."""
        print(f"ALF_PROGRESS {percent:02d}%", flush=True)

    def ended(self) -> None:
        """In words, which come after it."""
        self._tell(1.0, None)

    def _tell(self, share: float, frame: Frame | None) -> None:
        """At most 99: 100 would be read as 10."""
        super()._tell(min(share, 0.99), frame)

    def failed(self, text: str) -> None:
        """The line by which a task is known to have failed."""
        print(f"Error: {text}", flush=True)


class OpenJdProgress(FarmProgress):
    """Open Job Description's messages."""

    def progress(self, percent: int, frame: Frame | None) -> None:
        """Of 0 to 100."""
        print(f"openjd_progress: {percent}", flush=True)
        if frame is not None:
            print(f"openjd_status: frame {format_frame(frame)}", flush=True)

    def ended(self) -> None:
        """In full."""
        self._tell(1.0, None)

    def failed(self, text: str) -> None:
        """Why."""
        print(f"openjd_fail: {text}", flush=True)


class JsonProgress(FarmProgress):
    """An object a line."""

    def __init__(self, total: int) -> None:
        super().__init__(total, rows=False)

    def progress(self, percent: int, frame: Frame | None) -> None:
        """With the frame, where one is being traced."""
        self._print(
            event="progress",
            percent=percent,
            frame=format_frame(frame) if frame is not None else None,
        )

    def message(self, text: str) -> None:
        """As an object, too."""
        self._print(event="message", text=_harmless(text))

    def ended(self) -> None:
        """Once."""
        self._tell(1.0, None)
        self._print(event="done")

    def failed(self, text: str) -> None:
        """Why."""
        self._print(event="failed", text=text)

    def _print(self, **entries: Any) -> None:
        print(json.dumps(entries), flush=True)


def _harmless(text: str) -> str:
    """`text` without the words by which farm managers know a failure."""
    return text.replace("Error:", "error:").replace("USD ERROR", "USD error")


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

    def resumed(self, count: int) -> None:
        """Moves the bar."""
        self._bar.advance(self._frames, count)

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


def shot_progress(
    total: int, header: str, quiet: bool, kind: ProgressFormat | None = None
) -> ShotProgress:
    """Of that kind; None: the one that suits standard output."""
    if kind == "alf":
        return AlfProgress(total, not quiet)
    if kind == "openjd":
        return OpenJdProgress(total, not quiet)
    if kind == "json":
        return JsonProgress(total)
    if kind == "none" or (quiet and kind is None):
        return QuietProgress()
    if sys.stdout.isatty():
        return LiveProgress(total, header, Console())
    return PlainProgress(total, header)
