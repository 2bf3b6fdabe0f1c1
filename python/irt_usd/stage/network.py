# SPDX-License-Identifier: Apache-2.0
"""A network of UsdPreviewSurface's nodes, and the graph that it is at a time.

UsdUVTexture, UsdPrimvarReader_* and UsdTransform2d, by UsdPreviewSurface's specification 2.6.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, cast

from pxr import Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.connections import Source, source_of
from irt_usd.stage.graph import Constant, Node, TextureReference, Wrap
from irt_usd.stage.parameters import Parameter
from irt_usd.stage.values import Value

TEXTURE = "UsdUVTexture"
TRANSFORM = "UsdTransform2d"
_READER = "UsdPrimvarReader_"

_TEXTURE_INPUTS: dict[str, Value] = {
    "file": "",
    "st": (0.0, 0.0),
    "wrapS": "useMetadata",
    "wrapT": "useMetadata",
    "fallback": (0.0, 0.0, 0.0, 1.0),
    "scale": (1.0, 1.0, 1.0, 1.0),
    "bias": (0.0, 0.0, 0.0, 0.0),
    "sourceColorSpace": "auto",
}
_TRANSFORM_INPUTS: dict[str, Value] = {
    "in": (0.0, 0.0),
    "scale": (1.0, 1.0),
    "rotation": 0.0,
    "translation": (0.0, 0.0),
}
_READER_FALLBACKS: dict[str, Value] = {
    "float": 0.0,
    "int": 0,
    "float2": (0.0, 0.0),
    "float3": (0.0, 0.0, 0.0),
    "float4": (0.0, 0.0, 0.0, 0.0),
    "normal": (0.0, 0.0, 0.0),
    "point": (0.0, 0.0, 0.0),
    "vector": (0.0, 0.0, 0.0),
}
"""The types whose values can reach a surface; strings and matrices have no input to go to."""

_WRAPS = ("black", "clamp", "repeat", "mirror", "useMetadata")
_TOKENS = {"wrapS": _WRAPS, "wrapT": _WRAPS}

Feed = tuple[int, str]
"""A node and which of its values: "rgb" or one of "r", "g", "b", "a"."""


@dataclass(eq=False, slots=True)
class Shader:
    """A shader that the network has: its parameters and the shaders that feed it, by input."""

    path: str
    kind: str
    parameters: dict[str, Parameter] = field(default_factory=dict)
    links: dict[str, "Link"] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class Link:
    """A connection to a shader's output."""

    shader: Shader
    output: str
    text: str


class Network:
    """The shaders behind the inputs of one surface."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._shaders: dict[str, Shader | None] = {}
        self._open: list[str] = []
        """Shaders whose inputs are being followed, from the surface upstream."""

    def link(self, source: Source, place: Usd.Attribute) -> Link | None:
        """The connection from `source`; None, and reported, where it feeds nothing."""
        assert source.shader is not None
        path = str(source.shader.GetPath())
        if path in self._open:
            self._report.skipped("a connection that leads back to itself", _location(place))
            return None
        if path not in self._shaders:
            self._open.append(path)
            self._shaders[path] = self._follow(source.shader, path, place)
            self._open.pop()
        shader = self._shaders[path]
        return Link(shader, source.output, source.text) if shader is not None else None

    @property
    def parameters(self) -> Iterator[tuple[str, Parameter]]:
        """All values, by the USD path of the input that they are for."""
        for shader in self._used():
            for name, parameter in shader.parameters.items():
                yield f"{shader.path}.inputs:{name}", parameter

    @property
    def links(self) -> Iterator[tuple[str, str]]:
        """All connections between shaders, by the USD path of the input, as texts."""
        for shader in self._used():
            for name, link in shader.links.items():
                yield f"{shader.path}.inputs:{name}", link.text

    @property
    def primvars(self) -> frozenset[str]:
        """Names of the primvars that are read at any time."""
        names = (
            value
            for shader in self._used()
            if shader.kind.startswith(_READER)
            for value in shader.parameters["varname"].all_values()
        )
        return frozenset(str(name) for name in names if name)

    def textures(self) -> dict[TextureReference, str]:
        """The images that are read at any time, and the attribute that names each, in its file."""
        found: dict[TextureReference, str] = {}
        for shader in self._used():
            if shader.kind != TEXTURE:
                continue
            file, space = shader.parameters["file"], shader.parameters["sourceColorSpace"]
            for path, time in file.all_values().items():
                for color_space in space.all_values():
                    if path:
                        reference = _reference(shader, str(path), str(color_space))
                        found.setdefault(reference, file.location(time))
        return found

    def _used(self) -> Iterator[Shader]:
        return (shader for shader in self._shaders.values() if shader is not None)

    def _follow(self, prim: UsdShade.Shader, path: str, place: Usd.Attribute) -> Shader | None:
        kind = str(prim.GetIdAttr().Get() or "")
        inputs = inputs_of(kind)
        if inputs is None:
            named = f"shader node {kind}" if kind else "shader node without an info:id"
            kind_and_use = f"{named} (its fallback or the input's default rendered)"
            self._report.unsupported(kind_and_use, _location(place))
            fallback = prim.GetInput("fallback")
            source = source_of(fallback, self._report) if fallback else Source()
            if source.attribute is None:
                return None
            value = Parameter("fallback", source.attribute, None, self._report)
            return Shader(path, "", {"fallback": value})
        shader = Shader(path, kind)
        for name, default in inputs.items():
            port = prim.GetInput(name)
            source = source_of(port, self._report) if port else Source()
            if source.shader is not None:
                if isinstance(default, str):
                    message = f"{name} connected to a shader (its default rendered)"
                    self._report.unsupported(message, _location(port.GetAttr()))
                else:
                    link = self.link(source, port.GetAttr())
                    if link is not None:
                        shader.links[name] = link
                        continue
            shader.parameters[name] = Parameter(
                name, source.attribute, default, self._report, allowed=_TOKENS.get(name, ())
            )
        return shader


def inputs_of(kind: str) -> dict[str, Value] | None:
    """A shader's inputs and their defaults; None if it is not of those known."""
    if kind == TEXTURE:
        return _TEXTURE_INPUTS
    if kind == TRANSFORM:
        return _TRANSFORM_INPUTS
    fallback = _READER_FALLBACKS.get(kind.removeprefix(_READER))
    if kind.startswith(_READER) and fallback is not None:
        return {"varname": "", "fallback": fallback}
    return None


