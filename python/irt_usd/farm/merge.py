# SPDX-License-Identifier: Apache-2.0
"""Partial frames to whole ones: only of one job, and only where every cell is there once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from irt_usd.checkpoint.container import RefusedError
from irt_usd.checkpoint.provenance import differences
from irt_usd.errors import InputError
from irt_usd.farm.cells import CELLS, format_cells
from irt_usd.farm.partial import Partial, assembled, read_partial
from irt_usd.images.exr import write_exr
from irt_usd.shot.frames import Frame, format_frame, parse_frames
from irt_usd.shot.output import output_paths, parse_pattern
from irt_usd.shot.products import PRODUCT_TOKEN

_SHOWN = 5
"""Faults of a kind that a message lists."""


@dataclass(frozen=True)
class Whole:
    """A frame of a product, all of whose cells are there."""

    frame: Frame
    product: str
    parts: Sequence[Path]


def complete_frames(folders: Sequence[Path]) -> list[Whole]:
    """The frames whose parts lie in `folders`, in order.

    Raises InputError where a part is damaged or of another job, or a cell is missing or there
    twice.
    """
    found = sorted({path for folder in folders for path in _parts_in(folder)})
    if not found:
        raise InputError(f"{_listed(folders)}: no partial frames (*.irtpart); render them first")
    parts = [_read(path) for path in found]
    _refuse_strangers(parts)
    job = parts[0].header["job"]
    wanted = [(frame, view[1]) for frame in parse_frames(job["frames"]) for view in job["views"]]
    by_frame: dict[tuple[str, str], list[Partial]] = {}
    for part in parts:
        by_frame.setdefault((part.header["frame"], part.header["product"]), []).append(part)
    faults: list[str] = []
    whole: list[Whole] = []
    for frame, product in wanted:
        of_frame = by_frame.get((format_frame(frame), product), [])
        name = f"frame {format_frame(frame)}" + (f" of {product}" if product else "")
        faults += _uncovered(name, of_frame)
        whole.append(Whole(frame, product, [part.path for part in of_frame]))
    if faults:
        more = f"\n  and {len(faults) - _SHOWN} more" if len(faults) > _SHOWN else ""
        raise InputError(
            "the parts do not make whole frames; nothing was written:\n  "
            + "\n  ".join(faults[:_SHOWN])
            + more
        )
    return whole


def merged_paths(frames: Sequence[Whole], output: str) -> list[Path]:
    """The file of each. Raises InputError."""
    products = list(dict.fromkeys(whole.product for whole in frames))
    if len(products) > 1 and PRODUCT_TOKEN not in output:
        raise InputError(
            f"--output {output}: the parts are of {len(products)} products; put {PRODUCT_TOKEN} in"
            " the name, which becomes each product's prim name"
        )
    paths: dict[tuple[Frame, str], Path] = {}
    for product in products:
        label = product.rsplit("/", 1)[-1]
        own = [whole.frame for whole in frames if whole.product == product]
        pattern = parse_pattern(output.replace(PRODUCT_TOKEN, label))
        for frame, path in zip(own, output_paths(pattern, own), strict=True):
            paths[frame, product] = path
    return [paths[whole.frame, whole.product] for whole in frames]


def merge_frames(
    frames: Sequence[Whole], paths: Sequence[Path], done: Callable[[Whole, Path], None]
) -> None:
    """Writes each frame's file and tells `done`. Raises InputError and MachineError."""
    for whole, path in zip(frames, paths, strict=True):
        film, metadata, pixel_type = assembled([_read(part) for part in whole.parts])
        write_exr(path, film, metadata, pixel_type)
        done(whole, path)


def _parts_in(folder: Path) -> list[Path]:
    if folder.is_file():
        return [folder]
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give those of irt render --cells")
    return list(folder.glob("*.irtpart"))


def _read(path: Path) -> Partial:
    try:
        return read_partial(path)
    except RefusedError as error:
        raise InputError(f"{error}; render it again") from error


def _refuse_strangers(parts: Sequence[Partial]) -> None:
    first = parts[0]
    files = dict(first.header["files"])
    sources = dict.fromkeys(files, first)
    for part in parts[1:]:
        found = list(differences(first.header["job"], part.header["job"]))
        for name, hashed in part.header["files"].items():
            if files.setdefault(name, hashed) != hashed:
                found.append(f"file {name}: another than for {sources[name].path.name}")
            sources.setdefault(name, part)
        if found:
            raise InputError(
                f"{part.path}: is of another job than {first.path}: {'; '.join(found)}"
            )


def _uncovered(name: str, parts: Sequence[Partial]) -> list[str]:
    faults = []
    owners: dict[int, Path] = {}
    for part in parts:
        twice = [cell for cell in part.cells if cell in owners]
        if twice:
            other = owners[twice[0]]
            faults.append(
                f"{name}: cells {format_cells(twice)} are both in {other} and {part.path}"
            )
        owners.update(dict.fromkeys(part.cells, part.path))
    missing = [cell for cell in range(CELLS) if cell not in owners]
    if missing:
        faults.append(f"{name}: cells {format_cells(missing)} are missing")
    if not faults and any(part.header["metadata"] != parts[0].header["metadata"] for part in parts):
        faults.append(f"{name}: its parts differ in what the file's header is to say")
    return faults


def _listed(paths: Sequence[Path]) -> str:
    return ", ".join(map(str, paths))
