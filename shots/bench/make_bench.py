# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of `irt bench trace`: python -m shots.bench.make_bench FOLDER.

quadrics.usda: the paper's chess position, 144 quadrics. triangles.usdc: 32 turned pieces on bumpy
ground, 1.3 million triangles. pieces.usdc: the same coarsely, 207 thousand. instances.usda: 500
native instances of a pawn and of a bishop.
"""

import sys
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom

from shots.kit import pieces
from shots.kit.mesh import PolygonMesh, define_mesh, grid
from shots.kit.stage import (
    bind,
    camera,
    distant_light,
    material,
    new_stage,
    render_settings,
    save,
    sphere_light,
)
from shots.paper.make_paper import chess

SIZE = (640, 480)


def triangles(segments: int, per_span: int, cells: int) -> Usd.Stage:
    """32 turned pieces, each a mesh of its own, on ground of `cells` by `cells` quads."""
    stage = _lit_stage((26, 30, 44))
    clay = material(stage, "/World/materials/clay", (0.6, 0.5, 0.4), roughness=0.4)
    bind(UsdGeom.Xform.Define(stage, "/World/pieces").GetPrim(), clay)
    piece = pieces.bishop_mesh(segments, per_span)
    for i in range(32):
        prim = define_mesh(stage, f"/World/pieces/piece_{i:02}", piece, decimals=6)
        place = Gf.Vec3d((i % 8 - 3.5) * 5, 0.6, (i // 8 - 1.5) * 8)
        UsdGeom.Xformable(prim).AddTranslateOp().Set(place)
    bind(define_mesh(stage, "/World/ground", bumpy_ground(cells), decimals=6), clay)
    return stage


def bumpy_ground(cells: int) -> PolygonMesh:
    """A sheet of `cells` by `cells` quads, 80 cm wide, with dunes of up to 0.6 cm."""
    x, z = np.meshgrid(np.linspace(-40, 40, cells + 1), np.linspace(40, -40, cells + 1))
    y = 0.3 * np.sin(1.3 * x + 0.7 * np.sin(0.5 * z)) + 0.3 * np.cos(1.1 * z + 0.4 * x)
    return grid(np.stack([x, y, z], axis=-1), None, closed=False)


def instances() -> Usd.Stage:
    """A parade of 25 by 20, pawns of 7 quadrics beside bishops of 6,478 triangles."""
    stage = _lit_stage((60, 60, 90))
    clay = material(stage, "/World/materials/clay", (0.6, 0.5, 0.4), roughness=0.4)
    for kind, make in (("pawn", pieces.pawn), ("bishop", pieces.bishop)):
        prototype = stage.CreateClassPrim(f"/_class_{kind}")
        make(stage, f"/_class_{kind}")
        bind(prototype, clay)
    for i in range(500):
        xform = UsdGeom.Xform.Define(stage, f"/World/parade/piece_{i:03}")
        prim = xform.GetPrim()
        prim.GetReferences().AddInternalReference(f"/_class_{'bishop' if i % 2 else 'pawn'}")
        prim.SetInstanceable(True)
        xform.AddTranslateOp().Set(Gf.Vec3d((i % 25 - 12) * 4.2, 0, (i // 25 - 9.5) * 4.2))
        xform.AddRotateYOp().Set(float(37 * i % 360))
    floor = UsdGeom.Plane.Define(stage, "/World/floor")
    floor.CreateAxisAttr(UsdGeom.Tokens.y)
    floor.CreateWidthAttr(160)
    floor.CreateLengthAttr(160)
    bind(floor.GetPrim(), clay)
    return stage


def _lit_stage(eye: tuple[float, float, float]) -> Usd.Stage:
    """Two shadowing lights and a camera at `eye` that looks at the origin."""
    stage = new_stage(1, 1, "Written by shots/bench/make_bench.py.")
    sphere_light(stage, "/World/lights/lamp", (-30, 60, 30), 3.0, 300.0, 5000)
    distant_light(stage, "/World/lights/window", (0.5, -0.8, 0.4), 1.0, (0.8, 0.9, 1.0))
    view = camera(stage, "/World/camera", eye, (0, 0, 0), focal_mm=40, aspect=SIZE[0] / SIZE[1])
    render_settings(stage, *SIZE, view)
    return stage


def main(folder: Path) -> None:
    """Write every scene into `folder`."""
    save(chess(lights=1), folder / "quadrics.usda")
    save(triangles(160, 5, 380), folder / "triangles.usdc")
    save(triangles(40, 4, 8), folder / "pieces.usdc")
    save(instances(), folder / "instances.usda")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
