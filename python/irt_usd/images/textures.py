# SPDX-License-Identifier: Apache-2.0
"""The textures of a shot: decoded once each, at first use, within a limit of memory."""

import os
from collections.abc import Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pxr import Ar, Usd, UsdShade

from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.images.color import LINEAR_REC709, ColorSpaces, Conversion
from irt_usd.images.decode import DecodeError, ImageHeader, decode, read_header
from irt_usd.images.texture_memory import Pyramid, levels_to_drop
from irt_usd.report import Report
from irt_usd.stage.graph import AUTO, AUTO_COLOR, TextureReference, Wrap, WrapMode
from irt_usd.stage.missing import missing_text, report_missing

_FIRST_TILE, _LAST_TILE = 1001, 1100
_THREADS = min(8, os.cpu_count() or 1)
_ALPHAS = {1: False, 2: True, 3: False, 4: True}


@dataclass(frozen=True)
class _Image:
    """What is known of a reference before it is decoded."""

    tiles: tuple[tuple[int, int, str], ...]
    """u, v and file."""
    header: ImageHeader
    """Of the first tile, which says how all are read."""
    pyramid: Pyramid
    conversion: Conversion


class TextureLibrary:
    """The textures that materials refer to, shared by all of them.

    Each is decoded when a frame first shows it, and let go once neither a frame nor the one before
    it does, so that of a sequence of images no more than two are in memory.

    Which levels are dropped to stay within `limit` bytes (None: none) follows from all the
    references of the shot, so that it does not depend on the frames that are rendered.
    """

    def __init__(self, spaces: ColorSpaces, report: Report, limit: int | None = None) -> None:
        self._spaces = spaces
        self._report = report
        self._limit = limit
        self._images: dict[TextureReference, _Image | None] = {}
        self._textures: dict[TextureReference, Any] = {}
        self._kept: frozenset[TextureReference] = frozenset()
        self._means: dict[TextureReference, tuple[float, float, float]] = {}
        self._cells: dict[TextureReference, Any] = {}
        self._dropped: Mapping[TextureReference, int] = {}
        self._places: dict[TextureReference, str] = {}
        self._policy: MissingAsset = "fail"
        self._source = ""

    def survey(
        self,
        references: Mapping[TextureReference, str],
        stage: Usd.Stage,
        policy: MissingAsset,
        source: str,
    ) -> None:
        """Takes up all the references of a shot, with the attribute and file that names each.

        Reads their headers alone. Raises InputError, on the stage's file `source`, for what cannot
        be had, if that is `policy`; else it is reported, and its fallback rendered.
        """
        self._policy, self._source = policy, source
        self._places = dict(sorted(references.items(), key=lambda item: _order(item[0])))
        missing: list[str] = []
        unusable: list[str] = []
        for reference, place in self._places.items():
            try:
                self._images[reference] = self._look_at(reference, place)
            except DecodeError as error:
                self._images[reference] = None
                if error.missing:
                    missing.append(missing_text(stage, place, reference.file))
                else:
                    unusable.append(f"{place}: @{reference.file}@: {error}")
        report_missing("textures", missing, policy, self._report, source)
        self._refuse_unusable(unusable)
        self._plan()

    def load(self, references: Collection[TextureReference]) -> None:
        """Decodes those of `references` that are not yet, on several threads."""
        wanted = sorted((r for r in references if r not in self._textures), key=_order)
        if not wanted:
            return
        with ThreadPoolExecutor(_THREADS) as pool:
            made = list(pool.map(self._attempt, wanted))
        self._textures |= {r: texture for r, (texture, _) in zip(wanted, made, strict=True)}
        self._refuse_unusable([fault for _, fault in made if fault])

    def texture(self, reference: TextureReference) -> Any:
        """The core's texture, the same one at every call; None: its fallback is rendered."""
        self.load((reference,))
        return self._textures[reference]

    def keep(self, references: Collection[TextureReference]) -> None:
        """Lets go of textures that are neither among `references` nor were at the last call."""
        before, self._kept = self._kept, frozenset(references)
        for reference, texture in list(self._textures.items()):
            if texture is not None and reference not in before | self._kept:
                del self._textures[reference]
                self._cells.pop(reference, None)

    @property
    def decoded(self) -> frozenset[TextureReference]:
        """Those that are in memory."""
        return frozenset(r for r, texture in self._textures.items() if texture is not None)

    def wrap(
        self, reference: TextureReference, wrap: tuple[Wrap, Wrap]
    ) -> tuple[WrapMode, WrapMode]:
        """`wrap` with what the file says in the place of useMetadata: black if it says nothing."""
        image = self._images.get(reference)
        found: Any = (image.header.wrap if image is not None else None) or ("black", "black")
        s, t = (f if w == "useMetadata" else w for w, f in zip(wrap, found, strict=True))
        return s, t

    def picture(self, reference: TextureReference) -> Any:
        """The core's texture of a light; None: the light is rendered without it."""
        return self.texture(reference)

    def mean(self, reference: TextureReference) -> tuple[float, float, float]:
        """The mean colour of a texture that can be had."""
        from irt_usd import _core

        if reference not in self._means:
            self._means[reference] = _core.texture_mean(self.texture(reference))
        return self._means[reference]

    def sky_cells(self, reference: TextureReference) -> Any:
        """The core's _core.SkyCells of a texture that can be had."""
        from irt_usd import _core

        if reference not in self._cells:
            self._cells[reference] = _core.SkyCells(self.texture(reference))
        return self._cells[reference]

    @property
    def files(self) -> list[str]:
        """What the textures are read from."""
        images = (image for image in self._images.values() if image is not None)
        return [file for image in images for _, _, file in image.tiles]

    @property
    def dropped(self) -> dict[str, int]:
        """How many of their finest levels files have lost to the limit."""
        return {reference.file: count for reference, count in self._dropped.items() if count}

    def _refuse_unusable(self, faults: list[str]) -> None:
        if faults and self._policy == "fail":
            advice = "mend them, or render their fallbacks by --missing-asset fallback"
            raise InputError(
                "\n  ".join([f"{self._source}: unusable textures; {advice}:", *faults])
            )
        for fault in faults:
            self._report.skipped("unusable textures, their fallbacks rendered", fault)

    def _look_at(self, reference: TextureReference, place: str) -> _Image:
        tiles = _tiles(reference)
        headers = [read_header(file) for _, _, file in tiles]
        first = headers[0]
        conversion = self._conversion(reference, first, place)
        baked = conversion.transfer == "baked"
        sizes = []
        for header in headers:
            channels = _baked_channels(header.channels) if baked else header.channels
            texel = header.texel_bytes if not baked else channels * _baked_depth(header.depth)[1]
            sizes.append((header.width, header.height, texel))
        self._mention_holes(reference, tiles, place)
        return _Image(tiles, first, Pyramid(tuple(sizes)), conversion)

    def _conversion(
        self, reference: TextureReference, header: ImageHeader, place: str
    ) -> Conversion:
        name = reference.color_space
        if name in (AUTO, AUTO_COLOR):
            name = "sRGB" if header.is_srgb else ("raw" if name == AUTO else LINEAR_REC709)
        found = self._spaces.conversion(name)
        if found is None:
            self._report.skipped(f"the colour space {name} is not known; raw is rendered", place)
            return Conversion("linear")
        return found

    def _mention_holes(
        self, reference: TextureReference, tiles: Collection[tuple[int, int, str]], place: str
    ) -> None:
        """Tiles between others that are not there."""
        if not reference.udim:
            return
        there = {1001 + u + 10 * v for u, v, _ in tiles}
        columns, rows = {u for u, _, _ in tiles}, {v for _, v, _ in tiles}
        holes = [
            1001 + u + 10 * v
            for v in range(min(rows), max(rows) + 1)
            for u in range(min(columns), max(columns) + 1)
            if 1001 + u + 10 * v not in there
        ]
        if holes:
            named = ", ".join(map(str, holes))
            self._report.mentioned(f"UDIM tiles missing, fallback rendered: {named}", place)

    def _plan(self) -> None:
        """Decides which levels are dropped, and says so."""
        if self._limit is None:
            return
        pyramids = {r: image.pyramid for r, image in self._images.items() if image is not None}
        self._dropped = levels_to_drop(pyramids, self._limit)
        for reference, count in self._dropped.items():
            if count:
                alone = pyramids[reference].bytes_without(0) > self._limit
                which = "textures larger than it by themselves, " if alone else ""
                self._report.mentioned(
                    f"--texture-memory: {which}finest levels dropped", f"{reference.file} ({count})"
                )

    def _attempt(self, reference: TextureReference) -> tuple[Any, str]:
        """The texture, or why there is none."""
        try:
            image = self._images.get(reference)
            if image is None:
                if reference in self._images:
                    return None, ""  # told by `survey`
                image = self._look_at(reference, reference.file)
            return self._make(reference, image), ""
        except DecodeError as error:
            return None, f"{self._places.get(reference, '')}: @{reference.file}@: {error}"
        except MemoryError:
            return None, f"{self._places.get(reference, '')}: @{reference.file}@: out of memory"

    def _make(self, reference: TextureReference, image: _Image) -> Any:
        from irt_usd import _core

        tiles = []
        for u, v, file in image.tiles:
            pixels = _finite(decode(file))
            if image.conversion.transfer == "baked":
                pixels = _bake(pixels, image.conversion)
            tiles.append((u, v, pixels))
        conversion = image.conversion
        transfer: Literal["srgb", "linear"] = "srgb" if conversion.transfer == "srgb" else "linear"
        texture = _core.Texture(
            tiles, transfer=transfer, matrix=conversion.matrix, udim=reference.udim
        )
        count = self._dropped.get(reference, 0)
        return texture.without_finest(count) if count else texture


