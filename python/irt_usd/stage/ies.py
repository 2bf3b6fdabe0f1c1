# SPDX-License-Identifier: Apache-2.0
"""Photometric webs of IES files (ANSI/IES LM-63-1986 to 2002, type C)."""

from functools import lru_cache
from itertools import pairwise
from math import cos, pi, radians
from pathlib import Path

from irt_usd.stage import assets_read

Web = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
"""Vertical and horizontal angles (degrees, ascending), candelas by horizontal, then vertical."""


class IesError(ValueError):
    """The file cannot be read or is no photometric web that is rendered."""


def read_ies(path: str, normalize: bool) -> Web:
    """The web of a file; `normalize`: divided by its mean over the sphere. Raises IesError."""
    assets_read.note(path)
    return _read_ies(path, normalize)


@lru_cache(maxsize=64)
def _read_ies(path: str, normalize: bool) -> Web:
    try:
        text = Path(path).read_text(encoding="latin-1")
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
    if normalize:
        mean = _mean(vertical, values, columns)
        if mean <= 0:
            raise IesError(f"{path}: gives no light, and cannot be normalized")
        values = tuple(value / mean for value in values)
    return vertical, horizontal, values


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
