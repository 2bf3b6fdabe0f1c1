# SPDX-License-Identifier: Apache-2.0
"""UsdGeomPoints: a ball at each point."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from irt_usd.stage.point_based import PointBasedSource, Widths, extent
from irt_usd.stage.primvars import PrimvarValue, primvar_attributes
from irt_usd.stage.snapshot import Shape

if TYPE_CHECKING:
    from irt_usd import _core


class PointsShape(Shape):
    """Balls. Attributes: points (n, 3) float32, widths (n,) or (1,) float32, diameters."""

    def __init__(
        self,
        points: NDArray[np.float32],
        widths: Widths,
        primvars: Mapping[str, PrimvarValue],
    ) -> None:
        self.attributes = {
            "typeName": "Points",
            "points": points,
            "widths": widths.values,
            **primvar_attributes(primvars),
        }
        self.extent = extent(points, widths)
        """The largest absolute coordinate."""
        self._arrays = points, widths.values
        self._varying = primvars
        self._geometry: _core.Spheres | None = None

    def geometry(self) -> "_core.Spheres":
        """The core's balls, made once."""
        if self._geometry is None:
            from irt_usd import _core

            primvars = {name: primvar.core for name, primvar in self._varying.items()}
            self._geometry = _core.Spheres(*self._arrays, primvars)
        return self._geometry


class PointsSource(PointBasedSource):
    """Reads one UsdGeomPoints."""

    kind = "points"

    def _shape_of(self, points: NDArray[np.float32], time: Usd.TimeCode) -> Shape | None:
        count = len(points)
        counts = {"constant": 1, "uniform": 1, "varying": count, "vertex": count}
        widths = self._read_widths(counts, time)
        if widths is None:
            return None

        def fault(primvar: PrimvarValue) -> str | None:
            wanted = counts.get(primvar.interpolation, count)
            if primvar.elements() == wanted:
                return None
            return f"it has {primvar.elements()} elements, expected {wanted}"

        return PointsShape(points, widths, _by_point(self._primvars.checked(fault, time)))


def _by_point(primvars: Mapping[str, PrimvarValue]) -> dict[str, PrimvarValue]:
    """Points have no faces: a value each is all that varying and faceVarying can mean."""
    return {
        name: PrimvarValue("vertex", p.values, p.indices)
        if p.interpolation in ("vertex", "faceVarying")
        else p
        for name, p in primvars.items()
    }
