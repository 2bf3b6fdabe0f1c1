# SPDX-License-Identifier: Apache-2.0
"""`irt bench paper`: counts of the paper's tables, on which all machines agree, and its JSON."""

import json
from functools import cache
from pathlib import Path

import pytest

from cli_support import failure, irt
from irt_usd.bench.paper import published
from irt_usd.bench.paper.costs import UnitCosts, ceiling, unit_costs
from irt_usd.bench.paper.run import tree_changes
from irt_usd.bench.paper.scenes import (
    EDITS,
    LIGHTS_STAGE,
    MOVED_LIGHTS,
    VARIANTS,
    PaperScene,
    load_lights,
    load_variant,
)
from irt_usd.bench.paper.times import EditTimes, medians, spread
from irt_usd.bench.paper.work import Counts, SceneWork, count_work, mean_level
from shots.paper import make_paper

SHOTS = Path(make_paper.__file__).parent
OBJECT_EDITS = ("move_1", "move_2", "resize", "color")


@cache
def scene(name: str) -> PaperScene:
    if name == "lights":
        return load_lights(SHOTS, make_paper.SIZE)
    return load_variant(name, SHOTS, make_paper.SIZE)


@cache
def work(name: str) -> SceneWork:
    return count_work(scene(name))


def test_frames_are_those_of_the_stages() -> None:
    assert EDITS == {
        "move_1": make_paper.MOVE_ONE,
        "move_2": make_paper.MOVE_SEVEN,
        "resize": make_paper.RESIZE,
        "light": make_paper.MOVE_LIGHT,
        "color": make_paper.RECOLOUR,
    }
    assert {frame: moved for moved, frame in MOVED_LIGHTS.items()} == make_paper.MOVE_LIGHTS


@pytest.mark.parametrize("edit", list(EDITS))
def test_table_2(edit: str) -> None:
    chess = work("chess_shadows")
    for kind in ("nodes_traversed", "shadings"):
        assert chess.share(edit, kind) <= published.share(edit, kind), kind
    most = published.MOST_INTERSECTIONS * published.share(edit, "intersections")
    assert chess.share(edit, "intersections") <= most


@pytest.mark.parametrize("name", [*VARIANTS, "lights"])
def test_waste(name: str) -> None:
    for edit, counts in work(name).edits.items():
        assert counts.waste <= published.MOST_WASTE, edit


@pytest.mark.parametrize("name", list(VARIANTS))
def test_a_colour_costs_no_intersection_and_no_ray(name: str) -> None:
    colour = work(name).edits["color"]
    assert colour.intersections == colour.new_rays == colour.retraced == 0
    assert colour.shadings > 0


@pytest.mark.parametrize("name", [*VARIANTS, "lights"])
def test_a_moved_light_costs_no_new_ray(name: str) -> None:
    edits = work(name).edits
    moved = edits.values() if name == "lights" else [edits["light"]]
    assert [counts.new_rays for counts in moved] == [0] * len(moved)


@pytest.mark.parametrize("name", list(VARIANTS))
def test_uncovered_points_are_answered_from_the_history(name: str) -> None:
    moved = work(name).edits["move_1"]
    assert moved.uncovered > 0
    assert moved.from_history is not None
    assert moved.from_history >= published.LEAST_FROM_HISTORY


@pytest.mark.parametrize("name", list(published.HISTORY))
def test_history_is_smaller_than_the_paper_s(name: str) -> None:
    history = work(name).history
    assert history["all_bytes"] / history["points"] <= published.HISTORY[name].bytes_per_node


@pytest.mark.parametrize("name", ["chess", "spheres"])
def test_what_is_recoloured_takes_few_nodes(name: str) -> None:
    # Recolouring shades the points of what it recolours, no others.
    assert work(name).share("color", "shadings") <= 0.012


@pytest.mark.parametrize(("name", "level"), [("chess", 2.25), ("spheres", 2.5)])
def test_mean_levels_are_near_the_paper_s(name: str, level: float) -> None:
    assert mean_level(scene(name)) == pytest.approx(level, abs=0.05)


@pytest.mark.parametrize("name", ["chess", "spheres"])
def test_trees_are_the_same_without_shadows(name: str) -> None:
    plain, shadowed = work(name), work(f"{name}_shadows")
    assert plain.rays["shadow"] == 0 < shadowed.rays["shadow"]
    assert plain.tree_rays == shadowed.tree_rays
    for edit, changed in tree_changes(plain).items():
        assert plain.edits[edit].new_rays == shadowed.edits[edit].new_rays
        assert changed <= shadowed.edits[edit].changed


