# SPDX-License-Identifier: Apache-2.0
"""Random sequences of every kind of edit, and whether a renderer that follows one shows the film of
a fresh one. Few places, sizes and materials: planes are shared, objects coincide, what was removed
comes back under its name, and edits are undone."""

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from hypothesis import strategies as st

import scenes
import textures
from irt_usd import _core
from scenes import BOX, CLOUD, LOCK, Edit

T = TypeVar("T")
Pick = Callable[[Sequence[Any]], Any]
"""One of several, by a property test's search or by a generator of random numbers."""

MORE = ("frustum", "round_cone", "points", "curves", "ribbons", "shell")
NAMES = ("/a", "/b", "/c", "/d", "/e")
MANY = ("/cloud", "/lock", "/ring", "/band")
MATERIALS = ("/red", "/glass", "/mirror", "/lamp", "/leaf", "/dyed")
DYED = (*NAMES, *MANY, "/swarm", "/shell")
DYES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.5), (0.25, 0.25, 1.0), (0.0, 0.0, 0.0))
PAPERS = ("/paper", "/tiles", "/lace", "/stained", "/screen", "/marble", "/rim")
LIGHTS = ("/key", "/fill")

COORDINATES = (0.0, 1.0, -1.0, 0.5, -0.5, 2.0, -2.0, 1.0 / 3.0)
SIZES = (1.0, 0.5, 2.0)
SHARES = (0.0, 0.2, 0.5, 1.0)
OFFSETS = (0.0, 0.25, -0.5, 0.01, 1.0, -2.0)
OUT_OF_BOUNDS = ((30.0, 0.0, 0.0), (0.0, 0.0, -25.0), (0.0, 12.0, -9.0), (0.0, 0.0, 8.0))
C, S = 0.8, 0.6
PLAIN = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TURNS = (
    ((C, S, 0.0), (-S, C, 0.0), (0.0, 0.0, 1.0)),
    ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
    ((C, 0.0, -S), (0.0, 1.0, 0.0), (S, 0.0, C)),
)
SCALES = ((0.5, 0.5, 0.5), (2.0, 2.0, 2.0), (1.0, 2.0, 0.5), (-1.0, 1.0, 1.0), (3.0, 1.0, 0.125))
DIRECTIONS = ((0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, -1.0, -1.0), (-0.3, -0.9, 0.1))
LOOKS: dict[str, Sequence[Any]] = {
    "metallic": SHARES,
    "roughness": (0.0, 0.05, 0.3, 1.0),
    "opacity": (1.0, 0.0, 0.25, 0.9),
    "opacity_threshold": (0.0, 0.3),
    "ior": (1.0, 1.33, 1.5),
    "transmission_color": ((1.0, 1.0, 1.0), (0.25, 1.0, 0.0)),
    "emissive_color": ((0.0, 0.0, 0.0), (0.5, 0.25, 0.0)),
    "use_specular_workflow": (False, True),
    "opacity_is_presence": (False, True),
}


IMAGES = (
    ("noise", 1, 8, 3, "u1"),
    ("noise", 2, 1, 1, "u1"),
    ("noise", 3, 5, 4, "u2"),
    ("noise", 4, 16, 2, "f2"),
    ("noise", 5, 3, 4, "f4"),
    ("bumps", 6, 8),
    ("solid", "perlin_3d", "object", 3.0),
    ("solid", "perlin_vector_3d", "world", 2.0),
    ("solid", "cells_3d", "world", 4.0),
    ("solid", "worley_3d", "object", 2.0),
    ("solid", "worley_cells_2d", "object", 5.0),
    ("view",),
)
WRAPS = ("black", "clamp", "repeat", "mirror")
RETEXTURES: dict[str, Sequence[Any]] = {
    "scale": (1.0, 0.5, 2.0, (2, 2, 2, 1)),
    "bias": (0.0, 0.25, -0.5, (-1, -1, -1, 0)),
    "turn": ((1.0, 0.0, 0.0), (2.0, 90.0, 0.5), (0.3, 17.0, 0.125), (-1.0, 45.0, 3.0)),
    "wrap": tuple((s, t) for s in WRAPS for t in WRAPS),
    "channel": ("r", "a"),
}
TETRAHEDRON = tuple(
    (*corner, *(0.25 * c for c in corner))
    for corner in ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))
)
NAMED: Sequence[Any] = ((), ("/a",), ("/floor",), ("/b", "/e"), ("/cloud", "/swarm", "/nowhere"))
MODIFIERS: dict[str, Sequence[Any]] = {
    "profile": ("uniform", "facing", "round", "facets"),
    "axis": DIRECTIONS[:2],
    "facets": (TETRAHEDRON, TETRAHEDRON[:1], TETRAHEDRON),
    "diffuse": SHARES,
    "specular": SHARES,
    "cone_angle": (180.0, 20.0, 45.0),
    "cone_softness": (0.0, 0.5),
    "focus": (0.0, 3.0),
    "ies": (
        ((0.0, 90.0, 180.0), (0.0,), (1.0, 0.5, 0.0)),
        ((0.0, 60.0), (0.0, 90.0), (1, 1, 0, 2)),
    ),
    "shadow_color": ((0.0, 0.0, 0.0), (0.5, 0.0, 0.25)),
    "shadow_distance": (-1.0, 0.5, 1.5, 3.0),
    "shadow_falloff": (0.0, 0.5, 2.0),
    "shadow_falloff_gamma": (1.0, 2.0),
    "unlit": NAMED,
    "shadowless": NAMED,
}
SWARMS = ("array", "forest")
SWARM = (
    (0, 0, (0.0, 0.0, 0.0), 0.5),
    (1, 1, (1.0, 0.0, 0.0), 0.4),
    (2, 2, (0.0, 1.0, 0.0), 0.5),
    (5, 1, (1.0, 0.0, 0.0), 0.4),
    (9, 0, (-1.0, 0.5, 0.5), 0.7),
)
"""Entries of an array, two of them in the same place."""


