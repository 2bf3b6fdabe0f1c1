# SPDX-License-Identifier: Apache-2.0
"""What MaterialX's nodes compute, in the operations of the shading graph.

By the MaterialX specification 1.39 and, for what that leaves open, its GLSL implementation.
Nodes that the standard library itself makes of others are not here.
"""

from collections.abc import Callable

from irt_usd.materialx.compositing import COMPOSITING
from irt_usd.materialx.expressions import CHANNELS, Value, constant
from irt_usd.materialx.inputs import WIDTHS, Inputs, Made, Matrix
from irt_usd.materialx.noises import NOISES
from irt_usd.materialx.spaces import SPACES

_BINARY = {
    "add": "add",
    "subtract": "subtract",
    "multiply": "multiply",
    "divide": "divide",
    "modulo": "modulo",
    "power": "power",
    "min": "min",
    "max": "max",
    "crossproduct": "cross",
}
_UNARY = {
    "absval": "absolute",
    "sign": "sign",
    "floor": "floor",
    "ceil": "ceil",
    "round": "round",
    "sqrt": "sqrt",
    "sin": "sin",
    "cos": "cos",
    "asin": "asin",
    "acos": "acos",
    "exp": "exp",
    "ln": "log",
    "normalize": "normalize",
    "rgbtohsv": "rgb_to_hsv",
    "hsvtorgb": "hsv_to_rgb",
}
_COMPARISONS = ("ifgreater", "ifgreatereq", "ifequal")


def is_known(category: str) -> bool:
    """Whether nodes of this kind are computed here."""
    return category in _BINARY or category in _UNARY or category in _OTHERS


def outputs(category: str, node: Inputs) -> Made:
    """The value of a node, or of each of its outputs where it has several."""
    if category in _BINARY:
        return node.expressions.apply(_BINARY[category], node.value("in1"), node.value("in2"))
    if category in _UNARY:
        return node.expressions.apply(_UNARY[category], node.value("in"))
    return _OTHERS[category](node)


def _constant(node: Inputs) -> Value | Matrix:
    return node.matrix("value") if node.type.startswith("matrix") else node.value("value")


def _dot(node: Inputs) -> Value:
    return node.value("in")


def _tangent(node: Inputs) -> Value:
    ex = node.expressions
    return ex.apply("divide", ex.apply("sin", node.value("in")), ex.apply("cos", node.value("in")))


def _fraction(node: Inputs) -> Value:
    ex = node.expressions
    return ex.apply("subtract", node.value("in"), ex.apply("floor", node.value("in")))


def _magnitude(node: Inputs) -> Value:
    value = node.value("in")
    ex = node.expressions
    if _input_width(node) == 4:
        xyz = ex.apply("length", value)
        w = ex.channel(value, 3)
        return ex.apply(
            "sqrt", ex.apply("add", ex.apply("multiply", xyz, xyz), ex.apply("multiply", w, w))
        )
    return ex.apply("length", _flattened(node, value))


def _dotproduct(node: Inputs) -> Value:
    ex = node.expressions
    a, b = node.value("in1"), node.value("in2")
    if _input_width(node, "in1") == 4:
        w = ex.apply("multiply", ex.channel(a, 3), ex.channel(b, 3))
        return ex.apply("add", ex.apply("dot", a, b), w)
    return ex.apply("dot", _flattened(node, a, "in1"), b)


def _invert(node: Inputs) -> Value:
    return node.expressions.apply("subtract", node.value("amount"), node.value("in"))


def _clamp(node: Inputs) -> Value:
    values = (node.value(name) for name in ("in", "low", "high"))
    return node.expressions.apply("clamp", *values)


def _mix(node: Inputs) -> Value:
    return node.expressions.apply("mix", *(node.value(name) for name in ("bg", "fg", "mix")))


def _smoothstep(node: Inputs) -> Value:
    values = (node.value(name) for name in ("in", "low", "high"))
    return node.expressions.apply("smoothstep", *values)


def _remap(node: Inputs) -> Value:
    ex = node.expressions
    low, out_low = node.value("inlow"), node.value("outlow")
    share = ex.apply(
        "divide",
        ex.apply("subtract", node.value("in"), low),
        ex.apply("subtract", node.value("inhigh"), low),
    )
    reach = ex.apply("subtract", node.value("outhigh"), out_low)
    return ex.apply("add", out_low, ex.apply("multiply", share, reach))


def _luminance(node: Inputs) -> Value:
    ex = node.expressions
    grey = ex.apply("dot", node.value("in"), node.value("lumacoeffs"))
    if node.type == "color4":
        return ex.combine(*(grey,) * 3, ex.channel(node.value("in"), 3))
    return grey


