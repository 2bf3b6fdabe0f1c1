# SPDX-License-Identifier: Apache-2.0
"""Repeated measurements: taken in turns, reported as a median and the range around it."""

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

Timers = Mapping[str, Callable[[], float]]
"""What is measured, by name; each call measures once and returns seconds."""


@dataclass(frozen=True)
class Spread:
    """Median, lowest and highest of repeated measurements."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Spread":
        """That of `values`, of which there is at least one."""
        return cls(statistics.median(values), min(values), max(values))


@dataclass(frozen=True)
class Figure:
    """A ratio beside what it must reach (floor) and what it should (aim); None: not stated."""

    name: str
    ratio: Spread
    floor: float | None
    aim: float | None

    @property
    def verdict(self) -> str:
        """What the median reaches; empty where nothing was asked."""
        if self.floor is not None and self.ratio.median < self.floor:
            return "floor missed"
        if self.aim is not None:
            return "aim reached" if self.ratio.median >= self.aim else "aim missed"
        return "floor reached" if self.floor is not None else ""

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        return {**asdict(self), "verdict": self.verdict}


def interleave(timers: Timers, repeats: int) -> dict[str, list[float]]:
    """Measures everything `repeats` times, in rounds, each round beginning with another timer.

    What slows the machine for a while thus slows all of a round, and ratios are taken within
    rounds.
    """
    names = list(timers)
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(repeats):
        first = turn % len(names)
        for name in names[first:] + names[:first]:
            seconds[name].append(timers[name]())
    return seconds


def ratios(above: Sequence[float], below: Sequence[float]) -> Spread:
    """Of `above` over `below`, round by round."""
    return Spread.of([a / b for a, b in zip(above, below, strict=True)])


def sums(*series: Sequence[float]) -> list[float]:
    """Of all series, round by round."""
    return [sum(values) for values in zip(*series, strict=True)]
