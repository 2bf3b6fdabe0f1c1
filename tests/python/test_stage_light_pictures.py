# SPDX-License-Identifier: Apache-2.0
"""Pictures on domes and rectangles, read from stages: place, colour, policy, edits."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from conftest import MakeShot, ReadShot
from irt_usd.changes import diff
from irt_usd.errors import InputError
from irt_usd.stage import LightState, ReadOptions
from textured import write_image

UNIT = "float inputs:intensity = 1\n"
FILE = "asset inputs:texture:file = @./sky.exr@\n"
Y_UP, Z_UP = 'upAxis = "Y"', 'upAxis = "Z"'


def light(kind: str, body: str, schemas: str = "") -> str:
    metadata = f'(\nprepend apiSchemas = ["{schemas}"]\n)' if schemas else ""
    return f'def {kind} "L" {metadata}\n{{\n{body}\n}}'


def lit(made: ReadShot, time: float = 1) -> LightState:
    return made.read(time).lights["/L"]


@pytest.fixture(autouse=True)
def sky(tmp_path: Path) -> np.ndarray:
    pixels = np.random.default_rng(1).random((8, 16, 3)).astype(np.float32)
    write_image(tmp_path / "sky.exr", pixels)
    write_image(tmp_path / "other.exr", pixels[::-1].copy())
    return pixels


def axes(shot: MakeShot, kind: str, body: str, metadata: str) -> np.ndarray:
    made = shot(light(kind, UNIT + FILE + body), metadata=metadata, name=f"{len(body)}{kind}.usda")
    found = lit(made).sky
    assert found is not None
    return np.array(found.axes)


TURN = "float xformOp:rotateX = 90\n" + 'uniform token[] xformOpOrder = ["xformOp:rotateX"]\n'
MIRRORED = (
    "float3 xformOp:scale = (-2, 3, 0.5)\ndouble3 xformOp:translate = (9, 9, 9)\n"
    'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]'
)
UPRIGHT = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
POLE_Z = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
"""Latitudes along z, longitude 0 towards -y."""


@pytest.mark.parametrize(
    ("kind", "body", "metadata", "expected"),
    [
        ("DomeLight", "", Y_UP, UPRIGHT),
        ("DomeLight", "", Z_UP, UPRIGHT),
        ("DomeLight", TURN, Y_UP, POLE_Z),
        ("DomeLight_1", "", Y_UP, UPRIGHT),
        ("DomeLight_1", "", Z_UP, POLE_Z),
        ("DomeLight_1", 'uniform token poleAxis = "Z"', Y_UP, POLE_Z),
        ("DomeLight_1", 'uniform token poleAxis = "Y"', Z_UP, UPRIGHT),
        ("DomeLight_1", TURN + 'uniform token poleAxis = "Y"', Z_UP, POLE_Z),
        (
            "DomeLight",
            MIRRORED,
            Y_UP,
            [[-1, 0, 0], [0, 1, 0], [0, 0, 1]],
        ),
    ],
)
def test_orientation(
    shot: MakeShot, kind: str, body: str, metadata: str, expected: list[list[float]]
) -> None:
    np.testing.assert_allclose(axes(shot, kind, body, metadata), expected, atol=1e-12)


def test_a_dome_that_is_flat_is_skipped(shot: MakeShot) -> None:
    flat = 'float3 xformOp:scale = (1, 0, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]'
    made = shot(light("DomeLight", UNIT + FILE + flat))
    assert not made.read().lights
    (text,) = made.notices("skipped")
    assert "no orientation" in text
    assert "/L.xformOp:scale" in text


def irradiances(made: ReadShot) -> np.ndarray:
    """Sum over the dome's lights."""
    state = lit(made)
    assert state.sky is not None
    ways = [(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)]
    total: np.ndarray = np.array(state.sky.irradiances(ways)).sum(axis=0)
    return total


