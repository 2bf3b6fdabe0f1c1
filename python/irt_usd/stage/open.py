# SPDX-License-Identifier: Apache-2.0
"""Opening a stage: whatever makes it other than its author meant is an error here, not a hole."""

import os
import re
from pathlib import Path

from pxr import Pcp, Tf, Usd, UsdUtils

from irt_usd.errors import InputError
from irt_usd.stage.diagnostics import (
    diagnostics_of,
    error_lines,
    one_line,
    refuse_lost_clips,
)

_EXTENSIONS = ".usd, .usda, .usdc or .usdz"

_LOCATED = re.compile(r"(/[^\s:]+|\w:[^\s:]+):(\d+):(\d+): (.*)")
"""file:line:col: message, as USD's text parser says it."""

_ASSET = re.compile(r"Could not open asset @([^@]+)@")

_ADVICE: dict[type[Pcp.ErrorBase], str] = {
    Pcp.ErrorInvalidAssetPath: "mend the path, or deactivate the prim",
    Pcp.ErrorUnresolvedPrimPath: "name a prim that exists in that layer",
    Pcp.ErrorArcCycle: "break the cycle",
    Pcp.ErrorSublayerCycle: "remove one of the sublayers",
    Pcp.ErrorInvalidSublayerPath: "mend the path, or remove the sublayer",
}


def open_stage(path: str) -> Usd.Stage:
    """The stage of the file `path`, with all its payloads.

    Raises InputError: no such file, not USD, a layer that does not parse (with file:line:column),
    a missing sublayer, reference, payload or value clip, a cycle, or any other composition error.
    """
    file = Path(path)
    if not file.exists():
        raise InputError(f"{path}: no such file; give a USD stage ({_EXTENSIONS})")
    if file.is_dir():
        raise InputError(f"{path}: a folder, not a file; give a USD stage ({_EXTENSIONS})")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: no permission to read it; change its mode or owner")
    try:
        path.encode()
    except UnicodeEncodeError:
        raise InputError(f"{path}: its name is not UTF-8, as USD needs it; rename it") from None
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        stage = Usd.Stage.Open(path)
        said = diagnostics_of(delegate)
    except Tf.ErrorException as error:
        raise InputError(_open_failure(path, error_lines(error))) from None
    finally:
        del delegate
    errors = [e for e in stage.GetCompositionErrors() if not materialx_file(e)]
    if errors:
        raise InputError(_composition_failure(path, errors))
    refuse_lost_clips(said, stage, path)
    return stage


def materialx_file(error: Pcp.ErrorBase) -> str | None:
    """The MaterialX file that `error` is about, there but unreadable without USD's plugin for it.

    Such a file holds materials for other renderers alone, so that the stage renders without it.
    """
    if not isinstance(error, Pcp.ErrorInvalidAssetPath):
        return None
    named = _ASSET.search(str(error))
    if named and named[1].endswith(".mtlx") and Path(named[1]).exists():
        return named[1]
    return None


def _open_failure(path: str, lines: list[str]) -> str:
    for line in lines:
        located = _LOCATED.search(line)
        if located:
            file, row, column, message = located.groups()
            return f"{file}:{row}:{column}: {message}; mend the layer"
    if any("Cannot determine file format" in line for line in lines):
        return f"{path}: not a USD file by its name; give a USD stage ({_EXTENSIONS})"
    details = [line for line in lines if not line.startswith("Failed to open layer")]
    reason = "; ".join(details) or "its contents are none of USD's file formats"
    return f"{path}: not a USD file, or a damaged one: {reason}; write it again"


def _composition_failure(path: str, errors: list[Pcp.ErrorBase]) -> str:
    lines: dict[str, None] = {}
    for error in errors:
        advice = next((a for kind, a in _ADVICE.items() if isinstance(error, kind)), "mend it")
        message = one_line(str(error)).rstrip(".")
        located = _LOCATED.search(message)
        file = f"{located[1]}:{located[2]}:{located[3]}: " if located else ""
        lines[f"{file}prim <{error.rootSite.path}>: {message}; {advice}"] = None
    return "\n  ".join([f"{path}: the stage does not compose:", *lines])
