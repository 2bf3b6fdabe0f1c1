# SPDX-License-Identifier: Apache-2.0
"""EXR frames: scene-linear beauty and AOVs in one file, the same bytes for the same pixels.

Beauty is `R G B A` in the root layer. The AOVs are layers beside it (docs/aovs.md): colours stored
as beauty is, others in single precision, ids as uint32 in parts of their own.

The data window is the film's, the display window the full frame's.

OpenImageIO converts pixels of mixed types by way of float, which cannot hold every id: hence
the further parts.
"""

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from irt_usd.aovs import aov, default_layer
from irt_usd.errors import InputError, MachineError
from irt_usd.images import cryptomatte
from irt_usd.images.aovs import Plane
from irt_usd.images.atomic import atomic_file

PixelType = Literal["half", "float"]
Matrix = tuple[float, ...]
"""16 numbers, row after row, for row vectors as in OpenEXR and USD."""


@dataclass(frozen=True)
class TimeCode:
    """SMPTE 12M's time and flags: two decimal digits a byte, hours first."""

    bits: int


MetadataValue = str | int | float | Fraction | Matrix | TimeCode

HALF_MAX = 65504.0
"""Larger finite values are written as this: the next half is infinity."""

_FRAME = re.compile(r"-?[0-9]+(\.[0-9]+)?")
_REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


@dataclass(frozen=True)
class Film:
    """One frame's pixels, row 0 on top.

    `beauty` (height, width, 4) float32, scene-linear; `aovs` by name: (height, width) or, of
    vectors and colours, (height, width, 3); uint32 of ids, float32 of the others. `start`: the
    full frame's pixel that is the film's upper left one; `frame`: the full frame's width and
    height, None where the film is all of it.
    """

    beauty: NDArray[np.float32]
    aovs: Mapping[str, Plane]
    start: tuple[int, int] = (0, 0)
    frame: tuple[int, int] | None = None
    layers: Mapping[str, str] = field(default_factory=dict)
    """Names of the AOVs' layers, where they are other than the AOVs'."""

    manifests: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    """Of cryptomattes, by AOV: the ids that the image shows, by name."""

    causes: Sequence[str] = ()
    """What the numbers of irt.cause stand for, from 1 on."""

    def layer(self, name: str) -> str:
        """The name of an AOV's layer."""
        return self.layers.get(name) or default_layer(name)


@dataclass(frozen=True)
class PixelFaults:
    """Beauty pixels that could not be written as any number, or not as their own."""

    non_finite: int
    too_bright: int


def write_exr(
    path: Path, film: Film, metadata: Mapping[str, MetadataValue], pixel_type: PixelType = "half"
) -> PixelFaults:
    """Writes one frame, atomically; returns what had to be bent.

    Raises MachineError where the file cannot be written.
    """
    pixels, spec = _colour_part(film, pixel_type)
    parts: list[tuple[oiio.ImageSpec, NDArray[Any]]] = [(spec, pixels)]
    ids = [_id_part(film, name) for name in film.aovs if aov(name).kind == "id"]
    if ids:
        parts += ids
        spec["oiio:subimagename"] = "rgba"
    for part_spec, _ in parts:
        _set_metadata(part_spec, metadata)
    for name, manifest in film.manifests.items():
        _set_metadata(spec, cryptomatte.metadata(film.layer(name), manifest))
    if "irt.cause" in film.aovs:
        table = {str(number): text for number, text in enumerate(film.causes, 1)}
        _set_metadata(spec, {"irt:causes": json.dumps(table, ensure_ascii=False)})
    with atomic_file(path) as temporary:
        _write_parts(temporary, path, parts)
    return _faults(film, pixel_type)


