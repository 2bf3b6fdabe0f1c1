# SPDX-License-Identifier: Apache-2.0
"""A material whose surface is one of MaterialX's models."""

from pxr import Usd, UsdShade

from irt_usd.materialx.document import definition_of
from irt_usd.materialx.evaluation import Evaluation, texture_reference
from irt_usd.materialx.expressions import Value as Expression
from irt_usd.materialx.expressions import constant
from irt_usd.materialx.network import Link, Network, Port, Step
from irt_usd.materialx.surfaces import MODELS
from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.graph import DEFAULTS, OTHER_DEFAULTS, Surface, TextureReference, TextureSource
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.values import Value, same_bits

_MAX_NODES = 256
"""What the core takes of a material."""

_PASSING = {"dot": ("in",), "normalize": ("in",), "mix": ("fg", "bg"), "switch": ("in1", "in2")}
"""Nodes whose output is a normal where these inputs are."""


class MaterialXSource:
    """Reads one material whose surface is `shader`, for which `is_surface`."""

    def __init__(
        self,
        path: str,
        shader: UsdShade.Shader,
        report: Report,
        colors: StageColors,
        textures: TextureSource | None,
    ) -> None:
        self.path = path
        self._report = report
        self._colors = colors
        self._texture_source = textures
        self._network = Network(report)
        definition = definition_of(str(shader.GetIdAttr().Get()))
        assert definition is not None
        self._surface = self._network.surface(shader, definition)
        self._model = MODELS[self._surface.category]
        self._state: MaterialState | None = None
        self._timed = any(step.category in ("frame", "time") for step in self._network.steps)
        self.varies = self._timed or any(p.varies for p in self._network.parameters.values())
        """Whether the material can differ between frames."""
        self.primvars = frozenset(self._find_primvars())
        """Names of the primvars that it can read."""
        self._normal = self._find_normal()
        self._report_unexpressed()

    def textures(self) -> dict[TextureReference, str]:
        """The images that it can read, and the attribute that names each, in its file."""
        found: dict[TextureReference, str] = {}
        for step in self._network.steps:
            file = step.inputs.get("file")
            if step.category == "image" and file is not None and not isinstance(file, Link):
                for name, time in file.all_values().items():
                    if name:
                        place = file.location(time)
                        found.setdefault(texture_reference(step, str(name)), place)
        return found

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        old = self._state
        if old is not None and not self.varies:
            return old
        prefix = f"{self._surface.path}.inputs:"
        attributes: dict[str, Value] = dict(self._network.links)
        attributes |= {name: p.read(time) for name, p in self._network.parameters.items()}
        if self._timed:
            attributes["frame"] = float(time.GetValue())
        attributes = {name.removeprefix(prefix): value for name, value in attributes.items()}
        if old is None or not all(
            same_bits(value, old.attributes[name]) for name, value in attributes.items()
        ):
            surface = self._evaluate(time)
            self._state = old = MaterialState(self.path, attributes, surface, self._texture_source)
        return old

    def _evaluate(self, time: Usd.TimeCode) -> Surface:
        evaluation = Evaluation(time, self._colors, self._report)
        step = self._surface

        def get(name: str) -> Expression:
            return evaluation.value(step, name)

        mapped = self._model.mapping(evaluation.expressions, get)
        present = mapped.pop("opacityMode", constant(0.0)).is_constant(1.0)
        if self._normal:
            mapped["normal"] = get(self._normal)
        constants: dict[str, Value] = {"useSpecularWorkflow": self._workflow(time)}
        if present:
            constants["opacityMode"] = "presence"
        fed: dict[str, int] = {}
        for name, value in mapped.items():
            if value.four is not None:
                constants[name] = _fitting(name, value.four)
            else:
                fed[name] = value.index
        if len(evaluation.expressions.nodes) > _MAX_NODES:
            count = len(evaluation.expressions.nodes)
            message = f"a network of {count} nodes; expected at most {_MAX_NODES}"
            self._report.skipped(f"{message}; defaults rendered in its place", step.path)
            return Surface(constants)
        nodes, places = evaluation.expressions.needed(fed.values())
        connected = {
            name: (places[index], "rgb" if _is_wide(name) else "r") for name, index in fed.items()
        }
        return Surface(constants, nodes, connected)

    def _workflow(self, time: Usd.TimeCode) -> int:
        """Which of UsdPreviewSurface's: that of its own input, else the specular one."""
        port = self._surface.inputs.get("useSpecularWorkflow")
        if port is None:
            return 1
        return 0 if isinstance(port, Link) or not port.read(time) else 1

    def _find_normal(self) -> str:
        """The input with the normal, if it has one of tangent space; others are reported."""
        name = self._model.normal
        port = self._surface.inputs.get(name)
        if port is None or name in self._surface.unset:
            return ""
        if self._surface.category == "UsdPreviewSurface":
            return name
        if isinstance(port, Link) and _is_normal_map(port):
            return name
        if isinstance(port, Link) and port.step.category == "normal":
            return ""
        if not isinstance(port, Link) and port.all_values().keys() == {(0.0, 0.0, 1.0)}:
            return ""
        if not (isinstance(port, Link) and port.step.missing):
            kind = f"{self._surface.category} {name} from other nodes than normal maps (ignored)"
            self._report.unsupported(kind, self.path)
        return ""

    def _find_primvars(self) -> set[str]:
        found: set[str] = set()
        for step in (self._surface, *self._network.steps):
            for name in step.unset.values():
                if name.startswith("UV"):
                    found.add("st" if name == "UV0" else f"st{name.removeprefix('UV')}")
            if step.category == "texcoord":
                found |= {f"st{i}" if i else "st" for i in _all_values(step.inputs["index"])}
            elif step.category == "geomcolor":
                found.add("displayColor")
            elif step.category == "geompropvalue":
                names = map(str, _all_values(step.inputs["geomprop"]))
                found |= {name.removeprefix("primvars:") for name in names if name}
        return found

    def _report_unexpressed(self) -> None:
        time = Usd.TimeCode.EarliestTime()
        evaluation = Evaluation(time, self._colors, Report())
        for name, left_out in self._model.unexpressed.items():
            if name in self._surface.unset or name not in self._surface.inputs:
                continue
            if left_out.weight and self._always(left_out.weight, evaluation, (0.0,)):
                continue
            neutral = left_out.neutral or _greys(evaluation.value(self._surface, name))
            if not self._always(name, evaluation, neutral):
                kind = f"{self._surface.category} {name} ({left_out.rendered})"
                self._report.unsupported(kind, self.path)

    def _always(self, name: str, evaluation: Evaluation, numbers: tuple[float, ...]) -> bool:
        """Whether an input has the value `numbers` at all times, all over the surface."""
        port = self._surface.inputs[name]
        if not isinstance(port, Link) and port.varies:
            return False
        return evaluation.value(self._surface, name).is_constant(*numbers)