def entry(pick: Pick) -> tuple[Any, ...] | None:
    there = (pick((0, 1, 2)), tuple(pick(OFFSETS) for _ in "xyz"), pick((0.4, 0.5, -0.5)))
    found: tuple[Any, ...] | None = pick((None, there, there, there))
    return found


def diagonal(scales: Sequence[float]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(s if i == k else 0.0 for k in range(3)) for i, s in enumerate(scales))


def color(pick: Pick) -> tuple[float, ...]:
    return pick(SHARES), pick(SHARES), pick(SHARES)


def point(pick: Pick) -> tuple[float, ...]:
    return pick(COORDINATES), pick(COORDINATES), pick(COORDINATES)


def geometry(pick: Pick) -> tuple[Any, ...]:
    solids = ("sphere", "cube", "cylinder", "cone", "capsule", "plane")
    kind = pick((*solids, "box", "sheet", "blob", "pair", *MORE, *SWARMS))
    if kind in ("frustum", "round_cone"):
        return kind, pick((0.5, 1.0, 0.0)), pick((0.25, 1.0)), pick(SIZES)
    if kind == "points":
        return kind, pick((CLOUD, tuple(CLOUD[i % 4] for i in range(9)), LOCK, ()))
    if kind in ("curves", "ribbons"):
        basis = pick(("linear", "bspline", "catmullRom"))
        return kind, basis, pick(("nonperiodic", "periodic", "pinned")), pick((LOCK, CLOUD))
    if kind in ("array", "forest"):
        return kind, pick((SWARM, SWARM[:3], ())), pick((0.5, 1.0))
    if kind == "box":
        return kind, pick((False, True)), BOX
    if kind == "blob":
        return kind, pick((1, 2, 0)), BOX, pick(range(len(scenes.TAGS)))
    if kind == "shell":
        return kind, pick(range(len(scenes.TOPOLOGIES))), BOX
    if kind == "pair":
        return kind, 0.5, pick((*MATERIALS, *PAPERS))
    if kind in ("sphere", "cube"):
        return kind, pick(SIZES)
    return kind, pick(SIZES), pick(SIZES)


def transform(pick: Pick) -> tuple[tuple[float, ...], ...]:
    """Axis-aligned or turned, mirrored or not, scaled alike or not; in front of the camera."""
    turn = pick((PLAIN, *TURNS))
    scales = pick(((1.0, 1.0, 1.0), *SCALES[:4]))
    x, y, z = point(pick)
    rows = [tuple(s * value for value in row) for s, row in zip(scales, turn, strict=True)]
    return (*((*row, 0.0) for row in rows), (x, y, z - 5.0, 1.0))


def material(pick: Pick) -> dict[str, Any]:
    look = {name: pick(values) for name, values in LOOKS.items()}
    return {**look, "diffuse_color": color(pick), "specular_color": color(pick)}


def light(pick: Pick) -> tuple[Any, ...]:
    kind = pick(("distant", "point"))
    aim = pick(DIRECTIONS) if kind == "distant" else point(pick)
    return kind, aim, color(pick), pick((True, True, False))


def look(pick: Pick) -> dict[str, Any]:
    name = pick((*LOOKS, "diffuse_color", "specular_color"))
    return {
        name: color(pick) if name.endswith("e_color") or name not in LOOKS else pick(LOOKS[name])
    }


