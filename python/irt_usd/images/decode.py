# SPDX-License-Identifier: Apache-2.0
"""Image files of any format that OpenImageIO reads, in their own bit depth."""

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray
from pxr import Ar, Tf

from irt_usd.memory import free_memory
from irt_usd.stage import assets_read

_DEPTHS = {"uint8": oiio.UINT8, "uint16": oiio.UINT16, "half": oiio.HALF}
"""What is kept as it is; all others become float."""

_BYTES = {"uint8": 1, "uint16": 2, "half": 2}

_WRAPS = {"periodic": "repeat", "black": "black", "clamp": "clamp", "mirror": "mirror"}
"""OpenImageIO's names of wrap modes, and UsdUVTexture's."""

_GAMMA_TOLERANCE = 0.25
"""How near to 2.2 a file's gamma must be to mean sRGB, which is no power."""


class DecodeError(Exception):
    """An image that cannot be had; `missing` if there is no such file. The text says why."""

    def __init__(self, reason: str, missing: bool = False) -> None:
        super().__init__(reason)
        self.missing = missing


@dataclass(frozen=True)
class ImageHeader:
    """What a file says of its image before it is decoded."""

    width: int
    height: int
    channels: int
    """1 to 4: those kept."""
    depth: str
    """uint8, uint16, half or float."""
    srgb: bool | None
    """Whether metadata says that it is sRGB, or that it is linear; None: it says nothing."""
    wrap: tuple[str, str] | None
    """UsdUVTexture's wrap modes, if metadata has them."""

    @property
    def texel_bytes(self) -> int:
        """Bytes of one texel in memory."""
        return self.channels * _BYTES.get(self.depth, 4)

    @property
    def is_srgb(self) -> bool:
        """UsdUVTexture's rule for the colour space "auto"."""
        if self.srgb is not None:
            return self.srgb
        return self.depth == "uint8" and self.channels in (3, 4)


def read_header(file: str) -> ImageHeader:
    """The header of `file`, a path or one within a package. Raises DecodeError."""
    with _opened(file) as image:
        return _header(image.spec())


def decode(file: str) -> NDArray[Any]:
    """The image as (h, w, channels), C-contiguous, row 0 on top, alpha as the file has it.

    uint8, uint16, float16 or float32; CMYK and palettes are RGB. Raises DecodeError.
    """
    with _opened(file) as image:
        header = _header(image.spec())
        size = header.width * header.height * header.texel_bytes
        free = free_memory()
        if size > free:
            raise DecodeError(
                f"an image of {header.width}x{header.height} needs {size / 2**30:.1f} GiB, and"
                f" {free / 2**30:.1f} GiB of memory are free; make it smaller"
            )
        kind = _DEPTHS.get(header.depth, oiio.FLOAT)
        pixels = image.read_image(0, 0, 0, header.channels, kind)
        if pixels is None or image.has_error:
            raise DecodeError(f"damaged: {_said(image.geterror())}; write it again")
    return np.ascontiguousarray(pixels).reshape(header.height, header.width, header.channels)


@contextmanager
def _opened(file: str) -> Iterator[Any]:
    with _as_file(file) as path:
        keep_alpha = oiio.ImageSpec()
        keep_alpha.attribute("oiio:UnassociatedAlpha", 1)
        image = oiio.ImageInput.open(path, keep_alpha)
        if image is None:
            reason = _said(oiio.geterror()).replace(path, Path(file).name)
            raise DecodeError(f"no image that OpenImageIO reads: {reason}; write it again")
        try:
            yield image
        finally:
            image.close()


@contextmanager
def _as_file(file: str) -> Iterator[str]:
    """A path that OpenImageIO can open.

    Of what is in a package, or is no file but something that the asset resolver opens, a temporary
    copy.
    """
    assets_read.note(file)
    packaged = Ar.IsPackageRelativePath(file)
    path = Path(file)
    if not packaged and path.exists():
        if path.is_dir():
            raise DecodeError("a folder, not an image", missing=True)
        if not os.access(path, os.R_OK):
            raise DecodeError("no permission to read it; change its mode or owner")
        yield file
        return
    try:
        asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(file))
        data = asset.GetBuffer() if asset else None
    except Tf.ErrorException as error:
        raise DecodeError(f"the package cannot be read: {error}; write it again") from None
    if data is None:
        lost = "not in the package, or compressed there, which USD forbids"
        raise DecodeError(lost if packaged else "no such file", missing=True)
    suffix = Path(Ar.SplitPackageRelativePathInner(file)[1] if packaged else file).suffix
    with tempfile.NamedTemporaryFile(suffix=suffix) as copy:
        copy.write(data)
        copy.flush()
        yield copy.name


def _header(spec: Any) -> ImageHeader:
    if spec.depth > 1 or spec.deep:
        raise DecodeError("a deep or volume image; expected a flat one")
    base = str(spec.format)
    return ImageHeader(
        spec.width,
        spec.height,
        min(spec.nchannels, 4),
        base if base in _DEPTHS else "float",
        _says_srgb({a.name: a.value for a in spec.extra_attribs}),
        _says_wrap(str(spec.get_string_attribute("wrapmodes"))),
    )


def _says_srgb(metadata: Mapping[str, Any]) -> bool | None:
    """OpenImageIO's own guess, `oiio:ColorSpace`, is none of the file's metadata."""
    gamma = metadata.get("oiio:Gamma")
    if gamma is not None and float(gamma) > 0:
        return abs(float(gamma) - 2.2) < _GAMMA_TOLERANCE
    interop = metadata.get("colorInteropID")
    if interop is not None:
        return str(interop) == "srgb_rec709_scene"
    if metadata.get("Exif:ColorSpace") == 1:
        return True
    return True if "sRGB" in str(metadata.get("ICCProfile:profile_description", "")) else None


def _says_wrap(modes: str) -> tuple[str, str] | None:
    found = [_WRAPS.get(mode.strip()) for mode in modes.split(",")] if modes else []
    if not found or None in found:
        return None
    return str(found[0]), str(found[-1])


def _said(error: str) -> str:
    return " ".join(error.split()) or "no reason given"
