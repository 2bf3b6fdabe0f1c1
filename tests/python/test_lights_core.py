# SPDX-License-Identifier: Apache-2.0
"""Levels of lights against closed forms, and edits of every kind of theirs."""

from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import edits
import scenes
from irt_usd import _core

Array = NDArray[np.float64]

FLOOR = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
"""A plane across z turned across y, seen from above."""
ABOVE = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 10, 0, 1]], float)
SIZE = 33
HALF = 4.0


def floor_levels(*lights: Any, **extra: Any) -> tuple[Array, Array]:
    """Radiance of a white Lambert floor at y = 0, and its positions; times pi it is irradiance."""
    changes = _core.ChangeSet()
    changes.set_material(
        "m",
        _core.Material(
            diffuse_color=(1, 1, 1), use_specular_workflow=True, specular_color=(0, 0, 0)
        ),
    )
    changes.set_object("/floor", _core.Quadric.plane(100, 100), FLOOR, "m")
    for path, shape, world in extra.get("objects", ()):
        changes.set_object(path, shape, world, "m")
    for i, light in enumerate(lights):
        changes.set_light(f"/l{i}", light)
    window = (-HALF, HALF, -HALF, HALF)
    camera = _core.Camera(ABOVE, window, True)
    renderer = _core.Renderer(camera, _core.ViewSettings(SIZE, SIZE, aovs=("position",)))
    renderer.update(changes)
    renderer.validate()
    return renderer.beauty()[..., 0].astype(float), renderer.aov("position").astype(float)


DOWN = {"axis": (0.0, -1.0, 0.0), "side": (1.0, 0.0, 0.0)}
HEIGHT = 3.0


def point(**modifiers: Any) -> _core.Light:
    return _core.Light.point((0, HEIGHT, 0), (2, 2, 2), modifiers={**DOWN, **modifiers})


def angles(positions: Array) -> tuple[Array, Array, Array]:
    """Polar and azimuth (degrees) from a light that shines down, and what is left of intensity."""
    x, z = positions[..., 0], positions[..., 2]
    squared = x * x + z * z + HEIGHT**2
    cosine = HEIGHT / np.sqrt(squared)
    up = np.cross(DOWN["side"], DOWN["axis"])
    around = np.degrees(np.arctan2(positions @ up, x)) % 360
    return np.degrees(np.arccos(cosine)), around, cosine / squared / pi * 2


def expected(share: Array, positions: Array) -> Array:
    """Of UsdPreviewSurface with F0 = 0 and F90 = 1: Lambert less Fresnel's share, and GGX."""
    polar, _, falloff = angles(positions)
    half = np.cos(np.radians(polar) / 2)
    fresnel = (1 - half) ** 5
    level: Array = share * falloff * (1 - fresnel) + specular(polar) * falloff * pi * share
    return level


def specular(polar: Array) -> Array:
    """GGX of roughness 0.5 with F0 = 0 and F90 = 1, seen along the normal."""
    a2 = 0.25**2
    nl = np.cos(np.radians(polar))
    nh = np.cos(np.radians(polar) / 2)
    d = nh * nh * (a2 - 1) + 1
    distribution = a2 / (pi * d * d)
    visibility = 0.5 / (nl + np.sqrt(nl * nl * (1 - a2) + a2))
    shine: Array = distribution * visibility * (1 - nh) ** 5
    return shine


@pytest.mark.parametrize(
    ("modifiers", "share"),
    [
        ({}, lambda p, a: np.ones_like(p)),
        ({"profile": "facing"}, lambda p, a: np.cos(np.radians(p))),
        (
            {"profile": "round"},
            lambda p, a: np.sqrt(1 - (np.sin(np.radians(p)) * np.cos(np.radians(a))) ** 2),
        ),
        ({"cone_angle": 30.0}, lambda p, a: (p <= 30).astype(float)),
        (
            {"cone_angle": 40.0, "cone_softness": 0.5},
            lambda p, a: 1 - smooth((p - 20) / 20),
        ),
        ({"focus": 3.0}, lambda p, a: np.cos(np.radians(p)) ** 3),
        (
            {"focus": 3.0, "focus_tint": (0.5, 0.5, 0.5)},
            lambda p, a: 0.5 + 0.5 * np.cos(np.radians(p)) ** 3,
        ),
        (
            {"ies": ((0.0, 30.0, 60.0), (0.0,), (3.0, 2.0, 0.5))},
            lambda p, a: np.where(p <= 60, np.interp(p, (0, 30, 60), (3, 2, 0.5)), 0),
        ),
        (
            {"ies": ((0.0, 90.0), (0.0, 90.0), (1.0, 1.0, 3.0, 3.0))},
            lambda p, a: 1 + 2 * np.minimum(fold(a), 90) / 90,
        ),
    ],
)
def test_levels_on_a_floor(modifiers: dict[str, Any], share: Any) -> None:
    levels, positions = floor_levels(point(**modifiers))
    polar, around, _ = angles(positions)
    np.testing.assert_allclose(
        levels, expected(share(polar, around), positions), rtol=2e-4, atol=1e-6
    )


