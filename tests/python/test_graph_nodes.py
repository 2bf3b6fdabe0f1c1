# SPDX-License-Identifier: Apache-2.0
"""Noises, positions and spaces as the core's graphs compute them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import mx_noise
from irt_usd import _core

Four = tuple[float, ...]
GLOW: dict[str, Any] = {
    "diffuse_color": (0.0, 0.0, 0.0),
    "specular_color": (0.0, 0.0, 0.0),
    "ior": 1.0,
}


def glowing(nodes: list[Any], scale: float = 1.0, offset: float = 0.0) -> Any:
    """A material that shows scale x + offset of its last node's value."""
    last = len(nodes) - 1
    shown = [
        _core.ShadeNode("multiply", [last], [0, scale]),
        _core.ShadeNode("add", [last + 1], [0, offset]),
    ]
    connected = {"emissive_color": (last + 2, "rgb")}
    return _core.Material(**GLOW, nodes=[*nodes, *shown], connected=connected)


def placed(x: float, y: float, z: float) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[3, :3] = (x, y, z)
    return matrix


def row_of(materials: list[Any]) -> NDArray[np.float64]:
    """What a row of squares shows, one of each material: (n, 3)."""
    changes = _core.ChangeSet()
    for i, material in enumerate(materials):
        changes.set_material(f"/m{i}", material)
        changes.set_object(f"/o{i}", _core.Quadric.plane(1, 1), placed(i, 0, -5), f"/m{i}")
    count = len(materials)
    camera = _core.Camera(np.eye(4), (-0.5, count - 0.5, -0.5, 0.5), True)
    renderer = _core.Renderer(camera, _core.ViewSettings(count, 1))
    renderer.update(changes)
    shown: NDArray[np.float64] = renderer.beauty()[0, :, :3].astype(float)
    return shown


def points(width: int) -> list[Four]:
    random = np.random.default_rng(width)
    some = random.integers(-40 << 10, 40 << 10, (40, width)) / 1024.0
    return [*map(tuple, some.tolist()), (0.0,) * width, (-1.0,) * width, (0.5, -7.25, 1e5)[:width]]