def rewrite_metadata(old: Path, path: Path, metadata: Mapping[str, MetadataValue]) -> None:
    """Writes the pixels of a frame of ours to `path`, atomically, under other metadata.

    Raises MachineError where one cannot be read or the other not be written.
    """
    image = oiio.ImageInput.open(str(old))
    if image is None:
        raise MachineError(f"{old}: cannot be read: {oiio.geterror()}")
    parts: list[tuple[oiio.ImageSpec, NDArray[Any]]] = []
    while image.seek_subimage(len(parts), 0):
        spec = image.spec()
        kind = oiio.UINT32 if spec.format == oiio.UINT32 else oiio.FLOAT
        pixels = image.read_image(len(parts), 0, 0, spec.nchannels, kind)
        if pixels is None:
            raise MachineError(f"{old}: cannot be read: {image.geterror()}")
        own = oiio.ImageSpec(spec.width, spec.height, spec.nchannels, spec.format)
        own.x, own.y = spec.x, spec.y
        own.full_x, own.full_y = spec.full_x, spec.full_y
        own.full_width, own.full_height = spec.full_width, spec.full_height
        own.channelnames, own.channelformats = spec.channelnames, spec.channelformats
        own["compression"] = "zip"
        own["DateTime"] = ""
        own.attribute("chromaticities", oiio.TypeDesc("float[8]"), _REC709)
        name = spec.getattribute("oiio:subimagename")
        if name:
            own["oiio:subimagename"] = name
        _set_metadata(own, metadata)
        parts.append((own, pixels))
    image.close()
    with atomic_file(path) as temporary:
        _write_parts(temporary, path, parts)


def read_beauty(path: Path) -> NDArray[np.float32]:
    """The RGB of an EXR: (height, width, 3) float32. Raises InputError."""
    image = _open(path)
    if image.spec().nchannels < 3:
        raise InputError(f"{path}: has no R, G and B channels")
    return _read_channels(path, image, 0, 3)


def read_retraced(path: Path) -> NDArray[np.float32]:
    """The irt.retraced layer of an EXR: (height, width) rays. Raises InputError."""
    image = _open(path)
    names = image.spec().channelnames
    if "irt.retraced" not in names:
        raise InputError(f"{path}: has no channel irt.retraced; render with --aov irt.retraced")
    index = names.index("irt.retraced")
    return _read_channels(path, image, index, index + 1)[..., 0]


def _open(path: Path) -> oiio.ImageInput:
    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise InputError(f"{path}: cannot be read: {oiio.geterror().strip()}")
    return image


def _read_channels(path: Path, image: oiio.ImageInput, begin: int, end: int) -> NDArray[np.float32]:
    pixels = image.read_image(0, 0, begin, end, oiio.FLOAT)
    if pixels is None:
        raise InputError(f"{path}: is damaged: {image.geterror().strip()}")
    return np.asarray(pixels, dtype=np.float32)


def read_frame_number(path: Path) -> str | None:
    """The frame an EXR of ours was rendered for, as a decimal; None where none is recorded."""
    image = oiio.ImageInput.open(str(path))
    recorded = image.spec().getattribute("irt:frame") if image is not None else None
    return recorded if isinstance(recorded, str) and _FRAME.fullmatch(recorded) else None


def source_date() -> str:
    """SOURCE_DATE_EPOCH as the `DateTime` of a header (UTC), empty where it is not set.

    Raises InputError where it is no number of seconds.
    """
    text = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not text:
        return ""
    try:
        return datetime.fromtimestamp(int(text), UTC).strftime("%Y:%m:%d %H:%M:%S")
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(
            f"SOURCE_DATE_EPOCH is '{text}': expected seconds since 1970; correct or unset it"
        ) from error


def _colour_part(film: Film, pixel_type: PixelType) -> tuple[NDArray[np.float32], oiio.ImageSpec]:
    """The root layer and all float layers, as (height, width, channels), and their spec."""
    colour_type = oiio.HALF if pixel_type == "half" else oiio.FLOAT
    height, width = film.beauty.shape[:2]
    planes: list[NDArray[Any]] = [_storable(film.beauty, pixel_type)]
    names = ["R", "G", "B", "A"]
    formats = [colour_type] * 4
    for name, values in film.aovs.items():
        kind = aov(name).kind
        if kind == "id":
            continue
        colour = kind == "colour"
        plane = values.reshape(height, width, -1)
        channels = aov(name).channels(film.layer(name), plane.shape[2])
        planes.append(_storable(plane, pixel_type) if colour else plane)
        names += channels
        formats += [colour_type if colour else oiio.FLOAT] * len(channels)
    spec = _new_spec(film, names, colour_type)
    spec.channelformats = tuple(formats)
    return np.ascontiguousarray(np.concatenate(planes, axis=2, dtype=np.float32)), spec


