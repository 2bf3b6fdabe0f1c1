# SPDX-License-Identifier: Apache-2.0
"""A mesh's faces: checked, and freed of holes."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from irt_usd.stage.values import Value, same_bits


class TopologyError(Exception):
    """Why a mesh's attribute cannot be used."""

    def __init__(self, attribute: str, message: str) -> None:
        super().__init__(f"{attribute}: {message}")
        self.attribute = attribute
        self.message = message


class Topology:
    """`counts` and `indices` as int32, holes taken out. Raises TopologyError on broken ones."""

    def __init__(self, counts: Value, indices: Value, holes: Value) -> None:
        self._source = (counts, indices, holes)
        self._all_counts = integers("faceVertexCounts", counts)
        self._all_indices = integers("faceVertexIndices", indices)
        if len(self._all_counts) and self._all_counts.min() < 0:
            raise TopologyError(
                "faceVertexCounts", "a face vertex count is negative; expected 3 or more"
            )
        corners = int(self._all_counts.sum(dtype=np.int64))
        if corners != len(self._all_indices):
            raise TopologyError(
                "faceVertexCounts",
                f"the face vertex counts sum to {corners}, but there are "
                f"{len(self._all_indices)} faceVertexIndices; expected as many",
            )
        self._kept_faces = self.without_holes(holes)
        self.counts = self._all_counts
        self.indices = self._all_indices
        if self._kept_faces is not None:
            self._kept_corners = np.repeat(self._kept_faces, self._all_counts)
            self.counts = np.ascontiguousarray(self._all_counts[self._kept_faces])
            self.indices = np.ascontiguousarray(self._all_indices[self._kept_corners])

    def made_of(self, arrays: Sequence[Value]) -> bool:
        """Whether it was made of the very bits of `arrays`."""
        return all(map(same_bits, self._source, arrays))

    def check(self, point_count: int) -> None:
        """Raises TopologyError unless every index names one of `point_count` points."""
        low, high = int(self._all_indices.min()), int(self._all_indices.max())
        if low < 0 or high >= point_count:
            raise TopologyError(
                "faceVertexIndices",
                f"index {low if low < 0 else high} names none of the {point_count} points;"
                f" expected 0 to {point_count - 1}",
            )

    def degenerate_faces(self, points: NDArray[np.float32]) -> int:
        """How many faces have no area; each point's coordinates are as authored, float32."""
        counts = self.counts.astype(np.int64)
        solid = counts >= 3
        indices = self.indices[np.repeat(solid, counts)]
        counts = counts[solid]
        degenerate = int((~solid).sum())
        if len(counts) == 0:
            return degenerate
        starts = np.cumsum(counts) - counts
        following = np.arange(1, len(indices) + 1)
        following[starts + counts - 1] = starts
        corners = points[indices].astype(np.float64)
        corners -= np.repeat(corners[starts], counts, axis=0)
        x, y, z = corners.T
        u, v, w = corners[following].T
        flat = np.ones(len(counts), dtype=np.bool_)
        for cross in (y * w - z * v, z * u - x * w, x * v - y * u):
            flat &= np.add.reduceat(cross, starts) == 0
        return degenerate + int(flat.sum())

    @property
    def face_count(self) -> int:
        """Of all faces, holes included."""
        return len(self._all_counts)

    def size_fault(self, interpolation: str, size: int, point_count: int) -> str | None:
        """What is wrong with `size` elements of this interpolation, if anything."""
        sizes = {
            "constant": 1,
            "uniform": len(self._all_counts),
            "vertex": point_count,
            "faceVarying": len(self._all_indices),
        }
        if interpolation not in sizes:
            return f"the interpolation is '{interpolation}'"
        if size == sizes[interpolation]:
            return None
        return (
            f"there are {size} elements; expected {sizes[interpolation]}, "
            f"the interpolation being {interpolation}"
        )

    def kept(self, interpolation: str) -> NDArray[np.bool_] | None:
        """Which elements of this interpolation are of no hole; None: all."""
        if self._kept_faces is None or interpolation in ("constant", "vertex"):
            return None
        return self._kept_faces if interpolation == "uniform" else self._kept_corners

    def without_holes(self, holes: Value) -> NDArray[np.bool_] | None:
        """Which faces `holes` leaves; None: all. Raises TopologyError where it names none."""
        if holes is None or (isinstance(holes, np.ndarray) and len(holes) == 0):
            return None
        faces = integers("holeIndices", holes)
        if faces.min() < 0 or faces.max() >= len(self._all_counts):
            message = f"an index names none of the faces; expected 0 to {len(self._all_counts) - 1}"
            raise TopologyError("holeIndices", message)
        kept = np.ones(len(self._all_counts), dtype=np.bool_)
        kept[faces] = False
        return kept


def integers(attribute: str, value: Value) -> NDArray[np.int32]:
    """`value` as int32. Raises TopologyError unless it is an array of integers that fit."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "iu" or value.ndim != 1:
        raise TopologyError(attribute, f"the {attribute} are no array of integers; expected int[]")
    array = np.ascontiguousarray(value, dtype=np.int32)
    if value.dtype != np.int32 and (array != value).any():
        raise TopologyError(attribute, f"the {attribute} hold numbers beyond 32 bits")
    return array
