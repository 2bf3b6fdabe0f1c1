# SPDX-License-Identifier: Apache-2.0
"""The rendering space, against matrices made from published primaries."""

from pathlib import Path

import numpy as np
import pytest

from irt_usd.errors import InputError
from irt_usd.images.color import ColorSpaces
from irt_usd.report import Report
from irt_usd.shot.metadata import shot_metadata
from irt_usd.shot.settings import TraceSettings
from textured import picture, shot_of, srgb, write_image, write_stage

_REC709 = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06)), (0.3127, 0.3290)
_AP1 = ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044)), (0.32168, 0.33767)
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)

ACESCG = """def Scope "Render"
{
    def RenderSettings "S"
    {
        token renderingColorSpace = "lin_ap1_scene"
    }
}"""
SETTINGS = 'upAxis = "Y"\n    renderSettingsPrimPath = "/Render/S"'


def xyz(point: tuple[float, float]) -> np.ndarray:
    x, y = point
    return np.array([x / y, 1, (1 - x - y) / y])


def xyz_from_rgb(
    primaries: tuple[tuple[float, float], ...], white: tuple[float, float]
) -> np.ndarray:
    columns = np.stack([xyz(p) for p in primaries], axis=1)
    scaled: np.ndarray = columns * np.linalg.solve(columns, xyz(white))
    return scaled


def ap1_from_rec709() -> np.ndarray:
    """By Bradford's adaptation from D65 to ACES' white."""
    cones = [_BRADFORD @ xyz(white) for white in (_REC709[1], _AP1[1])]
    adapt = np.linalg.inv(_BRADFORD) @ np.diag(cones[1] / cones[0]) @ _BRADFORD
    matrix: np.ndarray = np.linalg.inv(xyz_from_rgb(*_AP1)) @ adapt @ xyz_from_rgb(*_REC709)
    return matrix


def acescg(stage: Path) -> Path:
    stage.write_text(stage.read_text().replace('upAxis = "Y"', SETTINGS, 1))
    return stage


def test_textures_and_constants_in_acescg(tmp_path: Path) -> None:
    code = np.array([200, 100, 50])
    write_image(tmp_path / "image.png", np.broadcast_to(code, (4, 4, 3)).astype(np.uint8).copy())
    texture = "asset inputs:file = @image.png@"
    stage = acescg(write_stage(tmp_path, texture=texture, extra=ACESCG))
    expected = ap1_from_rec709() @ srgb(code / 255)
    np.testing.assert_allclose(picture(stage)[4, 4], expected, rtol=1e-4)
    raw = acescg(
        write_stage(
            tmp_path, texture=f'{texture}\ntoken inputs:sourceColorSpace = "raw"', extra=ACESCG
        )
    )
    np.testing.assert_allclose(picture(raw)[4, 4], code / 255, rtol=1e-6)
    inputs = "color3f inputs:emissiveColor = (0.8, 0.4, 0.2)"
    constant = acescg(write_stage(tmp_path, inputs=inputs, extra=ACESCG))
    expected = ap1_from_rec709() @ (0.8, 0.4, 0.2)
    np.testing.assert_allclose(picture(constant)[4, 4], expected, rtol=1e-4)
    declared = inputs + ' (\ncolorSpace = "lin_ap1_scene"\n)'
    own = acescg(write_stage(tmp_path, inputs=declared, extra=ACESCG))
    np.testing.assert_allclose(picture(own)[4, 4], (0.8, 0.4, 0.2), rtol=1e-6)


def test_lights_in_acescg(tmp_path: Path) -> None:
    light = """
def DistantLight "L"
{
    float inputs:angle = 0
    float inputs:intensity = 1
    color3f inputs:color = (0.8, 0.4, 0.2)
}"""
    stage = acescg(write_stage(tmp_path, inputs="", extra=ACESCG + light))
    state = shot_of(stage).reader.read(1).lights["/L"]
    np.testing.assert_allclose(state.energy, ap1_from_rec709() @ (0.8, 0.4, 0.2), rtol=1e-4)


