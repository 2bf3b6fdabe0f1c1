# SPDX-License-Identifier: Apache-2.0
"""AOVs that are made of the core's."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from irt_usd.aovs import LPE, PRIMVARS, aov
from irt_usd.images.cryptomatte import ranks

Plane = NDArray[np.float32] | NDArray[np.uint32]


def derived(
    name: str,
    source: Callable[[str], Plane],
    world_from_camera: NDArray[np.float64],
    exposure: float = 1.0,
) -> Plane:
    """An AOV's plane from the core's; a copy. Not of those that need other frames.

    `exposure`: what parts of the beauty are multiplied by.
    """
    if name.startswith(LPE):
        return exposed(source(name).view(np.float32), exposure).copy()
    wanted = aov(name)
    plane = source(wanted.source)
    if wanted.kind == "cryptomatte":
        return ranks(plane.view(np.uint32))
    if name.startswith(PRIMVARS):
        return (plane[..., : len(wanted.letters)] if wanted.letters else plane[..., 0]).copy()
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
    """`beauty` (height, width, 3 or 4), colours times `scale`: what a camera's exposure does."""
    if scale == 1:
        return beauty
    result: NDArray[np.float32] = beauty.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        result[..., :3] = (beauty[..., :3].astype(np.float64) * scale).astype(np.float32)
    return result
