# SPDX-License-Identifier: Apache-2.0
"""`--log-file`: all that a command says, with the time it was said, at the end of a file."""

import re
import shlex
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Self, TextIO

import click

from irt_usd.errors import InputError
from irt_usd.report import Notice
from irt_usd.shot.frames import Frame
from irt_usd.shot.progress import ShotProgress

_KEY = "irt.log"
"""Key of the root context's `meta`: the open log."""

_LINE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ ")
_LONGEST_START = 32


def open_log(path: Path) -> None:
    """Has the running command log to `path`, after what is there.

    Raises InputError where it cannot be written, or is a file of another kind.
    """
    try:
        file = path.open("a+", encoding="utf-8", errors="backslashreplace")
        file.seek(0)
        try:
            begun = file.readline(_LONGEST_START)
        except UnicodeDecodeError:
            begun = "\0"
        if begun and not _LINE.match(begun):
            file.close()
            raise InputError(f"--log-file {path}: is no log of irt's; give another name")
    except OSError as error:
        raise InputError(
            f"--log-file {path}: cannot be written: {error.strerror}; give another name"
        ) from error
    root = click.get_current_context().find_root()
    root.meta[_KEY] = file
    root.call_on_close(file.close)
    log(f"irt {shlex.join(sys.argv[1:])}")


def log(text: str) -> None:
    """Adds `text` to the log, if there is one."""
    context = click.get_current_context(silent=True)
    file: TextIO | None = context.find_root().meta.get(_KEY) if context is not None else None
    if file is None:
        return
    time = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    for line in text.splitlines():
        file.write(f"{time} {line}\n")
    file.flush()


def say(text: str, quiet: bool = False) -> None:
    """Prints `text` unless `quiet`, and logs it."""
    if not quiet:
        click.echo(text)
    log(text)


def say_notices(notices: Iterable[Notice]) -> None:
    """Says them on standard error, and logs them."""
    for notice in notices:
        text = f"irt: {notice.text}"
        click.echo(text, err=True)
        log(text)


class LoggedProgress:
    """Hands on what it is told, and logs messages and rows."""

    def __init__(self, inner: ShotProgress, header: str) -> None:
        self._inner = inner
        self._header = header

    def message(self, text: str) -> None:
        """As the inner one."""
        self._inner.message(text)
        log(text)

    def tracing(self, frame: Frame, fraction: float) -> None:
        """As the inner one; not logged."""
        self._inner.tracing(frame, fraction)

    def finished(self, row: str) -> None:
        """As the inner one."""
        self._inner.finished(row)
        log(row)

    def resumed(self, count: int) -> None:
        """As the inner one."""
        self._inner.resumed(count)

    def __enter__(self) -> Self:
        self._inner.__enter__()
        log(self._header)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._inner.__exit__(kind, error, traceback)
