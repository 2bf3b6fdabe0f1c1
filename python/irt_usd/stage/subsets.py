# SPDX-License-Identifier: Apache-2.0
"""GeomSubsets that bind materials to faces of a mesh."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.topology import TopologyError, integers
from irt_usd.stage.values import Value


def material_subsets(prim: Usd.Prim) -> list[Usd.Prim]:
    """The subsets of faces whose bindings count, by UsdShade: of the family materialBind."""
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
    return [s.GetPrim() for s in subsets if s.GetElementTypeAttr().Get() == UsdGeom.Tokens.face]


class FaceMaterials:
    """Which face of a mesh wears what, by subsets and the names of their materials."""

    def __init__(self, worn: Sequence[tuple[Usd.Prim, str]], report: Report) -> None:
        self._report = report
        self._worn = worn
        self.names = tuple(dict.fromkeys(name for _, name in worn))
        """Of the materials, each once."""
        self._indices = [Attributes(prim, ("indices",), report) for prim, _ in worn]

    @property
    def vary(self) -> bool:
        """Whether a subset's faces can differ between frames."""
        return any(indices.vary for indices in self._indices)

    def update(self, time: Usd.TimeCode) -> bool:
        """Reads what can vary at `time`; returns whether any bit differs from before."""
        changed = False
        for indices in self._indices:
            changed |= indices.update(time)
        return changed

    @property
    def attributes(self) -> dict[str, Value]:
        """What a change is looked for in."""
        found: dict[str, Value] = {}
        for (prim, name), indices in zip(self._worn, self._indices, strict=True):
            found[f"{prim.GetPath()}.indices"] = indices.values["indices"]
            found[f"{prim.GetPath()}.material:binding"] = name
        return found

    def of_faces(self, count: int, time: Usd.TimeCode) -> NDArray[np.int32] | None:
        """For each of `count` faces the place of its material in `names`, -1: the mesh's own.

        Where subsets overlap the first one counts. None: all are the mesh's own.
        """
        faces = np.full(count, -1, np.int32)
        for (prim, name), attributes in zip(self._worn, self._indices, strict=True):
            value = attributes.values["indices"]
            if value is None:
                continue
            try:
                indices = integers("indices", value)
            except TopologyError as fault:
                self._report.skipped(fault.message, where(prim, "indices", time))
                continue
            inside = (indices >= 0) & (indices < count)
            if not inside.all():
                message = f"a subset names faces that are not there: expected 0 to {count - 1}"
                self._report.skipped(message, where(prim, "indices", time))
                indices = indices[inside]
            place = self.names.index(name)
            if ((faces[indices] != -1) & (faces[indices] != place)).any():
                message = "subsets overlap: the first one's material is rendered"
                self._report.skipped(message, where(prim, "indices", time))
            free = indices[faces[indices] == -1]
            faces[free] = place
        return faces if (faces != -1).any() else None
