# SPDX-License-Identifier: Apache-2.0
"""Image files into arrays, and what is dropped of them where memory is limited."""

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irt_usd.cli.options import parse_bytes
from irt_usd.errors import InputError
from irt_usd.images.decode import decode, read_header
from irt_usd.images.texture_memory import Pyramid, levels_to_drop
from irt_usd.images.textures import TextureLibrary
from irt_usd.report import Report
from irt_usd.shot.session import Shot
from irt_usd.stage.graph import TextureReference
from textured import picture, shot_of, write_image, write_stage

ASSETS = Path(__file__).parents[2].parent / "shared" / "assets" / "test_assets"


@pytest.mark.parametrize(
    ("name", "kind", "channels"),
    [
        ("a.png", "uint8", 1),
        ("a.png", "uint8", 2),
        ("a.png", "uint8", 3),
        ("a.png", "uint16", 4),
        ("a.tif", "uint8", 4),
        ("a.tif", "uint16", 3),
        ("a.tif", "float32", 1),
        ("a.exr", "float16", 4),
        ("a.exr", "float32", 3),
        ("a.tga", "uint8", 4),
        ("a.bmp", "uint8", 3),
    ],
)
def test_bits_are_kept(tmp_path: Path, name: str, kind: str, channels: int) -> None:
    random = np.random.default_rng(1)
    values = random.integers(0, 250, (5, 7, channels))
    pixels = values.astype(kind) if kind.startswith("u") else (values / 256).astype(kind)
    file = write_image(tmp_path / name, pixels)
    found = decode(str(file))
    assert found.dtype == pixels.dtype
    np.testing.assert_array_equal(found, pixels)


def test_a_palette(tmp_path: Path) -> None:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", 2, 1, 8, 3, 0, 0, 0)
    file = tmp_path / "p.png"
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"PLTE", bytes([10, 20, 30, 40, 50, 60]))
        + chunk(b"IDAT", zlib.compress(bytes([0, 1, 0])))
        + chunk(b"IEND", b"")
    )
    np.testing.assert_array_equal(decode(str(file))[0, :, :3], [[40, 50, 60], [10, 20, 30]])


@pytest.mark.skipif(not ASSETS.exists(), reason=f"{ASSETS} is not there")
def test_cmyk() -> None:
    folder = ASSETS / "TextureFileFormatTests"
    found = decode(str(folder / "jpeg_cmyk_8-bit.jpg")).astype(float)
    alike = decode(str(folder / "jpeg_rgb_8-bit.jpg")).astype(float)
    assert found.shape == alike.shape
    # No ICC profile is applied: the colours are near, not the same. Left out: the captions.
    difference = np.abs(found[120:] - alike[120:]).mean(axis=(0, 1))
    assert (difference < 40).all()


@pytest.mark.parametrize(
    ("kind", "channels", "metadata", "is_srgb"),
    [
        ("uint8", 3, {}, True),
        ("uint8", 4, {}, True),
        ("uint8", 1, {}, False),
        ("uint8", 2, {}, False),
        ("uint16", 3, {}, False),
        ("uint16", 3, {"Exif:ColorSpace": 1}, True),
        ("float32", 3, {}, False),
    ],
)
def test_the_rule_of_auto(
    tmp_path: Path, kind: str, channels: int, metadata: dict[str, Any], is_srgb: bool
) -> None:
    file = write_image(tmp_path / "a.tif", np.zeros((4, 4, channels), kind), metadata)
    assert read_header(str(file)).is_srgb == is_srgb


def test_levels_are_the_cores() -> None:
    from irt_usd import _core

    for shape in ((5, 7, 3), (1, 9, 1), (16, 16, 4)):
        texture = _core.Texture([(0, 0, np.zeros(shape, np.uint16))])
        height, width, channels = shape
        assert list(Pyramid(((width, height, 2 * channels),)).levels) == texture.level_bytes


def test_the_largest_levels_are_dropped_first() -> None:
    small, big, twin = (TextureReference(name) for name in ("c.png", "b.png", "a.png"))
    pyramids = {
        small: Pyramid(((64, 64, 4),)),
        big: Pyramid(((256, 256, 4),)),
        twin: Pyramid(((256, 256, 4),)),
    }
    total = sum(p.bytes_without(0) for p in pyramids.values())
    assert levels_to_drop(pyramids, total) == {small: 0, big: 0, twin: 0}
    assert levels_to_drop(pyramids, total - 1) == {small: 0, big: 0, twin: 1}
    assert levels_to_drop(pyramids, total - 256 * 256 * 4 - 1) == {small: 0, big: 1, twin: 1}
    assert levels_to_drop(pyramids, 1) == {small: 6, big: 8, twin: 8}


def test_a_limit_shows_and_is_said(tmp_path: Path) -> None:
    checks = np.indices((64, 64)).sum(axis=0) % 2
    pixels = np.repeat((checks * 255)[..., None], 3, axis=2).astype(np.uint8)
    write_image(tmp_path / "image.png", pixels)
    texture = 'asset inputs:file = @image.png@\ntoken inputs:sourceColorSpace = "raw"'
    stage = write_stage(tmp_path, texture=texture)
    report = Report()
    found = picture(stage, report, size=(256, 256), texture_memory=64 * 64)
    assert np.abs(found[8:-8, 8:-8] - 0.5).max() < 0.01  # beyond the black border all is grey
    sharp = picture(stage, size=(256, 256))
    assert sharp[8:-8, 8:-8].min() < 0.25
    assert sharp.max() > 0.75
    (text,) = [n.text for n in report.notices if "texture-memory" in n.message]
    assert "larger than it by themselves" in text
    assert text.endswith("image.png (1)")


def dropped(shot: Shot) -> dict[str, int]:
    assert isinstance(shot.reader.textures, TextureLibrary)
    return shot.reader.textures.dropped


def test_a_limit_is_a_setting_of_the_shot(tmp_path: Path) -> None:
    """What is dropped follows from all frames' textures, whichever are rendered."""
    for name in ("one", "two"):
        write_image(tmp_path / f"{name}.png", np.zeros((64, 64, 3), np.uint8))
    keys = "asset inputs:file.timeSamples = {1: @one.png@, 2: @two.png@}"
    stage = write_stage(tmp_path, texture=keys)
    limits = [
        dropped(shot_of(stage, frames=frames, texture_memory=20_000))
        for frames in ("1", "2", "1:2")
    ]
    assert limits[0] == limits[1] == limits[2]
    assert {Path(file).name: count for file, count in limits[0].items()} == {
        "one.png": 1,
        "two.png": 1,
    }


def test_sizes() -> None:
    assert parse_bytes("--texture-memory", "4G") == 4 * 2**30
    assert parse_bytes("--texture-memory", "512m") == 512 * 2**20
    assert parse_bytes("--texture-memory", "1.5KiB") == 1536
    assert parse_bytes("--texture-memory", "100") == 100
    for text in ("", "0", "-1G", "G", "4X", "nan"):
        with pytest.raises(InputError, match="--texture-memory"):
            parse_bytes("--texture-memory", text)
