# SPDX-License-Identifier: Apache-2.0
"""EXR files: what is stored, byte for byte, and what is left when writing fails."""

import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from numpy.typing import NDArray

from irt_usd.errors import InputError, MachineError
from irt_usd.images.atomic import atomic_file
from irt_usd.images.contact_sheet import display_srgb, write_contact_sheet
from irt_usd.images.exr import Film, MetadataValue, PixelFaults, read_beauty, source_date, write_exr
from irt_usd.shot.metadata import camera_matrices, frames_per_second

WIDTH, HEIGHT = 33, 17
METADATA: dict[str, MetadataValue] = {
    "Software": "irt 0",
    "framesPerSecond": Fraction(24000, 1001),
    "worldToCamera": tuple(float(value) for value in range(16)),
    "irt:frame": "1.25",
    "irt:samples": 4,
}


def film() -> Film:
    random = np.random.default_rng(7)

    def plane(channels: int) -> NDArray[np.float32]:
        return random.random((HEIGHT, WIDTH, channels), dtype=np.float32)

    return Film(
        plane(4),
        {
            "depth": plane(1)[..., 0],
            "normal": plane(3),
            "position": plane(3) * 1e6,
            "albedo": plane(3),
            "objectId": random.integers(0, 2**32, (HEIGHT, WIDTH), dtype=np.uint32),
        },
    )


def opened(path: Path) -> Any:
    return oiio.ImageInput.open(str(path))


def channel(path: Path, part: int, name: str, kind: Any = oiio.FLOAT) -> NDArray[Any]:
    image = opened(path)
    image.seek_subimage(part, 0)
    index = image.spec().channelnames.index(name)
    return np.asarray(image.read_image(part, 0, index, index + 1, kind))[..., 0]


def test_layers_and_their_types(tmp_path: Path) -> None:
    path, pixels = tmp_path / "a.exr", film()
    assert write_exr(path, pixels, METADATA) == PixelFaults(0, 0)
    spec = opened(path).spec()
    types = dict(zip(spec.channelnames, map(str, spec.channelformats), strict=True))
    assert types == {
        **dict.fromkeys(("R", "G", "B", "A"), "half"),
        **dict.fromkeys(("albedo.R", "albedo.G", "albedo.B"), "half"),
        **dict.fromkeys(("normal.X", "normal.Y", "normal.Z", "Z"), "float"),
        **dict.fromkeys(("position.X", "position.Y", "position.Z"), "float"),
    }
    assert spec["compression"] == "zip"
    for index, name in enumerate("RGBA"):
        half = pixels.beauty[..., index].astype(np.float16).astype(np.float32)
        assert np.array_equal(channel(path, 0, name), half)
    assert np.array_equal(channel(path, 0, "Z"), pixels.aovs["depth"])
    for index, axis in enumerate("XYZ"):
        assert np.array_equal(
            channel(path, 0, f"position.{axis}"), pixels.aovs["position"][..., index]
        )
    assert np.array_equal(channel(path, 1, "objectId.id", oiio.UINT32), pixels.aovs["objectId"])


def test_float_keeps_every_bit(tmp_path: Path) -> None:
    path, pixels = tmp_path / "a.exr", film()
    pixels.beauty[0, 0] = (1e30, -0.0, 1e-45, 1)
    assert write_exr(path, pixels, {}, "float") == PixelFaults(0, 0)
    for index, name in enumerate("RGBA"):
        stored = channel(path, 0, name).view(np.uint32)
        assert np.array_equal(
            stored, np.ascontiguousarray(pixels.beauty[..., index]).view(np.uint32)
        )


