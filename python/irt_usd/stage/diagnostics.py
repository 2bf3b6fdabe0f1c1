# SPDX-License-Identifier: Apache-2.0
"""USD's own diagnostics: collected, so that nothing raw reaches the terminal."""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from pxr import Sdf, Tf, Usd, UsdUtils

from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import prim_location

_T = TypeVar("_T")

_LOST_CLIP = re.compile(r"Unable to open clip layer @(.+?)@")


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
def usd_diagnostics(report: Report, stage: Usd.Stage, source: str) -> Iterator[None]:
    """Warnings become mentions in `report`; errors, and clips lost, InputError on `source`."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    said: list[str] = []
    try:
        with usd_errors(source):
            yield
    finally:
        said += diagnostics_of(delegate)
        del delegate
        for text in said:
            if not _LOST_CLIP.search(text):
                report.mentioned(f"USD says: {text}")
    refuse_lost_clips(said, stage, source)


def diagnostics_of(delegate: UsdUtils.CoalescingDiagnosticDelegate) -> list[str]:
    """What `delegate` has collected, one line each."""
    return [one_line(diagnostic.commentary) for diagnostic in delegate.TakeUncoalescedDiagnostics()]


def refuse_lost_clips(said: Iterable[str], stage: Usd.Stage, source: str) -> None:
    """Raises InputError if USD said that it cannot open value clips, whose values it then lacks."""
    found = [_LOST_CLIP.search(text) for text in said]
    lines = dict.fromkeys(_lost_clip(stage, match[1]) for match in found if match)
    if lines:
        raise InputError("\n  ".join([f"{source}: value clips cannot be read:", *lines]))


def _lost_clip(stage: Usd.Stage, asset: str) -> str:
    place, reason = "", "no such file"
    for prim in stage.TraverseAll():
        api = Usd.ClipsAPI(prim)
        for name in prim.GetMetadata("clips") or ():
            paths = [*api.ComputeClipAssetPaths(name), api.GetClipManifestAssetPath(name)]
            for path in filter(None, paths):
                if asset in (path.path, path.resolvedPath):
                    place = f"prim {prim_location(prim)}: "
                    reason = _unopened(path.resolvedPath) if path.resolvedPath else reason
    return f"{place}@{asset}@: {reason}; mend the layer, or the prim's clips"


def _unopened(file: str) -> str:
    try:
        Sdf.Layer.FindOrOpen(file)
    except Tf.ErrorException as error:
        return "; ".join(error_lines(error))
    return "no such file, or not USD"
