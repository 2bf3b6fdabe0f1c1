# SPDX-License-Identifier: Apache-2.0
"""Frames are written while the next ones are traced."""

import queue
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from irt_usd import _core
from irt_usd.images.exr import Film, MetadataValue, PixelFaults, PixelType, write_exr
from irt_usd.images.png import write_png
from irt_usd.images.preview import DisplayView
from irt_usd.shot.sidecar import write_sidecar
from irt_usd.shot.stats import FrameStats

_QUEUE_LENGTH = 2
"""Frames that may wait: tracing stops rather than fill the memory where the disk is slow."""


@dataclass(frozen=True)
class FrameJob:
    """A whole frame. The film is the job's own: the renderer's changes with its next update."""

    path: Path
    film: Film
    metadata: Mapping[str, MetadataValue]
    pixel_type: PixelType
    stats: FrameStats
    preview: DisplayView | None = None
    """How a PNG beside the frame shows it; None: there is none."""
    sidecar_threads: int | None = None
    """The thread count that a sidecar tells; None: there is none."""


@dataclass(frozen=True)
class WrittenFrame:
    """A frame that is on disk under its name; its statistics have the seconds it took."""

    job: FrameJob
    faults: PixelFaults
    hash: str = ""
    """Of the file's bytes, where that was asked for."""


WriteFrame = Callable[[Path, Film, Mapping[str, MetadataValue], PixelType], PixelFaults]
"""As write_exr does it."""


class FrameWriter:
    """One background thread that writes frames in the order they are given.

    Not to be shared between threads. After a failure nothing more is written; the failure is
    raised at the next `submit`, `wait` or `finish`.
    """

    def __init__(self, write: WriteFrame = write_exr, hashing: bool = False) -> None:
        self._write = write
        self._hashing = hashing
        self._jobs: queue.Queue[FrameJob | None] = queue.Queue(_QUEUE_LENGTH)
        self._written: queue.SimpleQueue[WrittenFrame] = queue.SimpleQueue()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="frame writer", daemon=True)
        self._thread.start()

    def submit(self, job: FrameJob) -> None:
        """Queues a frame, waiting where the queue is full. Raises what an earlier one failed of."""
        self._raise_failure()
        self._jobs.put(job)

    def wait(self) -> None:
        """Waits until what is queued is written. Raises what a frame failed of."""
        self._jobs.join()
        self._raise_failure()

    def finish(self) -> None:
        """Writes what is queued and ends the thread. Raises what a frame failed of."""
        self._jobs.put(None)
        self._thread.join()
        self._raise_failure()

    def take_written(self) -> list[WrittenFrame]:
        """The frames that have reached the disk since the last call."""
        written = []
        while not self._written.empty():
            written.append(self._written.get())
        return written

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                if self._failure is None:
                    self._run_job(job)
            except BaseException as failure:  # raised again in the caller's thread
                self._failure = failure
            self._jobs.task_done()

    def _run_job(self, job: FrameJob) -> None:
        start = time.perf_counter()
        faults = self._write(job.path, job.film, job.metadata, job.pixel_type)
        if job.preview is not None:
            _write_preview(job.path, job.film, job.preview)
        hashed = _core.file_hash(str(job.path)) if self._hashing else ""
        seconds = time.perf_counter() - start
        job.stats.seconds["write"] = seconds
        job.stats.seconds["total"] += seconds
        job.stats.non_finite_pixels = faults.non_finite
        if job.sidecar_threads is not None:
            write_sidecar(job.path, job.stats, job.sidecar_threads)
        self._written.put(WrittenFrame(job, faults, hashed))


def preview_path(path: Path) -> Path:
    """The preview of the frame `path`."""
    return path.with_suffix(".png")


def _write_preview(path: Path, film: Film, shown: DisplayView) -> None:
    metadata = {"irt:display": shown.display, "irt:view": shown.view}
    write_png(preview_path(path), shown.shown(film.beauty), metadata)
