# SPDX-License-Identifier: Apache-2.0
"""Where chess pieces stand, and standing them there. The board's top is y = 0, its middle 0."""

from collections.abc import Callable

from pxr import Gf, Usd, UsdGeom

from shots.kit import pieces
from shots.kit.stage import Vec3

MAKERS: dict[str, Callable[[Usd.Stage, str], None]] = {
    "pawn": pieces.pawn,
    "rook": pieces.rook,
    "knight": pieces.knight,
    "bishop": pieces.bishop,
    "queen": pieces.queen,
    "king": pieces.king,
}


def center(file: int, rank: int) -> Vec3:
    """The middle of a square: files a to h along +x, ranks 1 to 8 along -z, both from 0."""
    return ((file - 3.5) * pieces.SQUARE, 0.0, (3.5 - rank) * pieces.SQUARE)


def square(name: str) -> Vec3:
    """The middle of a square by its name, such as "e4"."""
    return center("abcdefgh".index(name[0]), int(name[1]) - 1)


def place(stage: Usd.Stage, path: str, kind: str, at: Vec3, heading: float = 0.0) -> Usd.Prim:
    """Stand a piece at `at`; every kind is defined once, as a class, and referenced.

    `heading` turns a knight, in degrees about y.
    """
    pattern = f"/_class_{kind}"
    if not stage.GetPrimAtPath(pattern):
        stage.CreateClassPrim(pattern)
        MAKERS[kind](stage, pattern)
    xform = UsdGeom.Xform.Define(stage, path)
    xform.GetPrim().GetReferences().AddInternalReference(pattern)
    xform.AddTranslateOp().Set(Gf.Vec3d(*at))
    if kind == "knight":
        xform.AddRotateYOp().Set(heading)
    return xform.GetPrim()


def move(prim: Usd.Prim, keys: dict[int, Vec3]) -> None:
    """Key a prim's position by frame."""
    attribute = prim.GetAttribute("xformOp:translate")
    for frame, position in keys.items():
        attribute.Set(Gf.Vec3d(*position), frame)
