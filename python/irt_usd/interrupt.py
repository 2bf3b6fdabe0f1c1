# SPDX-License-Identifier: Apache-2.0
"""Signals that ask a command to stop: noted when they come, acted upon at safe points.

A handler that raises would do so wherever the interpreter happens to be, within USD's own import
hooks and callbacks too, which swallow the exception and go on.
"""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_AGAIN = 2.0
"""Seconds within which a signal may be repeated without meaning more by it."""


class Interrupted(BaseException):
    """A signal asked the command to stop. `checkpoint`: what it can be resumed from, or empty."""

    def __init__(self, signum: int, checkpoint: str = "") -> None:
        super().__init__(signum)
        self.signum = signum
        self.checkpoint = checkpoint


_noted: list[int] = []
_first_at = 0.0
_impatient = False
_allowance: Callable[[], float] | None = None


def noted() -> int | None:
    """The signal that has come and was not yet acted upon."""
    return _noted[-1] if _noted and _noted[-1] > 0 else None


def noted_since() -> float:
    """Seconds since it came."""
    return time.monotonic() - _first_at


def check() -> None:
    """Raises Interrupted if a signal has come: a safe point.

    Raises once; what is put in order after it is not interrupted again. Within `work_goes_on`, not
    before the time allowed is up.
    """
    if noted() is None:
        return
    if _allowance is not None and not _impatient and noted_since() < _allowance():
        return
    stop()


def stop() -> None:
    """Raises Interrupted for the signal that has come."""
    signum = _noted[-1]
    _noted.append(0)
    raise Interrupted(signum)


@contextmanager
def work_goes_on(seconds: Callable[[], float]) -> Iterator[None]:
    """After a signal `check` lets work go on for so long, unless Ctrl-C is pressed again."""
    global _allowance
    _allowance = seconds
    try:
        yield
    finally:
        _allowance = None


@contextmanager
def signals_noted() -> Iterator[None]:
    """Notes the first of SIGNALS instead of letting it end the process; ends in a safe point.

    Only the main thread can do so; elsewhere nothing changes. A signal that is ignored, as SIGHUP
    is under nohup, stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(signum: int, _frame: FrameType | None) -> None:
        global _first_at, _impatient
        if not _noted:
            _noted.append(signum)
            _first_at = time.monotonic()
        elif signum == signal.SIGINT and noted_since() > _AGAIN:
            _impatient = True

    global _impatient
    taken = [s for s in SIGNALS if signal.getsignal(s) is not signal.SIG_IGN]
    before = {signum: signal.signal(signum, note) for signum in taken}
    try:
        yield
        check()
    finally:
        _noted.clear()
        _impatient = False
        for signum, handler in before.items():
            signal.signal(signum, handler)
