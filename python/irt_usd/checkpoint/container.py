# SPDX-License-Identifier: Apache-2.0
"""The files: named arrays under a JSON header, every byte under a hash (docs/farm.md)."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core
from irt_usd.errors import IrtError

Header = dict[str, Any]

SCHEMA = 1
"""Of what the header and the arrays mean. What changes it adds a function to UPGRADES."""

UPGRADES: dict[int, Callable[[Header], Header]] = {}
"""By schema: makes a header of it one of the next."""


class RefusedError(IrtError):
    """A checkpoint, or a partial frame, that is damaged or of another job."""

    status: ClassVar[int] = 5


@dataclass(frozen=True)
class Entry:
    """Where an array lies: numpy's type, bytes an item, items, offset in the data."""

    type: str
    item_size: int
    count: int
    offset: int


@dataclass(frozen=True)
class Container:
    """An open file. Its arrays are views of the mapped file."""

    path: Path
    header: Header
    entries: Mapping[str, Entry]
    file: _core.MappedFile

    def array(self, name: str) -> NDArray[Any]:
        """One dimension, read-only, not copied. Raises KeyError."""
        entry = self.entries[name]
        end = entry.offset + entry.item_size * entry.count
        return self.file.data()[entry.offset : end].view(np.dtype(entry.type))

    def places(self, prefix: str = "") -> dict[str, tuple[int, int, int]]:
        """For Renderer.restore: the arrays whose names begin with `prefix`, named without it."""
        return {
            name.removeprefix(prefix): (entry.item_size, entry.count, entry.offset)
            for name, entry in self.entries.items()
            if name.startswith(prefix)
        }

    def verify(self) -> None:
        """Raises RefusedError where a block differs from its hash."""
        damaged = self.file.damaged()
        if damaged:
            size = _core.CHECKPOINT_BLOCK
            begin, end = damaged[0] * size, (damaged[0] + 1) * size
            hit = [
                name
                for name, entry in self.entries.items()
                if entry.offset < end and entry.offset + entry.item_size * entry.count > begin
            ]
            raise RefusedError(
                f"{self.path}: is damaged: {len(damaged)} of its blocks differ from their hashes,"
                f" the first at byte {begin} of the data ({', '.join(hit[:3]) or 'padding'})"
            )


def compose(header: Header, arrays: _core.ArrayWriter) -> str:
    """The text of a header for `arrays`."""
    full = {"schema": SCHEMA, **header, "arrays": arrays.directory()}
    return json.dumps(full, allow_nan=False, separators=(",", ":"))


def read(path: Path, kind: str) -> Container:
    """Opens a file of that `kind`; its blocks are proven by `Container.verify`.

    Raises RefusedError, saying what is wrong with it.
    """
    try:
        file = _core.MappedFile(str(path))
        header = json.loads(file.header())
    except OSError as error:
        raise RefusedError(f"{path}: cannot be read: {error.strerror}") from error
    except (RuntimeError, ValueError) as error:
        raise RefusedError(f"{path}: {error}") from error
    if header.get("kind") != kind:
        raise RefusedError(f"{path}: is a {header.get('kind')}; expected a {kind}")
    while (schema := header["schema"]) != SCHEMA:
        if schema not in UPGRADES:
            raise RefusedError(
                f"{path}: is of schema {schema}; this irt reads up to {SCHEMA}: make it again"
            )
        header = UPGRADES[schema](header)
    entries = {name: Entry(*place) for name, *place in header.pop("arrays")}
    return Container(path, header, entries, file)
