# SPDX-License-Identifier: Apache-2.0
"""Scenes for property tests, as plain values that print in a form they can be read from again.

A geometry is ("sphere", radius), ("cube", size), ("cylinder", radius, height), ("cone", ...),
("capsule", ...), ("plane", width, length), ("frustum" or "round_cone", radius_bottom, radius_top,
height), ("box", single_sided, corners[, faces, paints]), its faces' materials by place in paints, 0
the object's own, ("blob", level, corners[, tags]), a creased subdivision surface by one of TAGS,
("shell", topology, corners), a box of the faces of one of TOPOLOGIES, ("sheet", size, tiling),
a square mesh, ("points", ((x, y, z, width), ...)), ("curves" or "ribbons", basis, wrap, ((x, y, z,
width), ...)), ("pair", radius, material), an instance, or ("array" or "forest", ((key, prototype,
offset, scale), ...), size), instances, or instances of instances; a material is the arguments of
_core.Material, and perhaps "textured", see textures.py; a light is ("distant", direction,
irradiance, casts_shadows) or ("point", position, intensity, casts_shadows), perhaps with modifiers,
or ("sky", axes, radiance, image or None). Records of _core may stand in their place. An object is
(geometry, matrix, material), or has colours besides: its primvar "dye", by point, ball or entry, as
many as there are, over and over.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import textures
from irt_usd import _core

MANY = (("points",), ("curves",), ("ribbons",))
AOVS = (*(name for name in _core.AOVS if not name.startswith("irt.")), "primvars:st")

GROUPS: list[Any] = [("all", "any", True, None), ("key", "any", False, ["/key"])]
"""Parts of the beauty that settled samples have, too."""

EVENTS: list[Any] = [
    ("emitted", "none", True, None),
    ("direct", "once", True, None),
    ("indirect", "more", True, None),
    ("fill again", "some", False, ["fill"]),
]
"""Parts that are made of whole trees."""

Edit = tuple[Any, ...]

BOX = tuple((x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5))
CLOUD = ((0.0, 0.0, 0.0, 0.5), (0.3, 0.0, 0.1, 0.4), (0.3, 0.0, 0.1, 0.4), (-0.6, 0.5, 0.0, 0.25))
LOCK = (
    (-0.5, 0.0, 0.0, 0.25),
    (0.0, 0.25, 0.25, 0.125),
    (0.5, 0.0, 0.25, 0.25),
    (0.5, 0.0, 0.375, 0.3125),
    (0.5, -0.5, 0.5, 0.0),
)
HALF_W = np.diag([0.0, 0.0, 0.0, 0.5])
"""Makes half the identity a scaling by a half."""

BOX_FACES = np.array(
    [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3], np.int32
)
ST: Any = {"st": ("constant", np.array([[0.3, 0.7]], np.float32), None)}
QUADS = tuple(tuple(BOX_FACES[4 * i : 4 * i + 4].tolist()) for i in range(6))
TOPOLOGIES: tuple[tuple[tuple[int, ...], ...], ...] = (
    QUADS,
    QUADS[:5],
    tuple(face for q in QUADS for face in (q[:3], (q[0], *q[2:]))),
    (*QUADS[1:], (0, 1, 5, 3, 2)),
    (*QUADS[2:], QUADS[0][::-1], (4, 6), (7, 5, 5)),
)
TAGS: tuple[dict[str, Any], ...] = (
    {"crease_indices": BOX_FACES[:4], "crease_lengths": [4], "crease_sharpnesses": [1.5]},
    {"crease_indices": BOX_FACES[:4], "crease_lengths": [4], "crease_sharpnesses": [10]},
    {"crease_indices": [0, 1, 1, 3], "crease_lengths": [2, 2], "crease_sharpnesses": [0.5, 3]},
    {"corner_indices": [0, 6], "corner_sharpnesses": [10, 1.5], "hole_indices": [4]},
    {"interpolate_boundary": "none", "hole_indices": [0, 1]},
    {"scheme": "bilinear"},
)
CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)


@cache
def geometry(shape: tuple[Any, ...], dye: tuple[Any, ...] = ()) -> Any:
    """The record of a geometry; equal ones are one, so that instances share their prototype."""
    kind, *sizes = shape
    if kind == "box":
        single_sided, corners, *paint = sizes
        points = np.array(corners, np.float32)
        counts = np.full(6, 4, np.int32)
        tiled = np.concatenate([CORNERS * (1 + face) - 0.25 for face in range(6)])
        st: Any = {"st": ("faceVarying", tiled, None)} | dyed(dye, len(points))
        if not paint or not any(paint[0]):
            return _core.Mesh(points, counts, BOX_FACES, single_sided=single_sided, primvars=st)
        # Painted faces have normals of their own, too.
        faces = np.array(paint[0], np.int32)
        normals = np.array([(1, f, 0.5) for f in faces], np.float32)
        return _core.Mesh(
            points,
            counts,
            BOX_FACES,
            normals,
            "uniform",
            single_sided=single_sided,
            primvars=st | {"paint": ("uniform", normals, None)},
            face_materials=faces - 1,
        )
    if kind == "sheet":
        size, tiling = sizes
        points = np.zeros((4, 3), np.float32)
        points[:, :2] = (CORNERS - 0.5) * size
        return _core.Mesh(
            points,
            np.array([4], np.int32),
            np.arange(4, dtype=np.int32),
            primvars={"st": ("vertex", CORNERS * np.float32(tiling), None)} | dyed(dye, 4),
        )
    if kind == "shell":
        topology, corners = sizes
        polygons = TOPOLOGIES[topology]
        return _core.Mesh(
            np.array(corners, np.float32),
            np.array([len(polygon) for polygon in polygons], np.int32),
            np.array([i for polygon in polygons for i in polygon], np.int32),
            primvars=dyed(dye, len(corners)),
        )
    if kind == "blob":
        level, corners, *tags = sizes
        points, counts = np.array(corners, np.float32), np.full(6, 4, np.int32)
        primvars = dyed(dye, len(corners))
        cage = _core.Mesh(points, counts, BOX_FACES, primvars=primvars)
        rules = {"scheme": "catmullClark", **TAGS[tags[0] if tags else 0]}
        for name, value in rules.items():
            if isinstance(value, list):
                sharp = name.endswith("sharpnesses")
                rules[name] = np.array(value, np.float32 if sharp else np.int32)
        return _core.Subdivider(level=level, **rules).refine(cage)
    if kind == "pair":
        radius, material = sizes
        ball, box = ("sphere", radius), ("box", False, BOX)
        parts = [("q", ball, material), ("m", box, "/red")]
        return _core.Prototype([(n, geometry(g), np.eye(4), m, ST, ()) for n, g, m in parts])
    if kind in ("array", "forest"):
        entries, size = sizes
        return array(entries, size, kind == "forest", dye)
    if kind in ("points", "curves", "ribbons"):
        balls = np.array(sizes[-1], np.float32).reshape(-1, 4)
        points, widths = balls[:, :3], balls[:, 3]
        each: Any = {"st": ("vertex", np.ascontiguousarray(points[:, :2]), None)}
        each |= dyed(dye, len(balls))
        if kind == "points":
            return _core.Spheres(points, widths, each)
        basis, wrap, _ = sizes
        counts = np.array([len(balls)], np.int32)
        if kind == "curves":
            return _core.Curves(points, counts, widths, "vertex", basis, wrap, 3, each)
        return _core.Mesh.ribbons(
            points,
            counts,
            widths,
            points[:, ::-1] + np.float32(0.5),
            widths_interpolation="vertex",
            normals_interpolation="vertex",
            basis=basis,
            wrap=wrap,
            segments=3,
            primvars=each,
        )
    return getattr(_core.Quadric, kind)(*sizes)


def dyed(colors: tuple[Any, ...], count: int) -> dict[str, Any]:
    if not colors or count == 0:
        return {}
    values = [colors[i % len(colors)] for i in range(count)]
    return {"dye": ("vertex", np.array(values, np.float32), None)}


def array(
    entries: tuple[tuple[Any, ...], ...], size: float, nested: bool, dye: tuple[Any, ...]
) -> _core.InstanceArray:
    """Entries: key, prototype (0, 1, 2), where it is, scale. Nested: of arrays of the same."""
    pair, ball, box = ("pair", 0.5 * size, "/glass"), ("sphere", size), ("box", False, BOX)
    prototypes = [
        geometry(pair),
        _core.Prototype([("ball", geometry(ball), np.eye(4), "/mirror", ST, ())]),
        _core.Prototype(
            [
                ("box", geometry(box), 0.5 * np.eye(4) + HALF_W, "/red", ST, ()),
                ("dyed", geometry(("sphere", 0.4 * size)), np.eye(4), "/dyed", {}, ()),
            ]
        ),
    ]
    rows = np.zeros((len(entries), 4, 3))
    for row, (_, _, offset, scale) in zip(rows, sorted(entries), strict=True):
        row[:3] = scale * np.eye(3)
        row[3] = offset
    keys = np.array([entry[0] for entry in sorted(entries)], np.int64)
    kinds = np.array([entry[1] for entry in sorted(entries)], np.int32)
    if nested:
        some = _core.InstanceArray(prototypes, 0.5 * rows[: len(rows) // 2 + 1])
        inner: list[Any] = [
            ("some", some, np.eye(4), "", {}, ()),
            ("ball", geometry(ball), np.eye(4), "/red", {}, ()),
        ]
        prototypes[1] = _core.Prototype(inner)
    return _core.InstanceArray(prototypes, rows, kinds, keys, dyed(dye, len(rows)))


PLAIN_ROLE = (True, False)
"""Seen by the camera, and not matte."""


def object_record(
    shape: Any, matrix: Any, material: str, role: tuple[bool, bool], dye: tuple[Any, ...] = ()
) -> Any:
    """What ChangeSet.set_object takes."""
    made = geometry(shape, dye) if isinstance(shape, tuple) else shape
    painted = isinstance(shape, tuple) and shape[0] == "box" and len(shape) > 3
    whole = {"dye": ("constant", np.array(dye[:1], np.float32), None)} if dye else {}
    faces = shape[4] if painted else ()
    return made, np.asarray(matrix, float), material, whole, faces, _core.PassRole(*role)


def material_record(material: Any) -> Any:
    if not isinstance(material, dict):
        return material
    values = dict(material)
    graph = textures.graph(values.pop("textured", {}))
    return _core.Material(**values, **graph)


def light_record(light: Any) -> Any:
    if not isinstance(light, tuple):
        return light
    if light[0] == "sky":
        _, axes, radiance, image = light
        picture = textures.made(image, "linear") if image else None
        return _core.Light.environment(radiance, True, picture, axes)
    make = _core.Light.distant if light[0] == "distant" else _core.Light.point
    return make(*light[1:4], modifiers=light[4] if len(light) > 4 else {})


@dataclass
class State:
    """The records in force, to make fresh scenes from, and those of the frames before."""

    objects: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    materials: dict[str, Any] = field(default_factory=dict)
    lights: dict[str, Any] = field(default_factory=dict)
    hidden: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    past: list[tuple[dict[str, Any], ...]] = field(default_factory=list)

    def apply(self, edits: list[Edit]) -> _core.ChangeSet:
        """Applies one frame's edits here and returns them as a change set. An edit of what is not
        there, or cannot be edited so, does nothing."""
        before = self._records()
        for kind, name, *rest in edits:
            getattr(self, "_" + kind)(name, *rest)
        self.past.append(before)
        return self._leading_from(before)

    def fresh(self) -> _core.ChangeSet:
        """A change set that makes this state from nothing."""
        return self._leading_from(({}, {}, {}))

    def _records(self) -> tuple[dict[str, Any], ...]:
        return dict(self.objects), dict(self.materials), dict(self.lights)

    def _leading_from(self, before: tuple[dict[str, Any], ...]) -> _core.ChangeSet:
        """Changes from other records to these; a record that was set again is set again."""
        changes = _core.ChangeSet()
        objects, materials, lights = before
        for name, material in self.materials.items():
            if materials.get(name) is not material:
                changes.set_material(name, material_record(material))
        for name, record in self.objects.items():
            if objects.get(name) is not record:
                changes.set_object(name, *object_record(*record))
        for name in objects.keys() - self.objects.keys():
            changes.remove_object(name)
        for name, light in self.lights.items():
            if lights.get(name) is not light:
                changes.set_light(name, light_record(light))
        for name in lights.keys() - self.lights.keys():
            changes.remove_light(name)
        return changes

    # ---- objects

    def _object(self, name: str, shape: Any, matrix: Any, material: str) -> None:
        self.objects[name] = (shape, matrix, material, PLAIN_ROLE)

    def _role(self, name: str, role: tuple[bool, bool]) -> None:
        """In a render pass: whether the camera sees it, whether it is matte."""
        if name in self.objects:
            self.objects[name] = (*self.objects[name][:3], role, *self.objects[name][4:])

    def _remove(self, name: str) -> None:
        self.objects.pop(name, None)

    def _copy(self, name: str, other: str, material: str) -> None:
        """An object that coincides with another."""
        if other in self.objects:
            self.objects[name] = (*self.objects[other][:2], material, PLAIN_ROLE)

    def _hide(self, name: str) -> None:
        if name in self.objects:
            self.hidden[name] = self.objects.pop(name)

    def _show(self, name: str) -> None:
        if name in self.hidden:
            self.objects[name] = self.hidden.pop(name)

    def _move(self, name: str, matrix: Any) -> None:
        if name in self.objects:
            shape, _, *others = self.objects[name]
            self.objects[name] = (shape, matrix, *others)

    def _shift(self, name: str, offset: tuple[float, ...]) -> None:
        if name in self.objects:
            moved = np.array(self.objects[name][1], float)
            moved[3, :3] += offset
            self._move(name, as_tuples(moved))

    def _transform(self, name: str, matrix: Any) -> None:
        """Turns or scales an object about its own origin."""
        if name in self.objects:
            turned = np.eye(4)
            turned[:3, :3] = matrix
            self._move(name, as_tuples(turned @ np.array(self.objects[name][1], float)))

    def _resize(self, name: str, factors: tuple[float, ...]) -> None:
        """Keyed radius, height and size."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] in MANY:
            balls = tuple((*ball[:3], ball[3] * factors[0]) for ball in shape[-1])
            self.objects[name] = ((*shape[:-1], balls), *others)
        elif isinstance(shape, tuple) and len(shape) > 1 and shape[0] != "box":
            sizes = list(shape[1:])
            for i, factor in enumerate(factors[: len(sizes)]):
                sizes[i] *= factor if isinstance(sizes[i], float) else 1
            self.objects[name] = ((shape[0], *sizes), *others)

    def _deform(self, name: str, corner: int, offset: tuple[float, ...]) -> None:
        """Moves one point of a mesh, a cloud or a curve."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] in (("box",), ("blob",), ("shell",)):
            corners = list(shape[2])
            corners[corner] = tuple(a + b for a, b in zip(corners[corner], offset, strict=True))
            self.objects[name] = ((*shape[:2], tuple(corners), *shape[3:]), *others)
        elif isinstance(shape, tuple) and shape[:1] in MANY and shape[-1]:
            balls = list(shape[-1])
            ball = balls[corner % len(balls)]
            moved = tuple(a + b for a, b in zip(ball[:3], offset, strict=True))
            balls[corner % len(balls)] = (*moved, ball[3])
            self.objects[name] = ((*shape[:-1], tuple(balls)), *others)

    def _widen(self, name: str, which: int, width: float) -> None:
        """Another width of one point of a cloud or a curve."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] in MANY and shape[-1]:
            balls = list(shape[-1])
            balls[which % len(balls)] = (*balls[which % len(balls)][:3], width)
            self.objects[name] = ((*shape[:-1], tuple(balls)), *others)

    def _thin(self, name: str, which: int) -> None:
        """One point fewer."""
        shape, *others = self.objects.get(name, ((),))
        least = {"points": 0, "curves": 4, "ribbons": 4}
        if isinstance(shape, tuple) and shape and shape[0] in least:
            balls = list(shape[-1])
            if len(balls) > least[shape[0]]:
                del balls[which % len(balls)]
                self.objects[name] = ((*shape[:-1], tuple(balls)), *others)

    def _paint(self, name: str, faces: tuple[int, ...], paints: tuple[str, ...]) -> None:
        """Materials of a mesh's faces: 0 its own, else by place in `paints`."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] == ("box",):
            self.objects[name] = ((*shape[:3], faces, paints), *others)

    def _entry(self, name: str, key: int, entry: tuple[Any, ...] | None) -> None:
        """An entry of an array is (prototype, offset, scale), or is not there."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] in (("array",), ("forest",)):
            entries = [old for old in shape[1] if old[0] != key]
            if entry is not None:
                entries.append((key, *entry))
            self.objects[name] = ((shape[0], tuple(sorted(entries)), shape[2]), *others)

    def _bind(self, name: str, material: str) -> None:
        if name in self.objects:
            shape, matrix, _, *dye = self.objects[name]
            self.objects[name] = (shape, matrix, material, *dye)

    def _dye(self, name: str, colors: tuple[Any, ...]) -> None:
        """Another primvar."""
        if name in self.objects:
            self.objects[name] = (*self.objects[name][:4], colors)

    def _retag(self, name: str, kind: str, which: int) -> None:
        """Other creases, corners, holes of a "blob", or faces of a "shell"."""
        shape, *others = self.objects.get(name, ((),))
        if isinstance(shape, tuple) and shape[:1] == (kind,):
            blob = (*shape[:3], which % len(TAGS))
            shell = ("shell", which % len(TOPOLOGIES), shape[2])
            self.objects[name] = (blob if kind == "blob" else shell, *others)

    # ---- materials and lights

    def _material(self, name: str, material: Any) -> None:
        self.materials[name] = material

    def _look(self, name: str, values: dict[str, Any]) -> None:
        """Other values of some of a material's inputs."""
        if isinstance(self.materials.get(name), dict):
            self.materials[name] = {**self.materials[name], **values}

    def _texture(self, name: str, input_name: str, texture: Any) -> None:
        """Connects an input of a material to a texture; or to none, where that is None."""
        if isinstance(material := self.materials.get(name), dict):
            textured = {**material.get("textured", {}), input_name: texture}
            if texture is None:
                del textured[input_name]
            self.materials[name] = {**material, "textured": textured}

    def _retexture(self, name: str, values: dict[str, Any]) -> None:
        """Other wraps, scales, biases or transforms of all textures of a material."""
        if isinstance(material := self.materials.get(name), dict):
            textured = {
                key: {**texture, **values} for key, texture in material.get("textured", {}).items()
            }
            self.materials[name] = {**material, "textured": textured}

    def _light(self, name: str, light: Any) -> None:
        self.lights[name] = light

    def _dark(self, name: str) -> None:
        self.lights.pop(name, None)

    def _aim(self, name: str, vector: tuple[float, ...]) -> None:
        """Another direction or position of a light."""
        if isinstance(light := self.lights.get(name), tuple) and light[0] != "sky":
            self.lights[name] = (light[0], vector, *light[2:])

    def _shine(self, name: str, energy: tuple[float, ...]) -> None:
        """Another colour or energy of a light."""
        if isinstance(light := self.lights.get(name), tuple):
            self.lights[name] = (*light[:2], energy, *light[3:])

    def _shape(self, name: str, modifiers: dict[str, Any]) -> None:
        """Other modifiers of a light."""
        if isinstance(light := self.lights.get(name), tuple) and light[0] != "sky":
            before = light[4] if len(light) > 4 else {}
            self.lights[name] = (*light[:4], {**before, **modifiers})

    # ---- all

    def _undo(self, frames: int) -> None:
        """Back to the records of some frames before."""
        if len(self.past) >= frames:
            objects, materials, lights = self.past[-frames]
            self.objects, self.materials, self.lights = dict(objects), dict(materials), dict(lights)