class GraphBuilder:
    """Makes the nodes of a network at one time, of those shaders alone that are asked for."""

    def __init__(self, time: Usd.TimeCode, report: Report) -> None:
        self.nodes: list[Node] = []
        self._time = time
        self._report = report
        self._made: dict[Shader, int] = {}

    def feed(self, link: Link) -> Feed:
        """The node that `link` comes from, and which of its values it is."""
        shader = link.shader
        if shader not in self._made:
            if shader.kind == TEXTURE:
                self._made[shader] = self._texture(shader)
            elif shader.kind == TRANSFORM:
                self._made[shader] = self._transform(shader)
            elif shader.kind:
                self._made[shader] = self._primvar(shader)
            else:
                fallback = _constant(shader.parameters["fallback"].read(self._time))
                self._made[shader] = self._add(Node("constant", constants=(fallback,)))
        return self._made[shader], _channel(link)

    def _add(self, node: Node) -> int:
        self.nodes.append(node)
        return len(self.nodes) - 1

    def _value(self, shader: Shader, name: str) -> Any:
        return shader.parameters[name].read(self._time)

    def _slot(self, shader: Shader, name: str) -> tuple[int, Constant]:
        """The node that feeds an input, -1 if none does, and its constant."""
        if name not in shader.links:
            return -1, _constant(self._value(shader, name))
        index, channel = self.feed(shader.links[name])
        if channel != "rgb":
            index = self._add(Node("swizzle", (index,), swizzle=channel * 4))
        return index, 0.0

    def _texture(self, shader: Shader) -> int:
        (scaled, scale), (biased, bias) = self._slot(shader, "scale"), self._slot(shader, "bias")
        missing, fallback = self._slot(shader, "fallback")
        file = self._value(shader, "file")
        if not file:
            self._report.mentioned("texture without a file, its fallback rendered", shader.path)
            return missing if missing >= 0 else self._add(Node("constant", constants=(fallback,)))
        st, constant_st = self._slot(shader, "st")
        if scaled < 0 and biased < 0 and missing < 0:
            fallback = _before(fallback, scale, bias)
        space = str(self._value(shader, "sourceColorSpace"))
        wrap = self._value(shader, "wrapS"), self._value(shader, "wrapT")
        index = self._add(
            Node(
                "texture",
                (st, missing),
                (constant_st, fallback),
                texture=_reference(shader, file, space),
                wrap=cast("tuple[Wrap, Wrap]", wrap),
            )
        )
        if scaled >= 0 or scale != (1.0, 1.0, 1.0, 1.0):
            index = self._add(Node("multiply", (index, scaled), (0.0, scale)))
        if biased >= 0 or bias != (0.0, 0.0, 0.0, 0.0):
            index = self._add(Node("add", (index, biased), (0.0, bias)))
        return index

    def _transform(self, shader: Shader) -> int:
        slots = [self._slot(shader, name) for name in ("in", "scale", "rotation", "translation")]
        return self._add(
            Node(
                "transform2d", tuple(i for i, _ in slots), tuple(constant for _, constant in slots)
            )
        )

    def _primvar(self, shader: Shader) -> int:
        name = self._value(shader, "varname").removeprefix("primvars:")
        index, fallback = self._slot(shader, "fallback")
        if not name:
            self._report.mentioned("primvar reader without a varname, its fallback", shader.path)
            return index if index >= 0 else self._add(Node("constant", constants=(fallback,)))
        return self._add(Node("primvar", (index,), (fallback,), primvar=name))


def _reference(shader: Shader, file: str, color_space: str) -> TextureReference:
    """By the attribute's own colour space where the shader says nothing, or "auto"."""
    attribute = shader.parameters["file"].attribute
    if color_space == "auto" and attribute is not None and attribute.HasColorSpace():
        color_space = str(attribute.GetColorSpace())
    return TextureReference(file, color_space, UsdShade.UdimUtils.IsUdimIdentifier(file))


def _channel(link: Link) -> str:
    """Which of a node's values an output is."""
    kind, output = link.shader.kind, link.output
    if kind == TEXTURE:
        return output if output in ("r", "g", "b", "a") else "rgb"
    if kind in (f"{_READER}float", f"{_READER}int"):
        return "r"
    return "rgb"


def _constant(value: Any) -> Constant:
    if isinstance(value, tuple):
        return tuple(map(float, value))
    return float(value) if isinstance(value, (int, float)) else 0.0


def _before(fallback: Constant, scale: Constant, bias: Constant) -> Constant:
    """What scale and bias turn into `fallback`: they are of the texture alone."""
    values = zip(*(cast("tuple[float, ...]", v) for v in (fallback, scale, bias)), strict=True)
    return tuple((f - b) / s if s != 0.0 else f for f, s, b in values)


def _location(attribute: Usd.Attribute) -> str:
    return where(attribute.GetPrim(), attribute.GetName(), Usd.TimeCode.Default())
