# SPDX-License-Identifier: Apache-2.0
"""The frame loop: a shot in, its EXR sequence out."""

from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from irt_usd import interrupt
from irt_usd.aovs import MOTION
from irt_usd.images.exr import Film, PixelType, write_exr
from irt_usd.images.preview import DisplayView
from irt_usd.report import Notice, Report
from irt_usd.shot.frames import Frame, format_frame, format_frames
from irt_usd.shot.metadata import frame_metadata, shot_metadata
from irt_usd.shot.products import report_variables
from irt_usd.shot.progress import ShotProgress
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.stats import FrameStats, write_stats
from irt_usd.shot.tracer import History, ShotTracer, TracedFrame
from irt_usd.shot.writer import FrameJob, FrameWriter, WriteFrame, WrittenFrame

if TYPE_CHECKING:
    from irt_usd.checkpoint.keeper import CheckpointOptions, Keeper

TABLE_HEADER = f"{'frame':>8}  {'changed':<44}  {'rays traced':>12}  {'seconds':>8}"


@dataclass(frozen=True)
class OutputOptions:
    """Where frames go, by frame and view, and in which form."""

    paths: Sequence[tuple[Path, ...]]
    pixel_type: PixelType = "half"
    history: History = "shot"
    stats: Path | None = None
    preview: DisplayView | None = None
    """How a PNG beside each frame shows it; None: there are none."""
    checkpoint: "CheckpointOptions | None" = None
    start: Path | None = None
    """The checkpoint of another version, whose history is the start; None: nothing is."""
    reuse: bool = False
    """Keep the frames of that version whose scene is this one's."""

    def items(self, frames: Sequence[Frame]) -> dict[str, Any]:
        """What a checkpoint must agree in beside the shot and its settings."""
        return {
            "history": self.history,
            "output type": self.pixel_type,
            "cells": self.cells,
            "rendered frames": format_frames(frames),
        }

    cells: tuple[int, ...] | None = None
    """Those that are rendered, into partial frames; None: all, into whole ones."""
    sidecar: bool = False
    """Whether each frame gets a JSON file of what it took (shot/sidecar.py)."""


def render_shot(
    shot: Shot,
    frames: Sequence[Frame],
    settings: TraceSettings,
    output: OutputOptions,
    progress: ShotProgress,
) -> list[dict[str, Any]]:
    """Renders `frames` of the shot into `output.paths`; returns their statistics.

    However it ends, the frames traced by then are written whole, and the statistics tell of
    those. Raises InputError, MachineError and RefusedError.
    """
    from irt_usd.checkpoint.keeper import Keeper

    tracer = ShotTracer(shot, settings, frames, output.history, output.cells)
    keeper = None
    if output.checkpoint is not None:
        keeper = Keeper(output.checkpoint, shot, settings, output.items(frames), progress.message)
    with keeper.running() if keeper is not None else nullcontext():
        return _render_frames(shot, frames, settings, output, progress, tracer, keeper)


def _render_frames(
    shot: Shot,
    frames: Sequence[Frame],
    settings: TraceSettings,
    output: OutputOptions,
    progress: ShotProgress,
    tracer: ShotTracer,
    keeper: "Keeper | None",
) -> list[dict[str, Any]]:
    views = range(len(shot.views))
    common = [shot_metadata(shot, settings, view) for view in views]
    kept: set[Frame] = set()
    resumed = False
    if keeper is not None:
        kept = keeper.resume(tracer, frames, output.paths)
        resumed = keeper.resumed
        progress.resumed(len(kept) * len(shot.views))
        keeper.before_first()
    reused = None
    if output.start is not None and output.reuse:
        from irt_usd.checkpoint.reuse import OldFrames

        reused = OldFrames(output.start, shot, settings, output.items(frames))
    if output.start is not None and not resumed:
        from irt_usd.checkpoint.retake import start_retake

        told = start_retake(output.start, shot, settings, output.cells, tracer, frames[0])
        progress.message(f"irt: {told}")
    writer = FrameWriter(_writing(shot, settings, output), hashing=keeper is not None)
    written = _Written(shot.report, progress, keeper)
    report_variables(shot.views, shot.report)
    tell_notices(shot.report, progress)
    films: dict[int, Film] = {}
    last: Frame | None = None
    try:
        try:
            for frame, paths in zip(frames, output.paths, strict=True):
                if frame in kept:
                    continue
                if reused is not None:
                    interrupt.check()
                    snapshot = shot.reader.read(float(frame))
                    if reused.keep(frame, snapshot, paths):
                        if keeper is not None:
                            keeper.kept(frame, snapshot, paths)
                        for _ in views:
                            progress.finished(f"{format_frame(frame):>8}  kept")
                        continue
                traced = tracer.trace(frame, partial(progress.tracing, frame))
                written.expect(frame)
                for view, path in zip(views, paths, strict=True):
                    # The film of an unchanged frame is written again as it is.
                    if not (traced.unchanged(view) and view in films) or any(
                        name.startswith("irt.") or name in MOTION for name in tracer.aovs(view)
                    ):
                        films[view] = tracer.film(view)
                    camera = traced.snapshot.cameras[view]
                    metadata = common[view] | frame_metadata(shot, frame, camera)
                    stats = _frame_stats(shot, traced, view, path, output.history)
                    threads = settings.threads if output.sidecar else None
                    film, kind = films[view], output.pixel_type
                    job = FrameJob(path, film, metadata, kind, stats, output.preview, threads)
                    writer.submit(job)
                written.take(writer)
                last = frame
                if keeper is not None:
                    keeper.after(frame, tracer, partial(_finish_writing, writer, written))
        finally:
            written.expect(None)
            try:
                writer.finish()
            finally:
                written.take(writer)
    finally:
        if output.stats is not None:
            write_stats(output.stats, written.stats if keeper is None else keeper.stats)
    if keeper is not None and last is not None:
        keeper.finish(last, tracer)
    return written.stats


