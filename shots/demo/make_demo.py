# SPDX-License-Identifier: Apache-2.0
"""Writes shots/demo/chess.usda: python -m shots.demo.make_demo [PATH].

The Fried Liver attack (1.e4 e5 2.Nf3 Nc6 3.Bc4 Nf6 4.Ng5 d5 5.exd5 Nxd5), and now 6.Nxf7: the
white knight jumps, the pawn it takes leaves the board, the bishop behind the attack turns to
glass, the lamp dims, the lamp moves. Between the events nothing at all changes.
"""

import sys
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade

from shots.kit import pieces
from shots.kit.board import center, move, place, square
from shots.kit.mesh import PolygonMesh, border, define_mesh, extrude, grid, join
from shots.kit.motion import glide, ramp
from shots.kit.stage import (
    Vec3,
    bind,
    camera,
    distant_light,
    material,
    new_stage,
    render_settings,
    save,
    set_keys,
    sphere_light,
)

FIRST, LAST = 1001, 1048
KNIGHT_JUMPS = (1005, 1014)
PAWN_LEAVES = (1008, 1016)
BISHOP_TO_GLASS = (1023, 1029)
LAMP_DIMS = (1033, 1037)
LAMP_MOVES = (1041, 1045)

SIZE = (960, 540)
TABLE = -2.2
"""Height of the table; the board's top is at 0."""

WHITE = {
    "rook": "a1 h1",
    "knight": "b1 g5",
    "bishop": "c1 c4",
    "queen": "d1",
    "king": "e1",
    "pawn": "a2 b2 c2 d2 f2 g2 h2",
}
BLACK = {
    "rook": "a8 h8",
    "knight": "c6 d5",
    "bishop": "c8 f8",
    "queen": "d8",
    "king": "e8",
    "pawn": "a7 b7 c7 e5 f7 g7 h7",
}
BESIDE_WHITE = [(24.5, TABLE, 2.0), (26.5, TABLE, 6.0)]
"""Where black pawns stand that White has taken: the first is there, the second is about to be."""
BESIDE_BLACK = (-24.5, TABLE, -4.0)


def build() -> Usd.Stage:
    """Return the shot."""
    stage = new_stage(FIRST, LAST, "Written by shots/demo/make_demo.py; edit that instead.")
    looks = materials(stage)
    setting(stage, looks)
    board(stage, looks)
    army(stage, "white", WHITE, looks, heading=140.0)
    army(stage, "black", BLACK, looks, heading=-80.0)
    taken(stage, looks)
    play(stage, looks)
    lights(stage)
    view = camera(
        stage, "/World/camera", (25, 37, 64), (1.0, 0.5, 0.2), focal_mm=52, aspect=SIZE[0] / SIZE[1]
    )
    render_settings(stage, *SIZE, view)
    return stage


def materials(stage: Usd.Stage) -> dict[str, UsdShade.Material]:
    """Return every material by name; the mirrors are those of roughness at most 0.1."""

    def make(
        name: str, diffuse: Vec3, roughness: float, metallic: float = 0.0
    ) -> UsdShade.Material:
        path = f"/World/materials/{name}"
        return material(stage, path, diffuse, roughness=roughness, metallic=metallic)

    looks = {
        "backdrop": make("backdrop", (0.26, 0.36, 0.42), 0.7),
        "mahogany": make("mahogany", (0.06, 0.024, 0.016), 0.08),
        "brass": make("brass", (0.6, 0.4, 0.15), 0.3),
        "maple": make("maple", (0.56, 0.42, 0.27), 0.1),
        "walnut": make("walnut", (0.1, 0.052, 0.03), 0.1),
        "ivory": make("ivory", (0.76, 0.66, 0.48), 0.22),
        "ebony": make("ebony", (0.022, 0.016, 0.015), 0.07),
        "gold": make("gold", (0.94, 0.68, 0.3), 0.06, metallic=1.0),
        "steel": make("steel", (0.42, 0.44, 0.48), 0.06, metallic=1.0),
    }
    looks["ivory_to_glass"] = material(
        stage,
        "/World/materials/ivory_to_glass",
        (0.76, 0.66, 0.48),
        roughness=0.05,
        opacity=ramp(*BISHOP_TO_GLASS, 1.0, 0.1),
    )
    for name, glow in (
        ("softbox", (2.6, 2.5, 2.3)),
        ("strip", (1.2, 1.5, 1.9)),
        ("front", (0.35, 0.33, 0.3)),
        ("ceiling", (0.5, 0.5, 0.52)),
    ):
        looks[name] = material(stage, f"/World/materials/{name}", (0, 0, 0), emissive=glow)
    return looks


