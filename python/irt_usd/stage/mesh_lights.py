# SPDX-License-Identifier: Apache-2.0
"""Meshes that are lights (UsdLux's MeshLightAPI, or LightAPI on a mesh).

A mesh sends L times the area that it turns to a direction, from the front of its faces, all of it
from the centre of its surface; it stands in no light and no shadow of its own. What rays see of it
is by `light:materialSyncMode`: its material, whose glow tints the light (materialGlowTintsLight) or
not (independent), or (noMaterialResponse, and where no material is bound) its radiance alone.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pxr import Usd, UsdLux

from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.graph import DEFAULTS, Surface, TextureReference, TextureSource
from irt_usd.stage.lights import LightSource
from irt_usd.stage.material_set import MaterialLike
from irt_usd.stage.snapshot import LightState, MaterialState, Vector
from irt_usd.stage.transforms import Node
from irt_usd.stage.values import Value, same_bits

if TYPE_CHECKING:
    from irt_usd.stage.objects import ObjectSource

_BLACK = (0.0, 0.0, 0.0)


class MeshLightSource(LightSource):
    """Reads one mesh as a light. `wear` must have been called, and `mesh` be set, before `read`."""

    def __init__(
        self, node: Node, report: Report, colors: StageColors, textures: TextureSource
    ) -> None:
        super().__init__(node.prim, node, report, colors, textures)
        self.mesh: ObjectSource | None = None
        """The same prim as an object."""
        self._glow: MaterialLike | None = None
        self._shape: Any = None
        self._seen_tint: Vector | None = None

    def wear(self, material: MaterialLike | None) -> MaterialLike | None:
        """Takes up the material bound to the mesh; returns the one that it shows in its place.

        None: its own.
        """
        mode = str(UsdLux.LightAPI(self._prim).GetMaterialSyncModeAttr().Get())
        if material is None or mode == "noMaterialResponse":
            return GlowSource(self)
        if mode != "independent":
            self._glow = material
        return None

    def _set_linking(self, unlit: set[str], shadowless: set[str]) -> None:
        super()._set_linking(unlit | {self.node.path}, shadowless | {self.node.path})

    @property
    def varies(self) -> bool:
        """Whether the light, its shape, place or visibility can differ between frames."""
        glows = self._glow is not None and self._glow.varies
        return super().varies or glows or (self.mesh is not None and self.mesh.varies)

    def read(self, time: Usd.TimeCode) -> LightState | None:
        """As LightSource has it; None where the mesh cannot be drawn, which is reported of it."""
        assert self.mesh is not None, "set before anything is read"
        state = self.mesh.read(time)
        tint = self._tint(time)
        if self._shape is not state or tint != self._seen_tint:
            self._first = True
        self._shape, self._seen_tint = state, tint
        return super().read(time) if state is not None else None

    def radiance(self, time: Usd.TimeCode) -> Vector:
        """What the mesh sends by itself, black where it cannot be rendered."""
        state = self.read(time)
        if state is None or not self.node.visible:
            return _BLACK
        r, g, b = state.energy
        return r, g, b

    def _tint(self, time: Usd.TimeCode) -> Vector | None:
        """The material's glow at `time`, where it tints the light."""
        if self._glow is None:
            return None
        emission = self._glow.read(time).surface.constant("emissiveColor")
        if emission is None:
            self._report.unsupported(
                "mesh lights tinted by a glow that a graph gives (lit by their own colour)",
                self.node.path,
            )
            return None
        r, g, b = emission
        return float(r), float(g), float(b)

    def _area_light(
        self,
        attributes: dict[str, Value],
        shadows: bool,
        shaped: dict[str, Any],
        time: Usd.TimeCode,
    ) -> LightState | None:
        from irt_usd import _core

        _, mesh, placed, *_ = self._shape.part("")
        centre, area, facets = _core.mesh_light(mesh, placed, self.node.path)
        attributes["points"] = facets
        attributes["irt:centre"] = centre
        attributes["irt:glow"] = self._seen_tint
        shaped["profile"] = "facets"
        shaped["facets"] = tuple(map(tuple, facets.tolist()))
        normalized = bool(self._attributes.values["inputs:normalize"])
        factor = 0.0 if area == 0 else (1 / area if normalized else 1.0)
        energy = self._energy(factor, time, self._seen_tint or (1.0, 1.0, 1.0))
        if energy is None:
            return None
        return LightState(self.node.path, "point", attributes, centre, energy, shadows, shaped)


class GlowSource:
    """The material of a mesh light that shows nothing but its radiance."""

    primvars: frozenset[str] = frozenset()

    def __init__(self, light: MeshLightSource) -> None:
        self.path = f"{light.node.path}.light:radiance"
        self._light = light
        self._state: MaterialState | None = None

    @property
    def varies(self) -> bool:
        """Whether the radiance can differ between frames."""
        return self._light.varies

    def textures(self) -> Mapping[TextureReference, str]:
        """None."""
        return MappingProxyType({})

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        constants: dict[str, Value] = {
            "diffuseColor": _BLACK,
            "emissiveColor": tuple(max(channel, 0.0) for channel in self._light.radiance(time)),
            "useSpecularWorkflow": 1,
            "specularColor": _BLACK,
            "roughness": 1.0,
        }
        attributes = {**DEFAULTS, **constants}
        if self._state is None or not all(
            same_bits(attributes[name], self._state.attributes[name]) for name in attributes
        ):
            self._state = MaterialState(self.path, attributes, Surface(constants))
        return self._state