def smooth(t: Array) -> Array:
    t = np.clip(t, 0, 1)
    step: Array = t * t * (3 - 2 * t)
    return step


def fold(around: Array) -> Array:
    """Quadrants mirrored into the first."""
    half = np.minimum(around, 360 - around)
    quadrant: Array = np.minimum(half, 180 - half)
    return quadrant


def test_area_light_far_away_is_its_rectangle() -> None:
    """The integral over a rectangle, ten times its size away, to 1 %; on axis and off it."""
    side, radiance = 0.3, 5.0
    levels, positions = floor_levels(
        _core.Light.point(
            (0, HEIGHT, 0), (radiance * side**2,) * 3, modifiers={**DOWN, "profile": "facing"}
        )
    )
    steps = (np.arange(20) + 0.5) / 20 * side - side / 2
    for y, x in ((16, 16), (16, 24), (3, 5)):
        total = 0.0
        for sx in steps:
            for sz in steps:
                way = np.array([sx, HEIGHT, sz]) - positions[y, x]
                squared = way @ way
                total += radiance * (way[1] ** 2 / squared) / squared * (side / 20) ** 2
        whole = expected(np.ones((SIZE, SIZE)), positions)[y, x] / (angles(positions)[2][y, x] * pi)
        assert levels[y, x] == pytest.approx(total * whole, rel=0.01)


@pytest.mark.parametrize("share", [0.0, 0.25])
def test_diffuse_and_specular_multipliers(share: float) -> None:
    whole, _ = floor_levels(point())
    diffuse, _ = floor_levels(point(specular=0.0, diffuse=share))
    only, _ = floor_levels(point(specular=0.0))
    shine, _ = floor_levels(point(diffuse=0.0))
    np.testing.assert_allclose(only + shine, whole, rtol=1e-5)
    np.testing.assert_allclose(diffuse, only * share, rtol=1e-6)


BALL = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 1.5, 0, 1]], float)


def test_shadow_colour_and_distance() -> None:
    ball = [("/ball", _core.Quadric.sphere(0.25), BALL)]
    bare, _ = floor_levels(point())
    dark, positions = floor_levels(point(), objects=ball)
    under = (positions[..., 1] == 0) & (dark == 0)
    assert np.count_nonzero(under) > 4
    tinted, _ = floor_levels(point(shadow_color=(0.25, 0.25, 0.25)), objects=ball)
    np.testing.assert_allclose(tinted[under], bare[under] / 4, rtol=1e-5)
    near, _ = floor_levels(point(shadow_distance=1.0), objects=ball)
    np.testing.assert_array_equal(near[under], bare[under])
    far, _ = floor_levels(point(shadow_distance=1.8), objects=ball)
    np.testing.assert_array_equal(far[under], 0)


def test_light_linking() -> None:
    ball = [("/ball", _core.Quadric.sphere(0.25), BALL)]
    plain, positions = floor_levels(point(), objects=ball)
    unlit, _ = floor_levels(point(unlit=["/floor", "/nowhere"]), objects=ball)
    on_floor = np.abs(positions[..., 1]) < 1e-6
    assert not unlit[on_floor].any()
    np.testing.assert_array_equal(unlit[~on_floor], plain[~on_floor])


def test_environment_is_seen_beyond_and_lights_nothing() -> None:
    changes = _core.ChangeSet()
    changes.set_material("m", _core.Material(metallic=1.0, roughness=0.0, diffuse_color=(1, 1, 1)))
    world = np.eye(4)
    world[3, 2] = -5
    changes.set_object("/mirror", _core.Quadric.plane(2, 2), world, "m")
    changes.set_light("/sky", _core.Light.environment((0.25, 0.5, 2)))
    renderer = _core.Renderer(
        _core.Camera(np.eye(4), (-0.6, 0.6, -0.5, 0.5)), _core.ViewSettings(16, 12)
    )
    renderer.update(changes)
    renderer.validate()
    beauty = renderer.beauty()
    np.testing.assert_allclose(beauty[..., :3], np.broadcast_to((0.25, 0.5, 2), (12, 16, 3)))
    assert beauty[0, 0, 3] == 0
    assert beauty[6, 8, 3] == 1


