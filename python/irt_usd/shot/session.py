# SPDX-License-Identifier: Apache-2.0
"""An opened shot: its stage, its frames and what is the same in all of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from math import isfinite
from pathlib import Path

from pxr import Usd

from irt_usd.choices import COMPLEXITY
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.frames import (
    Frame,
    format_frames,
    frames_from_stage,
    parse_frames,
)
from irt_usd.shot.settings import ShotOptions
from irt_usd.stage import OpenOptions, ReadOptions, ShotReader, assets_read, open_stage
from irt_usd.stage.graph import NoTextures
from irt_usd.stage.views import View, settled

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Shot:
    """A shot ready to be read frame by frame.

    `render_origin` is the camera's place in world space at the start of the stage's range, at the
    earliest time where the stage has none: a setting of the shot, since what is traced relative to
    another origin rounds otherwise; whatever frames are rendered, it is the same. (Only where that
    place is not finite is it the one at the first frame.) `camera_moves` are, by view, the frames
    whose camera differs from that of the frame before.
    """

    options: ShotOptions
    stage: Usd.Stage
    report: Report
    frames: tuple[Frame, ...]
    reader: ShotReader
    render_origin: Vec3
    camera_moves: tuple[tuple[Frame, ...], ...]

    @property
    def views(self) -> tuple[View, ...]:
        """The shot's images, one at least."""
        return self.reader.views

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the first view's film in pixels."""
        return self.views[0].framing.size

    @property
    def moves(self) -> tuple[Frame, ...]:
        """The frames at which any camera differs from that of the frame before."""
        moving = {frame for moves in self.camera_moves for frame in moves}
        return tuple(frame for frame in self.frames if frame in moving)

    @property
    def read_files(self) -> list[Path]:
        """The files that the shot is read from: layers, textures and profiles."""
        layers = [layer.realPath for layer in self.stage.GetUsedLayers() if layer.realPath]
        return [Path(file) for file in (*layers, *self.reader.files)]

    def reread(self) -> ShotReader:
        """Another reader of the same frames, which reports to nobody and decodes no textures."""
        reading = replace(_reading(self.options), views=tuple(map(settled, self.views)))
        reading = replace(reading, textures=NoTextures())
        frames = [float(frame) for frame in self.frames]
        return ShotReader(self.stage, reading, Report(), frames)

    def reopened(self, frame: Frame) -> "Shot":
        """The one frame as a shot of its own, read from a new opening of the stage.

        What was settled for this shot (views, render origin) is settled for it too.
        """
        report = Report()
        stage = open_stage(self.options.stage, opening(self.options), report)
        reading = replace(_reading(self.options), views=tuple(map(settled, self.views)))
        reader = ShotReader(stage, reading, report, [float(frame)])
        still: tuple[tuple[Frame, ...], ...] = ((),) * len(self.views)
        return Shot(self.options, stage, report, (frame,), reader, self.render_origin, still)


def open_shot(options: ShotOptions, report: Report) -> Shot:
    """Opens the stage and settles frames, camera and size. Raises InputError."""
    if options.frames is not None:
        parse_frames(options.frames)  # refused before the stage is opened
    assets_read.forget()
    return shot_of(open_stage(options.stage, opening(options), report), options, report)


def shot_of(stage: Usd.Stage, options: ShotOptions, report: Report) -> Shot:
    """The shot of a stage that is open, as `opening` has it. Raises InputError."""
    requested = parse_frames(options.frames) if options.frames is not None else None
    frames = requested or _stage_frames(stage, options.stage)
    reader = ShotReader(stage, _reading(options), report, [float(f) for f in frames])
    _mention_range(stage, frames, report)
    report.enforce("the shot cannot be rendered whole; nothing was rendered")
    shot = Shot(
        options,
        stage,
        report,
        frames,
        reader,
        _render_origin(reader, stage, frames[0]),
        tuple(tuple(f for f in frames if float(f) in set(m)) for m in reader.camera_moves),
    )
    if shot.moves and options.require_locked:
        cameras = {
            v.camera for v, moves in zip(shot.views, shot.camera_moves, strict=True) if moves
        }
        raise InputError(
            f"{options.stage}: {', '.join(sorted(cameras))} moves at frames"
            f" {format_frames(shot.moves)}; --require-locked asks for a camera that does not: give"
            " a range in which it rests, or freeze it with --lock-camera FRAME"
        )
    return shot


def opening(options: ShotOptions) -> OpenOptions:
    """How the stage is opened; a camera given by its path is there behind any mask."""
    mask = options.mask
    if mask and options.camera is not None and options.camera.startswith("/"):
        mask = (*mask, options.camera)
    return OpenOptions(options.session_layer, mask, options.asset_path, options.missing_asset)


def _reading(options: ShotOptions) -> ReadOptions:
    return ReadOptions(
        camera=options.camera,
        purposes=options.purposes,
        camera_light=options.camera_light,
        level=COMPLEXITY[options.complexity],
        size=options.size,
        missing_asset=options.missing_asset,
        texture_memory=options.texture_memory,
        settings=options.settings,
        data_window=options.data_window,
        lock_camera=float(options.lock_camera) if options.lock_camera is not None else None,
        dome_samples=options.dome_samples,
        render_pass=options.render_pass,
        aovs=options.aovs,
    )


def _stage_frames(stage: Usd.Stage, file: str) -> tuple[Frame, ...]:
    """The stage's own range; where it has none, time code 0, at which defaults hold."""
    if stage.HasAuthoredTimeCodeRange():
        return frames_from_stage(stage.GetStartTimeCode(), stage.GetEndTimeCode(), file)
    return (Decimal(0),)


def _mention_range(stage: Usd.Stage, frames: Sequence[Frame], report: Report) -> None:
    if not stage.HasAuthoredTimeCodeRange():
        return
    start, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    if max(frames) < start or min(frames) > end:
        report.mentioned(
            f"no frame asked for lies in the stage's own range, {start:g} to {end:g}:"
            " values are held"
        )


def _render_origin(reader: ShotReader, stage: Usd.Stage, first: Frame) -> Vec3:
    start = Usd.TimeCode.EarliestTime()
    if stage.HasAuthoredTimeCodeRange():
        start = Usd.TimeCode(stage.GetStartTimeCode())
    place = reader.camera_position(start)
    if all(map(isfinite, place)):
        return place
    return reader.camera_position(Usd.TimeCode(float(first)))
