# SPDX-License-Identifier: Apache-2.0
"""AOVs of the core against closed forms: ids, coverage, primvars, light paths, motion, causes."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray

import edits
import scenes
from irt_usd import _core

NONE = 0xFFFFFFFF
LAMBERT: Any = {"specular_color": (0.0, 0.0, 0.0), "ior": 1.0}
BLACK = _core.Material(diffuse_color=(0, 0, 0), emissive_color=(0.5, 0.25, 1.0), **LAMBERT)
WHITE = _core.Material(diffuse_color=(1, 1, 1), **LAMBERT)
MIRROR = _core.Material(metallic=1, roughness=0, diffuse_color=(1, 1, 1))


def placed(x: float, y: float, z: float) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[3, :3] = (x, y, z)
    return matrix


def render(changes: _core.ChangeSet, **view: Any) -> _core.Renderer:
    """Looking along -z from the origin; the window is 2 wide and high at z = -1."""
    size = view.pop("size", (32, 32))
    camera = _core.Camera(np.eye(4), (-1, 1, -1, 1))
    renderer = _core.Renderer(camera, _core.ViewSettings(*size, **view))
    renderer.update(changes)
    return renderer


def scene(**materials: _core.Material) -> _core.ChangeSet:
    changes = _core.ChangeSet()
    for name, material in materials.items():
        changes.set_material("/" + name, material)
    return changes


def quads(columns: int, rows: int) -> _core.Mesh:
    """Faces in rows from the lower left, 2 by 2 in all, at z = 0; a primvar tells the face."""
    points = [
        (-1 + 2 * x / columns, -1 + 2 * y / rows, 0)
        for y in range(rows + 1)
        for x in range(columns + 1)
    ]
    corners = []
    for y in range(rows):
        for x in range(columns):
            first = y * (columns + 1) + x
            corners += [first, first + 1, first + columns + 2, first + columns + 1]
    count = columns * rows
    return _core.Mesh(
        np.array(points, np.float32),
        np.full(count, 4, np.int32),
        np.array(corners, np.int32),
        primvars={"face": ("uniform", np.arange(count, dtype=np.float32)[:, None], None)},
    )


def test_elements_are_the_faces_seen() -> None:
    changes = scene(white=WHITE)
    changes.set_object("/wall", quads(4, 4), placed(0, 0, -2), "/white")
    renderer = render(changes, size=(16, 16), aovs=["elementId", "primvars:face"])
    element = renderer.aov("elementId")
    # The wall fills the middle half of the image, a face two pixels.
    columns, rows = np.meshgrid(np.arange(4).repeat(2), np.arange(3, -1, -1).repeat(2))
    assert np.array_equal(element[4:12, 4:12], rows * 4 + columns)
    assert np.all(element[:4] == NONE)
    face = renderer.aov("primvars:face")
    assert np.array_equal(face[4:12, 4:12, 0], element[4:12, 4:12].astype(np.float32))
    assert not face[:4].any()


def test_elements_of_refined_faces_are_the_cages() -> None:
    cage = quads(4, 4)
    rules: Any = {"scheme": "bilinear", "level": 2, "name_elements": True}
    holes = np.array([5], np.int32)
    films = []
    for level in (0, 2):
        refined = _core.Subdivider(**rules | {"level": level, "hole_indices": holes}).refine(cage)
        changes = scene(white=WHITE)
        changes.set_object("/wall", refined, placed(0, 0, -2), "/white")
        films.append(render(changes, size=(16, 16), aovs=["elementId"]).aov("elementId").copy())
    assert np.array_equal(films[0], films[1])
    columns, rows = np.meshgrid(np.arange(4).repeat(2), np.arange(3, -1, -1).repeat(2))
    expected = rows * 4 + columns
    assert np.array_equal(films[0][4:12, 4:12], np.where(expected == 5, NONE, expected))


def test_elements_of_points_and_curves() -> None:
    changes = scene(white=WHITE)
    points = np.array([(-0.5, 0.5, 0), (0.5, 0.5, 0)], np.float32)
    changes.set_object(
        "/p", _core.Spheres(points, np.array([0.8], np.float32)), placed(0, 0, -1), "/white"
    )
    ends = np.array([(-0.8, -0.3, 0), (0.8, -0.3, 0), (-0.8, -0.7, 0), (0.8, -0.7, 0)], np.float32)
    curves = _core.Curves(ends, np.array([2, 2], np.int32), np.array([0.3], np.float32))
    changes.set_object("/c", curves, placed(0, 0, -1), "/white")
    element = render(changes, aovs=["elementId"]).aov("elementId")
    assert element[8, 8] == 0
    assert element[8, 24] == 1
    assert element[21, 16] == 0
    assert element[27, 16] == 1
    assert element[16, 0] == NONE


def test_instances_tell_their_keys() -> None:
    changes = scene(white=WHITE)
    ball = _core.Prototype([("b", _core.Quadric.sphere(0.3), np.eye(4), "/white", {}, ())])
    rows = np.zeros((2, 4, 3))
    rows[:, :3] = np.eye(3)
    rows[:, 3] = [(-0.5, 0, -1), (0.5, 0, -1)]
    keys = np.array([7, 41], np.int64)
    changes.set_object("/two", _core.InstanceArray([ball], rows, None, keys), np.eye(4))
    changes.set_object("/one", _core.Quadric.sphere(0.2), placed(0, 0.7, -1), "/white")
    renderer = render(changes, aovs=["instanceId", "CryptoObject", "objectId"])
    instance = renderer.aov("instanceId")
    assert instance[16, 8] == 7
    assert instance[16, 24] == 41
    assert instance[5, 16] == NONE
    names = renderer.names("CryptoObject", set(renderer.aov("CryptoObject")[..., 0].ravel()))
    assert set(names.values()) == {"/two[7]", "/two[41]", "/one"}
    assert names[int(renderer.aov("CryptoObject")[16, 8, 0, 0])] == "/two[7]"


def test_coverage_is_the_share_of_samples() -> None:
    """A half-plane's edge through a column of pixels; ranks sum to alpha, the greater first."""
    changes = scene(white=WHITE, black=BLACK)
    changes.set_object("/left", _core.Quadric.plane(2, 8), placed(-0.97, 0, -1), "/white")
    changes.set_object("/right", _core.Quadric.plane(2, 8), placed(1.03, 0, -1), "/black")
    renderer = render(changes, samples=16, aovs=["CryptoObject", "CryptoMaterial"])
    edge = 16  # left ends at x = 0.03, 0.48 of the way across this pixel
    for name, labels in (
        ("CryptoObject", ("/left", "/right")),
        ("CryptoMaterial", ("/white", "/black")),
    ):
        plane = renderer.aov(name)
        share = plane.view(np.float32)[..., 1]
        assert plane.shape == (32, 32, 6, 2)
        assert np.all(np.diff(share, axis=2) <= 0)
        assert share.sum(axis=2) == pytest.approx(renderer.beauty()[..., 3])
        names = renderer.names(name, set(plane[..., 0].ravel()))
        first, second = (names[int(i)] for i in plane[5, edge, :2, 0])
        assert {first, second} == set(labels)
        by_name = {first: share[5, edge, 0], second: share[5, edge, 1]}
        assert by_name[labels[0]] == pytest.approx(0.48, abs=1 / 16)
        assert names[int(plane[5, 3, 0, 0])] == labels[0]
        assert share[5, 3, 0] == 1


