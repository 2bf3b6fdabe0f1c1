# SPDX-License-Identifier: Apache-2.0
"""Textured materials: what their edits cost, and pictures against closed forms."""

import gc
import weakref
from typing import Any

import numpy as np
import pytest

import edits
import scenes
import textures
from irt_usd import _core
from scenes import Edit

NORMAL = ("normal", textures.texture(("bumps", 9, 16), scale=(2, 2, 2, 1), bias=(-1, -1, -1, 0)))

SHADING: dict[str, list[Edit]] = {
    "another texture": [
        ("texture", "/paper", "diffuse_color", textures.texture(("noise", 9, 7, 3, "u1")))
    ],
    "its scale and bias": [("retexture", "/paper", {"scale": 0.5, "bias": 0.125})],
    "its transform": [("retexture", "/paper", {"turn": (2.0, 30.0, 0.25)})],
    "its wrap": [("retexture", "/paper", {"wrap": ("black", "mirror")})],
    "none any more": [("texture", "/paper", "diffuse_color", None)],
    "emission": [("retexture", "/screen", {"scale": 2.0})],
}
"""Of opaque, rough surfaces: they cost no ray."""

SPAWNED: dict[str, list[Edit]] = {
    "normal map": [("texture", "/tiles", *NORMAL)],
    "bumps no more": [("texture", "/tiles", "normal", None)],
    "scale and bias of the normals": [
        (
            "texture",
            "/tiles",
            "normal",
            NORMAL[1] | {"scale": (1, 1, 2, 1), "bias": (-0.5, -0.5, -1)},
        )
    ],
    "transform of all textures": [("retexture", "/tiles", {"turn": (3.0, 45.0, 0.5)})],
    "roughness": [("texture", "/tiles", "roughness", textures.texture(("noise", 9, 4, 1, "u1")))],
    "coat": [("look", "/tiles", {"clearcoat": 0.25, "clearcoat_roughness": 0.0})],
}
"""These trace spawned rays again, and nothing else."""

TINTS: dict[str, list[Edit]] = {
    "holes": [("texture", "/lace", "opacity", textures.texture(("noise", 9, 8, 1, "u1")))],
    "threshold": [("look", "/lace", {"opacity_threshold": 0.3})],
    "no threshold": [("look", "/lace", {"opacity_threshold": 0.0})],
    "stain": [("retexture", "/stained", {"turn": (1.0, 90.0, 0.0)})],
    "opaque": [("texture", "/stained", "opacity", None)],
    "threshold by texture": [
        ("texture", "/lace", "opacity_threshold", textures.texture(("noise", 8, 8, 1, "u1")))
    ],
    "all bound anew": [("bind", "/c", "/stained"), ("bind", "/d", "/lace")],
}
ALL = SHADING | SPAWNED | TINTS


def done(frame: list[Edit], samples: int = 4) -> dict[str, Any]:
    """The update's statistics, after edit, undoing and edit again have been exact."""
    frames = [frame, [("undo", 1)], frame, [], [("undo", 4)]]
    return edits.play(edits.Shot("papered", frames, samples=samples))[1]


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("samples", [1, 4])
def test_edit_and_its_undoing_are_exact_and_incremental(name: str, samples: int) -> None:
    assert done(ALL[name], samples)["shadings"] > 0


@pytest.mark.parametrize("name", SHADING)
def test_what_only_shading_reads_costs_no_ray(name: str) -> None:
    update = done(SHADING[name])
    assert update["intersections"] == update["retraced_rays"] == 0
    assert sum(update["rays"].values()) == 0


@pytest.mark.parametrize("name", SPAWNED)
def test_what_bends_and_ends_spawned_rays_traces_those_alone(name: str) -> None:
    update = done(SPAWNED[name])
    rays = update["rays"]
    assert rays["primary"] == update["tested_rays"] == 0
    assert rays["reflected"] > 0
    assert update["retraced_rays"] == rays["reflected"] + rays["refracted"] + rays["shadow"]


@pytest.mark.parametrize("name", TINTS)
def test_shadows_follow_opacity_and_its_textures(name: str) -> None:
    update = done(TINTS[name])
    assert update["rays"]["primary"] == 0
    assert update["rays"]["shadow"] > 0


def test_equal_texels_are_no_change() -> None:
    textures.made.cache_clear()
    renderer = scenes.renderer()
    renderer.update(scenes.papered().fresh())
    textures.made.cache_clear()
    update = renderer.update(scenes.papered().fresh())
    assert update["shadings"] == update["flagged_rays"] == 0