def _id_part(film: Film, name: str) -> tuple[oiio.ImageSpec, NDArray[np.uint32]]:
    ids = film.aovs[name]
    height, width = ids.shape
    layer = film.layer(name)
    spec = _new_spec(film, aov(name).channels(layer), oiio.UINT32)
    spec["oiio:subimagename"] = layer
    return spec, np.ascontiguousarray(ids.reshape(height, width, 1), dtype=np.uint32)


def _storable(plane: NDArray[Any], pixel_type: PixelType) -> NDArray[Any]:
    if pixel_type == "float":
        return plane
    clipped = np.clip(plane, -HALF_MAX, HALF_MAX)
    return np.where(np.isinf(plane), plane, clipped)


def _faults(film: Film, pixel_type: PixelType) -> PixelFaults:
    finite = np.isfinite(film.beauty)
    too_bright = 0
    if pixel_type == "half":
        beyond = finite & (np.abs(film.beauty) > HALF_MAX)
        too_bright = int(np.count_nonzero(beyond.any(axis=2)))
    return PixelFaults(int(np.count_nonzero(~finite.all(axis=2))), too_bright)


def _new_spec(film: Film, channels: Sequence[str], pixel_format: Any) -> oiio.ImageSpec:
    height, width = film.beauty.shape[:2]
    spec = oiio.ImageSpec(width, height, len(channels), pixel_format)
    spec.x, spec.y = film.start
    spec.full_x, spec.full_y = 0, 0
    spec.full_width, spec.full_height = film.frame or (width, height)
    if (*film.start, width, height) != (0, 0, spec.full_width, spec.full_height):
        whole = (0, 0, spec.full_width - 1, spec.full_height - 1)
        spec.attribute("originalDataWindow", oiio.TypeDesc("box2i"), whole)
    spec.channelnames = tuple(channels)
    spec["compression"] = "zip"
    spec["DateTime"] = ""  # keeps OpenImageIO from adding the time of writing
    spec.attribute("chromaticities", oiio.TypeDesc("float[8]"), _REC709)
    return spec


def _set_metadata(spec: oiio.ImageSpec, metadata: Mapping[str, MetadataValue]) -> None:
    for key, value in metadata.items():
        if isinstance(value, Fraction):
            rational = (value.numerator, value.denominator)
            spec.attribute(key, oiio.TypeDesc("rational"), rational)
        elif isinstance(value, TimeCode):
            spec.attribute(key, oiio.TypeDesc("timecode"), (value.bits, 0))
        elif isinstance(value, tuple):
            kind = "matrix" if len(value) == 16 else f"float[{len(value)}]"
            spec.attribute(key, oiio.TypeDesc(kind), value)
        else:
            spec[key] = value


def _write_parts(
    temporary: Path, path: Path, parts: Sequence[tuple[oiio.ImageSpec, NDArray[Any]]]
) -> None:
    output = oiio.ImageOutput.create("openexr")
    if output is None:
        raise MachineError(f"{path}: OpenImageIO cannot write OpenEXR: {oiio.geterror()}")
    specs = tuple(spec for spec, _ in parts)
    written = output.open(str(temporary), specs if len(specs) > 1 else specs[0])
    for index, (spec, pixels) in enumerate(parts):
        if written and index > 0:
            written = output.open(str(temporary), spec, "AppendSubimage")
        written = written and output.write_image(pixels)
    closed = output.close()
    if not (written and closed):
        reason = " ".join(output.geterror().split()).replace(str(temporary), path.name)
        raise MachineError(f"{path}: cannot be written: {reason}")
