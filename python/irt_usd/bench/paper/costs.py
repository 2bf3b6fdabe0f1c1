# SPDX-License-Identifier: Apache-2.0
"""What rays and shadings cost in this run, and the ceilings that follow.

One thread's passes over the rays of a full trace give seconds a nearest-hit query and seconds an
occlusion query; what the whole trace takes on that thread beyond all its queries is put down to its
shadings, film and spawning included. Threads divide both sides of a ratio alike, so

    ceiling = full trace / (nearest * changed tree rays + occlusion * changed shadow rays
                            + shading * shadings)

with all four of one thread, in its processor seconds, which other work on the machine disturbs
little, and the counts of the edit. It is the ratio if nothing were paid for but the rays that did
change and the shadings that follow from them: finding them, the walk and combining are free, and
threads share the work of an update as well as they share a full trace's. A moved light shades every
point by itself alone, which costs less than the mean shading of a full trace (no spawning, no other
light): there a ratio can lie above its ceiling.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

from irt_usd import _core, interrupt
from irt_usd.bench.paper.work import Counts, SceneWork
from irt_usd.bench.timing import Spread


@dataclass(frozen=True)
class UnitCosts:
    """Processor seconds of one thread: a query or a shading, and the whole of a full trace."""

    nearest: float
    occlusion: float
    shading: float
    full: float

    def seconds(self, nearest: int, occlusion: int, shadings: int) -> float:
        """Of so many."""
        return nearest * self.nearest + occlusion * self.occlusion + shadings * self.shading


def timers(bench: _core.TraceBench) -> dict[str, Callable[[], float]]:
    """What unit costs are made of, and the bare loop, by name; in processor seconds."""
    return {
        "nearest": lambda: _thread_seconds(lambda: bench.time("ours", "nearest")),
        "occlusion": lambda: _thread_seconds(lambda: bench.time("ours", "occlusion")),
        "bare nearest": lambda: _thread_seconds(lambda: bench.time("bare", "nearest")),
        "bare occlusion": lambda: _thread_seconds(lambda: bench.time("bare", "occlusion")),
        "full": lambda: _thread_seconds(lambda: bench.render(1)),
    }


def unit_costs(seconds: dict[str, list[float]], work: SceneWork) -> UnitCosts:
    """From what `timers` measured."""
    median = {name: Spread.of(values).median for name, values in seconds.items()}
    shadow = work.rays["shadow"]
    rest = max(median["full"] - median["nearest"] - median["occlusion"], 0.0)
    return UnitCosts(
        median["nearest"] / work.tree_rays,
        median["occlusion"] / shadow if shadow else 0.0,
        rest / work.full.shadings,
        median["full"],
    )


def ceiling(costs: UnitCosts, edit: Counts, tree_rays: int) -> float | None:
    """Of an edit of whose changed rays `tree_rays` are no shadow rays; None: nothing to pay for."""
    needed = costs.seconds(tree_rays, edit.changed - tree_rays, edit.shadings)
    return costs.full / needed if needed > 0 else None


def _thread_seconds(run: Callable[[], object]) -> float:
    interrupt.check()
    start = time.thread_time()
    run()
    return time.thread_time() - start
