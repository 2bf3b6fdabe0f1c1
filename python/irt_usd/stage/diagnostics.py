# SPDX-License-Identifier: Apache-2.0
"""USD's own diagnostics: collected, so that nothing raw reaches the terminal."""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from pxr import Sdf, Tf, Usd, UsdUtils

from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import prim_location
from irt_usd.stage.missing import missing_text, report_missing

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
def usd_diagnostics(
    report: Report, stage: Usd.Stage, source: str, missing_asset: MissingAsset
) -> Iterator[None]:
    """Warnings become mentions in `report`, errors InputError on `source`; of clips lost, either.

    Which, `missing_asset` says.
    """
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
    deal_with_lost_clips(said, stage, source, missing_asset, report)


def diagnostics_of(delegate: UsdUtils.CoalescingDiagnosticDelegate) -> list[str]:
    """What `delegate` has collected, one line each."""
    return [one_line(diagnostic.commentary) for diagnostic in delegate.TakeUncoalescedDiagnostics()]


def deal_with_lost_clips(
    said: Iterable[str], stage: Usd.Stage, source: str, policy: MissingAsset, report: Report
) -> None:
    """Looks into what USD said for value clips that it cannot open, whose values it then lacks.

    Raises InputError for damaged ones; for missing ones, if `policy` is to fail.
    """
    found = (_LOST_CLIP.search(text) for text in said)
    assets = dict.fromkeys(match[1] for match in found if match)
    missing, damaged = [], []
    for asset in assets:
        place, authored, anchored, file = _clip_in_stage(stage, asset)
        if file:
            damaged.append(f"{place}: @{asset}@: {_unopened(file)}; mend the layer")
        else:
            missing.append(missing_text(stage, place, anchored, authored))
    if damaged:
        raise InputError("\n  ".join([f"{source}: value clips cannot be read:", *damaged]))
    report_missing("value clips", missing, policy, report, source)


def _clip_in_stage(stage: Usd.Stage, asset: str) -> tuple[str, str, str, str]:
    """Of the clip `asset`: the place that names it, its path as authored and anchored, its file."""
    for prim in stage.TraverseAll():
        api = Usd.ClipsAPI(prim)
        for name in prim.GetMetadata("clips") or ():
            paths = [*api.ComputeClipAssetPaths(name), api.GetClipManifestAssetPath(name)]
            for path in filter(None, paths):
                if asset in (path.path, path.resolvedPath):
                    layer = next(s.layer for s in prim.GetPrimStack() if s.HasInfo("clips"))
                    anchored = layer.ComputeAbsolutePath(path.path)
                    return (
                        f"clips of {prim_location(prim)}",
                        path.path,
                        anchored,
                        path.resolvedPath,
                    )
    return "clips", asset, asset, ""


def _unopened(file: str) -> str:
    try:
        Sdf.Layer.FindOrOpen(file)
    except Tf.ErrorException as error:
        return "; ".join(error_lines(error))
    return "not a USD file"
