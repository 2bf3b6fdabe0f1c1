# SPDX-License-Identifier: Apache-2.0
"""USD's own diagnostics: collected, so that nothing raw reaches the terminal."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from pxr import Tf, Usd, UsdUtils

from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import prim_location

_T = TypeVar("_T")


def one_line(text: str) -> str:
    """`text` without the line breaks, object addresses and internals that USD puts into it."""
    text = re.sub(r"\(\w+ stage on stage @.*?@ <0x\w+>\)", "", text)
    text = re.sub(r",?@anon:0x\w+:[^@]*-session\.usda@", "", text)
    text = re.sub(r"pxrInternal_\w+::", "", text)
    return " ".join(text.split())


def error_lines(error: Tf.ErrorException) -> list[str]:
    """What USD says in `error`, one line an error."""
    return [one_line(getattr(part, "commentary", str(part))) for part in error.args]


def unreadable(error: Tf.ErrorException) -> str:
    """What a notice says of a prim whose reading ended in `error`."""
    return f"USD cannot read it: {'; '.join(error_lines(error))}"


def attempt(read: Callable[[], _T], prim: Usd.Prim, report: Report) -> _T | None:
    """What `read` returns; None, and `prim` reported as skipped, where USD fails."""
    try:
        return read()
    except Tf.ErrorException as error:
        report.skipped(unreadable(error), prim_location(prim))
        return None


@contextmanager
def usd_errors(source: str) -> Iterator[None]:
    """USD's errors become InputError on `source`."""
    try:
        yield
    except Tf.ErrorException as error:
        raise InputError(f"{source}: {unreadable(error)}") from None


@contextmanager
def usd_diagnostics(report: Report | None, source: str) -> Iterator[None]:
    """Warnings become mentions in `report` (dropped without one), errors InputError on `source`."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        with usd_errors(source):
            yield
    finally:
        for diagnostic in delegate.TakeUncoalescedDiagnostics():
            if report:
                report.mentioned(f"USD says: {one_line(diagnostic.commentary)}")
        del delegate