def setting(stage: Usd.Stage, looks: dict[str, UsdShade.Material]) -> None:
    """The sweep behind the board, and the cards of light that the mirrors see."""
    arc = np.linspace(0, np.pi / 3, 17)
    sweep = [(160.0, TABLE), (-90.0, TABLE)]
    sweep += [(-90 - 60 * np.sin(a), TABLE + 60 * (1 - np.cos(a))) for a in arc[1:]]
    prim = define_mesh(stage, "/World/set/backdrop", extrude(np.array(sweep), 260.0))
    bind(prim, looks["backdrop"])
    for name, size, turn, position in (
        ("softbox", (60.0, 40.0), (180.0, 0.0, 60.0), (-85.0, 55.0, 30.0)),
        ("strip", (10.0, 80.0), (-20.0, 0.0, -68.0), (92.0, 42.0, -8.0)),
        ("front", (160.0, 70.0), (-80.0, 0.0, 0.0), (0.0, 60.0, 130.0)),
        ("ceiling", (110.0, 110.0), (180.0, 0.0, 0.0), (20.0, 120.0, 30.0)),
    ):
        card = UsdGeom.Plane.Define(stage, f"/World/set/{name}")
        card.CreateAxisAttr(UsdGeom.Tokens.y)
        card.CreateWidthAttr(size[0])
        card.CreateLengthAttr(size[1])
        card.AddTranslateOp().Set(Gf.Vec3d(*position))
        card.AddRotateXYZOp().Set(Gf.Vec3f(*turn))
        bind(card.GetPrim(), looks[name])


def board(stage: Usd.Stage, looks: dict[str, UsdShade.Material]) -> None:
    """64 squares as two meshes, an inlaid line, and a bevelled border."""
    half, line = 4 * pieces.SQUARE, 0.35
    for parity, wood in ((0, "walnut"), (1, "maple")):
        tiles = [
            tile(file, rank)
            for file in range(8)
            for rank in range(8)
            if (file + rank) % 2 == parity
        ]
        bind(define_mesh(stage, f"/World/board/{wood}", join(tiles)), looks[wood])
    inlay = np.array([(half + line, 0.0), (half, 0.0)])
    bind(define_mesh(stage, "/World/board/inlay", border(inlay)), looks["brass"])
    inner, outer = half + line, half + 3.2
    profile = np.array(
        [
            (outer, TABLE),
            (outer, -0.5),
            (outer - 0.15, -0.15),
            (outer - 0.5, 0.0),
            (inner + 0.25, 0.12),
            (inner, 0.0),
        ]
    )
    bind(define_mesh(stage, "/World/board/border", border(profile)), looks["mahogany"])


def tile(file: int, rank: int) -> PolygonMesh:
    """One square of the board."""
    x, _, z = center(file, rank)
    h = pieces.SQUARE / 2
    rows = [[(x - h, 0.0, z + h), (x + h, 0.0, z + h)], [(x - h, 0.0, z - h), (x + h, 0.0, z - h)]]
    return grid(np.array(rows), None, closed=False)


def army(
    stage: Usd.Stage,
    side: str,
    position: dict[str, str],
    looks: dict[str, UsdShade.Material],
    heading: float,
) -> None:
    """Place one side's pieces; its material is inherited from the army's prim, but for royalty."""
    common, royal = (
        (looks["ivory"], looks["gold"])
        if side == "white"
        else (
            looks["ebony"],
            looks["steel"],
        )
    )
    bind(UsdGeom.Xform.Define(stage, f"/World/{side}").GetPrim(), common)
    for kind, squares in position.items():
        for name in squares.split():
            prim = place(stage, f"/World/{side}/{kind}_{name}", kind, square(name), heading)
            if kind in ("queen", "king"):
                bind(prim, royal)


def taken(stage: Usd.Stage, looks: dict[str, UsdShade.Material]) -> None:
    """Place the pawns that were taken before the shot begins."""
    for name, look, at in (
        ("white_pawn", "ivory", BESIDE_BLACK),
        ("black_pawn", "ebony", BESIDE_WHITE[0]),
    ):
        bind(place(stage, f"/World/taken/{name}", "pawn", at, 0.0), looks[look])


def play(stage: Usd.Stage, looks: dict[str, UsdShade.Material]) -> None:
    """Key the moves, and bind the bishop that turns to glass."""
    knight = stage.GetPrimAtPath("/World/white/knight_g5")
    move(knight, glide(*KNIGHT_JUMPS, square("g5"), square("f7"), hop=7.0))
    pawn = stage.GetPrimAtPath("/World/black/pawn_f7")
    move(pawn, glide(*PAWN_LEAVES, square("f7"), BESIDE_WHITE[1], hop=6.0))
    bind(stage.GetPrimAtPath("/World/white/bishop_c4"), looks["ivory_to_glass"])


def lights(stage: Usd.Stage) -> None:
    """A warm lamp, a cool window from behind, and a fill that casts no shadows."""
    lamp = sphere_light(stage, "/World/lights/lamp", (-16, 38, 22), 3.0, 170.0, 4000)
    set_keys(lamp.GetAttribute("inputs:intensity"), ramp(*LAMP_DIMS, 170.0, 60.0))
    move(lamp, glide(*LAMP_MOVES, (-16, 38, 22), (20, 34, 16)))
    distant_light(stage, "/World/lights/window", (0.55, -0.75, 0.62), 0.75, (0.66, 0.83, 1.0))
    distant_light(
        stage, "/World/lights/fill", (-0.5, -0.6, -0.7), 0.22, (1.0, 0.95, 0.9), shadows=False
    )


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("chess.usda")
    save(build(), Path(target))
