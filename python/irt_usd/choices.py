# SPDX-License-Identifier: Apache-2.0
"""What options offer to choose from. No USD here, so that `irt --help` is quick."""

from typing import Literal, get_args

MissingAsset = Literal["fail", "fallback", "warn"]
"""fail: refuse the shot. fallback: render without it, and say so once. warn: say so each time."""

MISSING_ASSET: tuple[MissingAsset, ...] = get_args(MissingAsset)

ProgressFormat = Literal["openjd", "alf", "json", "bar", "none"]
"""Whose lines tell how far a shot is; bar: a live one on a terminal, plain lines elsewhere."""

PROGRESS: tuple[ProgressFormat, ...] = get_args(ProgressFormat)

COMPLEXITY = {"low": 0, "medium": 1, "high": 2, "veryhigh": 3}
"""How often subdivision faces and pieces of cubic curves are cut, by usdrecord's names."""

PURPOSES = ("default", "render", "proxy", "guide")
"""UsdGeom's purposes."""
