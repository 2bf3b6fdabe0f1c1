# SPDX-License-Identifier: Apache-2.0
"""Frame statistics: what a frame cost, as a table's row and as one JSON object a frame."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irt_usd.images.atomic import atomic_file
from irt_usd.shot.frames import Frame

PHASES = (
    "usd", "diff", "apply", "bvh", "detect", "trace", "shade", "combine", "film", "write", "total"
)  # fmt: skip
"""Seconds are told by phase. `total` is the frame's time by the clock from the start of its reading
to the end of its tracing, what lies between the phases included, plus `write`, which overlaps the
next frames: so no less than the sum of the phases."""


@dataclass
class FrameStats:
    """One frame's statistics; `update` is what Renderer.update returned."""

    frame: Frame
    file: str | None
    history: str
    summary: str
    change_count: int
    camera_changed: bool
    update: Mapping[str, Any]
    seconds: dict[str, float]
    non_finite_pixels: int = 0
    product: str = ""
    """The render product, where there are several."""

    @property
    def restart(self) -> str | None:
        """Why the update was a full trace, None where it was not or is the first."""
        return self.update["restart"]  # type: ignore[no-any-return]

    @property
    def all_rays(self) -> int:
        """Rays of the frame, had it been traced in full."""
        return int(self.update["all_rays"])

    @property
    def retraced_rays(self) -> int:
        """Rays traced for this frame."""
        return int(self.update["retraced_rays"])

    def to_json(self) -> dict[str, Any]:
        """The frame's object in a statistics file."""
        return {
            "frame": json_frame(self.frame),
            "time_code": float(self.frame),
            "file": self.file,
            **({"product": self.product} if self.product else {}),
            "history": self.history,
            "restart": self.restart,
            "changes": {
                "summary": self.summary,
                "count": self.change_count,
                "camera": self.camera_changed,
            },
            "rays": self.update["rays"],
            **{key: self.update[key] for key in RAY_COUNTS},
            "nodes_traversed": self.update["nodes_traversed"],
            "intersections": self.update["intersections"],
            "shadings": self.update["shadings"],
            "history_size": self.update["history"],
            "non_finite_pixels": self.non_finite_pixels,
            "seconds": {phase: round(self.seconds.get(phase, 0.0), 6) for phase in PHASES},
            "cells": {
                **self.update["cells"],
                "spread": {
                    kind: spread(self.update["cells"][kind]) for kind in ("rays", "seconds")
                },
            },
        }


def spread(values: Sequence[float]) -> float:
    """How far cells lie apart, as in the paper's table 4: (max - min) / max; 0 where all are 0."""
    greatest = max(values, default=0.0)
    return (greatest - min(values)) / greatest if greatest > 0 else 0.0


RAY_COUNTS = (
    "flagged_rays",
    "tested_rays",
    "retraced_rays",
    "changed_rays",
    "new_rays",
    "uncovered_rays",
    "whole_scene_rays",
    "all_rays",
)


def json_frame(frame: Frame) -> int | float:
    """A frame number as JSON shows it: 1001, 1.25."""
    return int(frame) if frame == frame.to_integral_value() else float(frame)


def write_stats(path: Path, frames: Iterable[Mapping[str, Any]]) -> None:
    """One JSON object a line, whole or not at all. Raises MachineError."""
    with atomic_file(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        for stats in frames:
            file.write(json.dumps(stats, allow_nan=False) + "\n")
