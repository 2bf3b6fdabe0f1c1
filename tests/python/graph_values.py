# SPDX-License-Identifier: Apache-2.0
"""What a shading graph comes to at a hit, computed in NumPy, images aside."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

import mx_noise
from irt_usd.stage.graph import DEFAULTS, OTHER_DEFAULTS, Node, Surface

_OPS: dict[str, Callable[..., Any]] = {
    "constant": lambda a: a,
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": lambda a, b: np.divide(a, b, out=np.zeros(4), where=b != 0),
    "min": np.minimum,
    "max": np.maximum,
    "power": np.power,
    "modulo": lambda a, b: a - b * np.floor(a / b),
    "clamp": np.clip,
    "mix": lambda a, b, t: a + (b - a) * t,
    "smoothstep": lambda x, low, high: _smooth(np.clip((x - low) / (high - low), 0, 1)),
    "absolute": np.abs,
    "sign": np.sign,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": np.round,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "log": np.log,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan2": np.arctan2,
    "dot": lambda a, b: np.full(4, a[:3] @ b[:3]),
    "length": lambda a: np.full(4, np.linalg.norm(a[:3])),
    "normalize": lambda a: np.append(a[:3] / np.linalg.norm(a[:3]), a[3]),
    "cross": lambda a, b: np.append(np.cross(a[:3], b[:3]), 0.0),
    "if_greater": lambda a, b, then, other: np.where(a > b, then, other),
    "if_equal": lambda a, b, then, other: np.where(a == b, then, other),
    "combine": lambda *parts: np.array([part[0] for part in parts]),
}


WORLD = (10.0, 20.0, 30.0)
"""Where an object's origin is; it is turned and scaled by nothing."""

_NOISES: dict[str, Callable[..., Any]] = {
    f"{name}_{width}d": getattr(mx_noise, name)
    for name in ("perlin", "perlin_vector", "cells", "worley", "worley_cells")
    for width in (2, 3)
}


def _smooth(t: Any) -> Any:
    return t * t * (3 - 2 * t)


def surface_value(surface: Surface, name: str, primvars: Mapping[str, Any] | None = None) -> Any:
    """An input of `surface` where the geometry has `primvars`; images give (s, t, s + t, 0.5)."""
    if name not in surface.connected:
        return surface.constants.get(name, (DEFAULTS | OTHER_DEFAULTS)[name])
    index, channel = surface.connected[name]
    value = _node_values(surface.nodes, primvars or {})[index]
    if channel == "rgb":
        return tuple(float(v) for v in value[:3])
    return float(value["rgba".index(channel)])


def _node_values(nodes: tuple[Node, ...], primvars: Mapping[str, Any]) -> list[NDArray[Any]]:
    values: list[NDArray[Any]] = []
    for node in nodes:
        inputs = [*node.inputs, *[-1] * (len(node.constants) - len(node.inputs))]
        slots = [
            values[index] if index >= 0 else _four(node.constants[slot])
            for slot, index in enumerate(inputs)
        ]
        values.append(_node_value(node, slots, primvars))
    return values


def _node_value(node: Node, slots: list[Any], primvars: Mapping[str, Any]) -> NDArray[Any]:
    if node.op == "primvar":
        return _four(primvars[node.primvar]) if node.primvar in primvars else slots[0]
    if node.op == "texture":
        s, t = slots[0][:2]
        return np.array([s, t, s + t, 0.5])
    if node.op in ("position", "normal", "view"):
        return _four(primvars[node.op])
    if node.op.endswith(("_to_world", "_to_object")):
        away = 1.0 if node.op.endswith("world") else -1.0
        moved = WORLD if node.op.startswith("point") else (0.0, 0.0, 0.0)
        return np.append(slots[0][:3] + np.multiply(away, moved), slots[0][3])
    if node.op in _NOISES:
        noise, width = _NOISES[node.op], int(node.op[-2])
        place = tuple(slots[0][:width])
        jitter = (slots[1][0],) if node.op.startswith("worley") else ()
        values = noise(place, *jitter)
        fourth = mx_noise.worley_cell(place, *jitter) if "worley_cells" in node.op else values[0]
        return np.array([*values[:3], fourth])
    if node.op == "swizzle":
        parts = {**dict(zip("rgba", slots[0], strict=True)), "0": 0.0, "1": 1.0}
        return np.array([parts[letter] for letter in node.swizzle])
    if node.op == "transform2d":
        x, y = slots[0][:2] * slots[1][:2]
        turn = np.radians(slots[2][0])
        turned = (x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn))
        return np.array([*(turned + slots[3][:2]), *slots[0][2:]])
    return np.asarray(_OPS[node.op](*slots), np.float64)


def _four(value: Any) -> NDArray[Any]:
    if isinstance(value, (int, float)):
        return np.full(4, float(value))
    return np.array([*value, *(0.0, 0.0, 0.0, 1.0)[len(value) :]])
