# SPDX-License-Identifier: Apache-2.0
"""Contact sheets: an EXR sequence at a glance, as one PNG for a screen."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from irt_usd.errors import InputError
from irt_usd.images.exr import read_beauty, read_frame_number, read_retraced
from irt_usd.images.png import write_png

_GAP = 4
_LABEL_HEIGHT = 16
_GLYPH_SCALE = 2
_BACKGROUND = 0.12
_INK = 0.85
_DIM = 0.35
# Five rows of three pixels a glyph; drawn here because a machine need not have a font.
_GLYPHS = {
    "0": "111101101101111",
    "1": "010110010010111",
    "2": "111001111100111",
    "3": "111001111001111",
    "4": "101101111001001",
    "5": "111100111001111",
    "6": "111100111101111",
    "7": "111001001001001",
    "8": "111101111101111",
    "9": "111101111001111",
    ".": "000000000000010",
    "-": "000000111000000",
}


def write_contact_sheet(
    path: Path,
    frames: Sequence[Path],
    columns: int | None = None,
    width: int = 240,
    retraced: bool = False,
) -> None:
    """Writes the sheet of `frames`, in that order, each labelled with its number.

    `columns` frames are beside each other, else about as many as below each other; each is
    `width` pixels wide. The display transform is sRGB's, unfilmed: values are clipped to 0..1,
    NaN shows black. `retraced`: rays retraced a pixel, from dark red (few) to white (as many as
    any pixel of these frames has), over a dim grey image. Raises InputError for frames that cannot
    be read, MachineError where the PNG cannot be written.
    """
    if path.suffix.lower() != ".png":
        raise InputError(f"{path}: a contact sheet is a PNG; end the name in .png")
    if not frames:
        raise InputError("a contact sheet needs frames; name some EXR files")
    columns = min(len(frames), columns or math.ceil(math.sqrt(len(frames))))
    most = 0.0
    if retraced:
        most = max(float(read_retraced(frame).max()) for frame in frames)
    tiles = [_tile(frame, width, most if retraced else None) for frame in frames]
    row_heights = [
        max(tile.shape[0] for tile in tiles[start : start + columns])
        for start in range(0, len(tiles), columns)
    ]
    sheet_size = (sum(row_heights) + _GAP * (len(row_heights) + 1), columns * (width + _GAP) + _GAP)
    sheet = np.full((*sheet_size, 3), _BACKGROUND, dtype=np.float32)
    for index, tile in enumerate(tiles):
        row, column = divmod(index, columns)
        top = _GAP + sum(row_heights[:row]) + _GAP * row
        left = _GAP + column * (width + _GAP)
        sheet[top : top + tile.shape[0], left : left + width] = tile
    write_png(path, sheet, {"oiio:ColorSpace": "srgb_rec709_scene"})


def display_srgb(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Scene-linear Rec.709 to sRGB display values (IEC 61966-2-1), clipped to 0..1."""
    clipped = np.clip(np.nan_to_num(linear, nan=0.0), 0.0, 1.0)
    curve = 1.055 * np.power(clipped, 1 / 2.4) - 0.055
    return np.where(clipped <= 0.0031308, 12.92 * clipped, curve).astype(np.float32)


def _tile(frame: Path, width: int, most_retraced: float | None) -> NDArray[np.float32]:
    """(height + label, width, 3), display values; heat where `most_retraced` is given."""
    # Clipped before it is averaged: one highlight must not light up its whole tile.
    pixels = np.clip(np.nan_to_num(read_beauty(frame), nan=0.0), 0.0, 1.0)
    height = max(1, round(width * pixels.shape[0] / pixels.shape[1]))
    image = display_srgb(_resized(pixels, width, height))
    if most_retraced is not None:
        grey = np.repeat(image.mean(axis=2, keepdims=True) * _DIM, 3, axis=2)
        # Shares of a tile's pixel that are touched must show, however few.
        share = _resized(read_retraced(frame)[..., np.newaxis], width, height)
        heat = _heat(np.clip(share[..., 0] / max(most_retraced, 1.0), 0.0, 1.0))
        image = np.where(share > 0, heat, grey).astype(np.float32)
    label = np.full((_LABEL_HEIGHT, width, 3), _BACKGROUND, dtype=np.float32)
    _draw(label, _frame_label(frame))
    return np.concatenate([image, label], axis=0)


def _resized(pixels: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Box-filtered to (height, width, channels): every pixel counts, and none goes below zero."""
    channels = pixels.shape[2]
    resized = oiio.ImageBufAlgo.resize(
        oiio.ImageBuf(np.ascontiguousarray(pixels)),
        "box",
        roi=oiio.ROI(0, width, 0, height, 0, 1, 0, channels),
    )
    result = np.asarray(resized.get_pixels(oiio.FLOAT), dtype=np.float32)
    return result.reshape(height, width, channels)


def _heat(share: NDArray[np.float32]) -> NDArray[np.float32]:
    """Display colours of shares from 0 to 1: dark red, red, orange, yellow, white."""
    level = 0.25 + 0.75 * np.sqrt(share)
    channels = [np.clip(3 * level - offset, 0.0, 1.0) for offset in (0.25, 1.0, 2.0)]
    return np.stack(channels, axis=-1)


def _frame_label(frame: Path) -> str:
    """The frame recorded in the file, else the last number in its name, else nothing."""
    recorded = read_frame_number(frame)
    if recorded is not None:
        return recorded
    numbers = re.findall(r"(?:(?<![0-9A-Za-z])-)?[0-9]+", frame.stem)
    return str(numbers[-1]) if numbers else ""


def _draw(label: NDArray[np.float32], text: str) -> None:
    left, top = 2, (_LABEL_HEIGHT - 5 * _GLYPH_SCALE) // 2
    for character in text:
        bits = np.array([int(bit) for bit in _GLYPHS[character]], dtype=bool).reshape(5, 3)
        mask = np.kron(bits, np.ones((_GLYPH_SCALE, _GLYPH_SCALE), dtype=bool))
        if left + mask.shape[1] > label.shape[1]:
            return
        label[top : top + mask.shape[0], left : left + mask.shape[1]][mask] = _INK
        left += mask.shape[1] + _GLYPH_SCALE
