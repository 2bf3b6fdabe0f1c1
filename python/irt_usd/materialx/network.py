# SPDX-License-Identifier: Apache-2.0
"""A network of MaterialX nodes: what is connected to what, and the parameters it all depends on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Union

import MaterialX as mx  # noqa: N813
from pxr import Usd, UsdShade

from irt_usd.materialx.document import definition_of
from irt_usd.materialx.operations import is_known
from irt_usd.materialx.values import usd_value
from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.connections import Source, source_of
from irt_usd.stage.parameters import Parameter
from irt_usd.stage.values import Value, plain

_NUMBERS = {"float": 1, "integer": 1, "boolean": 1, "color3": 3, "vector3": 3, "vector2": 2}
_NUMBERS |= {"color4": 4, "vector4": 4}


class Fixed:
    """A value that a definition gives."""

    attribute: Usd.Attribute | None = None
    varies = False

    def __init__(self, value: Value) -> None:
        self._value = value

    def read(self, _time: Usd.TimeCode) -> Value:
        """The value."""
        return self._value

    def all_values(self) -> dict[Value, Usd.TimeCode]:
        """The value, at any time."""
        return {self._value: Usd.TimeCode.EarliestTime()}

    def location(self, _time: Usd.TimeCode) -> str:
        """Nothing: it is in no layer."""
        return ""


@dataclass(eq=False, slots=True)
class Step:
    """A node: its definition, and its inputs, all those that the definition has.

    `unset`: inputs without a value, which the geometry gives (UV0, Nworld, ...).
    `expanded`: what its outputs are, where it stands for a graph of others. `missing`: it cannot be
    computed, and its definition's default takes its place.
    """

    path: str
    definition: mx.NodeDef
    inputs: dict[str, "Port"] = field(default_factory=dict)
    unset: dict[str, str] = field(default_factory=dict)
    expanded: dict[str, "Port"] | None = None
    missing: bool = False

    @property
    def category(self) -> str:
        """What kind of node it is, such as "multiply"."""
        return str(self.definition.getNodeString())

    @property
    def type(self) -> str:
        """The MaterialX type of its first output."""
        return str(self.definition.getActiveOutputs()[0].getType())


@dataclass(frozen=True, eq=False, slots=True)
class Link:
    """A connection to a node's output."""

    step: Step
    output: str
    text: str


Port = Union[Parameter, Fixed, Link]  # noqa: UP007 (a forward reference)