def test_beauty_alone_is_one_part(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_exr(path, Film(film().beauty, {}), METADATA)
    image = opened(path)
    assert image.spec().channelnames == ("R", "G", "B", "A")
    assert not image.seek_subimage(1, 0)
    assert np.allclose(read_beauty(path), film().beauty[..., :3], atol=1e-3)


def test_metadata(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_exr(path, film(), METADATA)
    spec = opened(path).spec()
    assert spec["framesPerSecond"] == (24000, 1001)
    assert spec["worldToCamera"] == METADATA["worldToCamera"]
    assert (spec["irt:frame"], spec["irt:samples"], spec["Software"]) == ("1.25", 4, "irt 0")


def test_same_pixels_same_bytes(tmp_path: Path) -> None:
    one, two = tmp_path / "one.exr", tmp_path / "two.exr"
    write_exr(one, film(), METADATA)
    time.sleep(1.1)
    write_exr(two, film(), METADATA)
    assert one.read_bytes() == two.read_bytes()
    assert b"capDate" not in one.read_bytes()


def test_date_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.exr"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write_exr(path, film(), {"DateTime": source_date()})
    assert opened(path).spec()["DateTime"] == "1970:01:02 00:00:00"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "yesterday")
    with pytest.raises(InputError, match="SOURCE_DATE_EPOCH"):
        source_date()


def test_what_no_half_can_hold_is_counted(tmp_path: Path) -> None:
    path, pixels = tmp_path / "a.exr", film()
    pixels.beauty[0, 0, 1] = np.nan
    pixels.beauty[0, 1, :2] = np.inf
    pixels.beauty[0, 2, 0] = 1e6
    assert write_exr(path, pixels, {}) == PixelFaults(2, 1)
    row = read_beauty(path)[0]
    assert np.isnan(row[0, 1])
    assert np.isinf(row[1, 0])
    assert row[2, 0] == 65504


def test_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_exr(path, film(), {})
    before = path.read_bytes()

    def write_half() -> None:
        with atomic_file(path) as temporary:
            temporary.write_bytes(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_half()
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@contextmanager
def files_of_at_most(size: int) -> Iterator[None]:
    """Stands in for a disk on which the last bytes of a larger file find no room."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def write_frame(path: Path) -> None:
    write_exr(path.with_suffix(".exr"), film(), {})


def write_sheet(path: Path) -> None:
    write_contact_sheet(path.with_suffix(".png"), [path.parent / "frame.exr"], width=32)


@pytest.mark.parametrize("write", [write_frame, write_sheet])
def test_no_file_without_its_last_bytes(tmp_path: Path, write: Callable[[Path], None]) -> None:
    write_frame(tmp_path / "frame")
    write(tmp_path / "whole")
    (whole,) = tmp_path.glob("whole.*")
    with (
        files_of_at_most(whole.stat().st_size - 5),
        pytest.raises(MachineError, match="cannot be written"),
    ):
        write(tmp_path / "cut")
    assert {path.name for path in tmp_path.iterdir()} == {"frame.exr", whole.name}


def test_a_folder_that_vanished(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"gone/a\.exr: cannot be written") as caught:
        write_exr(tmp_path / "gone" / "a.exr", film(), {})
    assert caught.value.status == 1


def test_reading_what_is_no_exr(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_beauty(tmp_path / "missing.exr")
    write_exr(tmp_path / "a.exr", film(), {})
    (tmp_path / "cut.exr").write_bytes((tmp_path / "a.exr").read_bytes()[:3000])
    with pytest.raises(InputError, match=r"cut\.exr"):
        read_beauty(tmp_path / "cut.exr")


def test_contact_sheet(tmp_path: Path) -> None:
    frames = [tmp_path / f"b.{number:04d}.exr" for number in range(3)]
    for level, frame in zip((0.0, 0.5, 2.0), frames, strict=True):
        write_exr(frame, Film(np.full((9, 16, 4), level, np.float32), {}), {})
    sheet = tmp_path / "sheet.png"
    write_contact_sheet(sheet, frames, columns=3, width=32)
    pixels = opened(sheet).read_image(0, 0, 0, 3, oiio.UINT8)
    assert pixels.shape == (4 + 18 + 16 + 4, 4 + 3 * 36, 3)
    assert [int(pixels[10, left, 0]) for left in (10, 46, 82)] == [0, 188, 255]
    with pytest.raises(InputError, match=r"\.png"):
        write_contact_sheet(tmp_path / "sheet.jpg", frames)


def test_display_curve() -> None:
    linear = np.array([0.0, 0.0031308, 0.21404114, 1.0, 5.0, -1.0, np.nan], np.float32)
    expected = [0.0, 0.04045, 0.5, 1.0, 1.0, 0.0, 0.0]
    assert np.allclose(display_srgb(linear), expected, atol=1e-5)


@pytest.mark.parametrize(
    ("rate", "fraction"),
    [
        (24.0, Fraction(24)),
        (23.976, Fraction(24000, 1001)),
        (29.97, Fraction(30000, 1001)),
        (12.5, Fraction(25, 2)),
    ],
)
def test_frame_rates(rate: float, fraction: Fraction) -> None:
    assert frames_per_second(rate) == fraction


@pytest.mark.parametrize("orthographic", [False, True])
def test_camera_matrices(orthographic: bool) -> None:
    world_from_camera = np.eye(4)
    world_from_camera[3, :3] = (10.0, 20.0, 30.0)
    window = (-0.5, 1.5, -0.25, 0.75)
    to_camera, to_ndc = (
        np.array(matrix).reshape(4, 4)
        for matrix in camera_matrices(world_from_camera, window, orthographic)
    )
    depth = 1.0 if orthographic else 4.0
    for camera_x, camera_y, ndc in (
        (-0.5, 0.75, (0, 0)),
        (1.5, -0.25, (1, 1)),
        (0.5, 0.25, (0.5, 0.5)),
    ):
        world = np.array([10 + camera_x * depth, 20 + camera_y * depth, 30 - 4.0, 1.0])
        assert np.allclose(world @ to_camera, (camera_x * depth, camera_y * depth, 4.0, 1.0))
        projected = world @ to_ndc
        assert np.allclose(projected[:2] / projected[3], ndc)
    assert np.linalg.matrix_rank(to_ndc) == 4
