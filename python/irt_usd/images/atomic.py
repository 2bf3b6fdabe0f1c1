# SPDX-License-Identifier: Apache-2.0
"""Files that appear whole or not at all: written beside, synced, renamed."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from irt_usd.errors import MachineError


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yields an empty temporary file beside `path`, which becomes `path` if the block succeeds.

    Where `path` is a link, that is the file it leads to.

    The file has the permissions a plain `open` would give. On any exception, interrupts
    included, the temporary file is removed and `path` is as it was. Raises MachineError where
    the system refuses, a full disk for one.
    """
    path = path.resolve()
    temporary = path.parent / f".irt-{secrets.token_hex(8)}.tmp"
    try:
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        yield temporary
        _sync(temporary)
        temporary.replace(path)
        _sync(path.parent)
    except OSError as error:
        raise MachineError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