@pytest.mark.parametrize("width", [2, 3])
@pytest.mark.parametrize(
    ("op", "reference"),
    [
        ("perlin", mx_noise.perlin),
        ("perlin_vector", mx_noise.perlin_vector),
        ("cells", mx_noise.cells),
    ],
)
def test_noises(op: str, reference: Callable[[Four], Four], width: int) -> None:
    """To the rounding of the film."""
    places = points(width)
    nodes = [[_core.ShadeNode(f"{op}_{width}d", [], [p])] for p in places]
    shown = row_of([glowing(n, 0.25, 0.5) for n in nodes])
    expected = [[0.25 * v + 0.5 for v in reference(p)] for p in places]
    np.testing.assert_allclose(shown, expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("width", [2, 3])
@pytest.mark.parametrize("jitter", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    ("op", "reference"),
    [("worley", mx_noise.worley), ("worley_cells", mx_noise.worley_cells)],
)
def test_worley(
    op: str, reference: Callable[[Four, float], Four], jitter: float, width: int
) -> None:
    places = [p for p in points(width) if len(set(mx_noise.worley(p, jitter))) == 3]
    nodes = [[_core.ShadeNode(f"{op}_{width}d", [], [p, jitter])] for p in places]
    shown = row_of([glowing(n) for n in nodes])
    np.testing.assert_allclose(shown, [reference(p, jitter) for p in places], rtol=2e-6)


def test_coordinates_that_are_no_numbers_have_noise_too() -> None:
    nodes = [[_core.ShadeNode("perlin_3d", [], [(1e30, -1e300, 0.5)])]]
    assert np.isfinite(row_of([glowing(n, 0.25, 0.5) for n in nodes])).all()


@pytest.mark.parametrize(("y", "x"), [(0.5, 0.25), (-1.0, -1.0), (1.0, 0.0), (0.0, 0.0)])
def test_arcs(y: float, x: float) -> None:
    ops = [("asin", [y]), ("acos", [y]), ("atan2", [y, x])]
    shown = row_of([glowing([_core.ShadeNode(op, [], slots)], 0.125, 0.5) for op, slots in ops])
    expected = [np.arcsin(y), np.arccos(y), np.arctan2(y, x)]
    np.testing.assert_allclose(shown[:, 0], 0.125 * np.array(expected) + 0.5, rtol=1e-6)


TURN = np.array(
    [[0.0, 0.0, -2.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)
TILT = np.array([[1.0, 0, 0.8, 0], [0, 1, 0.3, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)


def shapes() -> dict[str, Any]:
    """One of each kind that has a space of its own."""
    mesh = _core.Mesh(SQUARE, np.array([4], np.int32), np.arange(4, dtype=np.int32))
    ball = _core.Quadric.sphere(0.8)
    eye = np.eye(4)
    curve = np.array([[-0.8, 0, 0], [0.8, 0, 0]], np.float32)
    width = np.array([0.6, 0.6], np.float32)
    part = placed(0.25, 0.0, 0.0)
    parts: Any = [("ball", ball, part, "/m", {}, ()), ("m", mesh, eye, "/m", {}, ())]
    prototype = _core.Prototype(parts)
    spots = _core.Spheres(np.zeros((1, 3), np.float32), np.array([1.2], np.float32))
    tubes = _core.Curves(curve, np.array([2], np.int32), width, "vertex", "linear", "nonperiodic")
    rows = np.concatenate([np.eye(3), [[0.125, 0.0, 0.0]]])[np.newaxis]
    return {
        "mesh": mesh,
        "ball": ball,
        "points": spots,
        "curves": tubes,
        "instance": prototype,
        "array": _core.InstanceArray([prototype], rows),
    }


WHERE = {
    "turned": TURN @ placed(0.3, -0.2, -3.0),
    "scaled": np.diag([0.5, 2.0, -1.0, 1.0]) @ placed(-0.1, 0.0, -2.0),
}
AOVS = ("position", "normal", "objectId")


def seen(
    shape: Any, world_from_object: Any, nodes: list[Any]
) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """(h, w, 3) of what a graph shows, and the AOVs."""
    changes = _core.ChangeSet()
    changes.set_material("/m", glowing(nodes, 0.125, 0.5))
    changes.set_object("/o", shape, world_from_object, "/m")
    camera = _core.Camera(np.eye(4), (-0.6, 0.6, -0.6, 0.6))
    renderer = _core.Renderer(camera, _core.ViewSettings(24, 24, aovs=AOVS))
    renderer.update(changes)
    aovs = {name: np.array(renderer.aov(name), dtype=float) for name in AOVS}
    shown = (renderer.beauty()[..., :3].astype(float) - 0.5) / 0.125
    return shown, aovs


def world(op: str, to: str) -> list[Any]:
    return [_core.ShadeNode(op), _core.ShadeNode(to, [0])]


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("kind", ["mesh", "ball", "points", "curves", "instance", "array"])
def test_positions_and_normals_in_the_world(kind: str, where: str) -> None:
    """As the AOVs have them, which are another way to the same."""
    shape, matrix = shapes()[kind], WHERE[where]
    nodes = world("position", "point_to_world")
    shown, aovs = seen(shape, matrix, nodes)
    hit = aovs["objectId"] > 0
    assert hit.sum() > 10
    np.testing.assert_allclose(shown[hit], aovs["position"][hit], atol=1e-5)
    nodes = [*world("normal", "normal_to_world"), _core.ShadeNode("normalize", [1])]
    shown, aovs = seen(shape, matrix, nodes)
    # The AOV's is on the viewer's side.
    sign = np.sign((shown[hit] * aovs["normal"][hit]).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(sign * shown[hit], aovs["normal"][hit], atol=1e-5)
    nodes = [*world("view", "vector_to_world"), _core.ShadeNode("normalize", [1])]
    shown, _ = seen(shape, matrix, nodes)
    way = aovs["position"][hit]
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    np.testing.assert_allclose(shown[hit], way, atol=1e-5)


@pytest.mark.parametrize("where", WHERE)
@pytest.mark.parametrize("kind", ["mesh", "ball", "curves"])
def test_object_space_moves_along(kind: str, where: str) -> None:
    shape, matrix = shapes()[kind], WHERE[where]
    shown, aovs = seen(shape, matrix, [_core.ShadeNode("position")])
    hit = aovs["objectId"] > 0
    there = np.append(aovs["position"][hit], np.ones((hit.sum(), 1)), axis=1)
    np.testing.assert_allclose(shown[hit], (there @ np.linalg.inv(matrix))[:, :3], atol=2e-5)
    back, _ = seen(
        shape,
        matrix,
        [*world("position", "point_to_world"), _core.ShadeNode("point_to_object", [1])],
    )
    np.testing.assert_allclose(back[hit], shown[hit], atol=1e-6)


def test_a_textures_footprint_follows_positions() -> None:
    """A picture laid on by position is filtered as one laid on by st of the same size."""
    fine = np.indices((256, 256)).sum(axis=0) % 2
    texture = _core.Texture([(0, 0, fine.astype(np.float32))])
    st: Any = {"st": ("vertex", SQUARE[:, :2] * np.float32(2), None)}
    counts, indices = np.array([4], np.int32), np.arange(4, dtype=np.int32)
    changes = _core.ChangeSet()
    lookups = {
        "position": [_core.ShadeNode("position"), _core.ShadeNode("multiply", [0], [0, 2])],
        "st": [_core.ShadeNode("primvar", primvar="st")],
    }
    pictures = []
    for nodes in lookups.values():
        nodes.append(_core.ShadeNode("texture", [len(nodes) - 1], texture=texture))
        changes.set_material("/m", glowing(nodes))
        mesh = _core.Mesh(SQUARE, counts, indices, primvars=st)
        changes.set_object("/o", mesh, TILT @ placed(0.0, 0.0, -2.0), "/m")
        camera = _core.Camera(np.eye(4), (-0.6, 0.6, -0.6, 0.6))
        renderer = _core.Renderer(camera, _core.ViewSettings(16, 16))
        renderer.update(changes)
        pictures.append(renderer.beauty()[..., 0].copy())
    np.testing.assert_allclose(pictures[0], pictures[1], atol=1e-5)
    assert 0.4 < pictures[0][8, 8] < 0.6