class Network:
    """The nodes behind the inputs of one surface shader."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._steps: dict[str, Step | None] = {}
        self._open: list[str] = []
        self.parameters: dict[str, Parameter] = {}
        """All values, by the USD path of the input that they are for."""
        self.links: dict[str, str] = {}
        """All connections between shaders, by the USD path of the input, as texts."""

    def surface(self, shader: UsdShade.Shader, definition: mx.NodeDef) -> Step:
        """The surface shader with all that feeds it."""
        self._open.append(str(shader.GetPath()))
        return self._step(shader, definition)

    @property
    def steps(self) -> Iterator[Step]:
        """The nodes that feed the surface, those of expanded ones too."""
        waiting = [step for step in self._steps.values() if step is not None]
        seen: set[int] = set()
        while waiting:
            step = waiting.pop()
            if id(step) in seen:
                continue
            seen.add(id(step))
            yield step
            ports = [*step.inputs.values(), *(step.expanded or {}).values()]
            waiting += [port.step for port in ports if isinstance(port, Link)]

    def _step(self, shader: UsdShade.Shader, definition: mx.NodeDef) -> Step:
        step = Step(str(shader.GetPath()), definition)
        for declared in definition.getActiveInputs():
            name = declared.getName()
            port = shader.GetInput(name)
            source = source_of(port, self._report) if port else Source()
            if source.shader is not None:
                link = self._link(source, port.GetAttr())
                if link is not None:
                    self.links[f"{step.path}.inputs:{name}"] = link.text
                    step.inputs[name] = link
                    continue
            default = _default(declared)
            if source.attribute is None and declared.hasDefaultGeomPropString():
                step.unset[name] = declared.getDefaultGeomPropString()
            step.inputs[name] = parameter = Parameter(name, source.attribute, default, self._report)
            self.parameters[f"{step.path}.inputs:{name}"] = parameter
        return step

    def _link(self, source: Source, place: Usd.Attribute) -> Link | None:
        assert source.shader is not None
        path = str(source.shader.GetPath())
        if path in self._open:
            self._report.skipped("a connection that leads back to itself", _location(place))
            return None
        if path not in self._steps:
            identifier = str(source.shader.GetIdAttr().Get() or "")
            definition = definition_of(identifier)
            if definition is None:
                named = identifier or "without an info:id"
                kind = f"shader node {named} (the input's default rendered)"
                self._report.unsupported(kind, _location(place))
                self._steps[path] = None
            else:
                self._open.append(path)
                step = self._steps[path] = self._step(source.shader, definition)
                self._open.pop()
                self._expand(step)
        found = self._steps[path]
        return Link(found, source.output, source.text) if found is not None else None

    def _expand(self, step: Step) -> None:
        """Puts a graph in the place of a node that is made of others."""
        if is_known(step.category):
            return
        step.missing = not expand(step)
        if step.missing:
            step.expanded = None
            kind = f"MaterialX node {step.category} (its default rendered)"
            self._report.unsupported(kind, step.path)


class _Expansion:
    """The nodes of a definition's graph, its interface those inputs that `outer` has."""

    def __init__(self, outer: Step, graph: mx.NodeGraph) -> None:
        self._outer = outer
        self._graph = graph
        self._made: dict[str, Step] = {}
        self.unknown = False
        """Whether it has nodes that nothing is known of."""

    def port(self, element: mx.PortElement, default: Fixed) -> Port:
        """What `element` of the graph is fed by."""
        if element.getNodeName():
            step = self._step(self._graph.getNode(element.getNodeName()))
            return Link(step, element.getOutputString(), "")
        if element.hasInterfaceName():
            return self._outer.inputs.get(element.getInterfaceName(), default)
        if element.hasValueString():
            return Fixed(plain(usd_value(element.getValueString(), element.getType())))
        return default

    def _step(self, node: mx.Node) -> Step:
        name = node.getName()
        if name in self._made:
            return self._made[name]
        definition = node.getNodeDef()
        step = self._made[name] = Step(f"{self._outer.path}/{name}", definition)
        given: Mapping[str, mx.Input] = {i.getName(): i for i in node.getInputs()}
        for declared in definition.getActiveInputs():
            key, default = declared.getName(), Fixed(_default(declared))
            step.inputs[key] = self.port(given[key], default) if key in given else default
            interface = given[key].getInterfaceName() if key in given else ""
            if interface in self._outer.unset:
                step.unset[key] = self._outer.unset[interface]
            elif key not in given and declared.hasDefaultGeomPropString():
                step.unset[key] = declared.getDefaultGeomPropString()
        if not is_known(step.category) and not expand(step):
            self.unknown = True
        return step


def expand(step: Step) -> bool:
    """Puts its definition's graph in the place of `step`; whether all of it can be computed."""
    graph = step.definition.getImplementation()
    if not isinstance(graph, mx.NodeGraph):
        return False
    inner = _Expansion(step, graph)
    step.expanded = {o.getName(): inner.port(o, Fixed(0.0)) for o in graph.getOutputs()}
    return not inner.unknown


def _default(declared: mx.Input) -> Value:
    """A definition's default for an input, by its type where it has none."""
    kind = str(declared.getType())
    if declared.hasValueString():
        value = plain(usd_value(declared.getValueString(), kind))
        if value is not None:
            return "" if kind == "filename" else value
    if kind in _NUMBERS:
        zero = 0 if kind in ("integer", "boolean") else 0.0
        return zero if _NUMBERS[kind] == 1 else (0.0,) * _NUMBERS[kind]
    return ""


def _location(attribute: Usd.Attribute) -> str:
    return where(attribute.GetPrim(), attribute.GetName(), Usd.TimeCode.Default())
