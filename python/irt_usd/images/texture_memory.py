# SPDX-License-Identifier: Apache-2.0
"""What textures take of memory, and which of their levels are dropped where it is limited."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from irt_usd.stage.graph import TextureReference


@dataclass(frozen=True)
class Pyramid:
    """The mip levels of a texture. Each tile: width, height and bytes of a texel."""

    tiles: tuple[tuple[int, int, int], ...]

    @cached_property
    def levels(self) -> tuple[int, ...]:
        """Bytes of each level, all tiles together, the finest first, the coarsest of 1x1."""
        depth = max(max(width, height).bit_length() for width, height, _ in self.tiles)
        return tuple(
            sum(max(1, w >> level) * max(1, h >> level) * texel for w, h, texel in self.tiles)
            for level in range(depth)
        )

    def bytes_without(self, finest: int) -> int:
        """Bytes that remain without so many of the finest levels."""
        return sum(self.levels[finest:])


def levels_to_drop(
    pyramids: Mapping[TextureReference, Pyramid], limit: int
) -> dict[TextureReference, int]:
    """How many of its finest levels each texture loses, for all to take at most `limit` bytes.

    One level at a time: the largest of those that are then finest, of equal ones that of the first
    file by path and colour space. The coarsest levels stay, whatever they take.
    """
    order = sorted(pyramids, key=lambda r: (r.file, r.color_space))
    dropped = dict.fromkeys(order, 0)
    total = sum(pyramid.bytes_without(0) for pyramid in pyramids.values())
    while total > limit:
        candidates = [r for r in order if dropped[r] + 1 < len(pyramids[r].levels)]
        if not candidates:
            break
        largest = max(candidates, key=lambda r: pyramids[r].levels[dropped[r]])
        total -= pyramids[largest].levels[dropped[largest]]
        dropped[largest] += 1
    return dropped
