# SPDX-License-Identifier: Apache-2.0
"""What a user asks for: which shot, and how it is traced."""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from irt_usd.aovs import AOVS, aov
from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.memory import free_memory

MAX_SIDE = 65536
"""Pixels; wider images are taken for slips of the keyboard."""

_FILM_COPIES = 7
"""The film and its double, two frames that wait, one being encoded, its interleaved copy and its
file."""

AOV_NAMES = tuple(AOVS)


@dataclass(frozen=True)
class ShotOptions:
    """Which frames of which stage, through which camera; None asks the stage.

    `session_layer`, `mask`, `asset_path` and `missing_asset` are as in OpenOptions, the others (of
    `texture_memory` the bytes) as in ReadOptions.
    """

    stage: str
    camera: str | None = None
    frames: str | None = None
    size: tuple[int, int] | None = None
    camera_light: bool = True
    require_locked: bool = False
    purposes: tuple[str, ...] | None = None
    session_layer: str | None = None
    mask: tuple[str, ...] = ()
    asset_path: tuple[str, ...] = ()
    missing_asset: MissingAsset = "fail"
    texture_memory: int | None = None
    complexity: str = "low"
    """A key of COMPLEXITY."""
    settings: str | None = None
    data_window: tuple[float, float, float, float] | None = None
    lock_camera: Decimal | None = None
    dome_samples: int = 32
    render_pass: str | None = None
    aovs: tuple[str, ...] = ()
    """Those asked for: some need more of the stage than its picture does."""


@dataclass(frozen=True)
class TraceSettings:
    """How frames are traced. All but `threads` reaches pixels; `threads` 0 is all of them."""

    samples: int = 1
    max_depth: int = 8
    throughput_cutoff: float = 0.0009765625
    mirror_roughness: float = 0.1
    aovs: tuple[str, ...] | None = None
    """None: those that the render settings' products ask for."""
    layers: tuple[tuple[str, str], ...] = ()
    """AOVs, and the names of their EXR layers, where they have names of their own."""
    isa: str = "avx2"
    threads: int = 0


def _channels(name: str) -> int:
    """Of an AOV, at most."""
    wanted = aov(name)
    return 12 if wanted.kind == "cryptomatte" else max(1, len(wanted.letters))


def check_film_size(size: tuple[int, int], aovs: Sequence[str]) -> None:
    """Raises InputError for sizes that no film can have, or this machine's memory cannot hold."""
    width, height = size
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise InputError(
            f"--size {width}x{height}: each side must be 1 to {MAX_SIDE} pixels; write 960x540"
        )
    pixel_bytes = 4 * (4 + sum(map(_channels, aovs))) * _FILM_COPIES
    needed = width * height * pixel_bytes
    free = free_memory()
    if needed > free:
        shrink = (free / needed) ** 0.5
        raise InputError(
            f"--size {width}x{height}: the film needs {needed / 2**30:.1f} GiB and"
            f" {free / 2**30:.1f} GiB of memory are free; at most about"
            f" {int(width * shrink)}x{int(height * shrink)} fits"
        )