@pytest.mark.parametrize(
    ("name", "number"),
    [("", 0), ("hello", 0x248BFA47), ("The quick brown fox jumps over the lazy dog", 0x2E4FF723)],
)
def test_names_hash_as_murmur_3(name: str, number: int) -> None:
    """Published values of MurmurHash3_x86_32 with seed 0."""
    assert _core.name_hash(name) == number


def test_light_paths_sum_to_beauty_and_follow_closed_forms() -> None:
    """A white wall under two distant lights, a lamp, and a mirror that shows both."""
    changes = scene(white=WHITE, lamp=BLACK, mirror=MIRROR)
    changes.set_object("/wall", _core.Quadric.plane(2, 8), placed(-1, 0, -2), "/white")
    changes.set_object("/back", _core.Quadric.plane(8, 8), placed(0, 0, -3), "/white")
    changes.set_object("/lamp", _core.Quadric.plane(0.3, 8), placed(0.55, 0, -2), "/lamp")
    turned = np.eye(4)
    turned[:3, :3] = [(0, 0, 1), (0, 1, 0), (-1, 0, 0)]  # faces -x
    turned[3, :3] = (1.2, 0, -2)
    changes.set_object("/glass", _core.Quadric.plane(4, 8), turned, "/mirror")
    changes.set_light("/rig/a", _core.Light.distant((0, 0, -1), (1.0, 0.5, 0.25), False))
    changes.set_light("/rig/b", _core.Light.distant((0, -0.6, -0.8), (2.0, 2.0, 2.0), False))
    parts: Any = [
        ("all", "any", True, None),
        ("a", "any", False, ["a"]),
        ("rig", "any", False, ["/rig"]),
        ("none", "none", True, None),
        ("once", "once", True, None),
        ("more", "more", True, None),
        ("some", "some", True, None),
    ]
    renderer = render(changes, parts=parts, samples=4)
    part = {name: renderer.aov(name).view(np.float32) for name, *_ in parts}
    beauty = renderer.beauty()[..., :3]
    assert np.array_equal(part["all"], beauty)
    assert part["none"] + part["once"] + part["more"] == pytest.approx(beauty, abs=1e-6)
    assert part["once"] + part["more"] == pytest.approx(part["some"], abs=1e-6)
    assert np.all(part["rig"] <= beauty)
    wall, lamp = (16, 8), (16, 20)
    assert part["a"][wall] == pytest.approx(np.array([1.0, 0.5, 0.25]) / math.pi, rel=1e-6)
    assert part["once"][wall] == pytest.approx(beauty[wall], rel=1e-6)
    assert not part["more"][wall].any()
    assert part["none"][lamp] == pytest.approx((0.5, 0.25, 1.0))
    assert part["some"][lamp] == pytest.approx(0, abs=1e-5)
    # In the mirror: the wall's light is scattered twice, the lamp's once.
    mirror = np.zeros((32, 32), bool)
    mirror[:, 27:] = renderer.beauty()[:, 27:, 3] == 1
    assert part["more"][mirror].any()
    assert part["once"][mirror].any()
    assert not part["none"][mirror].any()


