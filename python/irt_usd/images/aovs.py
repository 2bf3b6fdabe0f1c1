# SPDX-License-Identifier: Apache-2.0
"""AOVs that are made of the core's."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from irt_usd.aovs import AOVS

Plane = NDArray[np.float32] | NDArray[np.uint32]


def derived(
    name: str,
    source: Callable[[str], Plane],
    world_from_camera: NDArray[np.float64],
) -> Plane:
    """An AOV's plane from the core's; a copy. Not of irt.age, which needs the frames before."""
    plane = source(AOVS[name].source)
    if name == "Peye":
        camera_from_world = np.linalg.inv(world_from_camera)
        eye = plane.astype(np.float64) @ camera_from_world[:3, :3] + camera_from_world[3, :3]
        # Where nothing is seen all AOVs are zero.
        seen = np.any(source("normal") != 0, axis=2, keepdims=True)
        visible: NDArray[np.float32] = np.where(seen, eye, 0).astype(np.float32)
        return visible
    if name == "Neye":
        # Normals are unit vectors of the world, and cameras may be scaled.
        rows = world_from_camera[:3, :3]
        turned = plane.astype(np.float64) @ (rows / np.linalg.norm(rows, axis=1)[:, None]).T
        unit: NDArray[np.float32] = turned.astype(np.float32)
        return unit
    return plane.copy()


def exposed(beauty: NDArray[np.float32], scale: float) -> NDArray[np.float32]:
    """`beauty` (height, width, 4) with its colours times `scale`: what a camera's exposure does."""
    if scale == 1:
        return beauty
    result: NDArray[np.float32] = beauty.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        result[..., :3] = (beauty[..., :3].astype(np.float64) * scale).astype(np.float32)
    return result