def texture(pick: Pick) -> dict[str, Any]:
    values = {name: pick(options) for name, options in RETEXTURES.items() if name != "channel"}
    return textures.texture(pick(IMAGES), transfer=pick(("linear", "srgb")), **values)


EDITS: dict[str, Callable[[Pick], Edit]] = {
    "move": lambda pick: ("move", pick(NAMES), transform(pick)),
    "shift": lambda pick: ("shift", pick((*NAMES, "/floor")), tuple(pick(OFFSETS) for _ in "xyz")),
    "leave the bounds": lambda pick: ("shift", pick(NAMES), pick(OUT_OF_BOUNDS)),
    "rotate": lambda pick: ("transform", pick(NAMES), pick(TURNS)),
    "scale": lambda pick: ("transform", pick(NAMES), diagonal(pick(SCALES))),
    "resize": lambda pick: ("resize", pick(NAMES), (pick((0.5, 1.5)), pick((1.0, 0.7)))),
    "deform": lambda pick: (
        "deform",
        pick((*NAMES, *MANY, "/shell", "/blob")),
        pick(range(8)),
        pick(((0.3, 0.0, 0.0), (0.0, 0.25, -0.5))),
    ),
    "widen": lambda pick: (
        "widen",
        pick((*NAMES, *MANY)),
        pick(range(5)),
        pick((0.0, 0.1, 0.5)),
    ),
    "entry": lambda pick: ("entry", pick((*NAMES, "/swarm")), pick((0, 1, 2, 5, 7)), entry(pick)),
    "dye": lambda pick: (
        "dye",
        pick(DYED),
        tuple(pick(DYES) for _ in range(pick((1, 2, 5, 0)))),
    ),
    "wear the dye": lambda pick: ("bind", pick(DYED[:-2]), "/dyed"),
    "faces": lambda pick: ("retag", pick((*NAMES, "/shell")), "shell", pick(range(5))),
    "creases": lambda pick: ("retag", pick((*NAMES, "/blob")), "blob", pick(range(6))),
    "dyed opacity": lambda pick: (
        "texture",
        "/dyed",
        pick(("opacity", "opacity", "roughness")),
        pick(({"primvar": "dye", "channel": "b"}, None)),
    ),
    "thin": lambda pick: ("thin", pick((*NAMES, *MANY)), pick(range(5))),
    "add": lambda pick: ("object", pick(NAMES), geometry(pick), transform(pick), pick(MATERIALS)),
    "coincide": lambda pick: ("copy", pick(NAMES), pick(NAMES), pick(MATERIALS)),
    "delete": lambda pick: ("remove", pick(NAMES)),
    "hide": lambda pick: ("hide", pick((*NAMES, "/floor"))),
    "show": lambda pick: ("show", pick((*NAMES, "/floor"))),
    "paint": lambda pick: (
        "paint",
        pick(NAMES),
        tuple(pick((0, 1, 2)) for _ in range(6)),
        (pick(MATERIALS), pick((*MATERIALS, *PAPERS))),
    ),
    "role": lambda pick: (
        "role",
        pick((*NAMES, *MANY, "/floor", "/swarm", "/leaves")),
        (pick((True, False)), pick((False, True))),
    ),
    "rebind": lambda pick: ("bind", pick((*NAMES, *MANY, "/floor")), pick(MATERIALS)),
    "material": lambda pick: ("material", pick(MATERIALS), material(pick)),
    "look": lambda pick: ("look", pick(MATERIALS), look(pick)),
    "texture": lambda pick: (
        "texture",
        pick((*MATERIALS, *PAPERS)),
        pick((*textures.SCALARS, *textures.COLORS, "normal")),
        pick((texture(pick), None)),
    ),
    "scale and bias": lambda pick: (
        "retexture",
        pick(PAPERS),
        {name: pick(RETEXTURES[name]) for name in (pick(tuple(RETEXTURES)),)},
    ),
    "paper": lambda pick: ("bind", pick((*NAMES, *MANY, "/floor")), pick(PAPERS)),
    "paper's look": lambda pick: ("look", pick(PAPERS), look(pick)),
    "light": lambda pick: ("light", pick(LIGHTS), light(pick)),
    "light off": lambda pick: ("dark", pick((*LIGHTS, "/sky"))),
    "light aimed": lambda pick: ("aim", pick(LIGHTS), pick(DIRECTIONS)),
    "light shaped": lambda pick: (
        "shape",
        pick(LIGHTS),
        {name: pick(MODIFIERS[name]) for name in (pick(tuple(MODIFIERS)),)},
    ),
    "sky": lambda pick: (
        "light",
        "/sky",
        ("sky", pick((PLAIN, *TURNS)), color(pick), pick((None, *IMAGES[:5]))),
    ),
    "sky's energy": lambda pick: ("shine", "/sky", color(pick)),
    "light's energy": lambda pick: ("shine", pick(LIGHTS), color(pick)),
    "undo": lambda pick: ("undo", pick((1, 1, 2, 3))),
}


