# SPDX-License-Identifier: Apache-2.0
"""Keeps a running shot's checkpoints, and finds the one to resume from."""

import json
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from decimal import Decimal
from pathlib import Path
from typing import Any, Literal

from irt_usd import _core, interrupt
from irt_usd.checkpoint.container import Container, RefusedError, read
from irt_usd.checkpoint.provenance import (
    FileHashes,
    SceneDigest,
    differences,
    file_differences,
    program_items,
    setting_items,
)
from irt_usd.checkpoint.retake import described
from irt_usd.checkpoint.store import KIND, CheckpointStore, checkpoints_in
from irt_usd.interrupt import Interrupted
from irt_usd.shot.frames import Frame, count_frames, format_frame
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.tracer import ShotTracer
from irt_usd.stage import Snapshot

Resume = Literal["auto", "require", "never"]

_MARGIN = 1.0
"""Seconds of the notice period left for the end of the process."""


@dataclass(frozen=True)
class Every:
    """How often checkpoints are made: by frames, or by seconds where those are 0."""

    frames: int = 0
    seconds: float = 60.0


@dataclass(frozen=True)
class CheckpointOptions:
    """Where checkpoints go, when, and what is done with those that are there."""

    folder: Path
    every: Every = Every()
    resume: Resume = "auto"
    keep: int = 2
    grace: float = 30.0