def as_tuples(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """A matrix as a plain value."""
    return tuple(tuple(row) for row in matrix.tolist())


def papers() -> list[Edit]:
    """Textured materials."""
    paint = textures.texture(("noise", 1, 8, 3, "u1"), transfer="srgb")
    bumps = textures.texture(("bumps", 2, 16), scale=(2, 2, 2, 1), bias=(-1, -1, -1, 0))
    gloss = textures.texture(("noise", 3, 4, 1, "f2"), scale=(0.3,) * 4, wrap=("mirror", "clamp"))
    holes = textures.texture(("noise", 4, 8, 4, "u2"), channel="a")
    marble = textures.texture(("solid", "perlin_vector_3d", "object", 3.0), scale=0.5, bias=0.5)
    rim = textures.texture(("view",), scale=0.5, bias=0.5)
    tint = textures.texture(("noise", 5, 4, 3, "f4"), turn=(2.0, 30.0, 0.25))
    return [
        ("material", "/paper", {"textured": {"diffuse_color": paint}}),
        (
            "material",
            "/tiles",
            {"metallic": 0.5, "clearcoat": 0.5, "clearcoat_roughness": 0.4}
            | {"textured": {"diffuse_color": paint, "normal": bumps, "roughness": gloss}},
        ),
        ("material", "/lace", {"opacity_threshold": 0.5, "textured": {"opacity": holes}}),
        (
            "material",
            "/stained",
            {"roughness": 0.0, "textured": {"diffuse_color": tint, "opacity": holes}},
        ),
        ("material", "/screen", {"textured": {"emissive_color": paint}}),
        ("material", "/marble", {"textured": {"diffuse_color": marble, "opacity": marble}}),
        ("material", "/rim", {"roughness": 0.0, "textured": {"metallic": rim}}),
    ]


def initial() -> State:
    """Every material in its first form, a floor, and one light."""
    state = State()
    state.apply(
        [
            ("material", "/red", {"diffuse_color": (0.8, 0.1, 0.1)}),
            ("material", "/glass", {"opacity": 0.1, "roughness": 0.0, "ior": 1.5}),
            ("material", "/mirror", {"metallic": 1.0, "roughness": 0.0}),
            ("material", "/lamp", {"emissive_color": (1, 1, 1)}),
            ("material", "/leaf", {"opacity": 0.2, "opacity_threshold": 0.5}),
            ("material", "/dyed", {"textured": {"diffuse_color": {"primvar": "dye"}}}),
            *papers(),
            ("object", "/floor", ("plane", 8.0, 8.0), floor(), "/red"),
            ("object", "/a", ("sphere", 0.5), floor(1.0), "/glass"),
            ("light", "/key", ("distant", (0.3, -1.0, -0.2), (1.0, 1.0, 0.9), True)),
        ]
    )
    return state


def glass_before_floor() -> State:
    """A pane between the light and the floor, for shadows whose tint changes."""
    state = initial()
    state.apply([("object", "/b", ("plane", 3.0, 3.0), floor(1.5), "/glass")])
    return state


def crowd() -> State:
    """Mirror, lamp and glass: coincident and touching objects, panes one above the other, an
    instance, and two lights."""
    state = initial()
    aside = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (-1.5, -0.5, -6, 1))
    state.apply(
        [
            ("object", "/b", ("box", False, BOX), aside, "/mirror"),
            ("object", "/c", ("cube", 1.0), aside, "/red"),
            ("object", "/d", ("plane", 3.0, 3.0), floor(2.5), "/glass"),
            ("object", "/e", ("pair", 0.5, "/lamp"), floor(1.5), "/red"),
            ("object", "/lantern", ("sphere", 0.25), (*aside[:3], (0.5, -0.5, -4, 1)), "/lamp"),
            ("object", "/cloud", ("points", CLOUD), floor(0.6), "/glass"),
            ("object", "/lock", ("curves", "bspline", "pinned", LOCK), floor(0.2), "/glass"),
            ("object", "/ring", ("curves", "linear", "periodic", LOCK), floor(1.0), "/mirror"),
            ("object", "/leaves", ("plane", 1.0, 1.0), floor(0.5), "/leaf"),
            ("light", "/fill", ("point", (0.5, 2.0, -3.0), (8.0, 4.0, 4.0), True)),
        ]
    )
    return state


