# SPDX-License-Identifier: Apache-2.0
"""Random scenes and edit sequences for property tests: few places, sizes and materials, so that
planes are shared, objects coincide, and removed objects come back under their names."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import strategies as st

from irt_usd import _core

AOVS = tuple(name for name in _core.AOVS if not name.startswith("irt."))
NAMES = ("/a", "/b", "/c", "/d", "/e")
MATERIALS = ("/red", "/glass", "/mirror", "/lamp", "/leaf")

coordinate = st.sampled_from((-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 1.0 / 3.0))
unit = st.sampled_from((0.0, 0.2, 0.5, 1.0))
color = st.tuples(unit, unit, unit)
size = st.sampled_from((0.5, 1.0, 2.0))

BOX = np.array(
    [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)], np.float32
)
BOX_FACES = np.array(
    [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3], np.int32
)


def box_mesh(single_sided: bool) -> _core.Mesh:
    """A cube of side 1 with shared vertices and outward faces."""
    return _core.Mesh(BOX, np.full(6, 4, np.int32), BOX_FACES, single_sided=single_sided)


geometry: st.SearchStrategy[Any] = st.one_of(
    st.builds(_core.Quadric.sphere, size),
    st.builds(_core.Quadric.cube, size),
    st.builds(_core.Quadric.cylinder, size, size),
    st.builds(_core.Quadric.cone, size, size),
    st.builds(_core.Quadric.capsule, size, size),
    st.builds(_core.Quadric.plane, size, size),
    st.builds(box_mesh, st.booleans()),
    st.builds(
        lambda quadric, material: _core.Prototype(
            [("q", quadric, np.eye(4), material), ("m", box_mesh(False), np.eye(4), "/red")]
        ),
        st.builds(_core.Quadric.sphere, st.just(0.5)),
        st.sampled_from(MATERIALS),
    ),
)


@st.composite
def transform(draw: st.DrawFn) -> np.ndarray:
    """Axis-aligned or turned, mirrored or not, scaled alike or not; in front of the camera."""
    matrix = np.eye(4)
    if draw(st.booleans()):
        c, s = 0.8, 0.6
        matrix[:3, :3] = draw(
            st.sampled_from(
                (
                    np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]),
                    np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
                    np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]),
                )
            )
        )
    scales = draw(st.sampled_from(((1, 1, 1), (-1, 1, 1), (1, 2, 0.5), (0.5, 0.5, 0.5))))
    matrix[:3, :3] = np.diag(scales) @ matrix[:3, :3]
    matrix[3, :3] = (draw(coordinate), draw(coordinate), draw(coordinate) - 5)
    return matrix


material = st.builds(
    _core.Material,
    diffuse_color=color,
    emissive_color=st.sampled_from(((0, 0, 0), (0.5, 0.25, 0))),
    metallic=unit,
    roughness=st.sampled_from((0.0, 0.05, 0.3, 1.0)),
    opacity=st.sampled_from((0.0, 0.25, 1.0, 1.0)),
    opacity_threshold=st.sampled_from((0.0, 0.0, 0.0, 0.3)),
    ior=st.sampled_from((1.0, 1.33, 1.5)),
)

light = st.one_of(
    st.builds(
        _core.Light.distant,
        st.sampled_from(((0, -1, 0), (0, 0, -1), (1, -1, -1), (-0.3, -0.9, 0.1))),
        color,
        st.booleans(),
    ),
    st.builds(
        _core.Light.point, st.tuples(coordinate, coordinate, coordinate), color, st.booleans()
    ),
)

edit = st.one_of(
    st.tuples(
        st.just("object"), st.sampled_from(NAMES), geometry, transform(), st.sampled_from(MATERIALS)
    ),
    st.tuples(st.just("remove"), st.sampled_from(NAMES)),
    st.tuples(st.just("move"), st.sampled_from(NAMES), transform()),
    st.tuples(st.just("bind"), st.sampled_from((*NAMES, "/floor")), st.sampled_from(MATERIALS)),
    st.tuples(st.just("material"), st.sampled_from(MATERIALS), material),
    st.tuples(st.just("light"), st.sampled_from(("/key", "/fill")), light),
    st.tuples(st.just("dark"), st.sampled_from(("/key", "/fill"))),
)
frame = st.lists(edit, max_size=3)
shot = st.lists(frame, min_size=1, max_size=4)


@dataclass
class State:
    """The records in force, to make fresh scenes from."""

    objects: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    materials: dict[str, Any] = field(default_factory=dict)
    lights: dict[str, Any] = field(default_factory=dict)

    def apply(self, edits: list[tuple[Any, ...]]) -> _core.ChangeSet:
        """Applies one frame's edits here and returns them as a change set."""
        changes = _core.ChangeSet()
        for kind, name, *rest in edits:
            if kind == "object":
                self.objects[name] = tuple(rest)
                changes.set_object(name, *rest)
            elif kind in ("move", "bind"):
                if name not in self.objects:
                    continue
                shape, matrix, material = self.objects[name]
                moved = rest[0] if kind == "move" else matrix
                self.objects[name] = (shape, moved, rest[0] if kind == "bind" else material)
                changes.set_object(name, *self.objects[name])
            elif kind == "remove":
                self.objects.pop(name, None)
                changes.remove_object(name)
            elif kind == "material":
                self.materials[name] = rest[0]
                changes.set_material(name, rest[0])
            elif kind == "light":
                self.lights[name] = rest[0]
                changes.set_light(name, rest[0])
            else:
                self.lights.pop(name, None)
                changes.remove_light(name)
        return changes

    def fresh(self) -> _core.ChangeSet:
        """A change set that makes this state from nothing."""
        changes = _core.ChangeSet()
        for name, record in self.materials.items():
            changes.set_material(name, record)
        for name, record in self.objects.items():
            changes.set_object(name, *record)
        for name, record in self.lights.items():
            changes.set_light(name, record)
        return changes


