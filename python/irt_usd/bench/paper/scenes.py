# SPDX-License-Identifier: Apache-2.0
"""The paper's scenes and edits as the core's records, all made before anything is timed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from irt_usd import _core
from irt_usd.changes import diff
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions
from irt_usd.stage import Snapshot

BASE = 1
"""The frame that every edit starts from."""

EDITS = {"move_1": 2, "move_2": 4, "resize": 6, "light": 8, "color": 10}
"""Frames of the edits of tables 1 and 2."""

MOVED_LIGHTS = {1: 6, 2: 4, 3: 2}
"""Frames of table 3, by lights moved."""

VARIANTS = {
    "chess": ("chess.usda", False),
    "chess_shadows": ("chess.usda", True),
    "spheres": ("spheres.usda", False),
    "spheres_shadows": ("spheres.usda", True),
}
"""Stage, and whether its lights cast shadows."""

LIGHTS_STAGE = "chess_3_lights.usda"


@dataclass(frozen=True)
class Edit:
    """From the base frame to `frame`, and back."""

    frame: int
    change: _core.ChangeSet
    undo: _core.ChangeSet


@dataclass(frozen=True)
class PaperScene:
    """A stage at its base frame, and its edits by name."""

    name: str
    shot: Shot
    shadows: bool
    base: Snapshot
    initial: _core.ChangeSet
    edits: Mapping[str, Edit]

    def read(self, frame: int) -> Snapshot:
        """The stage at `frame`; with lights that cast no shadows where the variant has none."""
        snapshot = self.shot.reader.read(float(frame))
        return snapshot if self.shadows else without_shadows(snapshot)

    @property
    def pixels(self) -> int:
        """Of the image."""
        width, height = self.shot.size
        return width * height

    def renderer(self, *, history: bool = True, threads: int = 0, depth: int = 8) -> _core.Renderer:
        """A new one, without a scene yet. No cost model: an edit is an update, or fails to be."""
        return _core.Renderer(
            self.base.camera.core(),
            _core.ViewSettings(*self.shot.size, max_depth=depth),
            render_origin=self.shot.render_origin,
            threads=threads,
            history=history,
            cost_model=False,
        )

    def trace_bench(self) -> _core.TraceBench:
        """Of the base frame."""
        return _core.TraceBench(
            self.initial,
            self.base.camera.core(),
            _core.ViewSettings(*self.shot.size),
            render_origin=self.shot.render_origin,
        )


def load_variant(name: str, folder: Path, size: tuple[int, int]) -> PaperScene:
    """Reads one of VARIANTS. Raises InputError if its stage is not there."""
    file, shadows = VARIANTS[name]
    return _load(name, folder / file, size, shadows, EDITS)


def load_lights(folder: Path, size: tuple[int, int]) -> PaperScene:
    """Reads table 3's scene; its edits are named "1", "2" and "3". Raises InputError."""
    frames = {str(moved): frame for moved, frame in MOVED_LIGHTS.items()}
    return _load("chess_3_lights", folder / LIGHTS_STAGE, size, True, frames)


def without_shadows(snapshot: Snapshot) -> Snapshot:
    """The same with UsdLux's inputs:shadow:enable false on every light."""
    off = {"inputs:shadow:enable": False}
    lights = {
        path: replace(light, attributes={**light.attributes, **off}, casts_shadows=False)
        for path, light in snapshot.lights.items()
    }
    return replace(snapshot, lights=lights)


def _load(
    name: str, path: Path, size: tuple[int, int], shadows: bool, frames: Mapping[str, int]
) -> PaperScene:
    if not path.is_file():
        raise InputError(
            f"{path}: no such file; run in the source folder of irt, or give the folder"
            f" that `python -m shots.paper.make_paper FOLDER` wrote with --scenes"
        )
    shot = open_shot(ShotOptions(str(path), size=size), Report())
    base = shot.reader.read(float(BASE))
    if not shadows:
        base = without_shadows(base)
    edits: dict[str, Edit] = {}
    scene = PaperScene(name, shot, shadows, base, diff(None, base).core, edits)
    for edit, frame in frames.items():
        after = scene.read(frame)
        edits[edit] = Edit(frame, diff(base, after).core, diff(after, base).core)
    return scene
