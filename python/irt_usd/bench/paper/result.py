# SPDX-License-Identifier: Apache-2.0
"""What `irt bench paper` found, scene by scene, and its JSON."""

import statistics
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from irt_usd.bench.paper import published
from irt_usd.bench.paper.costs import UnitCosts, ceiling
from irt_usd.bench.paper.times import EditTimes, InitialTimes, SceneTimes, medians, overhead, spread
from irt_usd.bench.paper.work import SceneWork
from irt_usd.bench.timing import Figure, Spread


@dataclass(frozen=True)
class EditResult:
    """An edit's times, and the ratio if only what changed were paid for (None: nothing)."""

    times: EditTimes
    ceiling: float | None


@dataclass(frozen=True)
class SceneResult:
    """One scene. Seconds are of all threads, `initial_cells` of each cell's task."""

    name: str
    pixels: int
    level: float
    work: SceneWork
    times: SceneTimes
    costs: UnitCosts
    edits: Mapping[str, EditResult]
    initial: list[InitialTimes]
    loops: Mapping[str, Spread]
    initial_cells: list[list[float]]

    @classmethod
    def of_edits(
        cls, times: SceneTimes, costs: UnitCosts, work: SceneWork, tree_changes: Mapping[str, int]
    ) -> dict[str, EditResult]:
        """`tree_changes`: by edit, how many of its changed rays are no shadow rays."""
        return {
            name: EditResult(entry, ceiling(costs, work.edits[name], tree_changes[name]))
            for name, entry in times.edits.items()
        }

    @property
    def overhead(self) -> float:
        """Of the initial step over a full trace without a history, both by new renderers."""
        return overhead([t.recorded for t in self.initial], [t.traced for t in self.initial])

    @property
    def processor_overhead(self) -> float:
        """The same in processor seconds."""
        return overhead(
            [t.recorded_processor for t in self.initial],
            [t.traced_processor for t in self.initial],
        )

    @property
    def empty_share(self) -> float:
        """An update that changes nothing, over a full trace."""
        return statistics.median(self.times.empty) / self.times.full_seconds

    @property
    def time_spread(self) -> float:
        """Over the cells, of the initial step's median seconds."""
        return spread(medians(self.initial_cells))

    @property
    def rays_spread(self) -> float:
        """Over the cells, of the rays that the initial step traced and the history holds."""
        return spread(self.work.cell_rays["full"])

    def update_time_spread(self, edit: str) -> float:
        """Over the cells, of an update's median seconds."""
        return spread(medians(self.times.edits[edit].cell_seconds))

    def update_rays_spread(self, edit: str) -> float:
        """Over the cells, of the rays that an update traced."""
        return spread(self.work.cell_rays[edit])

    @property
    def history_bytes(self) -> int:
        """All kinds together, the table included."""
        return int(self.work.history["all_bytes"])

    @property
    def bytes_per_node(self) -> float:
        """A node: a ray of the trees, whether it sees something or not."""
        return self.history_bytes / int(self.work.history["nodes"])

    @property
    def bytes_per_point(self) -> float:
        """The paper's nodes: those that see something."""
        return self.history_bytes / int(self.work.history["points"])

    def kinds(self) -> dict[str, dict[str, int | None]]:
        """Bytes and count by kind of structure; None: a count that is not told."""
        nodes, points = self.work.history["nodes"], self.work.history["points"]
        counts = {
            "nodes": nodes,
            "hash_indices": nodes,
            "points": points,
            "intersections": points,
            "masks": points,
            "intensities": points,
            "light_nodes": self.work.rays["shadow"],
        }
        return {
            kind: {"bytes": size, "count": counts.get(kind)}
            for kind, size in self.work.history["bytes"].items()
        }

    def figure(self, edit: str) -> Figure:
        """Table 1's ratio beside what it is to reach."""
        entry, paper = self.edits[edit], published.ratio(self.name, edit)
        if edit not in published.OBJECT_EDITS:
            return light_figure(entry, paper)
        aim = None
        if paper is not None:
            aim = published.COLOR_AIM if edit == "color" else published.AIM_OVER_PAPER * paper
        return Figure(edit, entry.times.ratio, paper, aim)

    def rays_per_second(self) -> dict[str, float]:
        """Of a full trace, and of Embree's bare loop over the same rays."""
        rays = sum(self.work.rays.values())
        bare = self.loops["bare nearest"].median + self.loops["bare occlusion"].median
        return {
            "full trace": rays / self.times.full_seconds,
            "full trace, 1 thread": rays / self.costs.full,
            "bare loop, 1 thread": rays / bare,
        }

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        return {
            "full_seconds": self.times.full_seconds,
            "history_overhead": self.overhead,
            "history_overhead_processor": self.processor_overhead,
            "cells": {
                "time_spread": self.time_spread,
                "history_spread": self.rays_spread,
                "update_spread": self.update_rays_spread("move_2"),
                "updates": {
                    edit: {
                        "rays_spread": self.update_rays_spread(edit),
                        "time_spread": self.update_time_spread(edit),
                    }
                    for edit in self.edits
                },
            },
            "history": {
                "nodes": self.work.history["nodes"],
                "points": self.work.history["points"],
                "bytes": self.history_bytes,
                "bytes_per_pixel": self.history_bytes / self.pixels,
                "bytes_per_node": self.bytes_per_node,
                "bytes_per_point": self.bytes_per_point,
                "kinds": self.kinds(),
            },
            "edits": {
                "full": {
                    "seconds": self.times.full_seconds,
                    "ratio": 1.0,
                    "ceiling": 1.0,
                    **self.work.counts_json("full"),
                },
                **{
                    edit: {**edit_json(entry), **self.work.counts_json(edit)}
                    for edit, entry in self.edits.items()
                },
            },
            "mean_level": self.level,
            "rays": dict(self.work.rays),
            "rays_per_second": self.rays_per_second(),
            "unit_costs": asdict(self.costs),
            "empty_update_share": self.empty_share,
        }


@dataclass(frozen=True)
class PaperResult:
    """Everything; `lights` by how many moved."""

    size: tuple[int, int]
    repeats: int
    scenes: Mapping[str, SceneResult]
    lights: Mapping[str, EditResult]

    def to_json(self, machine: Mapping[str, Any]) -> dict[str, Any]:
        """For `--json`."""
        return {
            "machine": dict(machine),
            "size": list(self.size),
            "repeats": self.repeats,
            "scenes": {name: scene.to_json() for name, scene in self.scenes.items()},
            "lights": {moved: edit_json(entry) for moved, entry in self.lights.items()},
        }


def light_figure(entry: EditResult, paper: float | None) -> Figure:
    """A moved light's ratio: most of its ceiling is asked for, the paper's is the aim."""
    floor = None if entry.ceiling is None else published.LEAST_OF_CEILING * entry.ceiling
    return Figure("light", entry.times.ratio, floor, paper)


def edit_json(entry: EditResult) -> dict[str, Any]:
    """Times of an edit."""
    times = entry.times
    return {
        "seconds": times.seconds,
        "ratio": times.ratio.median,
        "ratio_range": [times.ratio.low, times.ratio.high],
        "undo_ratio": times.undo_ratio.median,
        "processor_ratio": times.processor_ratio.median,
        "whole_frame_ratio": times.whole_frame_ratio.median,
        "ceiling": entry.ceiling,
    }
