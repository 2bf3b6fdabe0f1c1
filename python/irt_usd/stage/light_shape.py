# SPDX-License-Identifier: Apache-2.0
"""The sizes of UsdLux's lights, as factors of what a delta light in their place sends, and ways."""

from math import cbrt, hypot, pi, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf

from irt_usd.stage.snapshot import Vector
from irt_usd.stage.values import Value

SIZES: dict[str, tuple[str, ...]] = {
    "DistantLight": ("inputs:angle",),
    "SphereLight": ("inputs:radius",),
    "RectLight": ("inputs:width", "inputs:height"),
    "DiskLight": ("inputs:radius",),
    "CylinderLight": ("inputs:radius", "inputs:length"),
    "DomeLight": (),
    "DomeLight_1": (),
    "Mesh": (),
}


def distant_factor(values: dict[str, Value]) -> float:
    """Irradiance over luminance."""
    angle = min(float(values["inputs:angle"]), 360.0)  # type: ignore[arg-type]
    if angle == 0:
        return 1.0
    half = radians(angle) / 2
    if not values["inputs:normalize"]:
        return pi * sin(half) ** 2 if angle < 180 else pi
    return 1.0 if angle <= 180 else 1 / (2 - sin(half) ** 2)


def area_factor(kind: str, values: dict[str, Value], world: Gf.Matrix4d) -> float:
    """The greatest radiant intensity over luminance."""
    normalized = bool(values["inputs:normalize"])
    x, y, z = (world.GetRow3(row) for row in range(3))
    # Seven digits: what a rotation leaves of the last bits is no change of size.
    across = _rounded(Gf.Cross(x, y).GetLength())
    if kind == "RectLight":
        width, height = float(values["inputs:width"]), float(values["inputs:height"])  # type: ignore[arg-type]
        return 1.0 if normalized else width * height * across
    radius = float(values["inputs:radius"])  # type: ignore[arg-type]
    if kind == "DiskLight":
        return 1.0 if normalized else pi * radius**2 * across
    if kind == "CylinderLight":
        if normalized:
            return 1 / pi
        length = float(values["inputs:length"])  # type: ignore[arg-type]
        thick = (y.GetLength() * z.GetLength()) ** 0.5
        return 2 * radius * length * _rounded(x.GetLength() * thick)
    if normalized:
        return 0.25
    return pi * (radius * _rounded(cbrt(abs(world.GetDeterminant3())))) ** 2


def _rounded(scale: float) -> float:
    return float(f"{scale:.7g}")


def directions(kind: str, world: NDArray[np.float64], axis: Vector) -> dict[str, Any]:
    """Profile, axis and side of a point light that stands for a light of `kind`."""
    x, y = world[0, :3], world[1, :3]
    normal = np.cross(x, y)
    if kind in ("RectLight", "DiskLight"):
        facing = unit(tuple(normal if np.dot(normal, axis) > 0 else -normal))
        axis = facing or axis
    along = unit(tuple(x)) if kind == "CylinderLight" else None
    if along is None:
        crosswise = x - np.dot(x, axis) * np.asarray(axis)
        along = unit(tuple(crosswise)) or unit(tuple(np.cross(axis, (0.0, 1.0, 0.0))))
    profile = {"RectLight": "facing", "DiskLight": "facing", "CylinderLight": "round"}
    return {
        "profile": profile.get(kind, "uniform"),
        "axis": axis,
        "side": along or (1.0, 0.0, 0.0),
    }


def unit(v: Vector) -> Vector | None:
    """`v` at unit length; None if it has none."""
    largest = max(map(abs, v))
    if largest == 0:
        return None
    x, y, z = (float(c / largest) for c in v)
    length = hypot(x, y, z)
    return (x / length, y / length, z / length)
