# SPDX-License-Identifier: Apache-2.0
"""UsdPreviewSurface and the network behind its inputs."""

from pxr import Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.connections import Source, source_of
from irt_usd.stage.graph import DEFAULTS, Surface, TextureReference, TextureSource
from irt_usd.stage.network import Feed, GraphBuilder, Link, Network
from irt_usd.stage.parameters import ANY, Parameter, Range
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.values import Value, same_bits

_POSITIVE: Range = (0.0, float("inf"))
_SHARE: Range = (0.0, 1.0)

_RANGES: dict[str, Range] = {
    "diffuseColor": _POSITIVE,
    "emissiveColor": _POSITIVE,
    "specularColor": _POSITIVE,
    "metallic": _SHARE,
    "roughness": _SHARE,
    "clearcoat": _SHARE,
    "clearcoatRoughness": _SHARE,
    "opacity": _SHARE,
    "opacityThreshold": _SHARE,
    "ior": (1e-3, float("inf")),
}
"""What a value is clamped to, and said to have been. Mirrors what the specification allows."""

_COLORS = ("diffuseColor", "emissiveColor", "specularColor")
_VECTORS = frozenset((*_COLORS, "normal"))

_SWITCHES = ("useSpecularWorkflow", "opacityMode")
"""Inputs that are constant over a surface."""

_TOKENS = {"opacityMode": ("transparent", "presence")}

_NOT_RENDERED: dict[str, Value] = {"displacement": 0.0}
"""Inputs that are reported where they are not at their defaults. (`occlusion` is for renderers
that find none themselves.)"""

MAX_NODES = 256
"""What the core takes of a material."""


class MaterialSource:
    """Reads one material whose surface is `shader`, a UsdPreviewSurface."""

    def __init__(
        self,
        path: str,
        shader: UsdShade.Shader,
        report: Report,
        colors: StageColors,
        textures: TextureSource,
    ) -> None:
        self.path = path
        self._report = report
        self._textures = textures
        self._network = Network(report)
        self._parameters: dict[str, Parameter] = {}
        self._links: dict[str, Link] = {}
        self._shader_path = str(shader.GetPath())
        for name in DEFAULTS:
            self._follow(shader, name)
        self._matrices = {
            name: colors.to_rendering(parameter.attribute)
            for name, parameter in self._parameters.items()
            if name in _COLORS
        }
        self._state: MaterialState | None = None
        self.varies = any(p.varies for p in self._all_parameters())
        """Whether the material can differ between frames."""
        self.primvars = self._network.primvars
        """Names of the primvars that it can read."""
        self._report_unused(shader)

    def textures(self) -> dict[TextureReference, str]:
        """The images that it can read, and the attribute that names each, in its file."""
        return self._network.textures()

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        old = self._state
        if old is not None and not self.varies:
            return old
        inputs = {name: p.read(time) for name, p in self._parameters.items()}
        attributes: dict[str, Value] = {
            name: inputs[name] if name in inputs else self._links[name].text for name in DEFAULTS
        }
        attributes |= {name: p.read(time) for name, p in self._network.parameters}
        attributes |= dict(self._network.links)
        if old is None or not all(
            same_bits(value, old.attributes[name]) for name, value in attributes.items()
        ):
            surface = self._surface(inputs, time)
            self._state = old = MaterialState(self.path, attributes, surface, self._textures)
        return old

    def _surface(self, inputs: dict[str, Value], time: Usd.TimeCode) -> Surface:
        constants = {n: v for n, v in inputs.items() if not same_bits(v, DEFAULTS[n])}
        for name, matrix in self._matrices.items():
            if matrix is not None:
                constants[name] = matrix.color(inputs[name])  # type: ignore[arg-type]
        builder = GraphBuilder(time, self._report)
        connected = {name: _fitting(name, builder.feed(link)) for name, link in self._links.items()}
        if len(builder.nodes) > MAX_NODES:
            message = f"a network of {len(builder.nodes)} nodes; expected at most {MAX_NODES}"
            self._report.skipped(f"{message}; defaults rendered in its place", self._shader_path)
            return Surface(constants)
        return Surface(constants, tuple(builder.nodes), connected)

    def _follow(self, shader: UsdShade.Shader, name: str) -> None:
        port = shader.GetInput(name)
        source = source_of(port, self._report) if port else Source()
        if source.shader is not None:
            if name in _SWITCHES:
                message = f"{name} connected to a shader (its default rendered)"
                self._report.unsupported(message, f"{self._shader_path}.inputs:{name}")
            else:
                link = self._network.link(source, port.GetAttr())
                if link is not None:
                    self._links[name] = link
                    return
        bounds, allowed = _RANGES.get(name, ANY), _TOKENS.get(name, ())
        self._parameters[name] = Parameter(
            name, source.attribute, DEFAULTS[name], self._report, bounds, allowed
        )

    def _all_parameters(self) -> list[Parameter]:
        return [*self._parameters.values(), *(p for _, p in self._network.parameters)]

    def _report_unused(self, shader: UsdShade.Shader) -> None:
        for name, default in _NOT_RENDERED.items():
            port = shader.GetInput(name)
            source = source_of(port, self._report) if port else Source()
            unused = Parameter(name, source.attribute, default, self._report)
            if (
                source.shader is not None
                or unused.varies
                or not same_bits(unused.read(Usd.TimeCode.EarliestTime()), default)
            ):
                self._report.unsupported(f"UsdPreviewSurface {name}", self.path)


def _fitting(name: str, feed: Feed) -> Feed:
    """A number takes the first of several values."""
    index, channel = feed
    return (index, "r") if channel == "rgb" and name not in _VECTORS else feed
