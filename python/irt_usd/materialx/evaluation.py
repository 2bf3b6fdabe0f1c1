# SPDX-License-Identifier: Apache-2.0
"""A network at one time, as expressions."""

from typing import Any

from pxr import Usd, UsdShade

from irt_usd.materialx.expressions import Expressions, Value, constant
from irt_usd.materialx.inputs import Made, Matrix
from irt_usd.materialx.network import Link, Port, Step
from irt_usd.materialx.operations import outputs
from irt_usd.materialx.spaces import geometry
from irt_usd.report import Report
from irt_usd.stage.color import StageColors, color_space_of
from irt_usd.stage.graph import TextureReference, Wrap

_WRAPS: dict[str, Wrap] = {
    "constant": "black",
    "black": "black",
    "clamp": "clamp",
    "periodic": "repeat",
    "repeat": "repeat",
    "mirror": "mirror",
}
_GEOMETRY = {"P": "position", "N": "normal", "V": "view"}
"""What the first letter of a geometric property's name stands for; the rest is its space."""
_COLORS = ("color3", "color4")
_CHANNELS = {"float": "rrrr", "vector2": "rg01"}


class Evaluation:
    """Makes the values that a surface asks for."""

    def __init__(self, time: Usd.TimeCode, colors: StageColors, report: Report) -> None:
        self.expressions = Expressions()
        self._time = time
        self._colors = colors
        self._report = report
        self._made: dict[Step, Made] = {}

    def value(self, step: Step, name: str) -> Value:
        """An input of `step`."""
        port = step.inputs[name]
        if isinstance(port, Link):
            return self._output(port)
        if name in step.unset:
            return self._geometry(step.unset[name], step.path)
        read = port.read(self._time)
        kind = _input_type(step, name)
        if kind in _COLORS and isinstance(read, tuple):
            conversion = self._colors.to_rendering(port.attribute)
            if conversion is not None:
                read = (*conversion.color(read[:3]), *read[3:])
        return _constant(read)

    def read(self, step: Step, name: str) -> Any:
        """An input of `step` that has to be a constant; its default where it is none."""
        port = step.inputs[name]
        if isinstance(port, Link):
            message = f"{step.category}'s {name} connected to a shader (its default rendered)"
            self._report.unsupported(message, step.path)
            declared = step.definition.getActiveInput(name)
            return declared.getValue() if declared.hasValueString() else ""
        return port.read(self._time)

    def matrix(self, step: Step, name: str) -> Matrix:
        """An input of `step`, a matrix."""
        port = step.inputs[name]
        if not isinstance(port, Link):
            rows: Any = port.read(self._time)
            return Matrix(tuple(_constant(tuple(row)) for row in rows))
        made = self._made_by(port.step)
        return made if isinstance(made, Matrix) else self._no_matrix(step, name)

    def _no_matrix(self, step: Step, name: str) -> Matrix:
        declared = step.definition.getActiveInput(name)
        side = 3 if declared.getType() == "matrix33" else 4
        return Matrix(tuple(constant(*(float(i == k) for k in range(side))) for i in range(side)))

    @property
    def frame(self) -> float:
        """The frame that is rendered."""
        return 0.0 if self._time.IsEarliestTime() else float(self._time.GetValue())

    def _made_by(self, step: Step) -> Made:
        if step not in self._made:
            self._made[step] = self._outputs(step)
        return self._made[step]

    def _output(self, link: Link) -> Value:
        made = self._made_by(link.step)
        if isinstance(made, Matrix):
            return constant(0.0)
        if isinstance(made, dict):
            return made.get(link.output) or next(iter(made.values()))
        return made

    def _outputs(self, step: Step) -> Made:
        if step.missing:
            return self._default(step)
        if step.expanded is not None:
            return {name: self._port(port) for name, port in step.expanded.items()}
        return outputs(step.category, _StepInputs(self, step))

    def _default(self, step: Step) -> Value:
        """What the definition says a node is where it cannot be computed."""
        output = step.definition.getActiveOutputs()[0]
        passed = output.getAttribute("defaultinput")
        if passed in step.inputs:
            return self.value(step, passed)
        return constant(0.0)

    def _port(self, port: Port) -> Value:
        return self._output(port) if isinstance(port, Link) else _constant(port.read(self._time))

    def _geometry(self, name: str, path: str) -> Value:
        """What the geometry gives to inputs without a value."""
        if name.startswith("UV"):
            index = name.removeprefix("UV")
            return self.expressions.primvar("st" if index == "0" else f"st{index}", constant(0.0))
        kind = _GEOMETRY.get(name[:1])
        if kind is not None:
            return geometry(self.expressions, kind, name[1:])
        self._report.unsupported(f"MaterialX's {name} of the geometry (0 rendered)", path)
        return constant(0.0)

    def image(self, step: Step) -> Value:
        """The texture of an image node, filtered."""
        missing = self.value(step, "default")
        file = str(self.read(step, "file") or "")
        if not file:
            self._report.mentioned("image without a file, its default rendered", step.path)
            return missing
        wrap = tuple(self._wrap(step, name) for name in ("uaddressmode", "vaddressmode"))
        texel = self.expressions.texture(
            texture_reference(step, file), self.value(step, "texcoord"), missing, (wrap[0], wrap[1])
        )
        return self.expressions.swizzle(texel, _CHANNELS.get(step.type, "rgba"))

    def _wrap(self, step: Step, name: str) -> Wrap:
        mode = str(self.read(step, name))
        if mode not in _WRAPS:
            message = f"{name} is {mode}; expected {', '.join(_WRAPS)}; periodic is rendered"
            self._report.skipped(message, step.path)
        return _WRAPS.get(mode, "repeat")


def texture_reference(step: Step, file: str) -> TextureReference:
    """The image of a node: colours by the colour space of its file, other types as they are."""
    port = step.inputs["file"]
    attribute = None if isinstance(port, Link) else port.attribute
    space = "raw"
    if step.type in _COLORS and attribute is not None:
        space = color_space_of(attribute) or "raw"
    return TextureReference(file, space, UsdShade.UdimUtils.IsUdimIdentifier(file))


class _StepInputs:
    """The inputs of one node, as operations ask for them."""

    def __init__(self, evaluation: Evaluation, step: Step) -> None:
        self.expressions = evaluation.expressions
        self.type = step.type
        self._evaluation = evaluation
        self._step = step

    def value(self, name: str) -> Value:
        return self._evaluation.value(self._step, name)

    def read(self, name: str) -> Any:
        return self._evaluation.read(self._step, name)

    def matrix(self, name: str) -> Matrix:
        return self._evaluation.matrix(self._step, name)

    def frame(self) -> float:
        return self._evaluation.frame

    def input_type(self, name: str) -> str:
        return _input_type(self._step, name)

    def image(self) -> Value:
        return self._evaluation.image(self._step)


def _input_type(step: Step, name: str) -> str:
    return str(step.definition.getActiveInput(name).getType())


def _constant(value: Any) -> Value:
    if isinstance(value, tuple):
        return constant(*map(float, value))
    return constant(float(value)) if isinstance(value, (bool, int, float)) else constant(0.0)
