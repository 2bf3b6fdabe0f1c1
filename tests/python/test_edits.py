# SPDX-License-Identifier: Apache-2.0
"""Every kind of edit by itself: exact, incremental, and at the cost that its kind may have."""

from typing import Any

import pytest

import edits
import scenes
from scenes import Edit

ROOM = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1.0, 0.25, -4.5, 1))

GEOMETRY: dict[str, list[Edit]] = {
    "move": [("move", "/a", ROOM)],
    "move a little": [("shift", "/b", (0.01, 0.0, 0.0))],
    "rotate": [("transform", "/b", edits.TURNS[0])],
    "rotate an instance": [("transform", "/e", edits.TURNS[2])],
    "spin a sphere": [("transform", "/a", edits.TURNS[0])],
    "scale": [("transform", "/c", edits.diagonal((2.0, 2.0, 2.0)))],
    "scale one way": [("transform", "/a", edits.diagonal((1.0, 2.0, 0.5)))],
    "mirror": [("transform", "/e", edits.diagonal((-1.0, 1.0, 1.0)))],
    "radius": [("resize", "/a", (1.5,))],
    "radius of an instance's part": [("resize", "/e", (1.5,))],
    "height": [("object", "/f", ("cone", 0.5, 2.0), ROOM, "/red"), ("resize", "/f", (1.0, 0.7))],
    "size": [("resize", "/c", (0.5,))],
    "add": [("object", "/f", ("cylinder", 0.5, 1.0), ROOM, "/glass")],
    "delete": [("remove", "/a")],
    "hide": [("hide", "/floor")],
    "deform": [("deform", "/b", 3, (0.3, 0.0, 0.5))],
    "leave the first frame's bounds": [("shift", "/a", (0.0, 12.0, -9.0))],
    "hidden from the camera": [("role", "/a", (False, False))],
    "an instance hidden from the camera": [("role", "/e", (False, False))],
    "hidden from the camera, with a cut-out before it": [
        ("role", "/b", (False, False)),
        ("bind", "/d", "/leaf"),
        ("role", "/e", (True, True)),
    ],
    "an instance held out": [("role", "/e", (True, True))],
    "coincide": [("copy", "/b", "/c", "/glass"), ("copy", "/f", "/a", "/mirror")],
}
SHADING: dict[str, list[Edit]] = {
    "colour": [("look", "/red", {"diffuse_color": (0.1, 0.8, 0.1)})],
    "emission": [("look", "/red", {"emissive_color": (0.5, 0.25, 0.0)})],
    "emission ends": [("look", "/lamp", {"emissive_color": (0, 0, 0)})],
    "specular": [("look", "/red", {"use_specular_workflow": True, "specular_color": (1, 0, 0)})],
    "rough metal": [("look", "/red", {"metallic": 1.0})],
    "roughness": [("look", "/red", {"roughness": 0.9})],
    "rebind": [("bind", "/floor", "/lamp")],
}
MATTE: dict[str, list[Edit]] = {
    "held out": [("role", "/floor", (True, True))],
    "glass held out": [("role", "/d", (True, True))],
    "a cut-out held out": [("role", "/leaves", (True, True))],
}
RAYS: dict[str, list[Edit]] = {
    "metalness": [("look", "/mirror", {"metallic": 0.0})],
    "reflectance": [("look", "/red", {"metallic": 1.0, "roughness": 0.0})],
    "opacity below 1": [("look", "/red", {"opacity": 0.5, "roughness": 0.0})],
    "opacity to 1": [("look", "/glass", {"opacity": 1.0})],
    "cut out": [("look", "/glass", {"opacity_threshold": 0.5})],
    "cut out no more": [("look", "/leaf", {"opacity_threshold": 0.0})],
    "tint": [("look", "/glass", {"diffuse_color": (1.0, 0.2, 0.2)})],
    "tint of what is refracted": [("look", "/glass", {"transmission_color": (0.25, 1.0, 0.0)})],
    "index of refraction": [("look", "/glass", {"ior": 1.33})],
    "rebind to glass": [("bind", "/c", "/glass")],
    "rebind from glass": [("bind", "/d", "/red")],
}
LIGHTS: dict[str, list[Edit]] = {
    "light moved": [("aim", "/fill", (-1.0, 2.0, -4.0))],
    "light turned": [("aim", "/key", (-0.5, -1.0, 0.0))],
    "light added": [("light", "/late", ("distant", (0.0, -1.0, -1.0), (1, 1, 1), True))],
    "light before all others": [("light", "/early", ("point", (0, 2, -4), (4, 4, 4), False))],
    "light removed": [("dark", "/key")],
    "shadows off": [("light", "/key", ("distant", (0.3, -1.0, -0.2), (1, 1, 0.9), False))],
}
ENERGY: dict[str, list[Edit]] = {
    "light's energy": [("shine", "/key", (0.5, 0.5, 0.45))],
    "light's colour": [("shine", "/fill", (8.0, 1.0, 2.0))],
    "both lights' energies": [("shine", "/key", (0.3, 0.2, 0.1)), ("shine", "/fill", (1, 2, 3))],
}
MIXTURES: dict[str, list[Edit]] = {
    "all at once": [
        *GEOMETRY["move"], *GEOMETRY["deform"], *GEOMETRY["hide"], *SHADING["colour"],
        *RAYS["index of refraction"], *RAYS["rebind from glass"], *LIGHTS["light moved"],
        *ENERGY["light's energy"],
    ],
    "move and repaint": [*GEOMETRY["move"], *RAYS["reflectance"]],
    "replace the light": [*LIGHTS["light added"], *LIGHTS["light removed"]],
    "the mover's tint changes": [*RAYS["tint"], ("shift", "/d", (0.5, 0.0, 0.0))],
}  # fmt: skip
ALL = GEOMETRY | SHADING | MATTE | RAYS | LIGHTS | ENERGY | MIXTURES


