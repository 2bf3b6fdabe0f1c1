# SPDX-License-Identifier: Apache-2.0
"""Textured inputs of materials for property tests, as plain values.

A texture is a dictionary: `image`, ("noise", seed, size, channels, dtype) or ("bumps", seed, size),
a field of normals, or no picture at all but ("solid", operation, space, frequency), a noise over
positions in that space, or ("view",), which goes by the ray's direction; `channel`; `transfer`;
`wrap`; `turn`, (scale, degrees, offset) of st; `scale` and `bias` of what was looked up. Or it is a
`primvar`, with its `channel`, `scale` and `bias`.
"""

from functools import cache
from typing import Any

import numpy as np

from irt_usd import _core

SCALARS = ("metallic", "roughness", "clearcoat", "opacity", "opacity_threshold")
COLORS = ("diffuse_color", "emissive_color", "specular_color")


def texture(image: tuple[Any, ...], **others: Any) -> dict[str, Any]:
    return {"image": image, **others}


def texels(image: tuple[Any, ...]) -> np.ndarray:
    kind, seed, size, *rest = image
    random = np.random.default_rng(seed)
    if kind == "bumps":
        normals = random.integers(64, 192, (size, size, 3)).astype(np.uint8)
        normals[..., 2] = 255
        return normals
    channels, dtype = rest
    values = random.random((size, size, channels))
    if dtype[0] == "u":
        values = values * np.iinfo(dtype).max
    return values.astype(dtype)


@cache
def made(image: tuple[Any, ...], transfer: Any) -> _core.Texture:
    return _core.Texture([(0, 0, texels(image))], transfer=transfer)


def pattern(image: tuple[Any, ...], first: int) -> list[_core.ShadeNode]:
    """Nodes numbered from `first`, whose last is a pattern that needs no st, about from 0 to 1."""
    if image[0] == "view":
        return [_core.ShadeNode("view"), _core.ShadeNode("vector_to_world", [first])]
    _, op, space, frequency = image
    nodes = [_core.ShadeNode("position")]
    if space == "world":
        nodes.append(_core.ShadeNode("point_to_world", [first]))
    last = first + len(nodes) - 1
    nodes.append(_core.ShadeNode("multiply", [last], [0, frequency]))
    nodes.append(_core.ShadeNode(op, [last + 1], [0, 0.75]))
    return nodes


def graph(textured: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """`nodes` and `connected` of a material."""
    nodes = [_core.ShadeNode("primvar", primvar="st")]
    connected = {}
    for name, spec in textured.items():
        channel = spec.get("channel", "r" if name in SCALARS else "rgb")
        gain, bias = spec.get("scale", 1.0), spec.get("bias", 0.0)
        if "primvar" in spec:
            fallback = [(0.5, 0.75, 1.0)]
            nodes.append(_core.ShadeNode("primvar", [-1], fallback, primvar=spec["primvar"]))
        elif spec["image"][0] in ("solid", "view"):
            nodes += pattern(spec["image"], len(nodes))
        else:
            scale, degrees, offset = spec.get("turn", (1.0, 0.0, 0.0))
            image = made(spec["image"], spec.get("transfer", "linear"))
            wrap = spec.get("wrap", ("repeat", "repeat"))
            first = len(nodes)
            nodes += [
                _core.ShadeNode("transform2d", [0], [0, scale, degrees, (offset, -offset)]),
                _core.ShadeNode("texture", [first], texture=image, wrap=wrap),
            ]
        last = len(nodes) - 1
        nodes += [
            _core.ShadeNode("multiply", [last], [0, gain]),
            _core.ShadeNode("add", [last + 1], [0, bias]),
        ]
        connected[name] = (last + 2, channel)
    return {"nodes": nodes if connected else [], "connected": connected}