def test_headers_tell_the_rendering_space(tmp_path: Path) -> None:
    stage = acescg(write_stage(tmp_path, inputs="", extra=ACESCG))
    entries = shot_metadata(shot_of(stage), TraceSettings())
    assert entries["irt:renderingColorSpace"] == "lin_ap1_scene"
    adapted = np.linalg.inv(ap1_from_rec709())
    corners = xyz_from_rgb(*_REC709) @ adapted
    expected = [v for column in corners.T for v in column[:2] / column.sum()]
    found = entries["chromaticities"]
    assert isinstance(found, tuple)
    np.testing.assert_allclose(found[:6], expected, rtol=1e-3)
    np.testing.assert_allclose(found[6:], _REC709[1], rtol=1e-3)
    plain = shot_metadata(shot_of(write_stage(tmp_path, inputs="")), TraceSettings())
    assert plain["irt:renderingColorSpace"] == "lin_rec709_scene"


def test_another_curve_is_baked(tmp_path: Path) -> None:
    code = np.array([200, 100, 50])
    write_image(tmp_path / "image.png", np.broadcast_to(code, (4, 4, 3)).astype(np.uint8).copy())
    texture = 'asset inputs:file = @image.png@ (\ncolorSpace = "g22_rec709_scene"\n)'
    found = picture(write_stage(tmp_path, texture=texture))[4, 4]
    np.testing.assert_allclose(found, (code / 255) ** 2.2, rtol=1e-3)


def test_sixteen_bits_are_baked_to_float(tmp_path: Path) -> None:
    code = np.array([50_000, 20_000, 10_000])
    pixels = np.broadcast_to(code, (4, 4, 3)).astype(np.uint16).copy()
    write_image(tmp_path / "image.tif", pixels)
    texture = 'asset inputs:file = @image.tif@ (\ncolorSpace = "g22_rec709_scene"\n)'
    found = picture(write_stage(tmp_path, texture=texture))[4, 4]
    np.testing.assert_allclose(found, (code / 65535) ** 2.2, rtol=1e-5)


def test_ocio_names_the_rendering_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OCIO", "ocio://cg-config-v4.0.0_aces-v2.0_ocio-v2.5")
    assert ColorSpaces().rendering == "ACEScg"
    inputs = "color3f inputs:emissiveColor = (0.8, 0.4, 0.2)"
    found = picture(write_stage(tmp_path, inputs=inputs))[4, 4]
    np.testing.assert_allclose(found, ap1_from_rec709() @ (0.8, 0.4, 0.2), rtol=1e-4)


def test_an_ocio_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stage = write_stage(tmp_path)
    for path in ("/nowhere.ocio", str(stage)):
        monkeypatch.setenv("OCIO", path)
        with pytest.raises(InputError, match=f"OCIO={path}"):
            shot_of(stage)


@pytest.mark.parametrize(
    ("space", "reason"),
    [("plasma", "in no OpenColorIO config"), ("srgb_rec709_scene", "not linear")],
)
def test_a_rendering_space_that_is_none(tmp_path: Path, space: str, reason: str) -> None:
    settings = ACESCG.replace("lin_ap1_scene", space)
    stage = acescg(write_stage(tmp_path, extra=settings))
    with pytest.raises(
        InputError, match=rf"/Render/S.renderingColorSpace in .*{space} is {reason}"
    ):
        shot_of(stage)


def test_an_unknown_space_of_a_constant(tmp_path: Path) -> None:
    inputs = 'color3f inputs:emissiveColor = (0.8, 0.4, 0.2) (\ncolorSpace = "plasma"\n)'
    report = Report()
    found = picture(write_stage(tmp_path, inputs=inputs), report)[4, 4]
    np.testing.assert_allclose(found, (0.8, 0.4, 0.2), rtol=1e-6)
    (text,) = [n.text for n in report.notices if n.severity == "skipped"]
    assert "plasma" in text
    assert "/M/P.inputs:emissiveColor in " in text
