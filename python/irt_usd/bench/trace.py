# SPDX-License-Identifier: Apache-2.0
"""Our tracing against the bare loop over the same rays, and two threads against one."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from irt_usd import _core
from irt_usd.bench.scenes import BenchScene
from irt_usd.bench.timing import Figure, Spread, interleave, ratios, sums

Loop = Literal["bare", "ours"]
Query = Literal["nearest", "occlusion"]

INTERSECTION = ("intersection", 0.7, 0.9)
WITH_SHADING = ("with shading and film", 0.5, 0.7)
TWO_THREADS = ("2 threads over 1", 1.9, None)
BY_PROCESSOR_TIME = ("the same by processor time", None, None)
NEAREST = ("nearest alone", None, None)
OCCLUSION = ("occlusion alone", None, None)
"""Name, floor and aim of each figure."""


@dataclass(frozen=True)
class TraceResult:
    """What one scene measured.

    `seconds` of one thread are processor seconds of that thread, unless they say so; those of two
    threads are by the clock. By processor time 2 threads over 1 are at best 2: what is lacking is
    what threads cost each other, not how unevenly they share the work; other work on the machine
    disturbs it little. `hits` are rays that met something, of which the loops must agree; in
    occlusion ours counts opaque blockers alone, where the bare loop stops at anything.
    """

    scene: str
    contents: str
    size: tuple[int, int]
    rays: dict[str, int]
    hits: dict[str, int]
    seconds: dict[str, Spread]
    rays_per_second: dict[str, float]
    figures: tuple[Figure, ...]

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        fields = asdict(self)
        fields["figures"] = [figure.to_json() for figure in self.figures]
        return fields


def measure_scene(
    scene: BenchScene,
    repeats: int,
    isa: str = "avx2",
    on_round: Callable[[str], None] | None = None,
) -> TraceResult:
    """Traces `scene` at one sample a pixel and default depth, `repeats` times in turns."""
    if on_round:
        on_round(f"{scene.name}: building trees, recording rays")
    settings = _core.ViewSettings(*scene.shot.size)
    bench = _core.TraceBench(
        scene.changes, scene.camera, settings, render_origin=scene.shot.render_origin, isa=isa
    )
    rays = bench.rays
    hits: dict[str, int] = {}

    def loop(which: Loop, query: Query) -> Callable[[], float]:
        def once() -> float:
            start = time.thread_time()
            _, hits[f"{which} {query}"] = bench.time(which, query)
            return time.thread_time() - start

        return once

    def render_alone() -> float:
        start = time.thread_time()
        walls.append(bench.render(1))
        return time.thread_time() - start

    def render_two() -> float:
        start = time.process_time()
        seconds = bench.render(2)
        both.append((time.process_time() - start) / 2)
        return seconds

    walls: list[float] = []
    both: list[float] = []
    timers = {
        "bare nearest": loop("bare", "nearest"),
        "ours nearest": loop("ours", "nearest"),
        "bare occlusion": loop("bare", "occlusion"),
        "ours occlusion": loop("ours", "occlusion"),
        "render": render_alone,
        "render, 2 threads": render_two,
    }
    if on_round:
        on_round(f"{scene.name}: timing")
    interleave(timers, 1)  # warms caches and thread pool
    walls.clear()
    both.clear()
    seconds = interleave(timers, repeats)
    bare = sums(seconds["bare nearest"], seconds["bare occlusion"])
    ours = sums(seconds["ours nearest"], seconds["ours occlusion"])
    seconds["render, by the clock"] = walls
    seconds["render, 2 threads, processor time of each"] = both
    figures = (
        figure(INTERSECTION, ratios(bare, ours)),
        figure(WITH_SHADING, ratios(bare, seconds["render"])),
        figure(TWO_THREADS, ratios(walls, seconds["render, 2 threads"])),
        figure(BY_PROCESSOR_TIME, ratios(seconds["render"], both)),
        figure(NEAREST, ratios(seconds["bare nearest"], seconds["ours nearest"])),
        figure(OCCLUSION, ratios(seconds["bare occlusion"], seconds["ours occlusion"])),
    )
    total = sum(rays.values())
    each = {
        "bare loop": bare,
        "intersection": ours,
        "render": seconds["render"],
        "render, 2 threads": seconds["render, 2 threads"],
    }
    return TraceResult(
        scene.name,
        scene.contents,
        scene.shot.size,
        rays,
        hits,
        {name: Spread.of(values) for name, values in seconds.items()},
        {name: total / Spread.of(values).median for name, values in each.items()},
        figures,
    )


def figure(target: tuple[str, float | None, float | None], ratio: Spread) -> Figure:
    """A measured ratio beside its target."""
    name, floor, aim = target
    return Figure(name, ratio, floor, aim)