def bazaar() -> scenes.State:
    """What primvars, topologies and creases are edited on, and an array."""
    state = scenes.initial()
    beside = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (-1.0, 0.0, -4, 1))
    behind = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1.0, 0.0, -6, 1))
    band = ("ribbons", "catmullRom", "pinned", LOCK)
    state.apply(
        [
            ("object", "/band", band, scenes.floor(1.0), "/dyed"),
            ("object", "/shell", ("shell", 0, BOX), beside, "/dyed"),
            ("object", "/blob", ("blob", 1, BOX, 1), behind, "/mirror"),
            ("object", "/cloud", ("points", CLOUD), scenes.floor(0.6), "/dyed"),
            ("object", "/swarm", ("array", SWARM, 1.0), scenes.floor(1.0), ""),
            ("dye", "/swarm", DYES[:2]),
            ("light", "/fill", ("point", (0.5, 2.0, -3.0), (8.0, 4.0, 4.0), True)),
        ]
    )
    return state


def swarm() -> scenes.State:
    """The crowd, and an array among it."""
    state = scenes.crowd()
    record = (("array", SWARM, 1.0), scenes.floor(1.0), "")
    state.apply([("object", "/swarm", *record)])
    return state


STARTS: dict[str, Callable[[], scenes.State]] = {
    "plain": scenes.initial,
    "glass": scenes.glass_before_floor,
    "crowd": scenes.crowd,
    "hall": scenes.hall,
    "papered": scenes.papered,
    "swarm": swarm,
    "bazaar": bazaar,
}


def start(name: str) -> scenes.State:
    """A state to begin with: nothing leads back to before it."""
    state = STARTS[name]()
    state.past.clear()
    return state


@dataclass(frozen=True)
class Shot:
    """A scene to begin with and edits frame by frame. Its repr makes it again."""

    start: str
    frames: list[list[Edit]]
    size: tuple[int, int] = (24, 20)
    samples: int = 1
    throughput_cutoff: float = 0.0009765625
    foreseen: bool = False  # the renderer is told beforehand what will change


def random_shot(pick: Pick) -> Shot:
    frames = [
        [EDITS[pick(tuple(EDITS))](pick) for _ in range(pick((1, 1, 2, 3, 0)))]
        for _ in range(pick((1, 2, 3, 4, 6)))
    ]
    return Shot(
        pick(tuple(STARTS)),
        frames,
        pick(((24, 20), (24, 20), (33, 17), (7, 5), (1, 1))),
        pick((1, 1, 4)),
        pick((0.0009765625, 0.0009765625, 0.25)),
        pick((False, False, True)),
    )


@st.composite
def shots(draw: st.DrawFn) -> Shot:
    return random_shot(lambda options: draw(st.sampled_from(options)))


def seeded_shot(seed: int) -> Shot:
    return random_shot(random.Random(seed).choice)


def foreseen(shot: Shot) -> _core.Foreseen:
    state = start(shot.start)
    known = _core.Foreseen(state.fresh())
    for frame in shot.frames:
        known.add(state.apply(frame))
    return known


def play(shot: Shot, cost_model: bool = False) -> list[dict[str, Any]]:
    """Follows a shot and returns the statistics of its updates. Every frame's film must be that of
    a fresh renderer, its history valid, and no update a restart but for cost, where a cost model is
    asked: AssertionError, or RuntimeError on a broken invariant."""
    parts = scenes.GROUPS if shot.foreseen else [*scenes.GROUPS, *scenes.EVENTS]
    options: dict[str, Any] = {
        "samples": shot.samples,
        "throughput_cutoff": shot.throughput_cutoff,
        "parts": parts,
    }
    state = start(shot.start)
    known = foreseen(shot) if shot.foreseen else None
    renderer = scenes.renderer(*shot.size, foreseen=known, cost_model=cost_model, **options)
    statistics = [renderer.update(state.fresh())]
    renderer.validate()
    for number, frame in enumerate(shot.frames, start=1):
        done = renderer.update(state.apply(frame))
        statistics.append(done)
        renderer.validate()
        judge = scenes.renderer(*shot.size, history=False, **options)
        judged = judge.update(state.fresh())
        restart = done["restart"]
        for_cost = cost_model and str(restart).startswith("cost")
        assert restart is None or for_cost, f"frame {number}: {restart}"
        bits = [scenes.film_bits(film, parts=parts) for film in (renderer, judge)]
        assert bits[0] == bits[1], f"frame {number} differs"
        assert done["all_rays"] == judged["all_rays"], f"frame {number}: other rays"
    return statistics
