# SPDX-License-Identifier: Apache-2.0
"""Textured inputs of materials for property tests, as plain values.

A texture is a dictionary: `image`, ("noise", seed, size, channels, dtype) or ("bumps", seed, size),
a field of normals; `channel`; `transfer`; `wrap`; `turn`, (scale, degrees, offset) of st; `scale`
and `bias` of what was looked up.
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


def graph(textured: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """`nodes` and `connected` of a material."""
    nodes = [_core.ShadeNode("primvar", primvar="st")]
    connected = {}
    for name, spec in textured.items():
        scale, degrees, offset = spec.get("turn", (1.0, 0.0, 0.0))
        image = made(spec["image"], spec.get("transfer", "linear"))
        wrap = spec.get("wrap", ("repeat", "repeat"))
        gain, bias = spec.get("scale", 1.0), spec.get("bias", 0.0)
        first = len(nodes)
        nodes += [
            _core.ShadeNode("transform2d", [0], [0, scale, degrees, (offset, -offset)]),
            _core.ShadeNode("texture", [first], texture=image, wrap=wrap),
            _core.ShadeNode("multiply", [first + 1], [0, gain]),
            _core.ShadeNode("add", [first + 2], [0, bias]),
        ]
        channel = spec.get("channel", "r" if name in SCALARS else "rgb")
        connected[name] = (first + 3, channel)
    return {"nodes": nodes if connected else [], "connected": connected}
