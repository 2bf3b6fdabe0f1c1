# SPDX-License-Identifier: Apache-2.0
"""The USD Assets Working Group's texture tests: what their READMEs call the correct result."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from textured import picture, srgb

ROOT = Path(__file__).parents[3] / "shared" / "assets" / "test_assets"

pytestmark = pytest.mark.skipif(not ROOT.exists(), reason=f"{ROOT} is not there")

SUN = """def DistantLight "Sun"
{{
    float inputs:angle = 0
    float inputs:intensity = 3
    double3 xformOp:rotateXYZ = {}
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}}
"""


def ortho(
    folder: Path,
    asset: str,
    centre: tuple[float, float, float],
    width: float,
    turn: str = "(0, 0, 0)",
    extra: str = "",
) -> Path:
    """A stage that looks at `centre` from 1000 units away, square and `width` units wide."""
    stage = folder / "wrapper.usda"
    x, y, z = centre
    stage.write_text(f"""#usda 1.0
(
    subLayers = [@{ROOT / asset}@]
)
def Xform "View"
{{
    double3 xformOp:translate = ({x}, {y}, {z})
    double3 xformOp:rotateXYZ = {turn}
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
    def Camera "Camera"
    {{
        token projection = "orthographic"
        float horizontalAperture = {width * 10}
        float verticalAperture = {width * 10}
        float2 clippingRange = (1, 10000)
        double3 xformOp:translate = (0, 0, 1000)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
}}
{extra}""")
    return stage


def seen(stage: Path, side: int = 200, **options: Any) -> np.ndarray:
    image = picture(stage, camera="/View/Camera", size=(side, side), camera_light=True, **options)
    rgb: np.ndarray = image.astype(float)
    return rgb


def test_texture_coordinates(tmp_path: Path) -> None:
    """Each corner's square shows the part of the template that says so, in its colour."""
    folder = "TextureCoordinateTest"
    image = seen(ortho(tmp_path, f"{folder}/{folder}.usda", (0, 0, 0), 3))
    place = {"left": 40, "right": 160, "top": 60, "bottom": 140}

    def colour(x: str, y: str) -> np.ndarray:
        patch = image[place[y] - 10 : place[y] + 10, place[x] - 10 : place[x] + 10]
        mean: np.ndarray = patch.mean(axis=(0, 1))
        relative: np.ndarray = mean / mean.max()
        return relative

    assert (colour("left", "top") > (0.7, 0.7, -1)).all()  # yellow
    assert colour("left", "top")[2] < 0.3
    assert colour("right", "top").argmax() == 0  # orange
    assert colour("left", "bottom").argmax() == 2  # blue
    assert colour("right", "bottom").argmax() == 1  # green


def test_texture_transforms(tmp_path: Path) -> None:
    """The arrows of the lower row point at the marks called correct; the upper row shows ticks.

    The conversion to USD has lost that the marks' places are relative to their squares.
    """
    asset = "TextureTransformTest/TextureTransformTest.usd"
    stage = Usd.Stage.Open(str(ROOT / asset))
    side, width = 400, 340.0
    image = seen(ortho(tmp_path, asset, (0, 0, 0), width), side)

    def offset_of(name: str) -> np.ndarray:
        prim = UsdGeom.Xformable(stage.GetPrimAtPath(f"/TextureTransformTest/{name}"))
        x, y, _ = prim.ComputeLocalToWorldTransform(0).ExtractTranslation()
        return np.array([x, -y]) / width * side

    def pixel(name: str) -> np.ndarray:
        return offset_of(name) + side / 2

    for name, expected in (
        ("Offset_U", (0, 1, 0)),
        ("Offset_V", (0, 0, 1)),
        ("Offset_UV", (0, 1, 1)),
    ):
        x, y = pixel(name).astype(int)
        corner = image[y - 45, x - 45]
        np.testing.assert_array_equal(corner > 0.2, np.array(expected, bool))
    for name in ("Rotation", "Scale", "All"):
        centre = pixel(name)
        mark = centre + offset_of(f"{name}___Correct")
        rows, columns = np.indices(image.shape[:2])
        inside = (abs(columns + 0.5 - centre[0]) < 55) & (abs(rows + 0.5 - centre[1]) < 55)
        dark = np.argwhere(inside & (image.max(axis=2) < 0.05))[:, ::-1] + 0.5
        middle = dark.mean(axis=0)
        axis = np.linalg.svd(dark - middle, full_matrices=False)[2][0]
        offset = mark - middle
        off_axis = abs(offset[0] * axis[1] - offset[1] * axis[0])
        assert off_axis < 0.06 * np.hypot(*offset) + 2, name


def test_normal_maps_with_other_bias_and_scale(tmp_path: Path) -> None:
    """The three cubes look the same from above, whatever the light."""
    folder = "NormalsTextureBiasAndScale"
    for turn in ("(-90, 0, 0)", "(-45, 60, 0)", "(-45, -60, 0)"):
        off = 'over "NormalsTextureBiasAndScale"\n{\nover "Lights" (\nactive = false\n)\n{\n}\n}\n'
        stage = ortho(
            tmp_path,
            f"{folder}/{folder}.usda",
            (5, 0, 5),
            40,
            "(-90, 0, 0)",
            off + SUN.format(turn),
        )
        stage = stage.rename(tmp_path / f"{len(list(tmp_path.iterdir()))}.usda")
        image = seen(stage, 400)
        boxes = np.argwhere(image.max(axis=2) > 0)
        assert len(boxes), turn
        cubes = cube_tops(stage)
        assert len(cubes) == 3
        crops = [crop(image, low, high, (5, 5), 40) for low, high in cubes]
        contrast = crops[0].std()
        assert contrast > 0.01
        for other in crops[1:]:
            assert abs(other - crops[0]).mean() < 0.15 * contrast


def cube_tops(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """x and z of the corners of each cube."""
    stage = Usd.Stage.Open(str(path))
    cache = UsdGeom.BBoxCache(0, ["default"])
    found = []
    for prim in stage.GetPrimAtPath("/NormalsTextureBiasAndScale/Geom").GetChildren():
        box = cache.ComputeWorldBound(prim).ComputeAlignedRange()
        low, high = np.array(box.GetMin())[[0, 2]], np.array(box.GetMax())[[0, 2]]
        found.append((low, high))
    return found


def crop(
    image: np.ndarray, low: np.ndarray, high: np.ndarray, centre: tuple[float, float], width: float
) -> np.ndarray:
    side = image.shape[0]
    first = np.round(((low - centre) / width + 0.5) * side).astype(int) + 3
    last = first + int(np.floor((high - low)[0] / width * side)) - 6
    return image[first[1] : last[1], first[0] : last[0]]


def test_file_formats(tmp_path: Path) -> None:
    """All cells of colours are alike, all of grey are, and opacity makes no difference."""
    cells = {}
    for name in (
        "jpeg_rgb_8-bit",
        "png_rgb_8-bit",
        "png_rgb_16-bit",
        "jpeg_cmyk_8-bit",
        "jpeg_grayscale_8-bit",
        "png_grayscale_8-bit",
        "png_grayscale_16-bit",
    ):
        stage = ortho(tmp_path, f"TextureFileFormatTests/{name}.usda", (1.05, 0.5, 0), 2.2)
        image = seen(stage.rename(tmp_path / f"{name}.usda"), 220)
        # The middle of each square; captions differ, so that medians are compared.
        cells[name] = image[90:130, 15:100], image[90:130, 125:210]
        assert abs(cells[name][0] - cells[name][1]).mean() < 0.01, name
    for name in ("png_rgb_8-bit", "png_rgb_16-bit"):
        assert np.median(abs(cells[name][0] - cells["jpeg_rgb_8-bit"][0])) < 0.005, name
    assert abs(cells["jpeg_cmyk_8-bit"][0] - cells["jpeg_rgb_8-bit"][0]).mean() < 0.15
    for name in ("png_grayscale_8-bit", "png_grayscale_16-bit"):
        assert np.median(abs(cells[name][0] - cells["jpeg_grayscale_8-bit"][0])) < 0.005, name


def test_roughness_by_texture_and_by_constant(tmp_path: Path) -> None:
    """A row is the same whether its roughness is a texture's or a constant.

    The row of 0.33 reads its texture as raw, so that it is 0.6 there: the asset's own slip.
    """
    asset = "RoughnessTest/RoughnessTest.usdz"
    view = ((0.0, 0.0, 2.65), 14, "(90, 0, 0)")
    sun = SUN.format("(70, 0, 0)")
    by_texture = seen(ortho(tmp_path, asset, *view, sun))
    constants = "".join(
        f"""over "Tex{row}"
{{
    over "Principled_BSDF"
    {{
        float inputs:roughness = {value!r}
        float inputs:roughness.connect = None
    }}
}}
"""
        for row, value in (
            ("000", 0.0),
            ("033", 153 / 255),
            ("066", float(srgb(np.array(211 / 255)))),
        )
    )
    over = f'over "Roughness"\n{{\nover "Materials"\n{{\n{constants}}}\n}}\n'
    folder = tmp_path / "constants"
    folder.mkdir()
    by_constant = seen(ortho(folder, asset, *view, sun + over))
    assert by_texture.max() > 0.5
    np.testing.assert_allclose(by_texture, by_constant, rtol=1e-4, atol=1e-6)


def test_blended_shadows(tmp_path: Path) -> None:
    """Transparent planes darken each other, and show no edge where they are clear."""
    floor = """def Plane "Floor"
{
    double width = 4
    double length = 4
    uniform token axis = "Y"
    double3 xformOp:translate = (0, -0.02, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    color3f[] primvars:displayColor = [(0.6, 0.6, 0.6)]
}"""
    asset = "AlphaBlendSortTest/AlphaBlendSortTest.usda"
    image = seen(ortho(tmp_path, asset, (0, 0, 0), 2.4, "(-90, 0, 0)", floor))[..., 1]
    bare = image[10, 100]
    across = image[100]
    assert abs(image[100, 4] / bare - 1) < 0.02
    shadow, both = across[95:105].mean(), across[150:155].min()
    assert both < shadow < bare
