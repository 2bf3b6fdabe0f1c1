# SPDX-License-Identifier: Apache-2.0
"""The proof of contract C1: a shot's films against films made from nothing, bit by bit.

The judging side of a frame is a new opening of the stage, a new reading of that one frame and a
new renderer. What was settled for the shot (camera, size, render origin) is settled for it too.
"""

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irt_usd.aovs import aov, beauty_parts, sources
from irt_usd.images.exr import Film
from irt_usd.shot.frames import Frame, count_frames, format_frame
from irt_usd.shot.products import product_label
from irt_usd.shot.progress import ShotProgress
from irt_usd.shot.render import tell_notices
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.stats import RAY_COUNTS, json_frame
from irt_usd.shot.tracer import ShotTracer, TracedFrame

FLOAT_MAX = float(np.finfo(np.float32).max)
"""Stands in the verdict for differences that are not finite: JSON has no infinity."""

TABLE_HEADER = (
    f"{'frame':>8}  {'changed':<36}  {'rays':>11}  {'retraced':>11}  {'update s':>8}  {'full s':>8}"
    "  differing"
)


@dataclass(frozen=True)
class Difference:
    """Where two films first differ, row by row from the top."""

    frame: Frame
    x: int
    y: int
    channel: str

    def to_json(self) -> dict[str, Any]:
        """As the verdict's `first_difference`."""
        return {
            "frame": json_frame(self.frame),
            "x": self.x,
            "y": self.y,
            "channel": self.channel,
        }


@dataclass(frozen=True)
class FrameVerdict:
    """One frame's comparison, with the ray counts of the update that is judged."""

    frame: Frame
    rays: Mapping[str, int]
    restart: str | None
    seconds_update: float
    seconds_full: float
    differing_pixels: int
    max_abs_difference: float
    first_difference: Difference | None
    brute_force_differing: int


@dataclass
class Verdict:
    """What a verification found."""

    pixels: int
    """Of a frame, all views together."""
    brute_force_pixels: list[int]
    """By view the pixels of each frame that went through the brute-force twin as well."""
    frames: list[FrameVerdict] = field(default_factory=list)

    @property
    def _count(self) -> int:
        """Frames; `frames` has an entry for each view of them."""
        return len({found.frame for found in self.frames})

    @property
    def exact(self) -> bool:
        """Whether no pixel differs in any bit."""
        return not any(f.differing_pixels or f.brute_force_differing for f in self.frames)

    @property
    def restarts(self) -> int:
        """Updates that fell back to a full trace; the first frame is none."""
        return sum(frame.restart is not None for frame in self.frames)

    def to_json(self) -> dict[str, Any]:
        """The verdict as `irt verify --json` writes it."""
        first = next((f.first_difference for f in self.frames if f.first_difference), None)
        return {
            "frames": self._count,
            "pixels": self._count * self.pixels,
            "differing_pixels": sum(frame.differing_pixels for frame in self.frames),
            "max_abs_difference": max((f.max_abs_difference for f in self.frames), default=0.0),
            "first_difference": first.to_json() if first else None,
            "restarts": self.restarts,
            "seconds_update": sum(frame.seconds_update for frame in self.frames),
            "seconds_full": sum(frame.seconds_full for frame in self.frames),
            "brute_force_pixels": self._count * sum(self.brute_force_pixels),
            "brute_force_differing": sum(frame.brute_force_differing for frame in self.frames),
            "per_frame": [
                {"frame": json_frame(frame.frame), **frame.rays, "restart": frame.restart}
                for frame in self.frames
            ],
        }

    def sentence(self) -> str:
        """The verdict in a line."""
        found = self.to_json()
        what = f"{count_frames(found['frames'])}, {found['pixels']:,} pixels"
        if self.exact:
            return f"exact: {what}, every bit as traced from nothing"
        first = found["first_difference"]
        where = (
            f"; first at frame {first['frame']}, pixel {first['x']},{first['y']},"
            f" channel {first['channel']}"
            if first
            else ""
        )
        return (
            f"DIFFERENT: {found['differing_pixels']:,} of {what}{where};"
            f" brute force: {found['brute_force_differing']} of {found['brute_force_pixels']}"
        )


def verify_shot(
    shot: Shot, settings: TraceSettings, brute_force_pixels: int, progress: ShotProgress
) -> Verdict:
    """Renders the shot, and every frame of it again from nothing, and compares the films.

    Raises InputError as rendering does.
    """
    pixels = [view.framing.size[0] * view.framing.size[1] for view in shot.views]
    verdict = Verdict(sum(pixels), [min(brute_force_pixels, count) for count in pixels])
    tracer = ShotTracer(shot, settings, shot.frames)
    tell_notices(shot.report, progress)
    for frame in shot.frames:
        traced = tracer.trace(frame, partial(_show_half, progress, frame, 0.0))
        judge = ShotTracer(shot.reopened(frame), settings, (frame,), "none")
        fresh = judge.trace(frame, partial(_show_half, progress, frame, 0.5))
        for view, count in enumerate(verdict.brute_force_pixels):
            brute_differing = _brute_force_differing(tracer, judge, view, frame, count)
            found = _compare(traced, fresh, view, tracer, judge, brute_differing)
            verdict.frames.append(found)
            tell_notices(shot.report, progress)
            progress.finished(_table_row(found, _what(shot, view, traced)))
    return verdict


