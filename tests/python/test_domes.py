# SPDX-License-Identifier: Apache-2.0
"""Domes with a picture: where it is seen, what it lights, and edits of it."""

from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import edits
from irt_usd import _core

Array = NDArray[np.float64]

AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
WIDTH, HEIGHT = 64, 32


def picture(texels: Any) -> _core.Texture:
    return _core.Texture([(0, 0, np.ascontiguousarray(texels, np.float32))])


def directions_of_texels(width: int = WIDTH, height: int = HEIGHT) -> Array:
    """As OpenEXR has lat-long maps: the first pixel at latitude pi/2, longitude pi."""
    latitude = pi * (0.5 - (np.arange(height) + 0.5) / height)
    longitude = pi * (1 - 2 * (np.arange(width) + 0.5) / width)
    lat, lon = np.meshgrid(latitude, longitude, indexing="ij")
    return np.stack([np.cos(lat) * np.sin(lon), np.sin(lat), np.cos(lat) * np.cos(lon)], axis=-1)


def solid_angles(width: int = WIDTH, height: int = HEIGHT) -> Array:
    edges = np.cos(pi * np.arange(height + 1) / height)
    return np.repeat((edges[:-1] - edges[1:])[:, None] * 2 * pi / width, width, axis=1)


def seen(axes: Any, look: Array, size: int = 64) -> Array:
    """What a camera sees that looks along -z of `look`, and the directions of its pixels."""
    changes = _core.ChangeSet()
    texels = (directions_of_texels(256, 128) + 1) / 2
    changes.set_light("/sky", _core.Light.environment((1, 1, 1), True, picture(texels), axes))
    renderer = _core.Renderer(
        _core.Camera(look, (-1, 1, -1, 1)), _core.ViewSettings(size, size, samples=1)
    )
    renderer.update(changes)
    renderer.validate()
    return renderer.beauty()[..., :3].astype(float) * 2 - 1


def pixel_directions(look: Array, size: int = 64) -> Array:
    edge = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(edge, -edge)
    camera = np.stack([x, y, np.full_like(x, -1)], axis=-1)
    world = camera @ look[:3, :3]
    unit: Array = world / np.linalg.norm(world, axis=-1, keepdims=True)
    return unit


