# SPDX-License-Identifier: Apache-2.0
"""Writes shots/open_chess/open_chess.usda: python -m shots.open_chess.make_open_chess [PATH].

The Open Chess Set (ASWF USD working group, CC BY 4.0), found on the asset search path, after
1.d4 e6 2.Nf3 Bb4+ 3.c3: now 4.cxb4. The pawn, an instance of the white pawns' PointInstancer,
takes; the bishop leaves the board; the key light warms; the board's varnish turns from glossy to
satin. Between the events nothing at all changes.
"""

import sys
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

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

FIRST, LAST = 1001, 1096
PAWN_TAKES = (1009, 1020)
BISHOP_LEAVES = (1013, 1032)
KEY_WARMS = (1045, 1060)
VARNISH_DULLS = (1075, 1086)

SIZE = (960, 540)
ASSET = "OpenChessSet/chess_set.usda"
SET = "/World/ChessSet"
SQUARE = 0.0625
"""Side of a square, in metres."""
CAPTURING_PAWN = 6
"""The instance of the white pawns on c3."""


def build() -> Usd.Stage:
    """Return the shot; it composes only where the asset search path has the set."""
    stage = new_stage(FIRST, LAST, "Written by shots/open_chess/make_open_chess.py; edit that.")
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.meters)
    chess = stage.DefinePrim(SET)
    chess.GetReferences().AddReference(ASSET)
    opening(stage)
    play(stage)
    varnish(stage)
    setting(stage)
    lights(stage)
    view = camera(
        stage, "/World/camera", (-0.42, 0.42, -0.74), (0.0, 0.015, -0.015), 41, SIZE[0] / SIZE[1]
    )
    view.GetAttribute("clippingRange").Set(Gf.Vec2f(0.01, 100))
    render_settings(stage, *SIZE, view)
    return stage


def opening(stage: Usd.Stage) -> None:
    """Bring the white knight to f3, which the set leaves at home."""
    # The knight's transform is a matrix of its own; two squares up the board and one inwards.
    outer = UsdGeom.Xformable(stage.OverridePrim(f"{SET}/White/KnightL"))
    step = outer.AddTranslateOp(opSuffix="move")
    step.Set(Gf.Vec3d(SQUARE, 0, 2 * SQUARE))
    outer.GetXformOpOrderAttr().Set(["xformOp:translate:move", "xformOp:transform"])


def play(stage: Usd.Stage) -> None:
    """Key the capture: the pawn's entry in its instancer, and the bishop that goes."""
    pawns = UsdGeom.PointInstancer(stage.OverridePrim(f"{SET}/White/Pawns"))
    home: list[Vec3] = [
        (-0.21875, 0, 0.031875),
        (-0.15625, 0, 0.031875),
        (-0.09375, 0, 0.031875),
        (-0.03125, 0, 0.031875),
        (0.15625, 0, 0.031875),
        (0.21875, 0, 0.031875),
        (0.09375, 0, 0.094375),
        (0.03125, 0, 0.156875),
    ]
    x, y, z = home[CAPTURING_PAWN]
    positions = stage.GetPrimAtPath(pawns.GetPath()).CreateAttribute(
        "positions", Sdf.ValueTypeNames.Point3fArray, custom=False
    )
    for frame, at in glide(*PAWN_TAKES, (x, y, z), (x + SQUARE, y, z + SQUARE), hop=0.09).items():
        moved = [*home[:CAPTURING_PAWN], at, *home[CAPTURING_PAWN + 1 :]]
        positions.Set(Vt.Vec3fArray([Gf.Vec3f(*p) for p in moved]), frame)

    bishop = UsdGeom.Xformable(stage.OverridePrim(f"{SET}/Black/BishopL"))
    step = bishop.AddTranslateOp(opSuffix="move")
    bishop.GetXformOpOrderAttr().Set(["xformOp:translate:move", "xformOp:translate"])
    on_b4 = (4 * SQUARE, 0.0, -4 * SQUARE)
    beside = (0.53, -0.0145, -0.27)
    for frame, offset in glide(*BISHOP_LEAVES, on_b4, beside, hop=0.1).items():
        step.Set(Gf.Vec3d(*offset), frame)


def varnish(stage: Usd.Stage) -> None:
    """A coat over the board's textures, whose roughness grows."""
    look = UsdShade.Material(stage.OverridePrim(f"{SET}/Chessboard/Materials/M_Chessboard"))
    look.CreateInput("coat", Sdf.ValueTypeNames.Float).Set(0.7)
    roughness = look.CreateInput("coat_roughness", Sdf.ValueTypeNames.Float)
    set_keys(roughness.GetAttr(), ramp(*VARNISH_DULLS, 0.12, 0.45))


def setting(stage: Usd.Stage) -> None:
    """What the board stands on, and cards of light that gold and glass mirror."""
    top = UsdGeom.Plane.Define(stage, "/World/table")
    top.CreateAxisAttr(UsdGeom.Tokens.y)
    top.CreateWidthAttr(6.0)
    top.CreateLengthAttr(6.0)
    bind(
        top.GetPrim(), material(stage, "/World/materials/cloth", (0.12, 0.1, 0.085), roughness=0.8)
    )


def lights(stage: Usd.Stage) -> None:
    """The key, which warms; a cool window from behind; a fill that casts no shadows."""
    key = sphere_light(stage, "/World/lights/key", (-0.9, 1.3, -0.7), 0.1, 260.0, 6500)
    set_keys(key.GetAttribute("inputs:colorTemperature"), ramp(*KEY_WARMS, 6500.0, 3200.0))
    distant_light(stage, "/World/lights/window", (0.6, -0.7, -0.75), 1.7, (0.75, 0.87, 1.0))
    distant_light(
        stage, "/World/lights/fill", (0.3, -0.5, 0.8), 0.7, (1.0, 0.96, 0.92), shadows=False
    )


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("open_chess.usda")
    save(build(), Path(target))