def _compare(kind: str) -> Callable[[Inputs], Value]:
    def choose(node: Inputs) -> Value:
        a, b = node.value("value1"), node.value("value2")
        then, other = node.value("in1"), node.value("in2")
        if kind == "ifequal":
            return node.expressions.apply("if_equal", a, b, then, other)
        if kind == "ifgreatereq":
            return node.expressions.apply("if_greater", b, a, other, then)
        return node.expressions.apply("if_greater", a, b, then, other)

    return choose


def _switch(node: Inputs) -> Value:
    """The input that `which` counts to, from 1; black beyond them."""
    ex = node.expressions
    which = node.value("which")
    chosen = constant(0.0)
    for number in range(10, 0, -1):
        limit = constant(float(number))
        chosen = ex.apply("if_greater", limit, which, node.value(f"in{number}"), chosen)
    return ex.apply("if_greater", constant(0.0), which, constant(0.0), chosen)


def _extract(node: Inputs) -> Value:
    return node.expressions.channel(node.value("in"), int(node.read("index")))


def _swizzle(node: Inputs) -> Value:
    """Of version 1.38: `channels` are letters of rgba or xyzw, and 0 and 1."""
    letters = str(node.read("channels"))
    known = [
        letter if letter in "01" else "rgba"[CHANNELS[letter]]
        for letter in letters
        if letter in "01" or letter in CHANNELS
    ]
    if len(known) == 1:
        return node.expressions.swizzle(node.value("in"), known[0] * 4)
    return node.expressions.swizzle(node.value("in"), "".join([*known, *"0001"[len(known) :]])[:4])


def _combine(count: int) -> Callable[[Inputs], Value]:
    def combine(node: Inputs) -> Value:
        ex = node.expressions
        if count == 2 and node.type in ("color4", "vector4"):
            first, second = node.value("in1"), node.value("in2")
            if _input_width(node, "in2") > 1:
                parts = [ex.channel(v, i) for v in (first, second) for i in (0, 1)]
            else:
                parts = [*(ex.channel(first, i) for i in range(3)), second]
            return ex.combine(*parts)
        return ex.combine(*(node.value(f"in{i + 1}") for i in range(count)))

    return combine


def _separate(letters: str) -> Callable[[Inputs], dict[str, Value]]:
    def separate(node: Inputs) -> dict[str, Value]:
        value = node.value("in")
        parts = [node.expressions.channel(value, i) for i in range(4)]
        return {f"out{letter}": parts[CHANNELS[letter]] for letter in letters}

    return separate


def _convert(node: Inputs) -> Value:
    """Numbers fill vectors; longer vectors lose their ends, shorter ones grow by 0, alpha by 1."""
    ex = node.expressions
    value, width, wanted = node.value("in"), _input_width(node), WIDTHS.get(node.type, 1)
    if wanted == 1 and width > 1:
        return ex.channel(value, 0)
    if width == 3 and wanted == 4:
        return ex.swizzle(value, "rgb1")
    if width == 2 and wanted > 2:
        return ex.swizzle(value, "rg00" if wanted == 3 else "rg01")
    return value


def _rotate2d(node: Inputs) -> Value:
    """By degrees, clockwise where y is up."""
    ex = node.expressions
    turn = ex.apply("multiply", node.value("amount"), constant(-1.0))
    return ex.apply(
        "transform2d", node.value("in"), constant(1.0), turn, constant(0.0, 0.0, 0.0, 0.0)
    )


def _premult(op: str) -> Callable[[Inputs], Value]:
    def premult(node: Inputs) -> Value:
        ex = node.expressions
        value = node.value("in")
        alpha = ex.channel(value, 3)
        return ex.apply(op, value, ex.swizzle(alpha, "rrr1"))

    return premult


def _ramp(letter: str, first: str, last: str) -> Callable[[Inputs], Value]:
    def ramp(node: Inputs) -> Value:
        ex = node.expressions
        along = ex.channel(node.value("texcoord"), CHANNELS[letter])
        share = ex.apply("clamp", along, constant(0.0), constant(1.0))
        return ex.apply("mix", node.value(first), node.value(last), share)

    return ramp


def _split(letter: str, first: str, last: str) -> Callable[[Inputs], Value]:
    """A hard edge; the specification smooths it over a pixel."""

    def split(node: Inputs) -> Value:
        ex = node.expressions
        along = ex.channel(node.value("texcoord"), CHANNELS[letter])
        center = node.value("center")
        return ex.apply("if_greater", center, along, node.value(first), node.value(last))

    return split