@pytest.mark.parametrize("samples", [1, 4])
def test_brute_force_agrees(samples: int) -> None:
    renderer = scenes.renderer(samples=samples)
    renderer.update(scenes.papered().fresh())
    beauty = renderer.beauty()
    for y in range(20):
        for x in range(24):
            found = renderer.brute_force_pixel(x, y)
            rgba = found["beauty"] if isinstance(found, dict) else found[0]
            assert np.array_equal(beauty[y, x], np.array(rgba, np.float32))


# ---- pictures


def sheet(
    material: _core.Material, above: _core.Material | None = None, size: int = 8, **mesh: Any
) -> _core.Renderer:
    """A unit square, its st from corner to corner, seen from above as `size` by `size` pixels in an
    orthographic view, under light of irradiance pi that comes from there; perhaps one `above`."""
    camera = np.eye(4)
    camera[3, 2] = 5
    settings = _core.ViewSettings(size, size, aovs=("albedo", "normal"))
    window = (-0.5, 0.5, -0.5, 0.5)
    renderer = _core.Renderer(_core.Camera(camera, window, orthographic=True), settings)
    changes = _core.ChangeSet()
    changes.set_material("/m", material)
    points = np.zeros((4, 3), np.float32)
    points[:, :2] = scenes.CORNERS - 0.5
    st = mesh.pop("st", scenes.CORNERS)
    square = _core.Mesh(
        points,
        np.array([4], np.int32),
        np.arange(4, dtype=np.int32),
        primvars={"st": ("vertex", np.asarray(st, np.float32), None)},
        **mesh,
    )
    changes.set_object("/square", square, np.eye(4), "/m")
    if above:
        changes.set_material("/above", above)
        high = np.eye(4)
        high[3, 2] = 10  # behind the camera
        changes.set_object("/above", square, high, "/above")
    changes.set_light("/sun", _core.Light.distant((0, 0, -1), (np.pi,) * 3))
    renderer.update(changes)
    return renderer


def textured(
    texels: np.ndarray, name: str = "diffuse_color", channel: str = "rgb", **others: Any
) -> _core.Material:
    """A rough material one of whose inputs is a texture."""
    texture = _core.Texture([(0, 0, texels)])
    nodes = [
        _core.ShadeNode("primvar", primvar="st"),
        _core.ShadeNode("texture", [0], texture=texture, wrap=("clamp", "clamp")),
    ]
    others = {"roughness": 1.0, **others}
    return _core.Material(**others, nodes=nodes, connected={name: (1, channel)})


def test_texels_lie_where_the_image_has_them() -> None:
    texels = np.random.default_rng(1).random((8, 8, 3)).astype(np.float32)
    assert np.array_equal(sheet(textured(texels)).aov("albedo"), texels)


def test_alpha_cuts_out_from_the_threshold_on() -> None:
    alpha = np.arange(64, dtype=np.float32).reshape(8, 8) / 64
    cut = sheet(textured(alpha, "opacity", "r", opacity_threshold=0.495)).beauty()[..., 3]
    assert np.array_equal(cut, alpha >= 0.5)


def test_cut_outs_cast_the_shadow_of_what_is_left() -> None:
    alpha = (np.arange(64).reshape(8, 8) % 3 == 0).astype(np.float32)
    white = _core.Material(diffuse_color=(1, 1, 1), roughness=1, ior=1)
    above = textured(alpha, "opacity", "r", opacity_threshold=0.5)
    assert np.array_equal(sheet(white, above).beauty()[..., 0] == 0, alpha == 1)


def test_panes_tint_shadows_by_their_texels() -> None:
    texels = np.random.default_rng(1).random((8, 8, 3)).astype(np.float32)
    white = _core.Material(diffuse_color=(1, 1, 1), roughness=1, ior=1)
    lit = sheet(white).beauty()[..., :3]
    shadow = sheet(white, textured(texels, opacity=0.25)).beauty()[..., :3]
    np.testing.assert_allclose(shadow, lit * 0.75 * texels, rtol=3e-4)


def test_emission_is_added_as_it_is() -> None:
    texels = np.random.default_rng(1).random((8, 8, 3)).astype(np.float32)
    dark: dict[str, Any] = {"diffuse_color": (0, 0, 0), "ior": 1.0}
    emitted = sheet(textured(texels, "emissive_color", **dark)).beauty()
    assert np.abs(emitted[..., :3] - texels).max() < 1e-6


