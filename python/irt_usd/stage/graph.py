# SPDX-License-Identifier: Apache-2.0
"""A material as plain data: UsdPreviewSurface's inputs, constants or fed by a graph of nodes.

It mirrors the core's record, but for textures, which are references here and texels there.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from irt_usd.stage.values import Value

if TYPE_CHECKING:
    from irt_usd import _core

WrapMode = Literal["black", "clamp", "repeat", "mirror"]
Wrap = WrapMode | Literal["useMetadata"]
Constant = float | tuple[float, ...]
"""A number fills all four components; a shorter tuple is padded with 0, 0, 1."""

DEFAULTS: dict[str, Value] = {
    "diffuseColor": (0.18000000715255737,) * 3,
    "emissiveColor": (0.0, 0.0, 0.0),
    "useSpecularWorkflow": 0,
    "specularColor": (0.0, 0.0, 0.0),
    "metallic": 0.0,
    "roughness": 0.5,
    "clearcoat": 0.0,
    "clearcoatRoughness": 0.009999999776482582,
    "opacity": 1.0,
    "opacityMode": "transparent",
    "opacityThreshold": 0.0,
    "ior": 1.5,
    "normal": (0.0, 0.0, 1.0),
}
"""The inputs that are rendered, with UsdPreviewSurface's defaults (of single precision)."""

OTHER_DEFAULTS: dict[str, Value] = {"transmissionColor": (1.0, 1.0, 1.0)}
"""Inputs that other surface models give: what tints a refracted ray at each surface."""

_CORE_NAMES = {
    "diffuseColor": "diffuse_color",
    "emissiveColor": "emissive_color",
    "useSpecularWorkflow": "use_specular_workflow",
    "specularColor": "specular_color",
    "metallic": "metallic",
    "roughness": "roughness",
    "clearcoat": "clearcoat",
    "clearcoatRoughness": "clearcoat_roughness",
    "opacity": "opacity",
    "opacityMode": "opacity_is_presence",
    "opacityThreshold": "opacity_threshold",
    "ior": "ior",
    "normal": "normal",
    "transmissionColor": "transmission_color",
}


AUTO, AUTO_COLOR = "auto", "auto color"
"""Colour spaces that the file decides: sRGB, or else raw, or of colours linear Rec.709."""


@dataclass(frozen=True, slots=True)
class TextureReference:
    """An image file, and what its numbers mean."""

    file: str
    """Where the asset resolver finds it; with `udim`, it has <UDIM> in it."""
    color_space: str = AUTO
    """ "raw", "sRGB" or AUTO as UsdUVTexture has them, AUTO_COLOR, or a colour space's name."""
    udim: bool = False


@dataclass(frozen=True, slots=True)
class Node:
    """One operation. The core documents the operations and the slots they have.

    A slot's value is that of `inputs`, the index of an earlier node, or where that is -1 (or
    missing) its constant.
    """

    op: str
    inputs: tuple[int, ...] = ()
    constants: tuple[Constant, ...] = ()
    primvar: str = ""
    texture: TextureReference | None = None
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    swizzle: str = "rgba"


@dataclass(frozen=True, slots=True)
class Surface:
    """UsdPreviewSurface's inputs, colours in the rendering space.

    `constants` by input name, for those that DEFAULTS does not speak for. `nodes` in topological
    order. `connected` by input name: the node that feeds it, and which of its values: "rgb" or one
    of "r", "g", "b", "a".
    """

    constants: Mapping[str, Value] = field(default_factory=dict)
    nodes: tuple[Node, ...] = ()
    connected: Mapping[str, tuple[int, str]] = field(default_factory=dict)

    def constant(self, name: str) -> Any:
        """The value of an input, None where a node feeds it."""
        return (
            None
            if name in self.connected
            else self.constants.get(name, (DEFAULTS | OTHER_DEFAULTS)[name])
        )

    @property
    def primvars(self) -> frozenset[str]:
        """The primvars that the graph reads, without "primvars:"."""
        return frozenset(node.primvar for node in self.nodes if node.primvar)

    @property
    def textures(self) -> frozenset[TextureReference]:
        """The images that the graph reads."""
        return frozenset(node.texture for node in self.nodes if node.texture is not None)


