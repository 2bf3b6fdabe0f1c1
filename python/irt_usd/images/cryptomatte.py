# SPDX-License-Identifier: Apache-2.0
"""Cryptomatte 1.2.0 (github.com/Psyop/Cryptomatte): ids of names, ranked by coverage.

A pixel's ranks are pairs of id and coverage, by falling coverage, two to a layer of four channels.
An id is MurmurHash3 (x86, 32 bit) of the name, a bit of its exponent flipped where the float of
those bits would be no normal number. The manifest names the ids that the image shows.
"""

import json
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core

Names = Callable[[set[int]], dict[int, str]]


def ranks(plane: NDArray[np.uint32]) -> NDArray[np.float32]:
    """The core's ranks, (height, width, ranks, 2) bits, as (height, width, 2 ranks) float32."""
    height, width, count, _ = plane.shape
    return plane.view(np.float32).reshape(height, width, 2 * count).copy()


def manifest(plane: NDArray[np.uint32], names: Names) -> dict[str, int]:
    """The ids that `plane` shows, by name; `names` gives the names of ids."""
    shown = set(np.unique(plane[..., 0][plane[..., 1] != 0]).tolist())
    return {name: number for number, name in sorted(names(shown).items(), key=lambda n: n[1])}


def metadata(layer: str, names: Mapping[str, int]) -> dict[str, str]:
    """Header entries of a layer whose manifest is `names`."""
    key = f"cryptomatte/{_core.name_hash(layer):08x}"[: len("cryptomatte/") + 7]
    shown = {name: f"{number:08x}" for name, number in names.items()}
    return {
        f"{key}/name": layer,
        f"{key}/hash": "MurmurHash3_32",
        f"{key}/conversion": "uint32_to_float32",
        f"{key}/manifest": json.dumps(shown, separators=(",", ":"), ensure_ascii=False),
    }