def test_what_is_cut_out_scatters_nothing() -> None:
    """Behind a surface of no opacity, light is as direct as without it."""
    parts: Any = [("once", "once", True, None), ("more", "more", True, None)]
    films = []
    for hole in (False, True):
        changes = scene(
            white=WHITE, hole=_core.Material(opacity=0.0, opacity_threshold=0.5), lamp=BLACK
        )
        changes.set_object("/wall", _core.Quadric.plane(8, 8), placed(0, 0, -3), "/white")
        changes.set_light("/sun", _core.Light.distant((0, 0, -1), (1, 1, 1), False))
        if hole:
            changes.set_object("/hole", _core.Quadric.plane(8, 8), placed(0, 0, -2), "/hole")
        renderer = render(changes, parts=parts)
        films.append([renderer.aov(name).copy() for name in ("once", "more")])
    assert np.array_equal(films[0][0], films[1][0])
    assert films[0][0].any()
    assert not films[1][1].any()


@pytest.mark.parametrize("kind", ["sphere", "mesh", "points", "curves", "instance", "array"])
def test_motion_of_what_moves_aside(kind: str) -> None:
    """At depth 2 a shift by (0.25, -0.125) is one of 2 pixels to the right and 1 down, of 32."""
    shapes: dict[str, Any] = {
        "sphere": _core.Quadric.sphere(0.5),
        "mesh": quads(3, 3),
        "points": _core.Spheres(np.zeros((1, 3), np.float32), np.array([0.5], np.float32)),
        "curves": _core.Curves(
            np.array([(-0.5, 0, 0), (0.5, 0, 0)], np.float32),
            np.array([2], np.int32),
            np.array([0.5], np.float32),
        ),
        "instance": _core.Prototype([("m", quads(2, 2), np.eye(4), "/white", {}, ())]),
    }

    def state(shift: tuple[float, float]) -> _core.ChangeSet:
        changes = scene(white=WHITE)
        matrix = placed(*shift, -2)
        if kind == "array":
            rows = np.ascontiguousarray(matrix[None, :, :3])
            array = _core.InstanceArray([shapes["instance"]], rows)
            changes.set_object("/a", array, np.eye(4))
        elif kind == "instance":
            changes.set_object("/a", shapes[kind], matrix)
        else:
            changes.set_object("/a", shapes[kind], matrix, "/white")
        changes.set_object("/still", _core.Quadric.plane(80, 80), placed(0, 0, -9), "/white")
        return changes

    renderer = render(state((0, 0)), aovs=["irt.seen", "objectId", "depth"])
    motion = renderer.motion(state((0.25, -0.125)))
    moving = renderer.aov("objectId") != _core.name_hash("/still")
    assert moving.any()
    assert not motion[~moving].any()
    # Nearer parts of round shapes move by more pixels.
    scale = 2 / renderer.aov("depth")[moving][:, None].astype(np.float64)
    assert motion[moving] == pytest.approx(np.array([[2.0, -1.0]]) * scale, abs=1e-4)
    assert not renderer.motion(state((0, 0))).any()