def done(frame: list[Edit]) -> dict[str, Any]:
    """The update's statistics, after edit, undoing and edit again have been exact."""
    shot = edits.Shot("crowd", [frame, [("undo", 1)], frame, [], [("undo", 4)]], samples=4)
    return edits.play(shot)[1]


@pytest.mark.parametrize("name", ALL)
def test_edit_and_its_undoing_are_exact_and_incremental(name: str) -> None:
    update = done(ALL[name])
    summed_anew = name in ENERGY or name == "light removed"
    assert (update["changed_rays"] + update["shadings"] > 0) != summed_anew


@pytest.mark.parametrize("name", SHADING)
def test_what_only_shading_reads_costs_no_ray(name: str) -> None:
    update = done(SHADING[name])
    assert update["shadings"] > 0
    assert update["intersections"] == update["new_rays"] == update["retraced_rays"] == 0
    assert sum(update["rays"].values()) == 0


@pytest.mark.parametrize("name", ENERGY)
def test_energy_of_a_light_costs_neither_ray_nor_shading(name: str) -> None:
    update = done(ENERGY[name])
    assert sum(update["rays"].values()) == update["intersections"] == update["shadings"] == 0
    assert update["flagged_rays"] == update["nodes_traversed"] == 0


@pytest.mark.parametrize("name", LIGHTS)
def test_lights_spawn_no_ray(name: str) -> None:
    update = done(LIGHTS[name])
    assert update["new_rays"] == 0
    assert update["rays"]["primary"] == update["rays"]["reflected"] == 0


def test_hidden_objects_come_back() -> None:
    hide = [("hide", name) for name in ("/a", "/b", "/floor")]
    show = [("show", name) for name in ("/floor", "/b", "/a")]
    edits.play(edits.Shot("crowd", [hide, show, hide[:1], hide[1:], show[:1], show[1:]]))


def test_what_comes_back_under_its_name_may_be_something_else() -> None:
    frames: list[list[Edit]] = [
        [("remove", "/b")],
        [("object", "/b", ("sphere", 1.0), scenes.floor(1.0), "/mirror")],
        [("remove", "/b"), ("object", "/f", ("box", True, scenes.BOX), scenes.floor(1.0), "/red")],
        [("object", "/b", ("plane", 3.0, 3.0), scenes.floor(1.5), "/glass"), ("remove", "/f")],
    ]
    edits.play(edits.Shot("crowd", frames))


def test_an_array_may_begin_without_entries() -> None:
    frames: list[list[Edit]] = [
        [("object", "/f", ("array", (), 1.0), scenes.floor(1.0), "")],
        [("entry", "/f", 3, (1, (0.5, 0.0, 0.0), 0.5))],
        [("entry", "/f", 3, None)],
    ]
    edits.play(edits.Shot("crowd", frames))


def test_an_arrays_role_is_foreseen() -> None:
    frames: list[list[Edit]] = [[("role", "/swarm", (False, False))], [("undo", 1)]]
    edits.play(edits.Shot("swarm", frames, foreseen=True))


def test_shots_print_so_that_they_can_be_played_again() -> None:
    for seed in range(50):
        shot = edits.seeded_shot(seed)
        assert eval(repr(shot), {"Shot": edits.Shot}) == shot