def initial() -> State:
    """Every material in its first form, a floor, and one light."""
    state = State()
    state.apply(
        [
            ("material", "/red", _core.Material(diffuse_color=(0.8, 0.1, 0.1))),
            ("material", "/glass", _core.Material(opacity=0.1, roughness=0.0, ior=1.5)),
            ("material", "/mirror", _core.Material(metallic=1.0, roughness=0.0)),
            ("material", "/lamp", _core.Material(emissive_color=(1, 1, 1))),
            ("material", "/leaf", _core.Material(opacity=0.2, opacity_threshold=0.5)),
            ("object", "/floor", _core.Quadric.plane(8, 8), floor(), "/red"),
            ("object", "/a", _core.Quadric.sphere(0.5), floor(1.0), "/glass"),
            ("light", "/key", _core.Light.distant((0.3, -1, -0.2), (1, 1, 0.9))),
        ]
    )
    return state


def glass_before_floor() -> State:
    """A pane between the light and the floor, for shadows whose tint changes."""
    state = initial()
    state.apply([("object", "/b", _core.Quadric.plane(3, 3), floor(1.5), "/glass")])
    return state


def floor(height: float = 0.0) -> np.ndarray:
    """A plane's transform: facing up, below the camera."""
    matrix = np.eye(4)
    matrix[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    matrix[3, :3] = (0, -1 + height, -5)
    return matrix


def renderer(width: int = 24, height: int = 20, **options: Any) -> _core.Renderer:
    """A renderer whose camera looks down -z from the origin, all AOVs on."""
    options.setdefault("cost_model", False)
    samples = options.pop("samples", 1)
    camera = _core.Camera(np.eye(4), (-0.6, 0.6, -0.5, 0.5))
    aovs = options.pop("aovs", AOVS)
    settings = _core.ViewSettings(width, height, samples=samples, max_depth=5, aovs=aovs)
    return _core.Renderer(camera, settings, **options)


def film_bits(source: _core.Renderer) -> bytes:
    """Every bit of the film: beauty and all AOVs."""
    return source.beauty().tobytes() + b"".join(source.aov(name).tobytes() for name in AOVS)
