# SPDX-License-Identifier: Apache-2.0
"""Photometric webs of IES files (ANSI/IES LM-63-1986 to 2002, type C)."""

from collections.abc import Mapping
from errno import ENOENT
from functools import lru_cache
from itertools import pairwise
from math import cos, isfinite, pi, radians
from pathlib import Path

import numpy as np
from pxr import Ar, Usd

from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage import assets_read
from irt_usd.stage.missing import missing_text, report_missing

Web = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
"""Vertical and horizontal angles (degrees, ascending), candelas by horizontal, then vertical."""


class IesError(ValueError):
    """The file cannot be read (`missing`: is not there) or is no web that is rendered."""

    def __init__(self, message: str, missing: bool = False) -> None:
        super().__init__(message)
        self.missing = missing


def read_ies(path: str, normalize: bool = False, angle_scale: float = 0.0) -> Web:
    """The web of a file, its vertical angles scaled. Raises IesError.

    `angle_scale` (UsdLux's): 0 none, above 0 by it from 0 degrees, below 0 by its size from 180.
    `normalize`: divided by its mean over the sphere, unless that is dark.
    """
    assets_read.note(path)
    return _read_ies(path, normalize, angle_scale)


@lru_cache(maxsize=64)
def _read_ies(path: str, normalize: bool, angle_scale: float) -> Web:
    try:
        text = _text(path)
    except FileNotFoundError as error:
        raise IesError(f"{path}: {error.strerror}", missing=True) from error
    except OSError as error:
        raise IesError(f"{path}: {error.strerror}") from error
    tilt = text.find("TILT=")
    if tilt < 0:
        raise IesError(f"{path}: has no TILT= line; expected an IES file (LM-63)")
    line, _, rest = text[tilt:].partition("\n")
    kind = line[5:].strip()
    if kind not in ("NONE", "INCLUDE"):
        raise IesError(f"{path}: TILT={kind} names another file; expected NONE or INCLUDE")
    try:
        numbers = [float(word) for word in rest.replace(",", " ").split()]
    except ValueError as error:
        raise IesError(f"{path}: {error}; expected numbers after the TILT line") from error
    if kind == "INCLUDE":
        if len(numbers) < 2:
            raise IesError(f"{path}: ends within its tilt table")
        numbers = numbers[2 + 2 * int(numbers[1]) :]
    if len(numbers) < 13:
        raise IesError(f"{path}: ends before its angles")
    multiplier, photometric_type = numbers[2], int(numbers[5])
    rows, columns = int(numbers[3]), int(numbers[4])
    ballast = numbers[10] * numbers[11]
    if photometric_type != 1:
        raise IesError(f"{path}: photometric type {photometric_type}; expected 1 (type C)")
    table = numbers[13:]
    if rows < 1 or columns < 1 or len(table) < rows + columns + rows * columns:
        raise IesError(f"{path}: {rows} by {columns} candelas are said to follow, and fewer do")
    vertical, horizontal = tuple(table[:rows]), tuple(table[rows : rows + columns])
    for angles in (vertical, horizontal):
        if any(a >= b for a, b in pairwise(angles)):
            raise IesError(f"{path}: angles do not ascend")
    scale = multiplier * ballast
    candelas = table[rows + columns : rows + columns + rows * columns]
    values = tuple(value * scale for value in candelas)
    if not all(map(isfinite, (*vertical, *horizontal, *values))):
        raise IesError(f"{path}: holds a NaN or an infinity; expected finite numbers")
    vertical, values = _scaled(vertical, values, columns, angle_scale)
    if normalize:
        mean = _mean(vertical, values, columns)
        if mean > 0:
            values = tuple(value / mean for value in values)
    return vertical, horizontal, values


def check_profiles(
    profiles: Mapping[str, str], stage: Usd.Stage, policy: MissingAsset, report: Report, source: str
) -> None:
    """Deals with the IES files that cannot be had, of all by path the attribute that names each.

    Raises InputError, on the stage's file `source`, if `policy` is to fail; else they are reported,
    and their lights rendered without them.
    """
    missing: list[str] = []
    unusable: list[str] = []
    for path, place in sorted(profiles.items()):
        try:
            read_ies(path)
        except IesError as error:
            if error.missing:
                missing.append(missing_text(stage, place, path))
            else:
                unusable.append(f"{place}: {error}")
    report_missing("IES files", missing, policy, report, source)
    if unusable and policy == "fail":
        advice = "mend them, or render without them by --missing-asset fallback"
        raise InputError("\n  ".join([f"{source}: unusable IES files; {advice}:", *unusable]))
    for text in unusable:
        report.skipped("unusable IES files, rendered without", text)


def _text(path: str) -> str:
    """Of a file, or of one within a package."""
    if not Ar.IsPackageRelativePath(path):
        return Path(path).read_text(encoding="latin-1")
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise FileNotFoundError(ENOENT, "No such file in the package", path)
    with asset:
        return str(bytes(asset.GetBuffer()).decode("latin-1"))


def _scaled(
    vertical: tuple[float, ...], values: tuple[float, ...], columns: int, scale: float
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The web over other vertical angles, cut off at 0 and 180 degrees.

    Where scaling asks for what lies beyond those, their own value goes on.
    """
    if scale == 0:
        return vertical, values
    rows = len(vertical)
    planes = [values[c * rows : (c + 1) * rows] for c in range(columns)]
    if scale > 0:
        angles = [v * scale for v in vertical]
        goes_on = angles[-1] < 180 and vertical[-1] == 180
        angles += [180.0] * goes_on
        planes = [(*p, *p[-1:] * goes_on) for p in planes]
    else:
        angles = [180 + (v - 180) * -scale for v in vertical]
        goes_on = angles[0] > 0 and vertical[0] == 0
        angles = [0.0] * goes_on + angles
        planes = [(*p[:1] * goes_on, *p) for p in planes]
    low, high = max(angles[0], 0.0), min(angles[-1], 180.0)
    if low > high:  # all of it lies beyond
        return (0.0,), (0.0,) * columns
    kept = sorted({low, high, *(angle for angle in angles if low < angle < high)})
    cut = [float(v) for plane in planes for v in np.interp(kept, angles, plane)]
    return tuple(kept), tuple(cut)


def _mean(vertical: tuple[float, ...], values: tuple[float, ...], columns: int) -> float:
    """Over the sphere, planes of equal weight, of the linear interpolation's trapezoids."""
    rows, steps = len(vertical), 64
    total = 0.0
    for column in range(columns):
        plane = values[column * rows : (column + 1) * rows]
        for i in range(rows - 1):
            low, high = radians(vertical[i]), radians(vertical[i + 1])
            for k in range(steps):
                a, b = (low + (high - low) * (k + e) / steps for e in (0, 1))
                value = plane[i] + (plane[i + 1] - plane[i]) * (k + 0.5) / steps
                total += value * (cos(a) - cos(b))
    return total * 2 * pi / columns / (4 * pi)
