# SPDX-License-Identifier: Apache-2.0
"""Signals that ask a command to stop: noted when they come, acted upon at safe points.

A handler that raises would do so wherever the interpreter happens to be, within USD's own import
hooks and callbacks too, which swallow the exception and go on.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(BaseException):
    """A signal asked the command to stop."""

    def __init__(self, signum: int) -> None:
        super().__init__(signum)
        self.signum = signum


_noted: list[int] = []


def check() -> None:
    """Raises Interrupted if a signal has come: a safe point.

    Raises once; what is put in order after it is not interrupted again.
    """
    if _noted and _noted[-1] > 0:
        signum = _noted[-1]
        _noted.append(0)
        raise Interrupted(signum)


@contextmanager
def signals_noted() -> Iterator[None]:
    """Notes the first of SIGNALS instead of letting it end the process; ends in a safe point.

    Only the main thread can do so; elsewhere nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(signum: int, _frame: FrameType | None) -> None:
        if not _noted:
            _noted.append(signum)

    before = {signum: signal.signal(signum, note) for signum in SIGNALS}
    try:
        yield
        check()
    finally:
        _noted.clear()
        for signum, handler in before.items():
            signal.signal(signum, handler)
