# SPDX-License-Identifier: Apache-2.0
"""What the paper prints in its section 6, and what is asked of ours beside it."""

from dataclasses import dataclass

SECONDS = {
    "chess": {
        "full": 70.4,
        "move_1": 3.3,
        "move_2": 7.2,
        "resize": 4.1,
        "light": 7.6,
        "color": 0.8,
    },
    "chess_shadows": {
        "full": 101.4,
        "move_1": 5.8,
        "move_2": 13.8,
        "resize": 6.9,
        "light": 33.8,
        "color": 0.9,
    },
    "spheres": {
        "full": 113.3,
        "move_1": 6.7,
        "move_2": 9.4,
        "resize": 8.2,
        "light": 24.3,
        "color": 1.5,
    },
}
"""Table 1, by scene and edit. SPHERES with shadows is not in it."""

LIGHTS_FULL_SECONDS = 164.1
LIGHTS_SECONDS = {1: 48.8, 2: 75.4, 3: 102.4}
"""Table 3, by lights moved of three."""

HISTORY_OVERHEAD = 0.4
"""Of the initial step over tracing without a history (section 6)."""


@dataclass(frozen=True)
class Work:
    """A row of table 2: counts a cell, CHESS with shadows."""

    new_rays: int
    nodes_traversed: int
    intersections: int
    shadings: int


WORK = {
    "full": Work(1477, 1433, 13765, 807),
    "move_1": Work(5, 131, 419, 31),
    "move_2": Work(27, 231, 1518, 97),
    "resize": Work(28, 81, 620, 45),
    "light": Work(0, 1433, 4621, 807),
    "color": Work(0, 18, 0, 14),
}
"""Table 2. Of the full trace it gives no nodes traversed; these are all there are (section 6)."""


@dataclass(frozen=True)
class Spreads:
    """A row of table 4: (max - min) / max over the cells."""

    time: float
    history: float


SPREADS = {
    "chess": Spreads(0.027, 0.017),
    "chess_shadows": Spreads(0.030, 0.020),
    "spheres": Spreads(0.064, 0.033),
}
"""Table 4; CHESS's history as its own least and greatest give it, not the 2.4 % printed."""


@dataclass(frozen=True)
class HistorySize:
    """A row of table 5."""

    nodes: int
    megabytes: float

    @property
    def bytes_per_node(self) -> float:
        """10^6 bytes a megabyte."""
        return self.megabytes * 1e6 / self.nodes


HISTORY = {
    "chess": HistorySize(91_780, 39.8),
    "chess_shadows": HistorySize(91_780, 44.5),
    "spheres_shadows": HistorySize(208_192, 64.7),
}
"""Table 5."""

OBJECT_EDITS = ("move_1", "move_2", "resize", "color")
"""Edits whose ratio is to reach the paper's (a moved light's is held against its ceiling)."""

AIM_OVER_PAPER = 3.0
COLOR_AIM = 200.0
LEAST_OF_CEILING = 0.8
"""Of a moved light."""
MOST_INTERSECTIONS = 2.0
"""Times the paper's share: a BVH tests a fifth of what the paper's grid tested in a full trace."""
MOST_OVERHEAD, OVERHEAD_AIM = 0.40, 0.20
MOST_WASTE, WASTE_AIM = 2.0, 1.3
MOST_SPREAD, SPREAD_AIM = 0.03, 0.02
"""Of the rays of the cells in the initial step."""
BYTES_AIM = 96.0
LEAST_FROM_HISTORY = 0.9
"""Of the points uncovered by the first edit: answered without tracing the whole scene."""
MOST_EMPTY = 0.01
"""Of a full trace: an update without a change."""


def ratio(scene: str, edit: str) -> float | None:
    """Table 1's speed-up; None where the paper has none."""
    seconds = SECONDS.get(scene)
    return seconds["full"] / seconds[edit] if seconds else None


def lights_ratio(moved: int) -> float:
    """Table 3's."""
    return LIGHTS_FULL_SECONDS / LIGHTS_SECONDS[moved]


def share(edit: str, kind: str) -> float:
    """Table 2's count of `kind` as a share of the full trace's."""
    count, full = getattr(WORK[edit], kind), getattr(WORK["full"], kind)
    return float(count / full)
