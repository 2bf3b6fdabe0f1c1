# SPDX-License-Identifier: Apache-2.0
"""A camera for assets that bring none: a session layer that looks at all of them from a corner."""

from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom

CAMERA = "/framing_camera"

_FOCAL_LENGTH, _APERTURE = 35.0, 20.955


def framing_layer(
    stage: Usd.Stage, folder: Path, time: float, towards: Gf.Vec3d | None = None
) -> Path:
    """Writes a session layer for `stage` with a camera that sees its bound at `time`, at 4:3.

    `towards`: from its middle to the camera; by default a corner above and before it.
    """
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render]
    cache = UsdGeom.BBoxCache(time, purposes, useExtentsHint=False)
    box = cache.ComputeWorldBound(stage.GetPseudoRoot()).ComputeAlignedRange()
    if box.IsEmpty():
        box = Gf.Range3d(Gf.Vec3d(-1), Gf.Vec3d(1))
    radius = max(box.GetSize().GetLength() / 2, 1e-3)
    up = UsdGeom.GetStageUpAxis(stage)
    if towards is None:
        towards = Gf.Vec3d(0.5, 0.5, 1) if up == "Y" else Gf.Vec3d(0.5, -1, 0.5)
    distance = 1.2 * radius / np.sin(np.arctan(0.75 * _APERTURE / 2 / _FOCAL_LENGTH))
    eye = box.GetMidpoint() + towards.GetNormalized() * distance
    axis = Gf.Vec3d(0, 1, 0) if up == "Y" else Gf.Vec3d(0, 0, 1)
    world_from_camera = Gf.Matrix4d().SetLookAt(eye, box.GetMidpoint(), axis).GetInverse()
    rows = ", ".join(str(tuple(world_from_camera[row])) for row in range(4))
    path = folder / "framing.usda"
    path.write_text(
        f'#usda 1.0\ndef Camera "{CAMERA[1:]}"\n{{\n'
        f" float focalLength = {_FOCAL_LENGTH}\n"
        f" float horizontalAperture = {_APERTURE}\n"
        f" float verticalAperture = {0.75 * _APERTURE}\n"
        f" matrix4d xformOp:transform = ({rows})\n"
        ' uniform token[] xformOpOrder = ["xformOp:transform"]\n}\n'
    )
    return path
