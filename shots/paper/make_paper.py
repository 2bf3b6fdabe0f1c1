# SPDX-License-Identifier: Apache-2.0
"""Writes the paper's scenes beside this file: python -m shots.paper.make_paper [FOLDER].

In the spirit of figures 8 and 9 of "Incremental Ray Tracing" (Murakami, Hirota, Ishii, 1990), with
its numbers of objects and lights. Its edits are the even frames, each undone by the odd frame
after it: of chess.usda and spheres.usda (tables 1 and 2) 2 moves one primitive, 4 moves seven,
6 resizes one, 8 moves the light, 10 recolours; of chess_3_lights.usda (table 3) 2, 4 and 6 move
three lights, two and one.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade

from shots.kit.board import center, place, square
from shots.kit.solids import Turner
from shots.kit.stage import (
    Vec3,
    bind,
    camera,
    material,
    new_stage,
    render_settings,
    save,
    sphere_light,
)

SIZE = (512, 384)
MOVE_ONE, MOVE_SEVEN, RESIZE, MOVE_LIGHT, RECOLOUR = 2, 4, 6, 8, 10
LAST = 11
MOVE_LIGHTS = {2: 3, 4: 2, 6: 1}
"""Frame of table 3, and how many lights it moves."""
LAST_OF_LIGHTS = 7

LAMPS: Sequence[Vec3] = ((-30.0, 55.0, 25.0), (35.0, 45.0, 10.0), (0.0, 60.0, -35.0))
LAMP_STEP = (8.0, 0.0, -6.0)
WHITE = {"king": "e4", "rook": "a7", "pawn": "b6 f4 h5"}
BLACK = {"king": "f8", "rook": "c1", "pawn": "f7 g6"}
EDITED = "b6"
"""The pawn of chess that the edits move, resize and recolour: far back, and mirrored in little."""
GROUP, GROUP_RADIUS = (4.0, -14.0), 0.7
"""X and z of the spheres that the edits take, the seven nearest: far back too, and small."""


def chess(lights: int) -> Usd.Stage:
    """144 quadrics: the board's 64 squares on a slab, 5 pawns of 7, 2 rooks of 12, 2 kings of 10.

    With one light it has the edits of tables 1 and 2, with three those of table 3.
    """
    stage = _new_stage(LAST if lights == 1 else LAST_OF_LIGHTS)
    look = _chess_looks(stage)
    solids = Turner(stage, "/World/board")
    bind(solids.box("slab", (44, 1.5, 44), (0, -1.25, 0)).GetPrim(), look["slate"])
    for file in range(8):
        for rank in range(8):
            x, _, z = center(file, rank)
            tile = solids.box(f"{'abcdefgh'[file]}{rank + 1}", (5, 0.5, 5), (x, -0.25, z))
            bind(tile.GetPrim(), look["dark" if (file + rank) % 2 == 0 else "light"])
    for side, position in (("white", WHITE), ("black", BLACK)):
        bind(UsdGeom.Xform.Define(stage, f"/World/{side}").GetPrim(), look[side])
        for kind, squares in position.items():
            for name in squares.split():
                prim = place(stage, f"/World/{side}/{kind}_{name}", kind, square(name))
                if kind == "king":
                    bind(prim, look["mirror"])
    bind(stage.GetPrimAtPath("/World/white/pawn_h5"), look["glass"])
    pawn = stage.GetPrimAtPath(f"/World/white/pawn_{EDITED}")
    bind(pawn, look["edited"])
    lamps = _lamps(stage, lights, intensity=420.0 / lights)
    if lights == 1:
        head = pawn.GetChild("head")
        _edit_moves(head, (0.0, 4.15, 0.0), MOVE_ONE, (0.9, 0.25, 0.3), LAST)
        _edit_moves(pawn, square(EDITED), MOVE_SEVEN, (0.0, 0.0, -5.0), LAST)
        _edit(head.GetAttribute("radius"), 0.95, RESIZE, 1.2, LAST)
        _edit_moves(lamps[0], LAMPS[0], MOVE_LIGHT, LAMP_STEP, LAST)
        _edit_colour(look["edited"], (0.7, 0.6, 0.42), (0.65, 0.12, 0.08))
    else:
        for number, lamp in enumerate(lamps):
            for frame, moved in MOVE_LIGHTS.items():
                if number < moved:
                    _edit_moves(lamp, LAMPS[number], frame, LAMP_STEP, LAST_OF_LIGHTS)
    _view(stage, (20, 30, 44), (-1.3, 0.4, 0.5))
    return stage


def spheres() -> Usd.Stage:
    """126 quadrics: a mirror floor and 125 spheres in a spiral, seven of them a group; 3 lights."""
    stage = _new_stage(LAST)
    looks = _sphere_looks(stage)
    floor = UsdGeom.Plane.Define(stage, "/World/floor")
    floor.CreateAxisAttr(UsdGeom.Tokens.y)
    floor.CreateWidthAttr(90)
    floor.CreateLengthAttr(90)
    bind(floor.GetPrim(), looks[-1])
    group = UsdGeom.Xform.Define(stage, "/World/group")
    group.AddTranslateOp().Set(Gf.Vec3d(0))
    edited = material(stage, "/World/materials/edited", (0.6, 0.6, 0.62), roughness=0.05)
    bind(group.GetPrim(), edited)
    places = [_on_spiral(i) for i in range(125)]
    grouped = sorted(range(125), key=lambda i: np.hypot(*np.subtract(places[i], GROUP)))[:7]
    for i, (x, z) in enumerate(places):
        parent = "/World/group" if i in grouped else "/World"
        radius = GROUP_RADIUS if i in grouped else 0.9 + 0.9 * (i / 124)
        solid = Turner(stage, parent).sphere(f"sphere_{i:03}", radius, (x, radius, z))
        if i not in grouped:
            bind(solid.GetPrim(), looks[i % 5])
    lamps = _lamps(stage, 3, intensity=170.0)
    x, z = places[grouped[0]]
    ball = stage.GetPrimAtPath(f"/World/group/sphere_{grouped[0]:03}")
    _edit_moves(ball, (x, GROUP_RADIUS, z), MOVE_ONE, (0.5, 1.4, 0.0), LAST)
    _edit_moves(group.GetPrim(), (0, 0, 0), MOVE_SEVEN, (0.0, 2.5, 0.0), LAST)
    _edit(ball.GetAttribute("radius"), GROUP_RADIUS, RESIZE, 1.2 * GROUP_RADIUS, LAST)
    _edit_moves(lamps[0], LAMPS[0], MOVE_LIGHT, LAMP_STEP, LAST)
    _edit_colour(edited, (0.6, 0.6, 0.62), (0.7, 0.3, 0.05))
    _view(stage, (0, 30, 52), (0.0, 0.0, 2.0))
    return stage


def _on_spiral(i: int) -> tuple[float, float]:
    """X and z of sphere i: a sunflower's seeds."""
    angle, distance = i * np.pi * (3 - np.sqrt(5)), 2.75 * np.sqrt(i)
    return round(float(distance * np.sin(angle)), 4), round(float(distance * np.cos(angle)), 4)