def normals(texel: tuple[float, float, float], **mesh: Any) -> np.ndarray:
    texels = np.broadcast_to(np.array(texel, np.float32), (2, 2, 3)).copy()
    return sheet(textured(texels, "normal"), size=2, **mesh).aov("normal")


def test_a_flat_normal_map_is_none() -> None:
    assert np.array_equal(normals((0, 0, 1)), sheet(_core.Material(), size=2).aov("normal"))


MIRRORED = scenes.CORNERS * (-1, 1)
TURNED = scenes.CORNERS[:, ::-1] * (1, -1)


@pytest.mark.parametrize(
    ("st", "expected"),
    [
        (scenes.CORNERS, (0.6, 0, 0.8)),
        (scenes.CORNERS * 7 + 3, (0.6, 0, 0.8)),
        (MIRRORED, (-0.6, 0, 0.8)),
        (TURNED, (0, 0.6, 0.8)),
        (scenes.CORNERS * (0, 1), (0, 0, 1)),
    ],
)
def test_tangents_follow_growing_s(st: np.ndarray, expected: tuple[float, ...]) -> None:
    assert np.allclose(normals((0.6, 0, 0.8), st=st), expected, atol=1e-7)


@pytest.mark.parametrize(
    ("st", "expected"),
    [(scenes.CORNERS, (0, 0.6, 0.8)), (MIRRORED, (0, 0.6, 0.8)), (TURNED, (-0.6, 0, 0.8))],
)
def test_bitangents_follow_growing_t(st: np.ndarray, expected: tuple[float, ...]) -> None:
    assert np.allclose(normals((0, 0.6, 0.8), st=st), expected, atol=1e-7)


def test_primvars_of_the_object_stand_in_for_the_meshs() -> None:
    nodes = [_core.ShadeNode("primvar", constants=[(0.5, 0.25, 0.125)], primvar="displayColor")]
    material = _core.Material(nodes=nodes, connected={"diffuse_color": (0, "rgb")})
    assert np.allclose(sheet(material).aov("albedo"), (0.5, 0.25, 0.125))
    renderer = scenes.renderer()
    changes = _core.ChangeSet()
    changes.set_material("/m", material)
    at = np.eye(4)
    at[3, 2] = -5
    color: dict[str, Any] = {
        "displayColor": ("constant", np.array([[1, 0.5, 0]], np.float32), None)
    }
    changes.set_object("/ball", _core.Quadric.sphere(1), at, "/m", color)
    renderer.update(changes)
    assert renderer.aov("albedo")[10, 12].tolist() == [1, 0.5, 0]


# ---- memory and bad input

NONSENSE: Any = "periodic"


def test_texels_are_shared_and_let_go() -> None:
    texels = np.zeros((4, 4, 3), np.uint8)
    gone = weakref.ref(texels)
    texture = _core.Texture([(0, 0, texels)])
    material = _core.Material(nodes=[_core.ShadeNode("texture", texture=texture)])
    coarse = texture.without_finest(1)
    del texels, texture
    gc.collect()
    assert gone() is not None
    del material
    gc.collect()
    assert gone() is None
    assert coarse.level_bytes == [12, 3]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: _core.Texture([(0, 0, np.zeros((2, 2), np.int64))]), "texels must be uint8"),
        (lambda: _core.Texture([(0, 0, np.zeros(2, np.uint8))]), "must have shape"),
        (lambda: _core.Texture([(0, 0, np.zeros((2, 2, 5), np.uint8))]), "1 to 4 channels"),
        (lambda: _core.Texture([]), "needs a tile"),
        (
            lambda: _core.Texture([(0, 0, np.zeros((2, 2), "u1"))], transfer=NONSENSE),
            "transfer 'periodic'",
        ),
        (lambda: _core.ShadeNode("noise"), "op 'noise' is unknown"),
        (lambda: _core.ShadeNode("texture", wrap=(NONSENSE, "clamp")), "wrap 'periodic'"),
        (lambda: _core.ShadeNode("swizzle", swizzle="xyzw"), "must consist of"),
        (lambda: _core.Material(nodes=[_core.ShadeNode("texture")]), "node 0 has no texture"),
        (lambda: _core.Material(nodes=[_core.ShadeNode("add", [0])]), "no earlier one"),
        (lambda: _core.Material(connected={"ior": (0, "r")}), "connected to node 0 of 0"),
        (lambda: _core.Material(connected={"occlusion": (0, "r")}), "input 'occlusion' is unknown"),
    ],
)
def test_bad_input_is_refused(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
