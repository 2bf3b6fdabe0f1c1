# SPDX-License-Identifier: Apache-2.0
"""The textures of shots/features, as arrays: (height, width, channels) uint8, row 0 at the top."""

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
SIDE = 64


def _grid() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coordinates s and t of texel centres; t runs upwards."""
    at = (np.arange(SIDE) + 0.5) / SIDE
    s, t = np.meshgrid(at, at[::-1])
    return s, t


def _bytes(*channels: NDArray[np.float64]) -> Image:
    return np.round(255 * np.clip(np.stack(channels, axis=-1), 0, 1)).astype(np.uint8)


def checks(dark: tuple[float, float, float], light: tuple[float, float, float]) -> Image:
    """A checkerboard of 4x4 with a mark in its lower left, so that a turn shows."""
    s, t = _grid()
    even = (np.floor(4 * s) + np.floor(4 * t)) % 2 == 0
    mark = (s < 0.25) & (t < 0.25)
    return _bytes(
        *(
            np.where(mark, m, np.where(even, d, b))
            for m, d, b in zip((0.9, 0.1, 0.1), dark, light, strict=True)
        )
    )


def bumps() -> Image:
    """A normal map: 3x3 round bumps. Texels are (n + 1) / 2."""
    s, t = _grid()
    x, y = (3 * s) % 1 - 0.5, (3 * t) % 1 - 0.5
    inside = np.hypot(x, y) < 0.4
    nx, ny = np.where(inside, x * 1.8, 0), np.where(inside, y * 1.8, 0)
    nz = np.sqrt(np.clip(1 - nx**2 - ny**2, 0, 1))
    return _bytes(nx / 2 + 0.5, ny / 2 + 0.5, nz / 2 + 0.5)


def leaf() -> Image:
    """A green leaf, black around it, with its outline in the alpha channel."""
    s, t = _grid()
    alpha = (np.abs(s - 0.5) < 0.4 * np.sin(np.pi * t)).astype(float)
    vein = np.abs(s - 0.5) < 0.03
    color = np.where(vein, 0.5, 0.15), np.where(vein, 0.6, 0.4), 0.1 + 0 * s
    return _bytes(*(channel * alpha for channel in color), alpha)


def stripes() -> Image:
    """One channel: rough and smooth stripes."""
    _, t = _grid()
    return _bytes(np.where((8 * t) % 2 < 1, 0.15, 0.6))


TEXTURES: dict[str, Image] = {
    "checks.png": checks((0.1, 0.15, 0.3), (0.8, 0.75, 0.6)),
    "checks_warm.png": checks((0.3, 0.1, 0.05), (0.9, 0.7, 0.3)),
    "bumps.png": bumps(),
    "leaf.png": leaf(),
    "stripes.png": stripes(),
    "tiles.1001.png": checks((0.1, 0.3, 0.15), (0.7, 0.8, 0.7)),
    "tiles.1002.png": checks((0.3, 0.1, 0.3), (0.8, 0.6, 0.8)),
}
"""By file name, below shots/features/textures."""
