# SPDX-License-Identifier: Apache-2.0
"""USDZ packages that are damaged, or claim what cannot be: refused, and quickly, before USD opens
them."""

import struct
from collections.abc import Callable
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import pytest

from conftest import CAMERA, WriteLayer
from irt_usd.errors import InputError
from irt_usd.stage import OpenOptions, open_stage

LAYER = f'#usda 1.0\n(\n defaultPrim = "S"\n)\ndef Sphere "S"\n{{\n}}\n{CAMERA}'
LOCAL_SIZES, LOCAL_FLAGS, LOCAL_NAME = 18, 6, 26
CENTRAL_SIZES = 20


def package(path: Path, compression: int = ZIP_STORED, **files: bytes) -> Path:
    with ZipFile(path, "w", compression) as archive:
        for name, content in files.items():
            archive.writestr(name.replace("_", "."), content)
    return path


def whole(path: Path) -> bytes:
    return package(path, a_usda=LAYER.encode(), b_png=b"png" * 99).read_bytes()


def patched(content: bytes, at: int, kind: str, *values: int) -> bytes:
    buffer = bytearray(content)
    struct.pack_into(kind, buffer, at, *values)
    return bytes(buffer)


def central(content: bytes) -> int:
    return content.index(b"PK\x01\x02")


HUGE = 0x7FFFFFF0

DAMAGE: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "cut in two": (lambda c: c[: len(c) // 2], "cut short"),
    "without its last bytes": (lambda c: c[:-10], "cut short"),
    "nothing": (lambda _: b"", "cut short"),
    "zeros": (lambda _: bytes(4096), "cut short"),
    "absurd size at the file": (
        lambda c: patched(c, LOCAL_SIZES, "<II", HUGE, HUGE),
        "claims",
    ),
    "absurd size in the directory": (
        lambda c: patched(c, central(c) + CENTRAL_SIZES, "<II", HUGE, HUGE),
        "claims",
    ),
    "absurd size in both": (
        lambda c: patched(
            patched(c, LOCAL_SIZES, "<II", HUGE, HUGE),
            central(c) + CENTRAL_SIZES,
            "<II",
            HUGE,
            HUGE,
        ),
        "claims",
    ),
    "absurd length of a name": (lambda c: patched(c, LOCAL_NAME, "<HH", 65535, 65535), "claims"),
    "encrypted": (lambda c: patched(c, central(c) + 8, "<H", 1), "encrypted"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged(tmp_path: Path, name: str) -> None:
    damage, what = DAMAGE[name]
    path = tmp_path / "p.usdz"
    path.write_bytes(damage(whole(path)))
    with pytest.raises(InputError, match=rf"p\.usdz: a damaged package: .*{what}"):
        open_stage(str(path))


def test_whole(tmp_path: Path) -> None:
    whole(tmp_path / "p.usdz")
    assert open_stage(str(tmp_path / "p.usdz")).GetPrimAtPath("/S")


def test_bomb(tmp_path: Path) -> None:
    """Five megabytes in some kilobytes: not even looked into."""
    bomb = package(tmp_path / "p.usdz", ZIP_DEFLATED, a_usda=LAYER.encode(), b_usda=bytes(5 << 20))
    with pytest.raises(InputError, match=r"a\.usda is compressed"):
        open_stage(str(bomb))


def test_no_layer(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="its first file is no USD layer"):
        open_stage(str(package(tmp_path / "p.usdz", a_png=b"png")))
    with pytest.raises(InputError, match="its first file is no USD layer"):
        open_stage(str(package(tmp_path / "p.usdz")))


def test_layer_in_a_package_that_does_not_parse(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"p\.usdz"):
        open_stage(str(package(tmp_path / "p.usdz", a_usda=b"#usda 1.0\ndef {")))
    with pytest.raises(InputError, match=r"p\.usdz"):
        open_stage(str(package(tmp_path / "p.usdz", a_usdc=b"PXR-USDC" + bytes(400))))


@pytest.mark.parametrize("name", DAMAGE)
@pytest.mark.parametrize("policy", ["fail", "fallback"])
def test_damaged_and_referred_to(usda: WriteLayer, tmp_path: Path, name: str, policy: str) -> None:
    path = tmp_path / "p.usdz"
    path.write_bytes(DAMAGE[name][0](whole(path)))
    stage = usda('def "W" (\n references = @./p.usdz@\n)\n{\n}\n' + CAMERA)
    with pytest.raises(InputError, match=r"p\.usdz.* damaged package"):
        open_stage(str(stage), OpenOptions(missing_asset=policy))  # type: ignore[arg-type]


def test_a_compressed_file_beside_the_layers(usda: WriteLayer, tmp_path: Path) -> None:
    whole(tmp_path / "p.usdz")
    with ZipFile(tmp_path / "p.usdz", "a", ZIP_DEFLATED) as archive:
        archive.writestr("c.png", bytes(10_000))
    stage = usda('def "W" (\n references = @./p.usdz@\n)\n{\n}\n' + CAMERA)
    with pytest.raises(InputError, match=r"c\.png is compressed"):
        open_stage(str(stage))
