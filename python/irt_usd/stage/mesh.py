# SPDX-License-Identifier: Apache-2.0
"""UsdGeomMesh: polygons, or a subdivision surface as polygons that the core makes of it."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage import subdivision
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.primvars import Interpolation, Primvars, PrimvarValue, primvar_attributes
from irt_usd.stage.skel import Deformation
from irt_usd.stage.snapshot import Shape
from irt_usd.stage.subdivision import Subdivision
from irt_usd.stage.subsets import FaceMaterials
from irt_usd.stage.topology import Topology, TopologyError, integers
from irt_usd.stage.transforms import Node
from irt_usd.stage.values import Value

if TYPE_CHECKING:
    from irt_usd import _core

_NAMES = (
    "points",
    "faceVertexCounts",
    "faceVertexIndices",
    "holeIndices",
    "orientation",
    "doubleSided",
    *subdivision.NAMES,
    "normals",
    "primvars:normals",
    "primvars:normals:indices",
)


class MeshShape(Shape):
    """Polygons.

    Attributes: points (n, 3) float32, faceVertexCounts and faceVertexIndices int32 without the
    holes, normals (k, 3) float32 or None with "normals:interpolation", orientation, doubleSided
    (None: not authored), and each primvar's values, ":indices" and ":interpolation". Of
    subdivision meshes: the control cage, holes included, and the attributes of its subdivision.
    """

    def __init__(
        self,
        attributes: Mapping[str, Value],
        extent: float,
        primvars: Mapping[str, PrimvarValue] = MappingProxyType({}),
        faces: NDArray[np.int32] | None = None,
        face_materials: tuple[str, ...] = (),
        elements: NDArray[np.int32] | None = None,
    ) -> None:
        self.attributes = {**attributes, **primvar_attributes(primvars)}
        self._primvars = primvars
        self._faces = faces
        self._elements = elements
        self.face_materials = face_materials
        self.extent = extent
        """The largest absolute coordinate."""
        self._geometry: _core.Mesh | None = None

    def geometry(self) -> "_core.Mesh":
        """The core's mesh, made once."""
        if self._geometry is None:
            from irt_usd import _core

            values: Mapping[str, Any] = self.attributes
            self._geometry = _core.Mesh(
                values["points"],
                values["faceVertexCounts"],
                values["faceVertexIndices"],
                values["normals"],
                values["normals:interpolation"],
                left_handed=values["orientation"] == "leftHanded",
                single_sided=values["doubleSided"] is False,
                primvars={name: primvar.core for name, primvar in self._primvars.items()},
                face_materials=self._faces,
                elements=self._elements,
            )
        return self._geometry

    def subdivide(self, rules: Subdivision) -> tuple[Sequence[str], str | None]:
        """Makes the core's mesh of the refined cage.

        Returns what of its creases and corners was left out; and why it is the cage itself, if so.
        """
        self._geometry, left_out, fault = rules.refine(self.geometry(), self.attributes)
        return left_out, fault


