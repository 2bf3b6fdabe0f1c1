# SPDX-License-Identifier: Apache-2.0
"""Files that appear whole or not at all: made in memory, written beside, synced, renamed."""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from irt_usd.errors import MachineError


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yields an empty file in memory, whose bytes become `path` if the block succeeds.

    Where `path` is a link, that is the file it leads to. In memory, because libraries for images
    do not say so when the last bytes of a file find no room; what goes to the disk is written here.

    The file has the permissions a plain `open` would give. On any exception, interrupts
    included, `path` is as it was. Raises MachineError where the system refuses, a full disk for
    one.
    """
    path = followed(path)
    temporary = path.parent / f".irt-{secrets.token_hex(8)}.tmp"
    try:
        with open(os.memfd_create("irt"), "r+b") as memory:  # noqa: PTH123 (no path)
            yield Path(f"/proc/self/fd/{memory.fileno()}")
            _refuse_cut(memory.fileno())
            descriptor = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
            with open(descriptor, "wb") as file:  # noqa: PTH123
                shutil.copyfileobj(memory, file, 2**20)
                file.flush()
                os.fsync(descriptor)
        temporary.replace(path)
        _sync(path.parent)
    except OSError as error:
        raise MachineError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def followed(path: Path) -> Path:
    """The absolute path that links lead to; links in a circle lead nowhere, to themselves."""
    return Path(os.path.realpath(path))


def _refuse_cut(descriptor: int) -> None:
    """Raises OSError where a limit on the size of files may have cut the last bytes off."""
    size = os.fstat(descriptor).st_size
    os.pwrite(descriptor, b"\0", size)
    os.ftruncate(descriptor, size)


def _sync(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
