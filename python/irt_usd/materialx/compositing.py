# SPDX-License-Identifier: Apache-2.0
"""MaterialX's compositing nodes, as its GLSL implementation has them."""

from collections.abc import Callable

from irt_usd.materialx.expressions import Expressions, Value, constant
from irt_usd.materialx.inputs import Inputs

_ONE, _ZERO = constant(1.0), constant(0.0)
_LEAST = constant(1e-6)
"""What counts as 0 below a fraction: M_FLOAT_EPS."""


def _rest(ex: Expressions, value: Value) -> Value:
    return ex.apply("subtract", _ONE, value)


def _mixed(node: Inputs, value: Value) -> Value:
    return node.expressions.apply("mix", node.value("bg"), value, node.value("mix"))


def _divided(node: Inputs, number: Value, divisor: Value, rest: Callable[[Value], Value]) -> Value:
    """`rest` of a fraction, mixed with the background; 0 where the divisor is about 0."""
    ex = node.expressions
    value = _mixed(node, rest(ex.apply("divide", number, divisor)))
    return ex.apply("if_greater", _LEAST, ex.apply("absolute", divisor), _ZERO, value)


def _burn(node: Inputs) -> Value:
    ex = node.expressions
    dark = _rest(ex, node.value("bg"))
    return _divided(node, dark, node.value("fg"), lambda value: _rest(ex, value))


def _dodge(node: Inputs) -> Value:
    divisor = _rest(node.expressions, node.value("fg"))
    return _divided(node, node.value("bg"), divisor, lambda value: value)


def _alphas(node: Inputs) -> tuple[Value, Value]:
    ex = node.expressions
    return ex.channel(node.value("fg"), 3), ex.channel(node.value("bg"), 3)


def _over(node: Inputs) -> Value:
    ex, (alpha, _) = node.expressions, _alphas(node)
    below = ex.apply("multiply", node.value("bg"), _rest(ex, alpha))
    return _mixed(node, ex.apply("add", node.value("fg"), below))


def _matte(node: Inputs) -> Value:
    ex, (alpha, _) = node.expressions, _alphas(node)
    scaled = ex.apply("multiply", node.value("fg"), ex.swizzle(alpha, "rrr1"))
    below = ex.apply("multiply", node.value("bg"), _rest(ex, alpha))
    return _mixed(node, ex.apply("add", scaled, below))


def _scaled(which: str, by: str, outside: bool = False) -> Callable[[Inputs], Value]:
    """One of the two by the other's alpha, or by what that leaves."""

    def scale(node: Inputs) -> Value:
        ex = node.expressions
        alpha = ex.channel(node.value(by), 3)
        share = _rest(ex, alpha) if outside else alpha
        return _mixed(node, ex.apply("multiply", node.value(which), share))

    return scale


def _disjoint(node: Inputs) -> Value:
    ex, (front, back) = node.expressions, _alphas(node)
    fg, bg = node.value("fg"), node.value("bg")
    total = ex.apply("add", front, back)
    share = ex.apply("divide", _rest(ex, front), back)
    squeezed = ex.apply("add", fg, ex.apply("multiply", bg, share))
    squeezed = ex.apply("if_greater", _LEAST, ex.apply("absolute", back), _ZERO, squeezed)
    color = ex.apply("if_greater", total, _ONE, squeezed, ex.apply("add", fg, bg))
    alpha = ex.apply("min", total, _ONE)
    return _mixed(node, ex.combine(*(ex.channel(color, i) for i in range(3)), alpha))


def _masked(outside: bool) -> Callable[[Inputs], Value]:
    def mask(node: Inputs) -> Value:
        ex, share = node.expressions, node.value("mask")
        return ex.apply("multiply", node.value("in"), _rest(ex, share) if outside else share)

    return mask


COMPOSITING: dict[str, Callable[[Inputs], Value]] = {
    "burn": _burn,
    "dodge": _dodge,
    "over": _over,
    "matte": _matte,
    "in": _scaled("fg", "bg"),
    "out": _scaled("fg", "bg", outside=True),
    "mask": _scaled("bg", "fg"),
    "disjointover": _disjoint,
    "inside": _masked(outside=False),
    "outside": _masked(outside=True),
}