class MeshSource:
    """Reads one mesh, and of its primvars those that are `wanted` (without "primvars:")."""

    def __init__(
        self,
        node: Node,
        report: Report,
        wanted: frozenset[str],
        skin: Deformation | None = None,
        level: int = 0,
        subsets: Sequence[tuple[Usd.Prim, str]] = (),
        name_elements: bool = False,
    ) -> None:
        """Cuts the faces of a subdivision mesh `level` times.

        `subsets`: those that bind materials, and the names of these. `name_elements`: whether the
        core is told which authored face each of its faces is of, where it has others.
        """
        self._report = report
        self._skin = skin
        self._skin_version = 0
        self._prim = prim = node.prim
        self._path = node.path
        self._attributes = Attributes(prim, _NAMES, report, node.in_clips)
        self._primvars = Primvars(prim, wanted, report)
        self._double_sided_authored = prim.GetAttribute("doubleSided").HasAuthoredValue()
        self._shape: Shape | None = None
        self._topology: Topology | None = None
        self._first = True
        self._faces = FaceMaterials(subsets, report) if subsets else None
        self._subdivision = Subdivision(level, name_elements)
        self._name_elements = name_elements

    @property
    def varies(self) -> bool:
        """Whether the shape can differ between frames."""
        skinned = self._skin is not None and self._skin.varies and not self._skin.rigid
        faces = self._faces is not None and self._faces.vary
        return self._attributes.vary or self._primvars.vary or skinned or faces

    def read(self, time: Usd.TimeCode) -> Shape | None:
        """The shape at `time` (the same object while nothing changes); None: nothing to draw."""
        changed = self._attributes.update(time)
        if self._skin is not None:
            self._skin.update(time)
            changed |= not self._skin.rigid and self._skin.version != self._skin_version
            self._skin_version = self._skin.version
        if self._faces is not None:
            changed |= self._faces.update(time)
        if self._primvars.update(time) or changed or self._first:
            self._first = False
            self._shape = self._build(time)
        return self._shape

    def _build(self, time: Usd.TimeCode) -> Shape | None:
        values = self._attributes.values
        if any(_empty(values[name]) for name in _NAMES[:3]):
            self._report.mentioned("empty mesh", self._path)
            return None
        try:
            points = vectors("points", values["points"])
            if self._skin is not None:
                points = self._skin.points(points)
            topology = self._read_topology(len(points), points)
        except TopologyError as fault:
            self._report.skipped(fault.message, where(self._prim, fault.attribute, time))
            return None
        if len(topology.counts) == 0:
            self._report.mentioned("empty mesh", self._path)
            return None
        smooth = self._subdivided
        normals, interpolation = (
            (None, "vertex") if smooth else self._read_normals(len(points), topology, time)
        )
        authored = self._double_sided_authored
        shape = {
            "typeName": "Mesh",
            "points": points,
            "faceVertexCounts": topology.counts,
            "faceVertexIndices": topology.indices,
            "normals": normals,
            "normals:interpolation": interpolation,
            "orientation": values["orientation"],
            "doubleSided": values["doubleSided"] if authored else None,
        }
        if smooth:
            shape |= {name: values[name] for name in (*subdivision.NAMES, "holeIndices")}
        faces = None
        if self._faces is not None:
            faces = self._faces.of_faces(topology.face_count, time)
            kept = topology.kept("uniform")
            faces = faces if faces is None or kept is None else faces[kept]
            shape |= self._faces.attributes
        primvars = self._primvars.checked(
            lambda v: topology.size_fault(v.interpolation, v.elements(), len(points)), time
        )
        made = MeshShape(
            shape,
            float(np.abs(points).max()),
            {name: _without_holes(value, topology) for name, value in primvars.items()},
            faces,
            self._faces.names if self._faces is not None and faces is not None else (),
            self._elements(topology),
        )
        if smooth:
            left_out, refusal = made.subdivide(self._subdivision)
            if refusal is not None:
                message = f"not subdivided, the control cage is rendered: {refusal}"
                self._report.skipped(message, where(self._prim, "subdivisionScheme", time))
            for what in left_out:
                attribute = "creaseIndices" if "crease" in what else "cornerIndices"
                message = f"subdivided without {what}"
                self._report.skipped(message, where(self._prim, attribute, time))
            if not self.varies:
                self._subdivision.forget()
        return made

    def _elements(self, topology: Topology) -> NDArray[np.int32] | None:
        """The authored face of each of the core's, where these are others."""
        kept = topology.kept("uniform")
        if not self._name_elements or self._subdivided or kept is None:
            return None
        return np.flatnonzero(kept).astype(np.int32)

    @property
    def _subdivided(self) -> bool:
        return self._attributes.values["subdivisionScheme"] in subdivision.SCHEMES

    def _read_topology(self, point_count: int, points: NDArray[np.float32]) -> Topology:
        values = self._attributes.values
        # Holes shape a subdivision surface all the same: the core takes them out.
        holes = None if self._subdivided else values["holeIndices"]
        arrays = [values["faceVertexCounts"], values["faceVertexIndices"], holes]
        known = self._topology
        if known is None or not known.made_of(arrays):
            known = Topology(*arrays)
            self._topology = known
            known.check(point_count)
            known.without_holes(values["holeIndices"])
            degenerate = known.degenerate_faces(points)
            if degenerate:
                self._report.mentioned("degenerate faces, invisible", self._path)
        else:
            known.check(point_count)
        return known

    def _read_normals(
        self, point_count: int, topology: Topology, time: Usd.TimeCode
    ) -> tuple[NDArray[np.float32] | None, Interpolation]:
        values = self._attributes.values
        name = "normals" if _empty(values["primvars:normals"]) else "primvars:normals"
        if _empty(values[name]):
            return None, "vertex"
        attribute = self._prim.GetAttribute(name)
        try:
            normals = vectors(name, values[name])
            if name == "normals":
                authored = attribute.GetMetadata("interpolation") or "vertex"
            else:
                authored = UsdGeom.Primvar(attribute).GetInterpolation()
                normals = flattened_normals(normals, values["primvars:normals:indices"])
            interpolation = "vertex" if authored == "varying" else str(authored)
            fault_found = topology.size_fault(interpolation, len(normals), point_count)
            if fault_found:
                raise TopologyError(name, f"{name}: {fault_found}")
            kept = topology.kept(interpolation)
            normals = normals if kept is None else normals[kept]
            if self._skin is not None:
                if interpolation not in ("vertex", "faceVarying"):
                    return None, "vertex"
                of = topology.indices if interpolation == "faceVarying" else None
                normals = self._skin.normals(normals, of)
        except TopologyError as fault:
            message = f"{fault.message}; facets rendered instead"
            self._report.skipped(message, where(self._prim, fault.attribute, time))
            return None, "vertex"
        return normals, cast("Interpolation", interpolation)


def _without_holes(primvar: PrimvarValue, topology: Topology) -> PrimvarValue:
    kept = topology.kept(primvar.interpolation)
    return primvar if kept is None else primvar.selected(kept)


def vectors(attribute: str, value: Value) -> NDArray[np.float32]:
    """`value` as (n, 3) float32. Raises TopologyError unless it is an array of finite vectors."""
    if not isinstance(value, np.ndarray) or value.dtype.kind != "f" or value.shape[1:] != (3,):
        raise TopologyError(attribute, f"the {attribute} are no array of 3-vectors")
    with np.errstate(over="ignore"):
        array = np.ascontiguousarray(value, dtype=np.float32)
    if not np.isfinite(array).all():
        message = f"the {attribute} hold a NaN or an infinity; expected finite numbers"
        raise TopologyError(attribute, message)
    return array


def flattened_normals(normals: NDArray[np.float32], indices: Value) -> NDArray[np.float32]:
    """The normal of each element of primvars:normals. Raises TopologyError."""
    if indices is None:
        return normals
    name = "primvars:normals:indices"
    array = integers(name, indices)
    if len(array) and (array.min() < 0 or array.max() >= len(normals)):
        raise TopologyError(name, f"an index is outside the {len(normals)} normals")
    return normals[array]


def _empty(value: Value) -> bool:
    return value is None or (isinstance(value, np.ndarray) and len(value) == 0)