def test_json_has_what_is_promised(tmp_path: Path) -> None:
    target = tmp_path / "paper.json"
    result = irt(
        *("bench", "paper", "--size", "96x72", "--repeats", "1"),
        *("--scenes", str(SHOTS), "--json", str(target)),
    )
    assert result.exit_code == 0, result.output
    assert all(f"Table {number}" in result.output for number in range(1, 6))
    written = json.loads(target.read_text())
    assert set(written["scenes"]) == set(VARIANTS)
    for name, entry in written["scenes"].items():
        assert entry["full_seconds"] > 0
        assert entry["history_overhead"] > -1
        for kind in ("time_spread", "history_spread", "update_spread"):
            assert 0 <= entry["cells"][kind] <= 1
        assert entry["history"]["nodes"] >= entry["history"]["points"] > 0
        assert entry["history"]["bytes"] == sum(
            kind["bytes"] for kind in entry["history"]["kinds"].values()
        )
        assert entry["history"]["bytes_per_pixel"] == entry["history"]["bytes"] / (96 * 72)
        assert set(entry["edits"]) == {"full", *EDITS}
        assert entry["edits"]["full"]["ratio"] == entry["edits"]["full"]["ceiling"] == 1
        for edit in OBJECT_EDITS:
            counts = entry["edits"][edit]
            assert counts["seconds"] > 0, (name, edit)
            assert counts["ratio"] > 0
            assert counts["ceiling"] is None or counts["ceiling"] > 0  # None: too short to time
            assert counts["nodes_traversed"] > 0
            assert {"new_rays", "intersections", "shadings", "waste"} <= set(counts)
    assert set(written["lights"]) == {"1", "2", "3"}
    assert all(entry["ratio"] > 0 < entry["ceiling"] for entry in written["lights"].values())


def test_scenes_that_are_not_there(tmp_path: Path) -> None:
    message = failure("bench", "paper", "--scenes", str(tmp_path))
    assert str(tmp_path / "chess.usda") in message
    assert "shots.paper.make_paper" in message
    assert (SHOTS / LIGHTS_STAGE).is_file()


def test_the_paper_s_figures() -> None:
    assert published.ratio("chess_shadows", "move_1") == pytest.approx(17.5, abs=0.05)
    assert published.ratio("spheres", "color") == pytest.approx(75.5, abs=0.05)
    assert published.ratio("spheres_shadows", "color") is None
    assert published.lights_ratio(1) == pytest.approx(3.36, abs=0.005)
    assert published.share("move_1", "nodes_traversed") == pytest.approx(0.091, abs=0.0005)
    per_node = [round(size.bytes_per_node) for size in published.HISTORY.values()]
    assert per_node == [434, 485, 311]  # the first 433.6


def counts(**given: int) -> Counts:
    return Counts(**{**dict.fromkeys(Counts.__dataclass_fields__, 0), **given})


def test_a_ceiling_pays_for_what_changed() -> None:
    costs = UnitCosts(nearest=3.0, occlusion=2.0, shading=5.0, full=580.0)
    edit = counts(changed=10, shadings=4, retraced=30, tested=500)
    assert ceiling(costs, edit, tree_rays=6) == 580 / (6 * 3 + 4 * 2 + 4 * 5)
    assert ceiling(costs, counts(), tree_rays=0) is None
    assert edit.waste == 3
    assert edit.tested_over_changed == 50
    assert counts().waste == 0


def test_unit_costs_add_up_to_the_full_trace() -> None:
    rays = {"primary": 60, "reflected": 30, "refracted": 10, "shadow": 50}
    full = SceneWork(counts(shadings=20), rays, {}, {}, {})
    seconds = {"nearest": 2.0, "occlusion": 1.0, "full": 4.0}
    costs = unit_costs({name: [value] for name, value in seconds.items()}, full)
    assert costs.nearest == pytest.approx(2 / 100)
    assert costs.seconds(100, 50, 20) == pytest.approx(4.0)


def test_spreads() -> None:
    assert spread([3.0, 4.0, 3.5]) == 0.25
    assert spread([0.0, 0.0]) == 0
    assert medians([[1.0, 9.0], [2.0, 8.0], [9.0, 1.0]]) == [2.0, 8.0]


def test_whole_frames_count_files_on_both_sides() -> None:
    times = EditTimes(ours=[1.0], full=[9.0], files=[3.0])
    assert times.ratio.median == 9
    assert times.whole_frame_ratio.median == 3