def _order(reference: TextureReference) -> tuple[str, str]:
    return reference.file, reference.color_space


def _tiles(reference: TextureReference) -> tuple[tuple[int, int, str], ...]:
    """Raises DecodeError where there is none."""
    if not reference.udim:
        return ((0, 0, reference.file),)
    resolver = Ar.GetResolver()
    found = []
    for number in range(_FIRST_TILE, _LAST_TILE + 1):
        file = UsdShade.UdimUtils.ReplaceUdimPattern(reference.file, str(number))
        if resolver.Resolve(file):
            index = number - _FIRST_TILE
            found.append((index % 10, index // 10, file))
    if not found:
        raise DecodeError("no such file for any tile from 1001 to 1100", missing=True)
    return tuple(found)


def _finite(pixels: NDArray[Any]) -> NDArray[Any]:
    if pixels.dtype.kind != "f" or np.isfinite(pixels).all():
        return pixels
    finite: NDArray[Any] = np.nan_to_num(pixels, nan=0.0)
    return finite


def _bake(pixels: NDArray[Any], conversion: Conversion) -> NDArray[Any]:
    """Colours in the rendering space: as half from 8 bits, else as float."""
    channels = pixels.shape[2]
    scale = 1.0 / np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else 1.0
    wide = np.empty((*pixels.shape[:2], _baked_channels(channels)), np.float32)
    wide[..., :3] = pixels[..., :1] if channels <= 2 else pixels[..., :3]
    if _ALPHAS[channels]:
        wide[..., 3] = pixels[..., -1]
    wide *= np.float32(scale)
    conversion.apply(wide)
    return wide.astype(np.float16) if pixels.dtype == np.uint8 else wide


def _baked_channels(channels: int) -> int:
    return 4 if _ALPHAS[channels] else 3


def _baked_depth(depth: str) -> tuple[str, int]:
    return ("half", 2) if depth == "uint8" else ("float", 4)
