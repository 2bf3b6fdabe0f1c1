# SPDX-License-Identifier: Apache-2.0
"""Scenes at the extremes, their films, and how far films are apart."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import scenes
from irt_usd import _core

Film = NDArray[np.float32]

MATT: dict[str, Any] = {
    "diffuse_color": (1, 1, 1),
    "specular_color": (0, 0, 0),
    "use_specular_workflow": True,
    "ior": 1.0,
}
GLOW: dict[str, Any] = {"emissive_color": (1, 1, 1), "diffuse_color": (0, 0, 0)}
GLASS: dict[str, Any] = {"opacity": 0.0, "roughness": 0.0, "ior": 1.5}
MIRROR: dict[str, Any] = {"metallic": 1.0, "roughness": 0.0, "diffuse_color": (1, 1, 1)}


def placed(position: Any, scale: Any = 1.0) -> Any:
    """A scaling, then a translation."""
    matrix = np.diag([*np.broadcast_to(scale, 3), 1.0])
    matrix[3, :3] = position
    return scenes.as_tuples(matrix)


def transformed(state: scenes.State, scale: float = 1.0, offset: Any = (0, 0, 0)) -> scenes.State:
    """The same scene, `scale` times as large and then moved by `offset`, all by transforms. Lights
    give surfaces as much as before."""
    larger = np.diag([scale, scale, scale, 1.0])
    larger[3, :3] = offset
    other = scenes.State(materials=dict(state.materials))
    for name, (shape, matrix, *rest) in state.objects.items():
        other.objects[name] = (shape, np.array(matrix, float) @ larger, *rest)
    for name, light in state.lights.items():
        if light[0] == "point":
            position = tuple(np.array(light[1]) * scale + offset)
            energy = tuple(np.array(light[2]) * scale**2)
            light = ("point", position, energy, *light[3:])
        other.lights[name] = light
    return other


def camera(
    position: Any = (0, 0, 0), window: Any = (-0.6, 0.6, -0.5, 0.5), **options: Any
) -> _core.Camera:
    """Looks along -z."""
    return _core.Camera(np.array(placed(position)), window, **options)


def renderer(
    size: tuple[int, int] = (96, 80),
    view: _core.Camera | None = None,
    aovs: tuple[str, ...] = scenes.AOVS,
    options: dict[str, Any] | None = None,
    **settings: Any,
) -> _core.Renderer:
    """With the cost model off, so that every edit runs as an update."""
    return _core.Renderer(
        view or camera(),
        _core.ViewSettings(*size, aovs=aovs, **settings),
        **{"cost_model": False, **(options or {})},
    )


def film(state: scenes.State, *arguments: Any, **settings: Any) -> Film:
    """The beauty of a full trace."""
    made = renderer(*arguments, **settings)
    made.update(state.fresh())
    return made.beauty().copy()


def half_steps(one: Film, other: Film) -> NDArray[np.int64]:
    """By pixel: how many steps of half float its channels are apart at most."""

    def order(image: Film) -> NDArray[np.int64]:
        bits = image.astype(np.float16).view(np.int16).astype(np.int64)
        return np.where(bits < 0, -(bits & 0x7FFF), bits)

    steps: NDArray[np.int64] = np.abs(order(one) - order(other)).max(axis=-1)
    return steps


def share_differing(one: Film, other: Film) -> float:
    """The share of pixels more than two steps of half float apart."""
    return float((half_steps(one, other) > 2).mean())


def update_differs(state: scenes.State, edits: list[scenes.Edit], **options: Any) -> float:
    """The share of pixels, over all AOVs, in which an update is not the full trace of the same;
    NaN if a film is not finite."""
    updated = renderer(**options)
    updated.update(state.fresh())
    done = updated.update(state.apply(edits))
    assert done["restart"] is None, done["restart"]
    updated.validate()
    judge = renderer(**{**options, "options": {"history": False, **options.get("options", {})}})
    judge.update(state.fresh())
    films = updated.beauty(), judge.beauty()
    if not all(np.isfinite(f).all() for f in films):
        return float("nan")
    differing = np.any(films[0].view(np.uint32) != films[1].view(np.uint32), axis=-1)
    for name in scenes.AOVS:
        one, two = (np.ascontiguousarray(r.aov(name)).view(np.uint8) for r in (updated, judge))
        differing |= (one != two).reshape(*differing.shape, -1).any(axis=-1)
    return float(differing.mean())
