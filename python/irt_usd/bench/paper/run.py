# SPDX-License-Identifier: Apache-2.0
"""The measurement: scenes, counts, times, unit costs, ceilings."""

from collections.abc import Callable, Mapping
from pathlib import Path

from irt_usd.bench.paper.costs import UnitCosts, timers, unit_costs
from irt_usd.bench.paper.result import EditResult, PaperResult, SceneResult
from irt_usd.bench.paper.scenes import VARIANTS, PaperScene, load_lights, load_variant
from irt_usd.bench.paper.times import time_edits, time_initial, time_initial_cells
from irt_usd.bench.paper.work import SceneWork, count_work, mean_level
from irt_usd.bench.timing import Spread, interleave

Say = Callable[[str], None]


def measure(folder: Path, size: tuple[int, int], repeats: int, say: Say) -> PaperResult:
    """Tables 1 to 5 of the scenes in `folder`. Raises InputError if one is not there."""
    scenes = {name: load_variant(name, folder, size) for name in VARIANTS}
    lights = load_lights(folder, size)
    works, levels, results = {}, {}, {}
    for name, scene in scenes.items():
        say(f"{name}: counting")
        works[name] = count_work(scene)
        if not scene.shadows:
            levels[name] = mean_level(scene)
    for name, scene in scenes.items():
        plain = name.removesuffix("_shadows")  # with the same trees
        changes = tree_changes(works[plain])
        results[name] = _measure_scene(scene, levels[plain], works[name], changes, repeats, say)
    return PaperResult(size, repeats, results, _measure_lights(lights, repeats, say))


def tree_changes(plain: SceneWork) -> dict[str, int]:
    """By edit, the changed rays that are no shadow rays: all that change where no light casts one.

    What a ray sees and spawns depends on no light, so that the trees of a scene are the same with
    shadows and without.
    """
    return {name: counts.changed for name, counts in plain.edits.items()}


def _measure_scene(
    scene: PaperScene,
    level: float,
    work: SceneWork,
    changes: Mapping[str, int],
    repeats: int,
    say: Say,
) -> SceneResult:
    say(f"{scene.name}: initial steps")
    loops, costs = _unit_costs(scene, work, repeats)
    time_initial(scene, 0)  # warms caches and memory
    initial = [time_initial(scene, turn) for turn in range(repeats)]
    cells = [time_initial_cells(scene) for _ in range(repeats)]
    say(f"{scene.name}: edits")
    times = time_edits(scene, repeats)
    return SceneResult(
        scene.name,
        scene.pixels,
        level,
        work,
        times,
        costs,
        SceneResult.of_edits(times, costs, work, changes),
        initial,
        loops,
        cells,
    )


def _measure_lights(scene: PaperScene, repeats: int, say: Say) -> dict[str, EditResult]:
    say(f"{scene.name}: edits")
    work = count_work(scene)
    _, costs = _unit_costs(scene, work, repeats)
    no_tree_ray = dict.fromkeys(scene.edits, 0)
    return SceneResult.of_edits(time_edits(scene, repeats), costs, work, no_tree_ray)


def _unit_costs(
    scene: PaperScene, work: SceneWork, repeats: int
) -> tuple[dict[str, Spread], UnitCosts]:
    what = timers(scene.trace_bench())
    interleave(what, 1)
    seconds = interleave(what, repeats)
    spreads = {name: Spread.of(values) for name, values in seconds.items()}
    return spreads, unit_costs(seconds, work)
