# SPDX-License-Identifier: Apache-2.0
"""What updates saved: the statistics of a shot beside those of its full traces."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irt_usd.errors import InputError

TRACING_PHASES = ("apply", "bvh", "detect", "trace", "shade", "combine", "film")
"""From the change set to the film."""

TABLE_HEADER = (
    f"{'frame':>8}  {'changed':<36}  {'retraced':>8}  {'full s':>8}  {'update s':>8}"
    f"  {'tracing':>8}  {'frame':>8}"
)


@dataclass(frozen=True)
class FrameTimes:
    """Seconds of one frame: of tracing alone, and of all of it, files included."""

    tracing: float
    whole: float


@dataclass(frozen=True)
class FrameSpeedup:
    """One frame both ways. `retraced` is the share of its rays."""

    frame: str
    summary: str
    retraced: float
    update: FrameTimes
    full: FrameTimes


def read_stats(path: Path) -> list[dict[str, Any]]:
    """The objects of a `--stats` file. Raises InputError."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as statistics: {error}") from error
    frames = []
    for number, line in enumerate(lines, 1):
        try:
            frame = json.loads(line)
            if not {"frame", "seconds", "changes", "all_rays", "retraced_rays"} <= frame.keys():
                raise ValueError("keys are missing")
        except (ValueError, AttributeError) as error:
            raise InputError(
                f"{path}: line {number} is not a frame's statistics ({error}); give a file that"
                " `irt render --stats` wrote"
            ) from error
        frames.append(frame)
    return frames


def compare_stats(
    updates: Sequence[Mapping[str, Any]], full: Sequence[Mapping[str, Any]]
) -> list[FrameSpeedup]:
    """The frames of `updates` beside the same ones of `full`. Raises InputError where one lacks."""
    others = {frame["frame"]: frame for frame in full}
    speedups = []
    for frame in updates:
        other = others.get(frame["frame"])
        if other is None:
            raise InputError(
                f"frame {frame['frame']} is not among the full traces; render the same frames"
                " with --history none"
            )
        rays = frame["all_rays"]
        speedups.append(
            FrameSpeedup(
                str(frame["frame"]),
                frame["changes"]["summary"],
                frame["retraced_rays"] / rays if rays else 0.0,
                _times(frame["seconds"]),
                _times(other["seconds"]),
            )
        )
    return speedups


def table_rows(speedups: Sequence[FrameSpeedup]) -> list[str]:
    """One line a frame under TABLE_HEADER, and one for the shot."""
    rows = [_row(s.frame, s.summary, f"{s.retraced:8.2%}", s.update, s.full) for s in speedups]
    update, full = (
        FrameTimes(sum(t.tracing for t in times), sum(t.whole for t in times))
        for times in ([s.update for s in speedups], [s.full for s in speedups])
    )
    return [*rows, _row("shot", f"{len(speedups)} frames", " " * 8, update, full)]


def _times(seconds: Mapping[str, float]) -> FrameTimes:
    return FrameTimes(sum(seconds[phase] for phase in TRACING_PHASES), seconds["total"])


def _row(frame: str, summary: str, retraced: str, update: FrameTimes, full: FrameTimes) -> str:
    return (
        f"{frame:>8}  {summary:<36}  {retraced}  {full.tracing:>8.3f}  {update.tracing:>8.4f}"
        f"  {_ratio(full.tracing, update.tracing):>8}  {_ratio(full.whole, update.whole):>8}"
    )


def _ratio(full: float, update: float) -> str:
    if update <= 0 or full / update > 9999:
        return ">9999x"
    return f"{full / update:.1f}x"