def test_motion_of_a_deforming_mesh_and_of_the_camera() -> None:
    """A wall that opens like a fan: each point's motion is the difference of its places."""
    still = quads(4, 4)
    points = still.points.copy()
    points[:, 0] *= 1.5
    wide = _core.Mesh(points, still.face_vertex_counts, still.face_vertex_indices)
    changes, other = scene(white=WHITE), _core.ChangeSet()
    changes.set_object("/wall", still, placed(0, 0, -2), "/white")
    other.set_object("/wall", wide, placed(0, 0, -2), "/white")
    renderer = render(changes, aovs=["irt.seen", "position"])
    motion = renderer.motion(other)
    position = renderer.aov("position")
    seen = position[..., 2] != 0
    assert motion[seen][:, 0] == pytest.approx(position[seen][:, 0] * 0.5 / 2 * 16, abs=1e-4)
    assert motion[seen][:, 1] == pytest.approx(0, abs=1e-5)
    aside = _core.Camera(placed(0.5, 0, 0), (-1, 1, -1, 1))
    panned = renderer.motion(_core.ChangeSet(), aside)
    assert panned[seen] == pytest.approx(np.broadcast_to([-4.0, 0.0], (seen.sum(), 2)), abs=1e-5)
    assert not panned[~seen].any()


def test_motion_where_nothing_corresponds_is_none() -> None:
    changes, gone, other = scene(white=WHITE), _core.ChangeSet(), _core.ChangeSet()
    changes.set_object("/wall", quads(4, 4), placed(0, 0, -2), "/white")
    gone.remove_object("/wall")
    other.set_object("/wall", quads(3, 4), placed(1, 0, -2), "/white")
    renderer = render(changes, aovs=["irt.seen"])
    assert not renderer.motion(gone).any()
    assert not renderer.motion(other).any()
    with pytest.raises(ValueError, match=r"irt\.seen"):
        render(changes).motion(gone)


@given(shot=edits.shots())
@settings(max_examples=60, deadline=None)
def test_motion_is_that_of_a_fresh_renderer(shot: edits.Shot) -> None:
    state = edits.start(shot.start)
    aovs = ("irt.seen",)
    renderer = scenes.renderer(aovs=aovs, parts=[])
    renderer.update(state.fresh())
    for frame in shot.frames:
        before = state.fresh()
        renderer.update(state.apply(frame))
        judge = scenes.renderer(aovs=aovs, parts=[], history=False)
        judge.update(state.fresh())
        assert renderer.motion(before).tobytes() == judge.motion(before).tobytes()


def test_causes_name_what_changed() -> None:
    changes = scene(white=WHITE, black=BLACK)
    changes.set_object("/floor", _core.Quadric.plane(40, 40), placed(0, 0, -6), "/white")
    changes.set_object("/ball", _core.Quadric.sphere(0.5), placed(-0.5, 0, -2), "/white")
    changes.set_object("/lamp", _core.Quadric.sphere(0.5), placed(1, 1, -2), "/black")
    changes.set_light("/sun", _core.Light.distant((0, 0, -1), (1, 1, 1), False))
    camera = _core.Camera(np.eye(4), (-1, 1, -1, 1))
    settings = _core.ViewSettings(32, 32, aovs=["irt.cause", "irt.retraced", "objectId"])
    renderer = _core.Renderer(camera, settings, cost_model=False)
    renderer.update(changes)
    assert {renderer.cause_name(int(c)) for c in np.unique(renderer.aov("irt.cause"))} == {""}
    before = renderer.aov("objectId").copy()

    def causes(edit: _core.ChangeSet) -> tuple[dict[str, NDArray[np.bool_]], NDArray[np.bool_]]:
        film = renderer.beauty().copy()
        assert renderer.update(edit)["restart"] is None
        plane = renderer.aov("irt.cause")
        named = {renderer.cause_name(int(c)): plane == c for c in np.unique(plane) if c}
        return named, (renderer.beauty() != film).any(axis=2)

    moved = _core.ChangeSet()
    moved.set_object("/ball", _core.Quadric.sphere(0.5), placed(-0.3, 0, -2), "/white")
    named, _ = causes(moved)
    ball = _core.name_hash("/ball")
    assert set(named) == {"/ball"}
    assert np.array_equal(named["/ball"], (before == ball) | (renderer.aov("objectId") == ball))

    named, changed = causes(scene(black=WHITE))
    assert set(named) == {"/black"}
    assert np.array_equal(named["/black"], changed)

    dimmed = _core.ChangeSet()
    dimmed.set_light("/sun", _core.Light.distant((0, 0, -1), (0.5, 0.5, 0.5), False))
    named, changed = causes(dimmed)
    assert set(named) == {"/sun"}
    assert np.array_equal(named["/sun"], changed)
    assert not causes(_core.ChangeSet())[0]
