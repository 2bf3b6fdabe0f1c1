# SPDX-License-Identifier: Apache-2.0
"""Partial frames: the pixels of some cells, with all that the whole frame's file needs."""

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core
from irt_usd.checkpoint.container import Container, compose, read
from irt_usd.checkpoint.provenance import FileHashes, program_items, setting_items
from irt_usd.errors import MachineError
from irt_usd.images.exr import Film, MetadataValue, PixelFaults, PixelType, TimeCode
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings

KIND = "irt partial frame"


class PartialWriter:
    """Writes partial frames as write_exr writes whole ones, with where they come from."""

    def __init__(
        self, shot: Shot, settings: TraceSettings, pixel_type: PixelType, cells: Sequence[int]
    ) -> None:
        self._cells = list(cells)
        self._files = FileHashes(shot)
        self._job = {
            **program_items(settings.isa, same_build=False),
            **setting_items(shot, settings, {"output type": pixel_type}),
        }
        self._products = [view.product.path for view in shot.views]

    def __call__(
        self, path: Path, film: Film, metadata: Mapping[str, MetadataValue], pixel_type: PixelType
    ) -> PixelFaults:
        """Raises MachineError where the file cannot be written."""
        mask = cell_mask(film.beauty.shape[:2], film.start, self._cells)
        arrays = _core.ArrayWriter()
        arrays.add("beauty", film.beauty[mask])
        for name, plane in film.aovs.items():
            arrays.add(f"aov.{name}", plane[mask])
        rest = {
            field.name: getattr(film, field.name)
            for field in fields(film)
            if field.name not in ("beauty", "aovs")
        }
        header = {
            "kind": KIND,
            "job": self._job,
            "files": self._files.take(),
            "frame": metadata["irt:frame"],
            "product": metadata.get("irt:renderProduct", ""),
            "cells": self._cells,
            "size": list(film.beauty.shape[:2]),
            "shapes": {name: list(plane.shape[2:]) for name, plane in film.aovs.items()},
            "film": _encoded(rest),
            "metadata": _encoded(dict(metadata)),
            "pixel_type": pixel_type,
        }
        try:
            arrays.write(os.path.realpath(path), compose(header, arrays))
        except OSError as error:
            raise MachineError(f"{path}: cannot be written: {error.strerror}") from error
        return PixelFaults(0, 0)  # told where whole frames are written


@dataclass(frozen=True)
class Partial:
    """A partial frame that was read."""

    container: Container

    @property
    def header(self) -> dict[str, Any]:
        """As PartialWriter writes it."""
        return self.container.header

    @property
    def path(self) -> Path:
        """Its file."""
        return self.container.path

    @property
    def cells(self) -> list[int]:
        """That it has."""
        found: list[int] = self.header["cells"]
        return found


def read_partial(path: Path) -> Partial:
    """A partial frame, proven whole. Raises RefusedError."""
    container = read(path, KIND)
    container.verify()
    return Partial(container)


def assembled(parts: Sequence[Partial]) -> tuple[Film, dict[str, MetadataValue], PixelType]:
    """The frame that parts of all cells make; write_exr's arguments."""
    first = parts[0].header
    height, width = first["size"]
    rest = _decoded(first["film"])
    beauty = np.zeros((height, width, 4), np.float32)
    causes = _together([_decoded(part.header["film"]) for part in parts])["causes"]
    aovs: dict[str, NDArray[Any]] = {}
    for part in parts:
        mask = cell_mask((height, width), rest["start"], part.cells)
        beauty[mask] = part.container.array("beauty").reshape(-1, 4)
        for name, tail in first["shapes"].items():
            pixels = part.container.array(f"aov.{name}")
            if name == "irt.cause":
                pixels = _renumbered(pixels, _decoded(part.header["film"])["causes"], causes)
            plane = aovs.setdefault(name, np.zeros((height, width, *tail), pixels.dtype))
            plane[mask] = pixels.reshape(-1, *tail)
    rest |= _together([_decoded(part.header["film"]) for part in parts])
    return Film(beauty, aovs, **rest), _decoded(first["metadata"]), first["pixel_type"]


def _renumbered(
    pixels: NDArray[np.float32], own: Sequence[str], causes: Sequence[str]
) -> NDArray[np.float32]:
    """irt.cause of a part, whose table is `own`, by the table of the whole frame."""
    numbers = np.array([0, *(causes.index(text) + 1 for text in own)], np.float32)
    renumbered: NDArray[np.float32] = numbers[pixels.astype(np.int64)]
    return renumbered


def _together(films: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What parts of a frame found each for itself."""
    manifests: dict[str, dict[str, int]] = {}
    for film in films:
        for name, names in film["manifests"].items():
            manifests.setdefault(name, {}).update(names)
    ordered = {name: dict(sorted(names.items())) for name, names in manifests.items()}
    return {"manifests": ordered, "causes": sorted({c for film in films for c in film["causes"]})}


def cell_mask(
    shape: Sequence[int], start: tuple[int, int], cells: Sequence[int]
) -> NDArray[np.bool_]:
    """(height, width): the pixels of `cells`, which are counted on the full frame."""
    height, width = shape
    columns = (np.arange(width) + start[0]) % 8
    rows = (np.arange(height) + start[1]) % 8
    found: NDArray[np.bool_] = np.isin(columns[None, :] + 8 * rows[:, None], list(cells))
    return found


def _encoded(value: Any) -> Any:
    """As JSON holds it without loss."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, TimeCode):
        return {"timecode": value.bits}
    if isinstance(value, Fraction):
        return {"fraction": [value.numerator, value.denominator]}
    if isinstance(value, (tuple, list)):
        return {type(value).__name__: [_encoded(item) for item in value]}
    if isinstance(value, Mapping):
        return {"map": [[key, _encoded(item)] for key, item in value.items()]}
    if isinstance(value, float) and not math.isfinite(value):
        return {"float": str(value)}
    return value


def _decoded(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    ((kind, inner),) = value.items()
    if kind == "timecode":
        return TimeCode(inner)
    if kind == "fraction":
        return Fraction(*inner)
    if kind == "map":
        return {key: _decoded(item) for key, item in inner}
    if kind == "float":
        return float(inner)
    items = [_decoded(item) for item in inner]
    return tuple(items) if kind == "tuple" else items