def _new_stage(last: int) -> Usd.Stage:
    return new_stage(1, last, "Written by shots/paper/make_paper.py; edit that instead.")


def _chess_looks(stage: Usd.Stage) -> dict[str, UsdShade.Material]:
    def make(name: str, diffuse: Vec3, roughness: float, metallic: float = 0.0) -> None:
        path = f"/World/materials/{name}"
        looks[name] = material(stage, path, diffuse, roughness=roughness, metallic=metallic)

    looks: dict[str, UsdShade.Material] = {}
    make("slate", (0.05, 0.06, 0.07), 0.1)
    make("light", (0.55, 0.5, 0.42), 0.08)
    make("dark", (0.1, 0.06, 0.045), 0.08)
    make("white", (0.7, 0.6, 0.42), 0.3)
    make("black", (0.04, 0.035, 0.04), 0.1)
    make("mirror", (0.85, 0.84, 0.8), 0.02, metallic=1.0)
    make("edited", (0.7, 0.6, 0.42), 0.3)
    looks["glass"] = material(
        stage, "/World/materials/glass", (0.85, 0.95, 0.9), roughness=0.02, opacity=0.36
    )
    return looks


def _sphere_looks(stage: Usd.Stage) -> list[UsdShade.Material]:
    """Five looks of spheres in turn, one of them glass, and the floor's."""
    path = "/World/materials"
    return [
        material(stage, f"{path}/mirror", (0.9, 0.88, 0.85), roughness=0.02, metallic=1.0),
        material(stage, f"{path}/blue", (0.08, 0.2, 0.5), roughness=0.08),
        material(stage, f"{path}/chalk", (0.7, 0.68, 0.62), roughness=0.5),
        material(stage, f"{path}/glass", (0.9, 0.95, 1.0), roughness=0.02, opacity=0.1),
        material(stage, f"{path}/coral", (0.55, 0.16, 0.1), roughness=0.5),
        material(stage, f"{path}/floor", (0.45, 0.47, 0.5), roughness=0.04, metallic=0.6),
    ]


def _lamps(stage: Usd.Stage, count: int, intensity: float) -> list[Usd.Prim]:
    return [
        sphere_light(stage, f"/World/lights/lamp_{i + 1}", position, 3.0, intensity, 6500)
        for i, position in enumerate(LAMPS[:count])
    ]


def _view(stage: Usd.Stage, eye: Vec3, target: Vec3) -> None:
    prim = camera(stage, "/World/camera", eye, target, focal_mm=45, aspect=SIZE[0] / SIZE[1])
    render_settings(stage, *SIZE, prim)


def _edit(attribute: Usd.Attribute, base: object, frame: int, edited: object, last: int) -> None:
    """Key `edited` at its frame and `base` at every other that has no key yet."""
    keyed = set(attribute.GetTimeSamples())
    for other in range(1, last + 1):
        if other not in keyed:
            attribute.Set(base, other)
    attribute.Set(edited, frame)


def _edit_moves(prim: Usd.Prim, base: Vec3, frame: int, step: Vec3, last: int) -> None:
    start = Gf.Vec3d(*base)
    attribute = prim.GetAttribute("xformOp:translate")
    _edit(attribute, start, frame, start + Gf.Vec3d(*step), last)


def _edit_colour(look: UsdShade.Material, base: Vec3, edited: Vec3) -> None:
    surface = UsdShade.Shader(look.GetPrim().GetChild("surface"))
    _edit(surface.GetInput("diffuseColor").GetAttr(), base, RECOLOUR, edited, LAST)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    save(chess(lights=1), folder / "chess.usda")
    save(chess(lights=3), folder / "chess_3_lights.usda")
    save(spheres(), folder / "spheres.usda")
