# SPDX-License-Identifier: Apache-2.0
"""UsdGeomBasisCurves: tubes along linear and cubic curves; ribbons, where they have normals."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.mesh import flattened_normals, vectors
from irt_usd.stage.point_based import PointBasedSource, Widths, empty, extent
from irt_usd.stage.primvars import PrimvarValue, primvar_attributes
from irt_usd.stage.skel import Deformation
from irt_usd.stage.snapshot import Shape
from irt_usd.stage.topology import TopologyError, integers
from irt_usd.stage.transforms import Node
from irt_usd.stage.values import Value

if TYPE_CHECKING:
    from irt_usd import _core

Basis = Literal["linear", "bezier", "bspline", "catmullRom"]
Wrap = Literal["nonperiodic", "periodic", "pinned"]

SEGMENTS = 8
"""Straight pieces of a cubic span at level 0; each level doubles them."""

_BASES = ("bezier", "bspline", "catmullRom")
_WRAPS = ("nonperiodic", "periodic", "pinned")
_NORMALS = ("normals", "primvars:normals")


@dataclass(frozen=True)
class Layout:
    """How points make spans: UsdGeomBasisCurves' rules."""

    basis: Basis
    wrap: Wrap
    counts: NDArray[np.int32]

    def fault(self) -> str | None:
        """What is wrong with the vertex counts, if anything."""
        least, step, rest = 4, 1, 0
        if self.wrap == "periodic":
            least, step = 3, 3 if self.basis == "bezier" else 1
        elif self.basis == "bezier":
            step, rest = 3, 1
        elif self.basis == "linear" or self.wrap == "pinned":
            least = 2
        wrong = (self.counts < least) | (self.counts % step != rest)
        if not wrong.any():
            return None
        at = int(np.flatnonzero(wrong)[0])
        fitting = f"{least}, {least + step}, {least + 2 * step} and so on" if step > 1 else ""
        return (
            f"curve {at} has {self.counts[at]} vertices; "
            f"a {self.wrap} {self.basis} curve takes {fitting or f'{least} or more'}"
        )

    def elements(self) -> dict[str, int]:
        """How many elements each interpolation takes."""
        vertices = int(self.counts.sum(dtype=np.int64))
        step = 3 if self.basis == "bezier" else 1
        if self.wrap == "periodic":
            ends = vertices // step
        elif self.basis == "linear" or (self.wrap == "pinned" and self.basis != "bezier"):
            ends = vertices
        else:
            ends = int(((self.counts.astype(np.int64) - 4) // step + 2).sum())
        return {
            "constant": 1,
            "uniform": len(self.counts),
            "varying": ends,
            "vertex": vertices,
            "faceVarying": ends,
        }


@dataclass(frozen=True)
class Normals:
    """Of ribbons, (n, 3) float32, and their interpolation as authored ("varying" stays)."""

    values: NDArray[np.float32]
    interpolation: str


class CurvesShape(Shape):
    """Tubes, or ribbons.

    Attributes: points (n, 3) float32, curveVertexCounts int32, widths float32 (diameters) with
    "widths:interpolation", type, basis, wrap; of ribbons, normals (k, 3) float32 with
    "normals:interpolation".
    """

    def __init__(
        self,
        points: NDArray[np.float32],
        layout: Layout,
        widths: Widths,
        normals: Normals | None,
        primvars: Mapping[str, PrimvarValue],
        level: int,
    ) -> None:
        self.attributes = {
            "typeName": "BasisCurves",
            "points": points,
            "curveVertexCounts": layout.counts,
            "widths": widths.values,
            "widths:interpolation": widths.interpolation,
            "type": "linear" if layout.basis == "linear" else "cubic",
            "basis": layout.basis,
            "wrap": layout.wrap,
            **primvar_attributes(primvars),
        }
        if normals is not None:
            self.attributes |= {
                "normals": normals.values,
                "normals:interpolation": normals.interpolation,
            }
        self.extent = 3 * extent(points, widths)
        """A bound on absolute coordinates: a cubic may leave its control points' box."""
        self._points, self._layout, self._widths, self._normals = points, layout, widths, normals
        self._varying = primvars
        self._segments = SEGMENTS << level
        self._geometry: _core.Curves | _core.Mesh | None = None

    def geometry(self) -> "_core.Curves | _core.Mesh":
        """The core's chains of round cones, or mesh of ribbons, made once."""
        if self._geometry is not None:
            return self._geometry
        from irt_usd import _core

        primvars = {name: primvar.core for name, primvar in self._varying.items()}
        if self._normals is not None:
            self._geometry = _core.Mesh.ribbons(
                self._points,
                self._layout.counts,
                self._widths.values,
                self._normals.values,
                widths_interpolation=_core_interpolation(self._widths.interpolation),
                normals_interpolation=_core_interpolation(self._normals.interpolation),
                basis=self._layout.basis,
                wrap=self._layout.wrap,
                segments=self._segments,
                primvars=primvars,
            )
        else:
            self._geometry = _core.Curves(
                self._points,
                self._layout.counts,
                self._widths.values,
                _core_interpolation(self._widths.interpolation),
                self._layout.basis,
                self._layout.wrap,
                self._segments,
                primvars,
            )
        return self._geometry


class CurvesSource(PointBasedSource):
    """Reads one UsdGeomBasisCurves, cubic spans cut as `level` of --complexity says."""

    kind = "curves"

    def __init__(
        self,
        node: Node,
        report: Report,
        wanted: frozenset[str],
        skin: Deformation | None,
        level: int = 0,
    ) -> None:
        self._level = level
        names = ("curveVertexCounts", "type", "basis", "wrap", *_NORMALS)
        super().__init__(node, report, wanted, skin, (*names, "primvars:normals:indices"))

    def _shape_of(self, points: NDArray[np.float32], time: Usd.TimeCode) -> Shape | None:
        values = self._attributes.values
        if empty(values["curveVertexCounts"]):
            self._report.mentioned("empty curves", self._path)
            return None
        layout = self._read_layout(len(points), values)
        counts = layout.elements()
        widths = self._read_widths(counts, time)
        if widths is None:
            return None

        def fault(primvar: PrimvarValue) -> str | None:
            if _fitting(primvar, counts) is not None:
                return None
            return (
                f"it has {primvar.elements()} elements of interpolation {primvar.interpolation}, "
                f"expected {counts[primvar.interpolation]}"
            )

        checked = self._primvars.checked(fault, time)
        primvars = {name: cast("PrimvarValue", _fitting(p, counts)) for name, p in checked.items()}
        normals = self._read_normals(counts, time)
        return CurvesShape(points, layout, widths, normals, primvars, self._level)

    def _read_normals(self, counts: Mapping[str, int], time: Usd.TimeCode) -> Normals | None:
        """What makes the curves ribbons; None: there is none, or it is reported."""
        values = self._attributes.values
        name = "normals" if empty(values["primvars:normals"]) else "primvars:normals"
        if empty(values[name]):
            return None
        attribute = self._prim.GetAttribute(name)
        try:
            normals = vectors(name, values[name])
            if name == "normals":
                interpolation = str(attribute.GetMetadata("interpolation") or "vertex")
            else:
                interpolation = str(UsdGeom.Primvar(attribute).GetInterpolation())
                normals = flattened_normals(normals, values["primvars:normals:indices"])
            wanted = counts.get(interpolation)
            if len(normals) != wanted:
                expected = f"{wanted}, the interpolation being {interpolation}"
                if wanted is None:
                    expected = f"an interpolation of {', '.join(counts)}, not {interpolation}"
                message = f"there are {len(normals)} {name}; expected {expected}"
                raise TopologyError(name, message)
            if self._skin is not None and interpolation == "vertex":
                normals = self._skin.normals(normals, None)
        except TopologyError as fault:
            message = f"{fault.message}; round tubes rendered instead of ribbons"
            self._report.skipped(message, where(self._prim, fault.attribute, time))
            return None
        return Normals(normals, interpolation)

    def _read_layout(self, points: int, values: Mapping[str, Value]) -> Layout:
        basis = values["basis"] if values["type"] == "cubic" else values["type"]
        wrap = values["wrap"]
        if values["type"] not in ("linear", "cubic"):
            raise TopologyError("type", f"the type is {values['type']}; expected linear or cubic")
        if basis not in (*_BASES, "linear"):
            raise TopologyError("basis", f"the basis is {basis}; expected {', '.join(_BASES)}")
        if wrap not in _WRAPS:
            raise TopologyError("wrap", f"the wrap is {wrap}; expected {', '.join(_WRAPS)}")
        counts = integers("curveVertexCounts", values["curveVertexCounts"])
        layout = Layout(cast("Basis", basis), cast("Wrap", wrap), counts)
        message = layout.fault()
        if message is None and int(counts.sum(dtype=np.int64)) != points:
            message = (
                f"the vertex counts sum to {counts.sum(dtype=np.int64)}, but there are {points} "
                "points; expected as many"
            )
        if message is not None:
            raise TopologyError("curveVertexCounts", message)
        return layout


def _fitting(primvar: PrimvarValue, counts: Mapping[str, int]) -> PrimvarValue | None:
    """`primvar` with the interpolation that it has the elements for; None: for none.

    "faceVarying" stands for varying. A size tells varying and vertex ones apart, too.
    """
    count, kind = primvar.elements(), primvar.interpolation
    if kind != "vertex":
        return primvar if count == counts[kind] else None
    if count == counts["varying"] and (primvar.linear or count != counts["vertex"]):
        return PrimvarValue("faceVarying", primvar.values, primvar.indices)
    if count == counts["vertex"]:
        return PrimvarValue("vertex", primvar.values, primvar.indices)
    return None


def _core_interpolation(
    authored: str,
) -> Literal["constant", "uniform", "vertex", "faceVarying"]:
    name = "faceVarying" if authored == "varying" else authored
    return cast("Literal['constant', 'uniform', 'vertex', 'faceVarying']", name)