def _is_normal_map(port: Port) -> bool:
    if not isinstance(port, Link):
        return False
    step: Step = port.step
    if step.category == "normalmap":
        return True
    if step.expanded is not None:
        return any(map(_is_normal_map, step.expanded.values()))
    return any(_is_normal_map(step.inputs[name]) for name in _PASSING.get(step.category, ()))


def _greys(value: Expression) -> tuple[float, ...]:
    """What `value` is if all its channels are as its first."""
    return (value.four[0],) if value.four is not None else (0.0,)


def _all_values(port: Port) -> list[Value]:
    return [] if isinstance(port, Link) else list(port.all_values())


def _is_wide(name: str) -> bool:
    """Whether an input of the surface is a colour or a vector."""
    return isinstance((DEFAULTS | OTHER_DEFAULTS)[name], tuple)


_LIMITS = {"ior": (1e-3, float("inf"))}
_SIGNED = ("normal",)


def _fitting(name: str, four: tuple[float, ...]) -> Value:
    """A constant as the surface's input has it, in the range of that input."""
    wide = _is_wide(name)
    low, high = _LIMITS.get(name, (0.0, float("inf") if wide else 1.0))
    if name in _SIGNED:
        return four[:3]
    numbers = tuple(min(max(number, low), high) for number in four)
    return numbers[:3] if wide else numbers[0]
