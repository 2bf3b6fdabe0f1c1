# SPDX-License-Identifier: Apache-2.0
"""Opening a stage: whatever makes it other than its author meant is an error here, not a hole."""

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pxr import Ar, Pcp, Sdf, Tf, Usd, UsdUtils

from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError, MachineError
from irt_usd.materialx.compose import open_with_materialx
from irt_usd.report import Report
from irt_usd.stage.diagnostics import (
    deal_with_lost_clips,
    diagnostics_of,
    error_lines,
    one_line,
)
from irt_usd.stage.missing import missing_text, report_missing
from irt_usd.stage.packages import package_fault

_OLDEST = (24, 11)
"""The first OpenUSD that serves."""

_EXTENSIONS = ".usd, .usda, .usdc or .usdz"

_LOCATED = re.compile(r"(/[^\s:]+|\w:[^\s:]+):(\d+):(\d+): (.*)")
"""file:line:col: message, as USD's text parser says it."""

_LOST_ARC = re.compile(
    r"Could not open asset @([^@]+)@ for (\w+) introduced by @([^@]+)@<([^>]+)>(.*)"
)
_LOST_SUBLAYER = re.compile(r"Could not load sublayer @([^@]+)@ of layer @([^@]+)@(.*); skipping")

_ADVICE: dict[type[Pcp.ErrorBase], str] = {
    Pcp.ErrorInvalidAssetPath: "mend the path, or deactivate the prim",
    Pcp.ErrorUnresolvedPrimPath: "name a prim that exists in that layer",
    Pcp.ErrorArcCycle: "break the cycle",
    Pcp.ErrorSublayerCycle: "remove one of the sublayers",
    Pcp.ErrorInvalidSublayerPath: "mend the path, or remove the sublayer",
}

_MASK_FOLLOWS = ("material:binding", "skel:", "prototypes")
"""Starts of the names of relationships whose targets a masked prim cannot be drawn without."""


@dataclass(frozen=True)
class OpenOptions:
    """How a stage is opened.

    `session_layer`: a file whose opinions are the strongest. `mask`: paths of the prims that alone
    are there, with their ancestors, their descendants and what those are bound to; empty: all.
    `asset_path`: folders searched for assets, after the stage's own and before those of
    PXR_AR_DEFAULT_SEARCH_PATH. `missing_asset`: what becomes of a shot whose layers name others
    that are not there.
    """

    session_layer: str | None = None
    mask: tuple[str, ...] = ()
    asset_path: tuple[str, ...] = ()
    missing_asset: MissingAsset = "fail"


def open_stage(
    path: str, options: OpenOptions | None = None, report: Report | None = None
) -> Usd.Stage:
    """The stage of the file `path`, with all its payloads.

    What is missing goes to `report` unless it is an error. Raises InputError: no such file, not
    USD, a layer that does not parse (with file:line:column), a cycle or any other composition
    error, a mask that names no prim; if missing assets are refused, a missing sublayer, reference,
    payload or value clip.
    """
    _check_version()
    options = options or OpenOptions()
    report = report or Report()
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        stage = open_with_materialx(lambda: _compose(path, options))
        said = diagnostics_of(delegate)
    finally:
        del delegate
    _deal_with_errors(path, stage, options.missing_asset, report)
    for prim_path in options.mask:
        if not stage.GetPrimAtPath(prim_path):
            raise InputError(f"--mask {prim_path}: {path} has no such prim; give paths that it has")
    deal_with_lost_clips(said, stage, path, options.missing_asset, report)
    return stage


def _check_version() -> None:
    """Raises MachineError on an OpenUSD that lacks what reading a stage needs."""
    found = tuple(Usd.GetVersion())[1:]
    if found < _OLDEST:
        file, (year, month) = getattr(Usd, "__file__", "pxr"), _OLDEST
        raise MachineError(
            f"OpenUSD {found[0]}.{found[1]:02d} ({file}): irt needs {year}.{month:02d} or newer;"
            " put a newer pxr first on PYTHONPATH, or install irt-usd[usd]"
        )


def _compose(path: str, options: OpenOptions) -> Usd.Stage:
    """The stage as USD makes it, errors of composition and all."""
    for file in filter(None, (path, options.session_layer)):
        _check_file(file)
    context = _resolver_context(path, options.asset_path)
    with Ar.ResolverContextBinder(context):
        root = _open_layer(path)
        session = Sdf.Layer.CreateAnonymous("irt-session.usda")
        if options.session_layer is not None:
            session = _open_layer(options.session_layer)
    if not options.mask:
        return Usd.Stage.Open(root, session, context)
    mask = Usd.StagePopulationMask([_prim_path(text) for text in options.mask])
    stage = Usd.Stage.OpenMasked(root, session, context, mask)
    stage.ExpandPopulationMask(
        lambda relationship: relationship.GetName().startswith(_MASK_FOLLOWS),
        lambda _: True,
    )
    return stage


def _resolver_context(path: str, asset_path: Sequence[str]) -> Ar.ResolverContext:
    """USD's own for the stage, its search path grown by `asset_path`."""
    context = Ar.GetResolver().CreateDefaultContextForAsset(path)
    if not asset_path:
        return context
    for folder in asset_path:
        if not Path(folder).is_dir():
            raise InputError(f"--asset-path {folder}: no such folder; give one that holds assets")
    folders: list[str] = []
    others = []
    for part in context.Get():
        if isinstance(part, Ar.DefaultResolverContext):
            folders += part.GetSearchPath()
        else:
            others.append(part)
    folders += (str(Path(folder).absolute()) for folder in asset_path)
    return Ar.ResolverContext(Ar.DefaultResolverContext(folders), *others)


