# SPDX-License-Identifier: Apache-2.0
"""Values while a shading graph is made: constants are computed at once, the rest become nodes.

A number is the same in all four components, so that it goes with vectors as it is; of vectors
those components count that their type has.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import cast

from irt_usd.stage.graph import Node, TextureReference, Wrap

Four = tuple[float, float, float, float]

CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3, "x": 0, "y": 1, "z": 2, "w": 3}


@dataclass(frozen=True, slots=True)
class Value:
    """A value at a hit: `four` where it is the same everywhere, else node `index`."""

    four: Four | None = None
    index: int = -1

    def is_constant(self, *numbers: float) -> bool:
        """Whether it is known to be `numbers` (one for all) in its first three components."""
        wanted = numbers * 3 if len(numbers) == 1 else numbers
        return self.four is not None and self.four[: len(wanted)] == wanted


def constant(*numbers: float) -> Value:
    """A number in all components, or up to four of a vector."""
    if len(numbers) == 1:
        return Value((numbers[0],) * 4)
    return Value(cast("Four", (*numbers, *(0.0, 0.0, 0.0, 1.0)[len(numbers) :])))


def _power(a: float, b: float) -> float:
    try:
        result = math.pow(a, b)
    except (ValueError, OverflowError):
        return 0.0
    return result if math.isfinite(result) else 0.0


_FOLDED: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b if b != 0.0 else 0.0,
    "power": _power,
    "min": min,
    "max": max,
    "modulo": lambda a, b: a - b * math.floor(a / b) if b != 0.0 else 0.0,
    "clamp": lambda a, low, high: min(max(a, low), high),
    "mix": lambda a, b, share: a + (b - a) * share,
    "absolute": abs,
    "sign": lambda a: float((a > 0.0) - (a < 0.0)),
    "floor": math.floor,
    "ceil": math.ceil,
    "sqrt": lambda a: math.sqrt(a) if a > 0.0 else 0.0,
    "if_greater": lambda a, b, then, other: then if a > b else other,
    "if_equal": lambda a, b, then, other: then if a == b else other,
}
"""Component by component, as the core has it."""

_CHOICES: dict[str, Callable[[float, float], bool]] = {
    "if_greater": lambda a, b: a > b,
    "if_equal": lambda a, b: a == b,
}

_NEUTRAL = {"add": 0.0, "subtract": 0.0, "multiply": 1.0, "divide": 1.0}
"""A second operand that changes nothing."""


class Expressions:
    """Collects the nodes of one graph."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._made: dict[Node, int] = {}

    def add(self, node: Node) -> Value:
        """The value of `node`, which is made once."""
        if node not in self._made:
            self._made[node] = len(self.nodes)
            self.nodes.append(node)
        return Value(index=self._made[node])

    def apply(self, op: str, *values: Value) -> Value:
        """An operation on up to four values."""
        folded = _FOLDED.get(op)
        fours = [value.four for value in values]
        if folded is not None and None not in fours:
            known = cast("list[Four]", fours)
            result = tuple(float(folded(*parts)) for parts in zip(*known, strict=True))
            return Value(cast("Four", result))
        if (op == "multiply" and (0.0,) * 4 in fours) or (
            op == "divide" and fours[0] == (0.0,) * 4
        ):
            return constant(0.0)
        if op in _NEUTRAL and values[1].four == (_NEUTRAL[op],) * 4:
            return values[0]
        if op == "multiply" and values[0].four == (1.0,) * 4:
            return values[1]
        if op in _CHOICES and None not in fours[:2]:
            pairs = zip(cast("Four", fours[0]), cast("Four", fours[1]), strict=True)
            chosen = {_CHOICES[op](a, b) for a, b in pairs}
            if len(chosen) == 1:
                return values[2] if chosen.pop() else values[3]
        if op == "mix" and values[0] == values[1]:
            return values[0]
        if op == "mix" and values[2].four in ((0.0,) * 4, (1.0,) * 4):
            return values[1] if values[2].four == (1.0,) * 4 else values[0]
        slots = tuple(value.index for value in values)
        constants = tuple(value.four if value.four is not None else 0.0 for value in values)
        return self.add(Node(op, slots, constants))

    def swizzle(self, value: Value, letters: str) -> Value:
        """Four components of `value`, by the letters r g b a 0 1."""
        if value.four is not None:
            parts = {**{k: value.four[i] for k, i in CHANNELS.items()}, "0": 0.0, "1": 1.0}
            return Value(cast("Four", tuple(parts[letter] for letter in letters)))
        if letters == "rgba":
            return value
        return self.add(Node("swizzle", (value.index,), swizzle=letters))

    def channel(self, value: Value, index: int) -> Value:
        """One component as a number."""
        return self.swizzle(value, "rgba"[min(max(index, 0), 3)] * 4)

    def combine(self, *numbers: Value) -> Value:
        """A vector of up to four numbers."""
        rest = (constant(0.0), constant(0.0), constant(0.0), constant(1.0))
        parts = (*numbers, *rest[len(numbers) :])
        if all(part.four is not None for part in parts):
            return Value(cast("Four", tuple(cast("Four", part.four)[0] for part in parts)))
        return self.apply("combine", *parts)

    def primvar(self, name: str, fallback: Value) -> Value:
        """A primvar of the geometry, as a vector."""
        four = fallback.four if fallback.four is not None else 0.0
        return self.add(Node("primvar", (fallback.index,), (four,), primvar=name))

    def texture(
        self, reference: TextureReference, st: Value, missing: Value, wrap: tuple[Wrap, Wrap]
    ) -> Value:
        """An image's colour at `st`; `missing` where there is no image."""
        slots = (st.index, missing.index)
        constants = tuple(v.four if v.four is not None else 0.0 for v in (st, missing))
        return self.add(Node("texture", slots, constants, texture=reference, wrap=wrap))

    def needed(self, outputs: Iterable[int]) -> tuple[tuple[Node, ...], dict[int, int]]:
        """The nodes that `outputs` depend on, and where each of those is among them."""
        wanted = set(outputs)
        for index in range(len(self.nodes) - 1, -1, -1):
            if index in wanted:
                wanted.update(i for i in self.nodes[index].inputs if i >= 0)
        places = {index: place for place, index in enumerate(sorted(wanted))}
        nodes = (self.nodes[index] for index in sorted(wanted))
        moved = (
            replace(node, inputs=tuple(places[i] if i >= 0 else -1 for i in node.inputs))
            for node in nodes
        )
        return tuple(moved), places