def rotation(axis: int, degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    m = np.eye(4)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, s, -s, c
    return m


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("degrees", [0, 90, 160, 270])
def test_a_picture_is_where_openexr_has_it(axis: int, degrees: float) -> None:
    """Texels hold their own direction, so that what is seen is the direction looked in."""
    look = rotation(axis, degrees)
    np.testing.assert_allclose(seen(AXES, look), pixel_directions(look), atol=0.02)


def test_a_picture_turns_with_its_axes() -> None:
    turned = rotation(1, 35) @ rotation(0, 20)
    axes = tuple(tuple(row[:3]) for row in turned[:3].tolist())
    look = np.eye(4)
    ways = pixel_directions(look) @ turned[:3, :3].T
    np.testing.assert_allclose(seen(axes, look), ways, atol=0.02)


def test_mirrors_and_glass_show_the_picture() -> None:
    changes = _core.ChangeSet()
    texels = (directions_of_texels(256, 128) + 1) / 2
    changes.set_light("/sky", _core.Light.environment((1, 1, 1), True, picture(texels)))
    white = (1.0, 1.0, 1.0)
    changes.set_material("m", _core.Material(metallic=1.0, roughness=0.0, diffuse_color=white))
    changes.set_material("g", _core.Material(opacity=0.0, ior=1.0, roughness=0.0))
    world = np.eye(4)
    world[3, :3] = (-1, 0, -2)
    changes.set_object("/mirror", _core.Quadric.plane(1, 1), world, "m")
    world[3, 0] = 1
    changes.set_object("/glass", _core.Quadric.plane(1, 1), world, "g")
    renderer = _core.Renderer(
        _core.Camera(np.eye(4), (-1, 1, -0.5, 0.5)), _core.ViewSettings(16, 8, aovs=("depth",))
    )
    renderer.update(changes)
    renderer.validate()
    beauty = renderer.beauty()[..., :3] * 2 - 1
    hit = renderer.aov("depth") > 0
    edge_x, edge_y = (np.arange(16) + 0.5) / 8 - 1, 0.5 - (np.arange(8) + 0.5) / 8
    x, y = np.meshgrid(edge_x, edge_y)
    way = np.stack([x, y, np.full_like(x, -1)], axis=-1)
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    left = hit & (x < 0)
    assert left.any()
    np.testing.assert_allclose(beauty[left], way[left] * (1, 1, -1), atol=0.02)
    np.testing.assert_allclose(beauty[~left], way[~left], atol=0.02)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lights_share_all_of_a_pictures_irradiance(seed: int) -> None:
    """Each direction has the part of the sky nearest to it, so that nothing is lost."""
    texels = np.random.default_rng(seed).random((HEIGHT, WIDTH, 3)) ** 4
    ways = _core.sky_directions(32, (0, 1, 0))
    shares = np.array(_core.SkyCells(picture(texels)).irradiances(AXES, ways))
    radiance = texels * solid_angles()[..., None]
    np.testing.assert_allclose(shares.sum(axis=0), radiance.sum(axis=(0, 1)), rtol=1e-5)
    nearest = (directions_of_texels() @ -np.array(ways).T).argmax(axis=-1)
    for i in range(32):
        np.testing.assert_allclose(shares[i], radiance[nearest == i].sum(axis=0), rtol=1e-5)


@pytest.mark.parametrize(("count", "close"), [(32, 0.05), (128, 0.01), (512, 0.003)])
def test_irradiance_of_a_gradient_sky(count: int, close: float) -> None:
    """Against the integral, as a share of the brightest channel; closer with more directions."""
    up = directions_of_texels()[..., 1:2]
    texels = np.where(up > 0, (0.4, 0.6, 1.0), (0.2, 0.15, 0.1)) * (0.5 + 0.5 * np.abs(up))
    ways = np.array(_core.sky_directions(count, (0, 1, 0)))
    shares = np.array(_core.SkyCells(picture(texels)).irradiances(AXES, ways.tolist()))
    for normal in np.array([[0, 1, 0], [0, -1, 0], [0.6, 0.8, 0], [0, 0.6, -0.8]]):
        lit = np.maximum(-ways @ normal, 0) @ shares
        cosine = np.maximum(directions_of_texels() @ normal, 0) * solid_angles()
        whole = (cosine[..., None] * texels).sum(axis=(0, 1))
        np.testing.assert_allclose(lit, whole, atol=close * whole.max())


def test_what_a_picture_takes_away_lights_nothing() -> None:
    texels = np.full((4, 8, 3), -1.0)
    ways = _core.sky_directions(8, (0, 1, 0))
    assert not np.array(_core.SkyCells(picture(texels)).irradiances(AXES, ways)).any()


def test_a_sky_needs_a_direction() -> None:
    with pytest.raises(ValueError, match="one direction at least"):
        _core.sky_directions(0, (0, 1, 0))


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1)])
def test_even_light_from_above_is_exact_on_a_floor(up: Any) -> None:
    ways = np.array(_core.sky_directions(32, up))
    assert np.maximum(-ways @ up, 0).sum() * 4 * pi / 32 == pytest.approx(pi, rel=1e-9)
    np.testing.assert_allclose(np.linalg.norm(ways, axis=-1), 1)


# ---- edits

NOISE = ("noise", 1, 8, 3, "u1")
OTHER = ("noise", 5, 16, 3, "f4")


def sky(image: Any = NOISE, turn: Any = edits.PLAIN, radiance: Any = (1.0, 1.0, 1.0)) -> Any:
    return [("light", "/sky", ("sky", turn, radiance, image))]


def no_rays(update: dict[str, Any]) -> bool:
    counts = [*update["rays"].values(), update["shadings"], update["new_rays"]]
    return not any(counts)


@pytest.mark.parametrize("foreseen", [False, True])
def test_no_edit_of_a_sky_traces_or_shades_anything(foreseen: bool) -> None:
    frames: list[Any] = [
        sky(),
        sky(OTHER),
        sky(OTHER, edits.TURNS[0]),
        sky(OTHER, edits.TURNS[0], (0.5, 2.0, 0.0)),
        sky(None),
        [("dark", "/sky")],
        sky(),
    ]
    for start in ("crowd", "papered"):
        done = edits.play(edits.Shot(start, frames, samples=2, foreseen=foreseen))
        assert all(map(no_rays, done[1:]))


def test_what_moves_under_a_sky() -> None:
    move: list[Any] = [("shift", "/b", (0.5, 0.25, 0.0))]
    frames = [sky(), move, [*move, *sky(OTHER)], [("hide", "/floor")], [("undo", 2)]]
    edits.play(edits.Shot("crowd", frames, samples=4))