def _logic(node: Inputs, kind: str) -> Value:
    ex = node.expressions
    a = node.value("in1" if kind != "not" else "in")
    if kind == "not":
        return ex.apply("subtract", constant(1.0), a)
    return ex.apply("min" if kind == "and" else "max", a, node.value("in2"))


def _blend(kind: str) -> Callable[[Inputs], Value]:
    """Of foreground and background, mixed by `mix` with the background."""

    def blend(node: Inputs) -> Value:
        ex = node.expressions
        fg, bg = node.value("fg"), node.value("bg")
        if kind == "plus":
            both = ex.apply("add", bg, fg)
        elif kind == "minus":
            both = ex.apply("subtract", bg, fg)
        elif kind == "difference":
            both = ex.apply("absolute", ex.apply("subtract", bg, fg))
        else:
            dark = (ex.apply("subtract", constant(1.0), value) for value in (fg, bg))
            both = ex.apply("subtract", constant(1.0), ex.apply("multiply", *dark))
        return ex.apply("mix", bg, both, node.value("mix"))

    return blend


def _texcoord(node: Inputs) -> Value:
    index = int(node.read("index"))
    return node.expressions.primvar(f"st{index}" if index else "st", constant(0.0))


def _geomcolor(node: Inputs) -> Value:
    return _of_width(node, node.expressions.primvar("displayColor", constant(0.0)))


def _geompropvalue(node: Inputs) -> Value:
    name = str(node.read("geomprop")).removeprefix("primvars:")
    fallback = node.value("default")
    return _of_width(node, node.expressions.primvar(name, fallback)) if name else fallback


def _normalmap(node: Inputs) -> Value:
    """Of tangent space: what the surface's normal takes."""
    ex = node.expressions
    doubled = ex.apply("multiply", node.value("in"), constant(2.0))
    unit = ex.apply("subtract", doubled, constant(1.0))
    scale = node.value("scale")
    if scale.is_constant(1.0):
        return unit
    return ex.apply("multiply", unit, ex.swizzle(scale, "rg11"))


def _of_width(node: Inputs, value: Value) -> Value:
    return value if node.type in WIDTHS else node.expressions.channel(value, 0)


def _input_width(node: Inputs, name: str = "in") -> int:
    return WIDTHS.get(node.input_type(name), 1)


def _flattened(node: Inputs, value: Value, name: str = "in") -> Value:
    """A vector of two, its third component 0."""
    return node.expressions.swizzle(value, "rg00") if _input_width(node, name) == 2 else value


def _arc_tangent(node: Inputs) -> Value:
    return node.expressions.apply("atan2", node.value("iny"), node.value("inx"))


def _seconds(node: Inputs) -> Value:
    rate = float(node.read("fps"))
    return constant(node.frame() / rate if rate else 0.0)


_OTHERS: dict[str, Callable[[Inputs], Made]] = {
    "constant": _constant,
    "dot": _dot,
    "tan": _tangent,
    "atan2": _arc_tangent,
    "frame": lambda node: constant(node.frame()),
    "time": _seconds,
    "fract": _fraction,
    "magnitude": _magnitude,
    "dotproduct": _dotproduct,
    "invert": _invert,
    "clamp": _clamp,
    "mix": _mix,
    "smoothstep": _smoothstep,
    "remap": _remap,
    "luminance": _luminance,
    "switch": _switch,
    "extract": _extract,
    "swizzle": _swizzle,
    "convert": _convert,
    "rotate2d": _rotate2d,
    "premult": _premult("multiply"),
    "unpremult": _premult("divide"),
    "ramplr": _ramp("x", "valuel", "valuer"),
    "ramptb": _ramp("y", "valueb", "valuet"),
    "splitlr": _split("x", "valuel", "valuer"),
    "splittb": _split("y", "valueb", "valuet"),
    "and": lambda node: _logic(node, "and"),
    "or": lambda node: _logic(node, "or"),
    "not": lambda node: _logic(node, "not"),
    "texcoord": _texcoord,
    "geomcolor": _geomcolor,
    "geompropvalue": _geompropvalue,
    "normalmap": _normalmap,
    "image": lambda node: node.image(),
    **{kind: _compare(kind) for kind in _COMPARISONS},
    **{f"combine{n}": _combine(n) for n in (2, 3, 4)},
    "separate2": _separate("xy"),
    "separate3": _separate("rgbxyz"),
    "separate4": _separate("rgbaxyzw"),
    **{kind: _blend(kind) for kind in ("plus", "minus", "difference", "screen")},
    **COMPOSITING,
    **NOISES,
    **SPACES,
}
