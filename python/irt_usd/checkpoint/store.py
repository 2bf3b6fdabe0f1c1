# SPDX-License-Identifier: Apache-2.0
"""A folder of checkpoints: one run at a time, the newest few, saved while rendering goes on."""

import fcntl
import os
import re
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from irt_usd import _core
from irt_usd.checkpoint.container import Header, compose
from irt_usd.errors import InputError, MachineError

KIND = "irt checkpoint"

_NAME = re.compile(r"checkpoint\.([0-9]{6,})\.irt")
_LOCK_ATTEMPTS = 20
_WRITE_SPEED = 100e6
"""Bytes a second that saving is expected to manage at the least, before any has been measured."""


def checkpoints_in(folder: Path) -> list[Path]:
    """Those in a folder, oldest first."""
    found = [(int(m[1]), p) for p in folder.iterdir() if (m := _NAME.fullmatch(p.name))]
    return [path for _, path in sorted(found)]


def newest(path: Path) -> Path:
    """The checkpoint `path`, or the newest of the folder. Raises InputError."""
    if path.is_dir():
        found = checkpoints_in(path)
        if not found:
            raise InputError(f"{path}: no checkpoint in this folder")
        return found[-1]
    if not path.is_file():
        raise InputError(f"{path}: no such file or folder; give a checkpoint")
    return path


class CheckpointStore:
    """The folder while it is this run's. `tell` says one line to the user.

    Raises InputError where it cannot be a folder to write in, MachineError where another run has
    it.
    """

    def __init__(self, folder: Path, keep: int, tell: Callable[[str], None]) -> None:
        self.folder = folder
        self._keep = keep
        self._tell = tell
        self._saving: _core.BackgroundWrite | None = None
        self._path = folder
        self._what = ""
        self._begun = 0.0
        self._speed = _WRITE_SPEED
        self._size = 0
        self.last: Path | None = None
        """The newest that this run knows to be good."""
        self._lock = self._locked()
        for left in folder.glob("checkpoint.*.irt.tmp"):
            with suppress(OSError):
                left.unlink()
        numbers = [int(path.name.split(".")[1]) for path in checkpoints_in(folder)]
        self._next = max(numbers, default=0) + 1

    def close(self) -> None:
        """Ends what is being saved, and lets others have the folder."""
        if self._saving is not None:
            self._saving.cancel()
            self._saving = None
        os.close(self._lock)

    def save(self, header: Header, arrays: _core.ArrayWriter, what: str) -> None:
        """Begins to save; `what` tells of when it is. Only where `busy` is false."""
        self._path = self.folder / f"checkpoint.{self._next:06d}.irt"
        self._next += 1
        self._what = what
        self._begun = time.monotonic()
        self._size = arrays.size()
        try:
            self._saving = arrays.write_in_background(
                str(self._path), compose({"kind": KIND, **header}, arrays)
            )
        except OSError as error:
            self._failed(error.strerror or str(error))

    @property
    def busy(self) -> bool:
        """Whether one is being saved; takes note of one that has ended."""
        if self._saving is None or not self._saving.done():
            return self._saving is not None
        result = self._saving.result()
        self._saving = None
        if result != 0:
            self._failed(os.strerror(result) if result > 0 else "it was ended by force")
            return False
        seconds = max(time.monotonic() - self._begun, 1e-3)
        self._speed = self._size / seconds
        self.last = self._path
        self._prune()
        return False

    def wait(self, seconds: float | None = None) -> bool:
        """Waits until nothing is being saved.

        False, and that one is given up, if that takes longer.
        """
        deadline = None if seconds is None else time.monotonic() + seconds
        while self.busy:
            if deadline is not None and time.monotonic() >= deadline:
                if self._saving is not None:
                    self._saving.cancel()
                self._saving = None
                return False
            time.sleep(0.005)
        return True

    def seconds_to_save(self) -> float:
        """That saving is expected to take: what the last one took, and half of that again."""
        return 0.5 + 1.5 * self._size / self._speed

    def _failed(self, why: str) -> None:
        stands = f"{self.last} stands" if self.last is not None else "there is none before it"
        self._tell(f"irt: no checkpoint {self._what}: {self._path}: {why}; {stands}")

    def _prune(self) -> None:
        for path in checkpoints_in(self.folder)[: -self._keep]:
            with suppress(OSError):
                path.unlink()

    def _locked(self) -> int:
        path = self.folder / "lock"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            lock = os.open(path, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise InputError(
                f"--checkpoint {self.folder}: cannot be used: {error.strerror}; give a folder to"
                " write in"
            ) from error
        # One that was killed may take a moment to be gone.
        for attempt in range(_LOCK_ATTEMPTS):
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError as error:
                if attempt + 1 < _LOCK_ATTEMPTS:
                    time.sleep(0.1)
                    continue
                holder = os.pread(lock, 200, 0).decode(errors="replace").strip()
                os.close(lock)
                raise MachineError(
                    f"--checkpoint {self.folder}: another run has it ({holder or 'unknown'}); give"
                    " each its own folder, or wait for its end"
                ) from error
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        return lock
