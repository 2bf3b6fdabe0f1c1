# SPDX-License-Identifier: Apache-2.0
"""The picture on a dome: its place in the world, and the lights that carry its irradiance.

UsdLux has DomeLight's pole along the dome's own y axis and DomeLight_1's along the one that
`poleAxis` names, and its picture as OpenEXR has lat-long environment maps.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom

from irt_usd.stage.graph import TextureReference, TextureSource
from irt_usd.stage.light_shape import unit
from irt_usd.stage.snapshot import Vector

if TYPE_CHECKING:
    from irt_usd import _core

Axes = tuple[Vector, Vector, Vector]

FORMATS = ("automatic", "latlong")
"""Of `texture:format`, those that are rendered."""


@dataclass(frozen=True)
class Sky:
    """A picture around the scene. Equal ones show the same."""

    reference: TextureReference
    axes: Axes
    """Its x, y (the pole) and z in the world, orthonormal."""
    source: TextureSource

    @property
    def texture(self) -> "_core.Texture":
        """The core's picture."""
        texture = self.source.picture(self.reference)
        assert texture is not None, "a picture that cannot be had makes no sky"
        return texture

    def irradiances(self, directions: list[Vector]) -> list[Vector]:
        """Of the distant lights that stand for it, at unit radiance."""
        return self.source.sky_cells(self.reference).irradiances(self.axes, directions)


def up_axis(stage: Usd.Stage) -> Vector:
    """The direction that is up on the stage."""
    z = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    return (0.0, 0.0, 1.0) if z else (0.0, 1.0, 0.0)


def picture_axes(prim: Usd.Prim, world: NDArray[np.float64]) -> Axes | None:
    """The axes of a dome's picture under its transform, whose sizes do not count.

    (4, 4), row vectors. None: the transform leaves it no orientation.
    """
    x, y, z = np.eye(3)
    if prim.GetTypeName() == "DomeLight_1":
        pole = str(prim.GetAttribute("poleAxis").Get())
        if pole == "Z" or (pole == "scene" and up_axis(prim.GetStage())[2] == 1):
            turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))
            x, y, z = np.rint(np.array(turn))[:3, :3]
    pole_axis = unit(tuple((y @ world[:3, :3]).tolist()))
    if pole_axis is None:
        return None
    rest = z @ world[:3, :3]
    forward = unit(tuple((rest - np.dot(rest, pole_axis) * np.array(pole_axis)).tolist()))
    if forward is None:
        return None
    side = np.cross(pole_axis, forward)
    if np.dot(side, x @ world[:3, :3]) < 0:  # mirrored
        side = -side
    return (float(side[0]), float(side[1]), float(side[2])), pole_axis, forward