def _finish_writing(writer: FrameWriter, written: "_Written") -> None:
    writer.wait()
    written.take(writer)


def _writing(shot: Shot, settings: TraceSettings, output: OutputOptions) -> WriteFrame:
    """How frames are written."""
    if output.cells is None:
        return write_exr
    from irt_usd.farm.partial import PartialWriter

    return PartialWriter(shot, settings, output.pixel_type, output.cells)


def table_row(stats: FrameStats) -> str:
    """One line of the table under TABLE_HEADER."""
    what = stats.summary if stats.restart is None else f"{stats.summary} (restart: {stats.restart})"
    seconds = f"{stats.seconds['total']:8.2f}"
    if stats.product:
        what = f"{stats.product.rsplit('/', 1)[-1]}: {what}"
    return f"{format_frame(stats.frame):>8}  {what:<44}  {stats.retraced_rays:>12,}  {seconds}"


def tell_notices(report: Report, progress: ShotProgress) -> None:
    """Says what the report holds that was not said before."""
    _tell(report.take_new(), progress)


def _tell(notices: Iterable[Notice], progress: ShotProgress) -> None:
    for notice in notices:
        progress.message(f"irt: {notice.text}")


class _Written:
    """Follows frames to the disk: their statistics, their rows, what they lacked."""

    def __init__(self, report: Report, progress: ShotProgress, keeper: "Keeper | None") -> None:
        self.stats: list[dict[str, Any]] = []
        self._keeper = keeper
        self._report = report
        self._progress = progress
        self._waiting: dict[Frame | None, list[Notice]] = {}

    def expect(self, frame: Frame | None) -> None:
        """Keeps what the report has to say of `frame` until its row; None: of one without a row."""
        self._waiting[frame] = self._report.take_new()

    def take(self, writer: FrameWriter) -> None:
        for frame in writer.take_written():
            stats = frame.job.stats
            self.stats.append(stats.to_json())
            if self._keeper is not None:
                self._keeper.written(stats.frame, frame.hash, self.stats[-1])
            _tell(self._waiting.pop(stats.frame, []), self._progress)
            self._progress.finished(table_row(stats))
            self._mention_faults(frame)
            tell_notices(self._report, self._progress)
        if None in self._waiting:
            for notices in self._waiting.values():
                _tell(notices, self._progress)
            self._waiting.clear()

    def _mention_faults(self, frame: WrittenFrame) -> None:
        name = f"frame {format_frame(frame.job.stats.frame)}"
        if frame.faults.non_finite:
            self._report.mentioned(
                "pixels that are NaN or infinite, written as they are",
                f"{name}: {frame.faults.non_finite}",
            )
        if frame.faults.too_bright:
            self._report.mentioned(
                "pixels brighter than a half can hold, written as 65504 (--exr-type float keeps"
                " them)",
                f"{name}: {frame.faults.too_bright}",
            )


def _frame_stats(
    shot: Shot, traced: TracedFrame, view: int, path: Path, history: str
) -> FrameStats:
    """Of one view; what all have in common is counted as the first one's time."""
    update = traced.updates[view]
    seconds = dict(traced.seconds if view == 0 else update["seconds"])
    for other in traced.updates[1:] if view == 0 else ():
        seconds["total"] -= other["seconds"]["total"]
    return FrameStats(
        frame=traced.frame,
        file=str(path),
        history=history,
        summary=traced.changes.summary(),
        change_count=len(traced.changes.changes),
        camera_changed=traced.changes.cameras[view],
        update=update,
        seconds=seconds,
        product=shot.views[view].product.path if len(shot.views) > 1 else "",
    )