def _prim_path(text: str) -> Sdf.Path:
    if not Sdf.Path.IsValidPathString(text)[0]:
        raise InputError(f"--mask {text}: not a prim path; write /World/Chair")
    path = Sdf.Path(text)
    if not path.IsAbsoluteRootOrPrimPath() or not path.IsAbsolutePath():
        raise InputError(f"--mask {text}: not an absolute prim path; write /World/Chair")
    return path


def _check_file(path: str) -> None:
    """Raises InputError unless `path` is a file that USD could read, whatever is in it.

    Or an asset that the site's resolver finds.
    """
    file = Path(path)
    if not file.exists() and Ar.GetResolver().Resolve(path):
        return  # found elsewhere, or no file at all: what it is the resolver knows
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
    fault = package_fault(path) if _is_package(path) else None
    if fault is not None:
        raise InputError(f"{path}: a damaged package: {fault}; write it again")


def _is_package(path: str) -> bool:
    return path.lower().endswith(".usdz")


def _damaged_packages(stage: Usd.Stage) -> Iterator[str]:
    """What is wrong with packages that the stage is composed of."""
    files = {layer.realPath for layer in stage.GetUsedLayers()}
    outer = {Ar.SplitPackageRelativePathOuter(file)[0] for file in files}
    for file in sorted(filter(_is_package, outer)):
        fault = package_fault(file)
        if fault is not None:
            yield f"{file}: a damaged package: {fault}; write it again"


def _open_layer(path: str) -> Sdf.Layer:
    """The layer of the file `path`. Raises InputError where it is not USD, or damaged."""
    try:
        layer = Sdf.Layer.FindOrOpen(path)
    except Tf.ErrorException as error:
        raise InputError(_open_failure(path, error_lines(error))) from None
    if layer is None:
        raise InputError(_open_failure(path, []))
    return layer


def _deal_with_errors(path: str, stage: Usd.Stage, policy: MissingAsset, report: Report) -> None:
    """Tells missing assets apart from what is wrong in any case, and refuses that."""
    lost: dict[str, dict[str, None]] = {}
    errors = []
    for error in stage.GetCompositionErrors():
        kind, text = _lost_asset(stage, error)
        if text is None:
            errors.append(error)
        else:
            lost.setdefault(kind, {})[text] = None
    if errors:
        raise InputError(_composition_failure(path, errors))
    damaged = list(_damaged_packages(stage))
    if damaged:
        raise InputError("\n  ".join([f"{path}: packages that cannot be used:", *damaged]))
    if policy == "fail":
        lost = {" and ".join(lost): {text: None for texts in lost.values() for text in texts}}
    for kind, texts in lost.items():
        report_missing(kind, list(texts), policy, report, path)


def _lost_asset(stage: Usd.Stage, error: Pcp.ErrorBase) -> tuple[str, str | None]:
    """Of an asset that is not there, its kind and what to say of it; else no text."""
    said = one_line(str(error))
    if isinstance(error, Pcp.ErrorInvalidAssetPath) and (match := _LOST_ARC.search(said)):
        asset, arc, layer_name, prim_path, reason = match.groups()
        layer = Sdf.Layer.Find(layer_name)
        if reason.strip(".") or Path(asset).exists():
            return "", None
        spec = layer.GetPrimAtPath(prim_path) if layer else None
        arcs = {"reference": "references", "payload": "payload"}.get(arc, arc)
        authored = _authored(layer, asset, _arc_assets(spec, arc)) if layer else None
        place = f"prim <{error.rootSite.path}>, {arcs} of <{prim_path}> in {layer_name}"
        return f"{arc}s", missing_text(stage, place, asset, authored)
    if isinstance(error, Pcp.ErrorInvalidSublayerPath) and (match := _LOST_SUBLAYER.search(said)):
        asset, layer_name, reason = match.groups()
        if reason or Path(asset).exists():
            return "", None
        layer = Sdf.Layer.Find(layer_name)
        authored = _authored(layer, asset, list(layer.subLayerPaths)) if layer else None
        return "sublayers", missing_text(stage, f"subLayers of {layer_name}", asset, authored)
    if isinstance(error, Pcp.ErrorUnresolvedPrimPath):
        return "prims to refer to", f"prim <{error.rootSite.path}>: {said.rstrip('.')}"
    return "", None


def _arc_assets(spec: Sdf.PrimSpec | None, arc: str) -> list[str]:
    if spec is None:
        return []
    items = spec.payloadList if arc == "payload" else spec.referenceList
    return [item.assetPath for item in items.GetAddedOrExplicitItems()]


def _authored(layer: Sdf.Layer, asset: str, candidates: Sequence[str]) -> str | None:
    """The one of `candidates` that USD calls `asset` once it is anchored to `layer`."""
    for text in candidates:
        if asset in (text, layer.ComputeAbsolutePath(text)):
            return text
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
        named = _LOST_ARC.search(message)
        if named and _is_package(named[1]) and Path(named[1]).exists():
            message = f"@{named[1]}@ is a damaged package: {package_fault(named[1])}"
            advice = "write it again"
        lines[f"{file}prim <{error.rootSite.path}>: {message}; {advice}"] = None
    return "\n  ".join([f"{path}: the stage does not compose:", *lines])
