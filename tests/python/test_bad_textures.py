# SPDX-License-Identifier: Apache-2.0
"""Textures and networks that cannot be had: one message each, the rest renders (contract C4)."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from irt_usd.errors import InputError
from irt_usd.report import Report
from textured import picture, shot_of, write_image, write_stage

FILE = "asset inputs:file = @./image.png@\nfloat4 inputs:fallback = (0.5, 0.25, 0.125, 1)"
FALLBACK = (0.5, 0.25, 0.125)


def said(report: Report, severity: str) -> list[str]:
    return [n.text for n in report.notices if n.severity == severity]


@pytest.mark.parametrize("policy", ["fallback", "warn"])
def test_a_missing_texture(tmp_path: Path, policy: str) -> None:
    stage = write_stage(tmp_path, texture=FILE + "\nfloat4 inputs:scale = (2, 2, 2, 1)")
    report = Report()
    found = picture(stage, report, missing_asset=policy)
    np.testing.assert_allclose(found[4, 4], FALLBACK, rtol=1e-6)
    (text,) = said(report, "skipped")
    assert f"/M/T.inputs:file in {stage}" in text
    assert str(tmp_path / "image.png") in text


def test_a_missing_texture_is_fatal(tmp_path: Path) -> None:
    stage = write_stage(tmp_path, texture=FILE)
    with pytest.raises(InputError, match=r"missing textures.*--missing-asset") as caught:
        shot_of(stage)
    assert f"/M/T.inputs:file in {stage}" in str(caught.value)
    assert str(tmp_path / "image.png") in str(caught.value)


def bomb(width: int, height: int) -> bytes:
    """A PNG whose header promises much more than the file has."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "no image that OpenImageIO reads"),
        (b"nothing of an image", "no image that OpenImageIO reads"),
        (bomb(16, 16), "damaged"),
        (bomb(200_000, 200_000), r"GiB|exceed|no image that OpenImageIO reads"),
    ],
    ids=["empty", "text", "truncated", "bomb"],
)
def test_an_unusable_texture(tmp_path: Path, content: bytes, reason: str) -> None:
    (tmp_path / "image.png").write_bytes(content)
    stage = write_stage(tmp_path, texture=FILE)
    with pytest.raises(InputError, match=reason) as caught:
        picture(stage)
    assert "/M/T.inputs:file in " in str(caught.value)
    report = Report()
    found = picture(stage, report, missing_asset="fallback")
    np.testing.assert_allclose(found[4, 4], FALLBACK, rtol=1e-6)
    (text,) = said(report, "skipped")
    assert "/M/T.inputs:file in " in text


def test_no_permission_and_a_folder(tmp_path: Path) -> None:
    (tmp_path / "image.png").mkdir()
    stage = write_stage(tmp_path, texture=FILE)
    with pytest.raises(InputError, match=r"/M/T\.inputs:file in "):
        shot_of(stage)


def test_no_file(tmp_path: Path) -> None:
    report = Report()
    texture = "float4 inputs:fallback = (0.5, 0.25, 0.125, 1)"
    found = picture(write_stage(tmp_path, texture=texture), report)
    np.testing.assert_allclose(found[4, 4], FALLBACK, rtol=1e-6)
    assert any("without a file" in text for text in said(report, "mentioned"))


def test_not_finite(tmp_path: Path) -> None:
    pixels = np.full((4, 4, 3), np.nan, np.float32)
    write_image(tmp_path / "image.exr", pixels)
    stage = write_stage(tmp_path, texture="asset inputs:file = @image.exr@")
    assert (picture(stage) == 0).all()


SHADER = 'def Shader "{}"\n{{\nuniform token info:id = "{}"\n{}\nfloat3 outputs:result\n}}\n'
EMITS = "color3f inputs:emissiveColor.connect = </M/{}.outputs:result>"


def network(folder: Path, shaders: str, first: str) -> tuple[np.ndarray, Report]:
    report = Report()
    stage = write_stage(folder, shaders=shaders, inputs=EMITS.format(first))
    return picture(stage, report)[4, 4], report


def test_an_unknown_shader(tmp_path: Path) -> None:
    shaders = SHADER.format("U", "Plasma", "float3 inputs:fallback = (0.5, 0.25, 0.125)")
    found, report = network(tmp_path, shaders, "U")
    np.testing.assert_allclose(found, FALLBACK, rtol=1e-6)
    (text,) = said(report, "unsupported")
    assert "Plasma" in text
    assert "/M/P.inputs:emissiveColor in " in text


def test_an_unknown_shader_without_a_fallback(tmp_path: Path) -> None:
    found, report = network(tmp_path, SHADER.format("U", "Plasma", ""), "U")
    assert (found == 0).all()  # emissiveColor's default
    assert said(report, "unsupported")


def test_a_dangling_connection(tmp_path: Path) -> None:
    found, report = network(tmp_path, "", "Nowhere")
    assert (found == 0).all()
    (text,) = said(report, "skipped")
    assert "</M/Nowhere.outputs:result>, which does not exist: /M/P.inputs:emissiveColor" in text


def test_shaders_in_a_circle(tmp_path: Path) -> None:
    shaders = SHADER.format(
        "A", "UsdTransform2d", "float2 inputs:in.connect = </M/B.outputs:result>"
    )
    shaders += SHADER.format(
        "B", "UsdTransform2d", "float2 inputs:in.connect = </M/A.outputs:result>"
    )
    found, report = network(tmp_path, shaders, "A")
    assert np.isfinite(found).all()
    (text,) = said(report, "skipped")
    assert "leads back to itself: /M/B.inputs:in in " in text


def test_inputs_in_a_circle(tmp_path: Path) -> None:
    interface = "color3f inputs:a.connect = </M.inputs:b>\ncolor3f inputs:b.connect = </M.inputs:a>"
    report = Report()
    stage = write_stage(
        tmp_path, interface=interface, inputs="color3f inputs:emissiveColor.connect = </M.inputs:a>"
    )
    assert (picture(stage, report) == 0).all()
    assert any("leads back to itself" in text for text in said(report, "skipped"))


def test_an_unknown_color_space(tmp_path: Path) -> None:
    write_image(tmp_path / "image.png", np.full((4, 4, 3), 51, np.uint8))
    report = Report()
    stage = write_stage(tmp_path, texture=FILE + '\ntoken inputs:sourceColorSpace = "plasma"')
    np.testing.assert_allclose(picture(stage, report)[4, 4], 0.2, rtol=1e-6)
    (text,) = said(report, "skipped")
    assert "plasma" in text
    assert "/M/T.inputs:file in " in text


def test_values_of_the_wrong_type(tmp_path: Path) -> None:
    write_image(tmp_path / "image.png", np.full((4, 4, 3), 51, np.uint8))
    texture = f"""{FILE}
token inputs:sourceColorSpace = "raw"
token inputs:wrapS = "sideways"
float inputs:scale = 2
float4 inputs:bias = (nan, 0, 0, 0)"""
    report = Report()
    found = picture(write_stage(tmp_path, texture=texture), report)
    np.testing.assert_allclose(found[4, 4], 0.2, rtol=1e-6)
    names = sorted(text.split("/M/T.")[1].split(" ")[0] for text in said(report, "skipped"))
    assert names == ["inputs:bias", "inputs:scale", "inputs:wrapS"]
