# SPDX-License-Identifier: Apache-2.0
"""What UsdGeomPoints and UsdGeomBasisCurves share: points, widths, skinning, primvars."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.mesh import vectors
from irt_usd.stage.primvars import Primvars
from irt_usd.stage.skel import Deformation
from irt_usd.stage.snapshot import Shape
from irt_usd.stage.topology import TopologyError, integers
from irt_usd.stage.transforms import Node
from irt_usd.stage.values import Value

_NAMES = ("points", "widths", "primvars:widths", "primvars:widths:indices")

_WIDTH_UNAUTHORED = 1.0
"""In object units, as usdview draws what has no widths."""


@dataclass(frozen=True)
class Widths:
    """Diameters, float32, and their interpolation as authored ("varying" stays)."""

    values: NDArray[np.float32]
    interpolation: str


class PointBasedSource(ABC):
    """Reads one prim, and of its primvars those that are `wanted` (without "primvars:")."""

    kind: str
    """What it is called in messages."""

    def __init__(
        self,
        node: Node,
        report: Report,
        wanted: frozenset[str],
        skin: Deformation | None,
        names: tuple[str, ...] = (),
    ) -> None:
        self._report = report
        self._skin = skin
        self._skin_version = 0
        self._prim = node.prim
        self._path = node.path
        self._attributes = Attributes(node.prim, (*_NAMES, *names), report, node.in_clips)
        self._primvars = Primvars(node.prim, wanted, report)
        self._shape: Shape | None = None
        self._first = True

    @property
    def varies(self) -> bool:
        """Whether the shape can differ between frames."""
        skinned = self._skin is not None and self._skin.varies and not self._skin.rigid
        return self._attributes.vary or self._primvars.vary or skinned

    def read(self, time: Usd.TimeCode) -> Shape | None:
        """The shape at `time` (the same object while nothing changes); None: nothing to draw."""
        changed = self._attributes.update(time)
        if self._skin is not None:
            self._skin.update(time)
            changed |= not self._skin.rigid and self._skin.version != self._skin_version
            self._skin_version = self._skin.version
        if self._primvars.update(time) or changed or self._first:
            self._first = False
            self._shape = self._build(time)
        return self._shape

    @abstractmethod
    def _shape_of(self, points: NDArray[np.float32], time: Usd.TimeCode) -> Shape | None:
        """The shape; raises TopologyError on what cannot be drawn."""

    def _build(self, time: Usd.TimeCode) -> Shape | None:
        values = self._attributes.values
        if empty(values["points"]):
            self._report.mentioned(f"empty {self.kind}", self._path)
            return None
        try:
            points = vectors("points", values["points"])
            if self._skin is not None:
                points = self._skin.points(points)
            return self._shape_of(points, time)
        except TopologyError as fault:
            self._report.skipped(fault.message, where(self._prim, fault.attribute, time))
            return None

    def _read_widths(self, counts: Mapping[str, int], time: Usd.TimeCode) -> Widths | None:
        """The diameters, of which `counts` tells how many each interpolation takes.

        None if none is above 0. Raises TopologyError.
        """
        values = self._attributes.values
        name = "widths" if empty(values["primvars:widths"]) else "primvars:widths"
        if empty(values[name]):
            self._report.mentioned(f"{self.kind} without widths (1 unit wide)", self._path)
            return Widths(np.array([_WIDTH_UNAUTHORED], np.float32), "constant")
        authored = values[name]
        if not isinstance(authored, np.ndarray) or authored.dtype.kind != "f" or authored.ndim > 1:
            raise TopologyError(name, "the widths are no array of numbers")
        with np.errstate(over="ignore"):
            widths = np.ascontiguousarray(authored, dtype=np.float32)
        indices = values["primvars:widths:indices"]
        if name == "primvars:widths" and indices is not None:
            into = integers("primvars:widths:indices", indices)
            if len(into) and (into.min() < 0 or into.max() >= len(widths)):
                message = f"an index is outside the {len(widths)} widths"
                raise TopologyError("primvars:widths:indices", message)
            widths = widths[into]
        wrong = ~(np.isfinite(widths) & (widths >= 0))
        if wrong.any():
            at = int(np.flatnonzero(wrong)[0])
            message = f"width {at} is {widths[at]:.9g}; expected finite numbers from 0"
            raise TopologyError(name, message)
        interpolation = self._widths_interpolation(name)
        if interpolation not in counts:
            message = f"their interpolation is {interpolation}; expected one of {', '.join(counts)}"
            raise TopologyError(name, message)
        if len(widths) != counts[interpolation]:
            if len(widths) != 1:
                raise TopologyError(
                    name,
                    f"there are {len(widths)} widths, but {counts[interpolation]} "
                    f"are expected of interpolation {interpolation}",
                )
            interpolation = "constant"
        if not widths.any():
            self._report.mentioned("of no width, so not there", where(self._prim, name, time))
            return None
        return Widths(widths, interpolation)

    def _widths_interpolation(self, name: str) -> str:
        attribute = self._prim.GetAttribute(name)
        if name == "widths":
            return str(attribute.GetMetadata("interpolation") or "vertex")
        return str(UsdGeom.Primvar(attribute).GetInterpolation())


def extent(points: NDArray[np.float32], widths: Widths) -> float:
    """The largest absolute coordinate that is reached."""
    return float(np.abs(points).max()) + float(widths.values.max()) / 2


def empty(value: Value) -> bool:
    """Whether there is nothing: no value, or an array of no elements."""
    return value is None or (isinstance(value, np.ndarray) and len(value) == 0)
