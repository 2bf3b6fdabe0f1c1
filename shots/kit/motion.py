# SPDX-License-Identifier: Apache-2.0
"""Keys by frame. Outside its keys a value is held, so the rest of a shot is still to the bit."""

import numpy as np

from shots.kit.stage import Keys, Vec3


def ease(first: int, last: int) -> dict[int, float]:
    """From 0 at frame `first` to 1 at `last`, starting and stopping gently; a key every frame."""
    parameter = np.linspace(0, 1, last - first + 1)
    return {first + i: float(3 * u**2 - 2 * u**3) for i, u in enumerate(parameter)}


def ramp(first: int, last: int, start: float, end: float) -> Keys:
    """Eased numbers from `start` to `end`."""
    return {frame: round(start + (end - start) * u, 6) for frame, u in ease(first, last).items()}


def glide(first: int, last: int, start: Vec3, end: Vec3, hop: float = 0.0) -> dict[int, Vec3]:
    """Eased positions from `start` to `end`, on an arc that rises by `hop` in the middle."""

    def at(u: float) -> Vec3:
        x, y, z = (round(a + (b - a) * u, 6) for a, b in zip(start, end, strict=True))
        return (x, round(y + 4 * hop * u * (1 - u), 6), z)

    return {frame: at(u) for frame, u in ease(first, last).items()}