class Keeper:
    """One run's checkpoints. `extra` are settings of the run beside the shot's and the tracer's."""

    def __init__(
        self,
        options: CheckpointOptions,
        shot: Shot,
        settings: TraceSettings,
        extra: Mapping[str, Any],
        tell: Callable[[str], None],
    ) -> None:
        self._options = options
        self._shot = shot
        self._tell = tell
        self._items = {
            **program_items(settings.isa, same_build=True),
            **setting_items(shot, settings, extra),
        }
        self._files = FileHashes(shot)
        self._files.take()
        self._digest = SceneDigest()
        self._store = CheckpointStore(options.folder, options.keep, tell)
        self._done: dict[str, list[str]] = {}
        self._saved_frame: Frame | None = None
        self._frames_since = 0
        self._saved_at = time.monotonic()
        self._asked_for = False
        self._digests: dict[str, list[str]] = {}
        self._outputs: dict[str, list[str]] = {}
        self.resumed = False
        self.stats: list[dict[str, Any]] = []
        """Of frames written, those of runs resumed from included."""

    @contextmanager
    def running(self) -> Iterator[None]:
        """The run: SIGUSR1 asks for a checkpoint, and other signals leave time for one."""

        def ask(_signum: int, _frame: Any) -> None:
            self._asked_for = True

        before = signal.signal(signal.SIGUSR1, ask)
        try:
            with interrupt.work_goes_on(self._seconds_to_trace):
                yield
        except Interrupted as error:
            self._store.wait(max(0.0, self._notice() - interrupt.noted_since()))
            error.checkpoint = str(self._store.last or "")
            raise
        except Exception:
            self._store.wait(self._options.grace)
            raise
        finally:
            signal.signal(signal.SIGUSR1, before)
            self._store.close()

    def resume(
        self, tracer: ShotTracer, frames: Sequence[Frame], paths: Sequence[tuple[Path, ...]]
    ) -> set[Frame]:
        """Brings `tracer` to the newest checkpoint that is this job's.

        Returns the frames of it whose files are as they were written. Raises RefusedError where
        there is none and one is required.
        """
        if self._options.resume == "never":
            return set()
        reasons: list[str] = []
        for path in reversed(checkpoints_in(self._store.folder)):
            try:
                container = read(path, KIND)
                container.verify()
                self._restore(container, tracer)
            except RefusedError as error:
                reasons.append(str(error))
                continue
            for reason in reasons:
                self._tell(f"irt: {reason}; an older one is used")
            self._store.last = path
            return self._take_up(container, frames, paths)
        if self._options.resume == "require":
            why = "\n  ".join(reasons) or "there is none"
            raise RefusedError(
                f"--resume require: no checkpoint in {self._store.folder} can be used; nothing was"
                f" rendered:\n  {why}"
            )
        for reason in reasons:
            self._tell(f"irt: {reason}")
        if reasons:
            self._tell("irt: no checkpoint here can be used; the shot starts again")
        return set()

    def written(self, frame: Frame, hashed: str, stats: dict[str, Any]) -> None:
        """A view's file is on the disk."""
        name = format_frame(frame)
        self._done.setdefault(name, []).append(hashed)
        self._outputs.setdefault(name, []).append(os.path.abspath(stats["file"]))  # noqa: PTH100
        self.stats.append(stats)

    def kept(self, frame: Frame, snapshot: Snapshot, paths: Sequence[Path]) -> None:
        """The files of `frame` are on the disk, kept from another version."""
        name = format_frame(frame)
        self._done[name] = [_core.file_hash(str(path)) for path in paths]
        self._outputs[name] = [os.path.abspath(path) for path in paths]  # noqa: PTH100
        self._digests[name] = self._digest_of(snapshot)

    def before_first(self) -> None:
        """A safe point at which there is nothing to save."""
        if interrupt.noted() is not None:
            interrupt.stop()

    def after(self, frame: Frame, tracer: ShotTracer, finish_writing: Callable[[], None]) -> None:
        """`frame` is traced: saves if it is time to. Raises Interrupted after a signal."""
        self._frames_since += 1
        self._digests[format_frame(frame)] = self._digest_of(tracer.scene)
        stopping = interrupt.noted() is not None
        if not stopping and (self._store.busy or not self._due()):
            return None
        finish_writing()
        if not stopping:
            return self._save(frame, tracer)
        left = self._notice() - interrupt.noted_since()
        self._store.wait(max(0.0, left - self._store.seconds_to_save()))
        if self._saved_frame != frame or self._store.last is None:
            self._save(frame, tracer)
            self._store.wait(max(0.0, self._notice() - interrupt.noted_since()))
        return interrupt.stop()

    def finish(self, frame: Frame, tracer: ShotTracer) -> None:
        """All frames are written, `frame` the last of them."""
        self._store.wait()
        if self._saved_frame != frame:
            self._save(frame, tracer)
            self._store.wait()

    def _digest_of(self, snapshot: Snapshot) -> list[str]:
        return [self._digest.scene(snapshot), *self._digest.cameras(snapshot)]

    def _due(self) -> bool:
        every = self._options.every
        if self._asked_for:
            return True
        if every.frames:
            return self._frames_since >= every.frames
        return time.monotonic() - self._saved_at >= every.seconds

    def _save(self, frame: Frame, tracer: ShotTracer) -> None:
        self._asked_for = False
        self._frames_since = 0
        self._saved_at = time.monotonic()
        arrays = _core.ArrayWriter()
        snapshot = tracer.save(arrays)
        header = {
            "job": self._items,
            "shot": described(self._shot),
            "files": self._files.take(),
            "frame": format_frame(frame),
            "cameras": self._digest.cameras(snapshot),
            "scene": self._digest.scene(snapshot),
            "done": self._done,
            "outputs": self._outputs,
            "digests": self._digests,
            "foreign": tracer.foreign,
            "stats": self.stats,
        }
        self._saved_frame = frame
        self._store.save(header, arrays, f"after frame {format_frame(frame)}")

    def _restore(self, container: Container, tracer: ShotTracer) -> None:
        """Raises RefusedError, with everything that differs by name."""
        header = container.header
        found = [
            *differences(header["job"], self._items),
            *file_differences(header["files"], self._files),
        ]
        if header["foreign"]:
            found.append("history: kept for the changes of the version it was started from")
        self._refuse(container, found)
        try:
            snapshot = tracer.restore(Decimal(header["frame"]), container)
        except RuntimeError as error:
            raise RefusedError(f"{container.path}: {error}") from error
        found = list(file_differences(header["files"], self._files))
        if header["cameras"] != self._digest.cameras(snapshot):
            found.append("camera: is another now")
        if header["scene"] != self._digest.scene(snapshot):
            found.append("scene: the stage is read otherwise now")
        if found:
            tracer.forget()
        self._refuse(container, found)

    def _refuse(self, container: Container, found: list[str]) -> None:
        if found:
            raise RefusedError(f"{container.path}: is not of this job: " + "; ".join(found))

    def _take_up(
        self, container: Container, frames: Sequence[Frame], paths: Sequence[tuple[Path, ...]]
    ) -> set[Frame]:
        header = container.header
        self.resumed = True
        kept: set[Frame] = set()
        gone: list[Frame] = []
        for frame, files in zip(frames, paths, strict=True):
            hashes = header["done"].get(format_frame(frame))
            if hashes is None:
                continue
            if all(map(_has_hash, files, hashes)):
                name = format_frame(frame)
                kept.add(frame)
                self._done[name] = hashes
                self._outputs[name] = header["outputs"][name]
                self._digests[name] = header["digests"][name]
            else:
                gone.append(frame)
        lost = {json.loads(format_frame(frame)) for frame in gone}
        self.stats = [stats for stats in header["stats"] if stats["frame"] not in lost]
        frame = Decimal(header["frame"])
        self._saved_frame = frame
        self._tell(
            f"irt: resumed after frame {format_frame(frame)} from {container.path}:"
            f" {count_frames(len(kept))} kept"
        )
        if gone:
            names = ", ".join(map(format_frame, gone))
            self._tell(f"irt: files that are not as they were written are made again: {names}")
        return kept

    def _notice(self) -> float:
        """Seconds from the signal to the end: as OpenJD says, else as asked for."""
        folder = os.environ.get("OPENJD_SESSION_WORKING_DIR", ".")
        try:
            text = Path(folder, "cancel_info.json").read_text(encoding="utf-8")
            end = datetime.fromisoformat(json.loads(text)["NotifyEnd"].replace("Z", "+00:00"))
            left = (end - datetime.now(UTC)).total_seconds()
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return self._options.grace
        # A clock that jumped says what no scheduler would.
        return interrupt.noted_since() + left if 0 < left <= 600 else self._options.grace

    def _seconds_to_trace(self) -> float:
        """After a signal, until there is just the time left to save."""
        return self._notice() - self._store.seconds_to_save() - _MARGIN


def _has_hash(path: Path, hashed: str) -> bool:
    try:
        return _core.file_hash(str(path)) == hashed
    except OSError:
        return False