def hall() -> State:
    """A crowd before a wall of many balls, beside which what has moved is little: it is not soon
    folded into what stands still."""
    state = crowd()
    for i in range(36):
        matrix = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (i % 6 - 2.5, i // 6 - 1.5, -8, 1))
        ball = ("sphere", 0.5) if i % 3 else ("box", False, BOX)
        state.apply([("object", f"/wall/{i:02}", ball, matrix, ("/red", "/mirror")[i % 2])])
    return state


def papered() -> State:
    """Textures on everything that they can change: a floor whose normals and roughness vary, so
    that mirrors begin and end on it; a cut-out and a pane between it and the light."""
    state = initial()
    above = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (-1.0, 0.0, -4, 1))
    state.apply(
        [
            ("object", "/floor", ("sheet", 8.0, 3.0), floor(), "/tiles"),
            ("object", "/b", ("box", False, BOX), floor(0.7), "/paper"),
            ("object", "/c", ("sheet", 2.0, 1.0), floor(2.0), "/lace"),
            ("object", "/d", ("sheet", 2.0, 2.0), above, "/stained"),
            ("object", "/e", ("pair", 0.75, "/screen"), floor(1.5), "/red"),
            ("light", "/fill", ("point", (0.5, 2.0, -3.0), (8.0, 4.0, 4.0), True)),
        ]
    )
    return state


def floor(height: float = 0.0) -> tuple[tuple[float, ...], ...]:
    """A plane's transform: facing up, below the camera."""
    return ((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, -1 + height, -5, 1))


def renderer(width: int = 24, height: int = 20, **options: Any) -> _core.Renderer:
    """A renderer whose camera looks down -z from the origin, all AOVs on."""
    options.setdefault("cost_model", False)
    view: dict[str, Any] = {"max_depth": 5, "aovs": AOVS, "parts": GROUPS}
    for name in ("samples", "throughput_cutoff", "aovs", "parts"):
        if name in options:
            view[name] = options.pop(name)
    camera = _core.Camera(np.eye(4), (-0.6, 0.6, -0.5, 0.5))
    settings = _core.ViewSettings(width, height, **view)
    return _core.Renderer(camera, settings, **options)


def film_bits(source: _core.Renderer, but: str = "", parts: Sequence[Any] = GROUPS) -> bytes:
    """Every bit of the film: beauty and all AOVs, `but` one."""
    names = [name for name in (*AOVS, *(part[0] for part in parts)) if name != but]
    return source.beauty().tobytes() + b"".join(source.aov(name).tobytes() for name in names)
