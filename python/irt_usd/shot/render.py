# SPDX-License-Identifier: Apache-2.0
"""The frame loop: a shot in, its EXR sequence out."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from irt_usd.images.exr import Film, PixelType
from irt_usd.images.preview import DisplayView
from irt_usd.report import Notice, Report
from irt_usd.shot.frames import Frame, format_frame
from irt_usd.shot.metadata import frame_metadata, shot_metadata
from irt_usd.shot.products import report_variables
from irt_usd.shot.progress import ShotProgress
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.stats import FrameStats, write_stats
from irt_usd.shot.tracer import History, ShotTracer, TracedFrame
from irt_usd.shot.writer import FrameJob, FrameWriter, WrittenFrame

TABLE_HEADER = f"{'frame':>8}  {'changed':<44}  {'rays traced':>12}  {'seconds':>8}"


@dataclass(frozen=True)
class OutputOptions:
    """Where frames go, by frame and view, and in which form."""

    paths: Sequence[tuple[Path, ...]]
    pixel_type: PixelType = "half"
    history: History = "full"
    stats: Path | None = None
    preview: DisplayView | None = None
    """How a PNG beside each frame shows it; None: there are none."""


def render_shot(
    shot: Shot,
    frames: Sequence[Frame],
    settings: TraceSettings,
    output: OutputOptions,
    progress: ShotProgress,
) -> None:
    """Renders `frames` of the shot into `output.paths`.

    However it ends, the frames traced by then are written whole, and the statistics tell of
    those. Raises InputError and MachineError.
    """
    tracer = ShotTracer(shot, settings, frames, output.history)
    views = range(len(shot.views))
    common = [shot_metadata(shot, settings, view) for view in views]
    writer = FrameWriter()
    written = _Written(shot.report, progress)
    report_variables(shot.views, shot.report)
    tell_notices(shot.report, progress)
    films: dict[int, Film] = {}
    try:
        try:
            for frame, paths in zip(frames, output.paths, strict=True):
                traced = tracer.trace(frame, partial(progress.tracing, frame))
                written.expect(frame)
                for view, path in zip(views, paths, strict=True):
                    # The film of an unchanged frame is written again as it is.
                    if not (traced.unchanged(view) and view in films) or any(
                        name.startswith("irt.") for name in tracer.aovs(view)
                    ):
                        films[view] = tracer.film(view)
                    camera = traced.snapshot.cameras[view]
                    metadata = common[view] | frame_metadata(frame, camera)
                    stats = _frame_stats(shot, traced, view, path, output.history)
                    film, kind = films[view], output.pixel_type
                    job = FrameJob(path, film, metadata, kind, stats, output.preview)
                    writer.submit(job)
                written.take(writer)
        finally:
            written.expect(None)
            try:
                writer.finish()
            finally:
                written.take(writer)
    finally:
        if output.stats is not None:
            write_stats(output.stats, written.stats)


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

    def __init__(self, report: Report, progress: ShotProgress) -> None:
        self.stats: list[FrameStats] = []
        self._report = report
        self._progress = progress
        self._waiting: dict[Frame | None, list[Notice]] = {}

    def expect(self, frame: Frame | None) -> None:
        """Keeps what the report has to say of `frame` until its row; None: of one without a row."""
        self._waiting[frame] = self._report.take_new()

    def take(self, writer: FrameWriter) -> None:
        for frame in writer.take_written():
            stats = frame.job.stats
            self.stats.append(stats)
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
