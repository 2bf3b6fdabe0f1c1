# SPDX-License-Identifier: Apache-2.0
"""Assets that are not there: the one rule of `--missing-asset` for layers, clips and textures."""

import os
from collections.abc import Sequence
from pathlib import Path

from pxr import Ar, Usd

from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.report import Report

ADVICE = (
    "mend the path, name its folder by --asset-path, or render without it by"
    " --missing-asset fallback"
)


def search_folders(stage: Usd.Stage) -> list[str]:
    """Where assets named by a search path (no ./ before it) are looked for, in order."""
    folders = [os.getcwd()]  # noqa: PTH109 (USD's resolver looks there first)
    for context in stage.GetPathResolverContext().Get():
        if isinstance(context, Ar.DefaultResolverContext):
            folders += context.GetSearchPath()
    folders += filter(None, os.environ.get("PXR_AR_DEFAULT_SEARCH_PATH", "").split(os.pathsep))
    return list(dict.fromkeys(str(Path(folder).absolute()) for folder in folders))


def missing_text(stage: Usd.Stage, place: str, asset: str, authored: str | None = None) -> str:
    """The text "/Prim.attribute in /file.usda: @asset@ (no such file as ...)".

    `asset` is as USD names it, anchored to its layer where it is relative; `authored` as the layer
    has it.
    """
    if Path(asset).is_absolute():
        tried = "no such file" if authored in (None, asset) else f"no such file as {asset}"
    else:
        tried = f"no such file in {', '.join(search_folders(stage))}"
    return f"{place}: @{authored or asset}@ ({tried})"


def report_missing(
    kind: str, lost: Sequence[str], policy: MissingAsset, report: Report, source: str
) -> None:
    """Deals with the assets `lost`, each a `missing_text`, of a `kind` in the plural ("textures").

    Raises InputError on `source` if the policy is to fail.
    """
    if not lost:
        return
    if policy == "fail":
        raise InputError("\n  ".join([f"{source}: missing {kind}; {ADVICE}:", *lost]))
    for text in lost:
        if policy == "warn":
            report.skipped(f"missing {kind}, rendered without: {text}")
        else:
            report.skipped(f"missing {kind}, rendered without", text)
