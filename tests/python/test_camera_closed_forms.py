# SPDX-License-Identifier: Apache-2.0
"""Cameras from stage to pixels: where each pixel of a wall lies, by UsdGeomCamera's arithmetic."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from cli_support import irt, write_stage

FOCAL, HORIZONTAL, VERTICAL = 40.0, 30.0, 20.0
EYE = (0.5, -0.25, 6.0)
WALL = -2.0
WIDTH, HEIGHT = 36, 16
WHOLE = (0.0, 0.0, 1.0, 1.0)

STAGE = """#usda 1.0
(
    renderSettingsPrimPath = "/S"
)
def Camera "Cam"
{{
    float focalLength = {focal}
    float horizontalAperture = {horizontal}
    float verticalAperture = {vertical}
    double3 xformOp:translate = {eye}
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {camera}
}}
def Plane "Wall"
{{
    double width = 400
    double length = 400
    double3 xformOp:translate = (0, 0, {wall})
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def RenderSettings "S"
{{
    uniform int2 resolution = ({width}, {height})
    {settings}
}}
"""


def apertures(policy: str, pixel_aspect: float) -> tuple[float, float]:
    """Those that the image shows, as UsdRenderSettings describes the policies."""
    image = WIDTH / HEIGHT * pixel_aspect
    wider = HORIZONTAL, HORIZONTAL / image
    higher = VERTICAL * image, VERTICAL
    if policy == "adjustApertureWidth":
        return higher
    if policy == "adjustApertureHeight":
        return wider
    if policy == "adjustPixelAspectRatio":
        return HORIZONTAL, VERTICAL
    larger, smaller = max(wider, higher), min(wider, higher)
    return larger if policy == "expandAperture" else smaller


def positions(folder: Path, camera: str, settings: str) -> np.ndarray:
    text = STAGE.format(
        focal=FOCAL, horizontal=HORIZONTAL, vertical=VERTICAL, eye=EYE, wall=WALL,
        width=WIDTH, height=HEIGHT, camera=camera, settings=settings,
    )  # fmt: skip
    out = folder / "f.exr"
    given = ("--aov", "position", "-o", str(out), "--history", "none", "--exr-type", "float")
    result = irt("render", write_stage(folder, text), *given)
    assert result.exit_code == 0, result.output
    image = oiio.ImageInput.open(str(out))
    assert image is not None
    names = list(image.spec().channelnames)
    first = names.index("position.X")
    assert names[first : first + 3] == ["position.X", "position.Y", "position.Z"]
    return np.asarray(image.read_image(0, 0, first, first + 3, oiio.FLOAT), np.float64)


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize(
    ("policy", "pixel_aspect", "offsets", "window"),
    [
        ("expandAperture", 1.0, (0.0, 0.0), WHOLE),
        ("cropAperture", 1.0, (3.0, -2.0), WHOLE),
        ("adjustApertureWidth", 2.0, (0.0, 5.0), WHOLE),
        ("adjustApertureHeight", 0.5, (-4.0, 0.0), WHOLE),
        ("adjustPixelAspectRatio", 1.0, (1.0, 1.0), WHOLE),
        ("expandAperture", 1.5, (1.0, -1.0), (0.25, -0.125, 1.5, 0.5)),
    ],
)
def test_each_pixel_sees_its_place_on_the_wall(
    tmp_path: Path,
    policy: str,
    pixel_aspect: float,
    offsets: tuple[float, float],
    window: tuple[float, float, float, float],
    orthographic: bool,
) -> None:
    camera = f"float horizontalApertureOffset = {offsets[0]}\n"
    camera += f"float verticalApertureOffset = {offsets[1]}\n"
    camera += 'token projection = "orthographic"\n' if orthographic else ""
    settings = f'uniform token aspectRatioConformPolicy = "{policy}"\n'
    settings += f"uniform float pixelAspectRatio = {pixel_aspect}\n"
    settings += f"uniform float4 dataWindowNDC = {window}\n"
    found = positions(tmp_path, camera, settings)

    left, bottom, right, top = window
    columns = np.arange(-WIDTH, 2 * WIDTH)
    columns = columns[(columns + 0.5 >= left * WIDTH) & (columns + 0.5 < right * WIDTH)]
    rows = np.arange(-HEIGHT, 2 * HEIGHT)
    up = HEIGHT - (rows + 0.5)
    rows = rows[(up >= bottom * HEIGHT) & (up < top * HEIGHT)]
    assert found.shape == (len(rows), len(columns), 3)
    width, height = apertures(policy, pixel_aspect)
    scale = 0.1 if orthographic else (EYE[2] - WALL) / FOCAL
    x = EYE[0] + scale * (offsets[0] + width * ((columns + 0.5) / WIDTH - 0.5))
    y = EYE[1] + scale * (offsets[1] + height * (0.5 - (rows + 0.5) / HEIGHT))
    expected = np.stack([*np.meshgrid(x, y), np.full((len(rows), len(columns)), WALL)], axis=2)
    np.testing.assert_allclose(found, expected, atol=2e-5)