# ---- edits


def shaped(kind: str, **modifiers: Any) -> Any:
    aim = {"axis": (0.0, -0.6, -0.8), "side": (1.0, 0.0, 0.0)}
    if kind == "distant":
        return _core.Light.distant((0.3, -1.0, -0.2), (1, 1, 0.9), modifiers=modifiers)
    return _core.Light.point((1, 2, -4), (9, 9, 9), modifiers={**aim, **modifiers})


RESHAPED: dict[str, list[scenes.Edit]] = {
    "cone": [("light", "/fill", shaped("point", cone_angle=40.0, cone_softness=0.5))],
    "focus": [("light", "/fill", shaped("point", focus=4.0))],
    "profile": [("light", "/fill", shaped("point", profile="facing"))],
    "web": [("light", "/fill", shaped("point", ies=((0.0, 90.0), (0.0,), (1.0, 0.5))))],
    "diffuse": [("light", "/key", shaped("distant", diffuse=0.5))],
    "specular": [("light", "/key", shaped("distant", specular=0.0))],
    "shadow colour": [("light", "/key", shaped("distant", shadow_color=(0.5, 0, 0)))],
}
LINKED: dict[str, list[scenes.Edit]] = {
    "one object": [("light", "/key", shaped("distant", unlit=["/a"]))],
    "an instance": [("light", "/key", shaped("distant", unlit=["/e"]))],
    "two lights": [
        ("light", "/key", shaped("distant", unlit=["/floor"])),
        ("light", "/fill", shaped("point", unlit=["/a", "/b"])),
    ],
}
START: list[scenes.Edit] = [
    ("light", "/key", shaped("distant")),
    ("light", "/fill", shaped("point")),
]


def played(*frames: list[scenes.Edit], foreseen: bool = False) -> list[dict[str, Any]]:
    return edits.play(edits.Shot("crowd", list(frames), samples=2, foreseen=foreseen))


@pytest.mark.parametrize("name", RESHAPED)
def test_shaping_responds_again_and_keeps_shadow_rays(name: str) -> None:
    plain = played(START, RESHAPED[name], START, [("undo", 1)])
    for update in plain[2:4]:
        assert update["shadings"] > 0
        assert update["new_rays"] == 0
        assert update["rays"]["primary"] == update["rays"]["reflected"] == 0
    if name in ("diffuse", "specular", "shadow colour"):
        assert sum(plain[2]["rays"].values()) == 0


@pytest.mark.parametrize("name", LINKED)
def test_linking_shades_again_what_is_linked(name: str) -> None:
    plain = played(START, LINKED[name], START, LINKED[name], [("shift", "/a", (0.2, 0.0, 0.0))])
    off, on = plain[2], plain[3]
    assert sum(off["rays"].values()) == 0  # what is not lit needs no ray
    assert on["new_rays"] == on["rays"]["primary"] == on["rays"]["reflected"] == 0
    assert 0 < off["shadings"] < off["all_rays"]
    assert on["rays"]["shadow"] <= on["shadings"] * 2


SKY: list[scenes.Edit] = [("light", "/sky", _core.Light.environment((0.5, 0.6, 0.7)))]


@pytest.mark.parametrize("foreseen", [False, True])
def test_a_sky_comes_shines_otherwise_and_goes(foreseen: bool) -> None:
    brighter: list[scenes.Edit] = [("light", "/sky", _core.Light.environment((1, 0.5, 0.25)))]
    move: list[scenes.Edit] = [("shift", "/a", (0.5, 0.0, 0.0)), ("hide", "/floor")]
    done = played(SKY, brighter, move, [("show", "/floor")], [("dark", "/sky")], foreseen=foreseen)
    assert sum(done[2]["rays"].values()) == done[2]["shadings"] == 0
    assert sum(done[5]["rays"].values()) == 0


@pytest.mark.parametrize("foreseen", [False, True])
def test_all_light_edits_in_a_row_are_exact(foreseen: bool) -> None:
    near: list[scenes.Edit] = [("light", "/key", shaped("distant", shadow_distance=2.0))]
    hide: list[scenes.Edit] = [("hide", "/floor")]
    frames = [START, *RESHAPED.values(), SKY, *LINKED.values(), hide, near, [("undo", 3)]]
    played(*frames, foreseen=foreseen)


def test_what_joins_the_scene_is_not_lit_if_linking_says_so() -> None:
    room = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1.0, 0.25, -4.5, 1))
    late: list[scenes.Edit] = [("object", "/late", ("sphere", 0.5), room, "/red")]
    played(
        [("light", "/key", shaped("distant", unlit=["/late"]))], late, [("remove", "/late")], late
    )
