# SPDX-License-Identifier: Apache-2.0
"""What rays and shadings cost in this run, and the ceilings that follow.

Of one thread's passes over the rays of a full trace come seconds a nearest-hit query and seconds an
occlusion query; what the whole trace takes beyond all its queries is put down to its shadings, film
and spawning included. All three are brought to all threads by the whole trace's time there over its
time on one thread. Then

    ceiling = full trace / (nearest * changed tree rays + occlusion * changed shadow rays
                            + shading * shadings)

with the counts of the edit: the ratio if nothing were paid for but the rays that did change and the
shadings that follow from them. Finding them, the walk and combining are free. A moved light shades
every point by itself alone, which costs less than the mean shading of a full trace (no spawning, no
other light): there a ratio can lie above its ceiling.
"""

from collections.abc import Callable
from dataclasses import dataclass

from irt_usd import _core
from irt_usd.bench.paper.work import Counts, SceneWork
from irt_usd.bench.timing import Spread


@dataclass(frozen=True)
class UnitCosts:
    """Seconds on all threads, a query or a shading."""

    nearest: float
    occlusion: float
    shading: float

    def seconds(self, nearest: int, occlusion: int, shadings: int) -> float:
        """Of so many."""
        return nearest * self.nearest + occlusion * self.occlusion + shadings * self.shading


def timers(bench: _core.TraceBench, threads: int) -> dict[str, Callable[[], float]]:
    """What unit costs are made of, and the bare loop, by name."""
    return {
        "nearest": lambda: bench.time("ours", "nearest")[0],
        "occlusion": lambda: bench.time("ours", "occlusion")[0],
        "bare nearest": lambda: bench.time("bare", "nearest")[0],
        "bare occlusion": lambda: bench.time("bare", "occlusion")[0],
        "trace, 1 thread": lambda: bench.render(1),
        "trace": lambda: bench.render(threads),
    }


def unit_costs(seconds: dict[str, list[float]], work: SceneWork) -> UnitCosts:
    """From what `timers` measured."""
    median = {name: Spread.of(values).median for name, values in seconds.items()}
    scale = median["trace"] / median["trace, 1 thread"]
    shadow = work.rays["shadow"]
    nearest = scale * median["nearest"] / work.tree_rays
    occlusion = scale * median["occlusion"] / shadow if shadow else 0.0
    rest = median["trace"] - scale * (median["nearest"] + median["occlusion"])
    return UnitCosts(nearest, occlusion, max(rest, 0.0) / work.full.shadings)


def ceiling(full_seconds: float, costs: UnitCosts, edit: Counts, tree_rays: int) -> float | None:
    """Of an edit of whose changed rays `tree_rays` are no shadow rays; None: nothing to pay for."""
    needed = costs.seconds(tree_rays, edit.changed - tree_rays, edit.shadings)
    return full_seconds / needed if needed > 0 else None