def test_colour_space(shot: MakeShot, tmp_path: Path, sky: np.ndarray) -> None:
    """Files say what they are: 8 bits sRGB, floats linear Rec.709; attributes say otherwise."""
    linear = irradiances(shot(light("DomeLight", UNIT + FILE)))
    edges = np.cos(pi * np.arange(9) / 8)
    bands = (edges[:-1] - edges[1:]) * 2 * pi
    np.testing.assert_allclose(linear, bands @ sky.mean(axis=1), rtol=1e-6)
    code = np.full((4, 8, 3), 128, np.uint8)
    write_image(tmp_path / "sky.png", code)
    srgb = irradiances(shot(light("DomeLight", UNIT + FILE.replace("exr", "png")), name="b.usda"))
    np.testing.assert_allclose(srgb, 4 * pi * ((128 / 255 + 0.055) / 1.055) ** 2.4, rtol=1e-6)
    raw = FILE.replace("exr", "png").rstrip() + ' (\ncolorSpace = "raw"\n)\n'
    found = irradiances(shot(light("DomeLight", UNIT + raw), name="c.usda"))
    np.testing.assert_allclose(found, 4 * pi * 128 / 255, rtol=1e-6)
    wide = FILE.rstrip() + ' (\ncolorSpace = "lin_ap1_scene"\n)\n'
    found = irradiances(shot(light("DomeLight", UNIT + wide), name="d.usda"))
    assert found[0] / found[2] != pytest.approx(linear[0] / linear[2], rel=1e-3)


def test_a_rectangles_power_is_that_of_its_picture(shot: MakeShot, sky: np.ndarray) -> None:
    plain = lit(shot(light("RectLight", UNIT + "float inputs:width = 3"))).energy
    made = shot(light("RectLight", UNIT + "float inputs:width = 3\n" + FILE), name="t.usda")
    expected = np.array(plain) * sky.astype(float).mean(axis=(0, 1))
    np.testing.assert_allclose(lit(made).energy, expected, rtol=1e-6)


def test_other_lights_have_no_pictures(shot: MakeShot) -> None:
    made = shot(light("DiskLight", UNIT + FILE.replace("sky", "nowhere")))
    assert lit(made).energy == pytest.approx((pi / 4,) * 3)


@pytest.mark.parametrize("kind", ["DomeLight", "RectLight"])
@pytest.mark.parametrize("content", [None, b"nothing of an image"])
def test_files_that_cannot_be_had(
    shot: MakeShot, tmp_path: Path, kind: str, content: bytes | None
) -> None:
    if content is not None:
        (tmp_path / "gone.exr").write_bytes(content)
    body = light(kind, UNIT + FILE.replace("sky", "gone"))
    with pytest.raises(InputError, match=r"textures.*--missing-asset fallback") as caught:
        shot(body)
    assert "/L.inputs:texture:file in" in str(caught.value)
    made = shot(body, options=ReadOptions(missing_asset="fallback"))
    assert lit(made).sky is None
    assert lit(made).energy == (1, 1, 1)
    (text,) = made.notices("skipped")
    assert "/L.inputs:texture:file in" in text


def test_a_format_that_is_not_rendered(shot: MakeShot) -> None:
    form = 'token inputs:texture:format = "mirroredBall"\n'
    made = shot(light("DomeLight", UNIT + FILE.replace("sky", "nowhere") + form))
    assert lit(made).sky is None
    (text,) = made.notices("unsupported")
    assert "mirroredBall" in text
    latlong = shot(
        light("DomeLight", UNIT + FILE + form.replace("mirroredBall", "latlong")), name="b.usda"
    )
    assert lit(latlong).sky is not None


@pytest.mark.parametrize(
    "keys",
    [
        "asset inputs:texture:file.timeSamples = {1: @./sky.exr@, 2: @./other.exr@}\n",
        FILE
        + "float xformOp:rotateY.timeSamples = {1: 0, 2: 50}\n"
        + 'uniform token[] xformOpOrder = ["xformOp:rotateY"]\n',
        FILE + "float inputs:exposure.timeSamples = {1: 0, 2: 1}\n",
    ],
)
def test_edits_of_a_dome_need_no_rays(shot: MakeShot, keys: str) -> None:
    made = shot(light("DomeLight", UNIT + keys), frames=(1, 2))
    first, second = made.read(1), made.read(2)
    assert made.read(1).lights["/L"] is not second.lights["/L"]
    for change in diff(first, second).changes:
        assert change.invalidates == "light energy only (no rays)"


def test_guide_radius_is_a_viewports(shot: MakeShot) -> None:
    made = shot(light("DomeLight", UNIT + "float guideRadius = 3"))
    assert any("guideRadius" in text for text in made.notices("mentioned"))
