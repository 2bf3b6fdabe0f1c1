# SPDX-License-Identifier: Apache-2.0
"""Sets of the 64 cells, as Open Job Description writes ranges: 0-30,40-60:2."""

import re
from collections.abc import Sequence
from pathlib import Path

from irt_usd.errors import InputError

CELLS = 64

_PART = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9})(?::([0-9]{1,9}))?)?")


def parse_cells(text: str) -> tuple[int, ...]:
    """The cells of a range, ascending. Raises InputError."""
    found: list[int] = []
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        if match is None:
            raise InputError(f"--cells {text}: '{part}' is no range; write 5, 0-30 or 40-60:2")
        first = int(match[1])
        last = int(match[2]) if match[2] else first
        step = int(match[3]) if match[3] else 1
        if not (first <= last < CELLS and step > 0):
            raise InputError(
                f"--cells {text}: '{part}' is not of the cells 0 to {CELLS - 1}, ascending"
            )
        found += range(first, last + 1, step)
    if len(set(found)) < len(found):
        raise InputError(f"--cells {text}: names a cell twice")
    return tuple(sorted(found))


def format_cells(cells: Sequence[int]) -> str:
    """The shortest way that `parse_cells` reads."""
    parts: list[str] = []
    index = 0
    while index < len(cells):
        end = index + 1
        step = cells[end] - cells[index] if end < len(cells) else 1
        while end < len(cells) and cells[end] - cells[end - 1] == step:
            end += 1
        if end - index >= 3 or (end - index == 2 and step == 1):
            suffix = f":{step}" if step > 1 else ""
            parts.append(f"{cells[index]}-{cells[end - 1]}{suffix}")
        else:
            end = index + 1
            parts.append(str(cells[index]))
        index = end
    return ",".join(parts)


def partial_path(path: Path, cells: Sequence[int]) -> Path:
    """Where the pixels of `cells` go, of the frame that is to become `path`."""
    label = format_cells(cells).replace(",", "_").replace(":", "x")
    return path.with_name(f"{path.stem}.cells{label}.irtpart")