def _what(shot: Shot, view: int, traced: TracedFrame) -> str:
    summary = traced.changes.summary()
    return summary if len(shot.views) == 1 else f"{product_label(shot.views[view])}: {summary}"


def _show_half(progress: ShotProgress, frame: Frame, start: float, fraction: float) -> None:
    progress.tracing(frame, start + fraction / 2)


def compare_films(frame: Frame, a: Film, b: Film) -> tuple[int, float, Difference | None]:
    """How many pixels differ in any bit of any channel, by how much at most, and where first.

    Ids have no magnitude: they count as pixels but not in the greatest difference.
    """
    height, width = a.beauty.shape[:2]
    differing = np.zeros((height, width), dtype=bool)
    greatest = 0.0
    first: tuple[int, str] | None = None
    for channel, left, right in _channels(a, b):
        unequal = _bits(left) != _bits(right)
        if not unequal.any():
            continue
        differing |= unequal
        index = int(np.flatnonzero(unequal)[0])
        if first is None or index < first[0]:
            first = (index, channel)
        if left.dtype.kind == "f":
            greatest = max(greatest, _greatest_difference(left[unequal], right[unequal]))
    if first is None:
        return 0, 0.0, None
    y, x = divmod(first[0], width)
    return int(np.count_nonzero(differing)), greatest, Difference(frame, x, y, first[1])


def _compare(
    traced: TracedFrame,
    fresh: TracedFrame,
    view: int,
    tracer: ShotTracer,
    judge: ShotTracer,
    brute_differing: int,
) -> FrameVerdict:
    differing, greatest, first = compare_films(traced.frame, tracer.film(view), judge.film(view))
    update = traced.updates[view]
    return FrameVerdict(
        frame=traced.frame,
        rays={key: int(update[key]) for key in RAY_COUNTS},
        restart=update["restart"],
        seconds_update=float(update["seconds"]["total"]),
        seconds_full=float(fresh.updates[view]["seconds"]["total"]),
        differing_pixels=differing,
        max_abs_difference=greatest,
        first_difference=first,
        brute_force_differing=brute_differing,
    )


def _channels(a: Film, b: Film) -> Iterator[tuple[str, NDArray[Any], NDArray[Any]]]:
    """Every channel's name with its two planes, (height, width)."""
    for index, name in enumerate("RGBA"):
        yield name, a.beauty[..., index], b.beauty[..., index]
    for name, plane in a.aovs.items():
        other = b.aovs[name]
        if plane.ndim == 2:
            yield name, plane, other
        else:
            for index, channel in enumerate(aov(name).channels(name, plane.shape[2])):
                yield channel, plane[..., index], other[..., index]


def _bits(plane: NDArray[Any]) -> NDArray[np.uint32]:
    return np.ascontiguousarray(plane).view(np.uint32)


def _greatest_difference(a: NDArray[Any], b: NDArray[Any]) -> float:
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(a.astype(np.float64) - b.astype(np.float64))
    return float(np.nan_to_num(difference, nan=FLOAT_MAX, posinf=FLOAT_MAX).max())


def _brute_force_differing(
    tracer: ShotTracer, judge: ShotTracer, view: int, frame: Frame, count: int
) -> int:
    """Pixels of a sample, the frame's own but always the same, that the twin sees otherwise."""
    beauty = tracer.renderer.beauty(view)
    planes = {
        name: tracer.renderer.aov(name, view)
        for name in (
            *sources(tracer.aovs(view)),
            *(part[0] for part in beauty_parts(tracer.aovs(view))),
        )
        if not name.startswith("irt.")
    }
    height, width = beauty.shape[:2]
    sample = random.Random(format_frame(frame)).sample(range(width * height), count)
    differing = 0
    for index in sample:
        y, x = divmod(index, width)
        twin = judge.renderer.brute_force_pixel(x, y, view)
        same = _same_bits(twin["beauty"], beauty[y, x]) and all(
            _same_bits(twin[name], plane[y, x]) for name, plane in planes.items()
        )
        differing += not same
    return differing


def _same_bits(a: Any, b: Any) -> bool:
    """`a` and `b`: a pixel's channels, 32 bits each."""
    left, right = np.atleast_1d(np.asarray(a)), np.atleast_1d(np.asarray(b))
    return bool(np.array_equal(_bits(left).ravel(), _bits(right).ravel()))


def _table_row(found: FrameVerdict, summary: str) -> str:
    differing = "-" if found.first_difference is None else f"{found.differing_pixels:,} pixels"
    if found.brute_force_differing:
        differing += f", {found.brute_force_differing} from brute force"
    return (
        f"{format_frame(found.frame):>8}  {summary:<36}  {found.rays['all_rays']:>11,}"
        f"  {found.rays['retraced_rays']:>11,}  {found.seconds_update:>8.2f}"
        f"  {found.seconds_full:>8.2f}  {differing}"
    )
