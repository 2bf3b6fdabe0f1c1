# SPDX-License-Identifier: Apache-2.0
"""The materials that a stage's objects wear, each read once."""

from collections.abc import Mapping
from functools import partial
from typing import Protocol

from pxr import Sdf, Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.diagnostics import attempt
from irt_usd.stage.display_color import DEFAULT_MATERIAL, DisplayColorSource, default_material
from irt_usd.stage.graph import DEFAULTS, Surface, TextureReference, TextureSource
from irt_usd.stage.materials import is_materialx, rendered_surface
from irt_usd.stage.preview_surface import MaterialSource
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.transforms import Node


class MaterialLike(Protocol):
    """What reads one material."""

    path: str
    primvars: frozenset[str]
    """Names of the primvars that it can read."""

    @property
    def varies(self) -> bool:
        """Whether the material can differ between frames."""

    def textures(self) -> Mapping[TextureReference, str]:
        """The images that it can read, and the attribute that names each, in its file."""

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""


class MaterialSet:
    """Reads the materials that objects wear."""

    def __init__(
        self, stage: Usd.Stage, colors: StageColors, textures: TextureSource, report: Report
    ) -> None:
        self._stage = stage
        self._colors = colors
        self._textures = textures
        self._report = report
        self._sources: dict[str, MaterialLike | None] = {}
        self._shown: dict[str, frozenset[TextureReference]] = {}
        self._first = True

    def bound(self, material: UsdShade.Material | None) -> MaterialLike | None:
        """What reads `material`; None, and reported, where irt cannot render it."""
        if material is None:
            return None
        name = str(material.GetPath())
        if name not in self._sources:
            make = partial(self._make, material)
            self._sources[name] = attempt(make, material.GetPrim(), self._report)
        return self._sources[name]

    def worn(
        self, node: Node, material: UsdShade.Material | None, given: frozenset[str] = frozenset()
    ) -> tuple[str, frozenset[str]]:
        """The name of the material that `node` wears, and the primvars that it reads.

        `material` is the one bound to it; where that is none, or cannot be rendered, the node's
        displayColor stands in, or its instance's, which may have the display primvars `given`.
        """
        source = self.bound(material) or self._display_color(node, given)
        return (source.path, source.primvars) if source else (DEFAULT_MATERIAL, frozenset())

    def add(self, source: MaterialLike) -> str:
        """Takes up a material that is no prim's; returns its name."""
        self._sources[source.path] = source
        return source.path

    def references(self) -> dict[TextureReference, str]:
        """The images of all materials at all times, and the attribute that names each."""
        found: dict[TextureReference, str] = {}
        for source in self._sources.values():
            if source is not None:
                for reference, place in source.textures().items():
                    found.setdefault(reference, place)
        return found

    @property
    def shown(self) -> frozenset[TextureReference]:
        """The images that the materials show, as they were last read."""
        return frozenset().union(*self._shown.values())

    def read(self, time: Usd.TimeCode) -> dict[str, MaterialState]:
        """Those that may have changed since the last call; at the first, all."""
        sources = [s for s in self._sources.values() if s and (self._first or s.varies)]
        materials = {source.path: self._read(source, time) for source in sources}
        if materials:
            self._shown |= {path: state.surface.textures for path, state in materials.items()}
        if self._first:
            materials[DEFAULT_MATERIAL] = default_material()
            self._first = False
        return materials

    def _make(self, material: UsdShade.Material) -> MaterialLike | None:
        shader = rendered_surface(material, self._report)
        if shader is None:
            return None
        path = str(material.GetPath())
        if is_materialx(str(shader.GetIdAttr().Get())):
            from irt_usd.materialx.material import MaterialXSource

            return MaterialXSource(path, shader, self._report, self._colors, self._textures)
        return MaterialSource(path, shader, self._report, self._colors, self._textures)

    def _display_color(self, node: Node, given: frozenset[str]) -> MaterialLike | None:
        if not node.display_primvars and not given:
            return None
        make = partial(DisplayColorSource, node.prim, self._report, self._colors, given)
        source = attempt(make, node.prim, self._report)
        if source is not None:
            self._sources[source.path] = source
        return source

    def _read(self, source: MaterialLike, time: Usd.TimeCode) -> MaterialState:
        """The material; UsdPreviewSurface's defaults, and reported, where USD fails."""
        prim = self._stage.GetPrimAtPath(Sdf.Path(source.path).GetPrimPath())
        state = attempt(partial(source.read, time), prim, self._report)
        return state if state is not None else MaterialState(source.path, DEFAULTS, Surface())