class TextureSource(Protocol):
    """Where the texels of a reference come from."""

    def load(self, references: Collection[TextureReference]) -> None:
        """Decodes those of `references` that are not yet, together."""

    def texture(self, reference: TextureReference) -> "_core.Texture | None":
        """The decoded texture, the same one at every call; None: its fallback is rendered."""

    def wrap(
        self, reference: TextureReference, wrap: tuple[Wrap, Wrap]
    ) -> tuple[WrapMode, WrapMode]:
        """`wrap` with what the file says in the place of useMetadata."""

    def keep(self, references: Collection[TextureReference]) -> None:
        """Told with each frame that differs what its materials and domes show."""

    def picture(self, reference: TextureReference) -> "_core.Texture | None":
        """A light's texture; None: the light is rendered without it."""

    def mean(self, reference: TextureReference) -> tuple[float, float, float]:
        """The mean colour of a light's texture that there is."""

    def sky_cells(self, reference: TextureReference) -> "_core.SkyCells":
        """A dome's texture that there is, summed up."""


class NoTextures:
    """A source for what only asks what changes.

    The fallbacks of materials stand for all texels; a single texel, another for each, for pictures
    of lights.
    """

    def __init__(self) -> None:
        self._numbers: dict[TextureReference, int] = {}

    def picture(self, reference: TextureReference) -> "_core.Texture":
        """One texel."""
        from irt_usd import _core

        number = self._numbers.setdefault(reference, len(self._numbers) + 1)
        return _core.Texture([(0, 0, np.full((1, 1, 1), number, np.float32))])

    def mean(self, _reference: TextureReference) -> tuple[float, float, float]:
        """White: energies change anyhow."""
        return 1.0, 1.0, 1.0

    def sky_cells(self, reference: TextureReference) -> "_core.SkyCells":
        """Those of the one texel."""
        from irt_usd import _core

        return _core.SkyCells(self.picture(reference))

    def load(self, references: Collection[TextureReference]) -> None:
        """Nothing."""

    def texture(self, _reference: TextureReference) -> None:
        """None."""

    def wrap(
        self, _reference: TextureReference, _wrap: tuple[Wrap, Wrap]
    ) -> tuple[WrapMode, WrapMode]:
        """Any: there is nothing to wrap."""
        return "black", "black"

    def keep(self, references: Collection[TextureReference]) -> None:
        """Nothing."""


def core_material(surface: Surface, textures: TextureSource | None = None) -> "_core.Material":
    """The core's record of `surface`, with the texels that `textures` has."""
    from irt_usd import _core

    values: dict[str, Any] = {_CORE_NAMES[name]: v for name, v in surface.constants.items()}
    if "useSpecularWorkflow" in surface.constants:
        values["use_specular_workflow"] = surface.constants["useSpecularWorkflow"] != 0
    if "opacityMode" in surface.constants:
        values["opacity_is_presence"] = surface.constants["opacityMode"] == "presence"
    if surface.nodes:
        values["nodes"] = [_core_node(node, textures) for node in surface.nodes]
        values["connected"] = {_CORE_NAMES[n]: feed for n, feed in surface.connected.items()}
    return _core.Material(**values)


def _core_node(node: Node, textures: TextureSource | None) -> "_core.ShadeNode":
    from irt_usd import _core

    make = _core.ShadeNode
    if node.texture is None:
        return make(
            node.op, node.inputs, node.constants, primvar=node.primvar, swizzle=node.swizzle
        )
    texture = textures.texture(node.texture) if textures is not None else None
    if texture is None:
        return make("constant", node.inputs[1:], node.constants[1:])
    assert textures is not None
    wrap = textures.wrap(node.texture, node.wrap)
    return make(node.op, node.inputs, node.constants, texture=texture, wrap=wrap)
