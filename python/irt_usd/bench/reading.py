# SPDX-License-Identifier: Apache-2.0
"""How long it takes to open a stage, and to find what changes from frame to frame."""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from irt_usd.bench.timing import Spread
from irt_usd.changes import diff
from irt_usd.report import Report
from irt_usd.shot.session import open_shot, opening, shot_of
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer
from irt_usd.stage import open_stage

_PHASES = (
    "USD opens the stage",
    "OpenImageIO decodes textures",
    "irt reads it",
    "the core builds its trees",
)

_FRAMES = 60
"""Of the shot in which prims move."""

_GROUP = 100
"""Prims that share a parent."""


@dataclass(frozen=True)
class Opening:
    """Seconds until the first ray of a stage could be traced, by phase."""

    stage: str
    phases: dict[str, Spread]
    total: Spread
    own: Spread
    """Without what USD and OpenImageIO take."""

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        phases = {name: vars(spread) for name, spread in self.phases.items()}
        return {
            "stage": self.stage,
            "seconds": phases,
            "total": vars(self.total),
            "own": vars(self.own),
        }

    def rows(self) -> Iterator[tuple[str, Spread]]:
        """Names and times, in the order of a table."""
        yield from self.phases.items()
        yield "all of it", self.total
        yield "of which irt's own", self.own


def measure_opening(options: ShotOptions, repeats: int, say: Callable[[str], None]) -> Opening:
    """Opens the stage of `options` `repeats` times after a first that warms the file cache.

    The ray itself is not traced, but a film of 8x8 pixels, so that all is there that rays need.
    """
    rounds = []
    for turn in range(repeats + 1):
        say(f"{options.stage}: round {turn} of {repeats}" if turn else f"{options.stage}: warming")
        rounds.append(_open_once(options))
    rounds.pop(0)
    phases = {
        name: Spread.of([times[index] for times in rounds]) for index, name in enumerate(_PHASES)
    }
    total = Spread.of([sum(times) for times in rounds])
    return Opening(options.stage, phases, total, Spread.of([sum(t[2:]) for t in rounds]))


def _open_once(options: ShotOptions) -> tuple[float, ...]:
    start = perf_counter()
    stage = open_stage(options.stage, opening(options))
    opened = perf_counter()
    shot = shot_of(stage, replace(options, size=(8, 8)), Report())
    frame = shot.frames[0]
    materials = shot.reader.read(float(frame)).materials.values()
    read = perf_counter()
    shot.reader.textures.load({t for state in materials for t in state.surface.textures})
    decoded = perf_counter()
    traced = ShotTracer(shot, TraceSettings(), (frame,), "none").trace(frame)
    done = perf_counter()
    update = traced.update["seconds"]
    built = update["apply"] + update["bvh"]
    own = read - opened + done - decoded - update["total"]
    return opened - start, decoded - read, own, built


@dataclass(frozen=True)
class Finding:
    """Milliseconds to find the change set of a frame."""

    prims: int
    moving: int
    frames: int
    milliseconds: Spread

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        return {**vars(self), "milliseconds": vars(self.milliseconds)}


def measure_changes(prims: int, moving: int) -> Finding:
    """Reads a shot of `prims` meshes of which `moving` move in every frame, and compares."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.usda"
        path.write_text(shot_text(prims, moving), encoding="utf-8")
        shot = open_shot(ShotOptions(str(path)), Report())
        previous = shot.reader.read(float(shot.frames[0]))
        times = []
        for frame in shot.frames[1:]:
            start = perf_counter()
            snapshot = shot.reader.read(float(frame))
            diff(previous, snapshot).core  # noqa: B018 (made when first asked for)
            times.append(1000 * (perf_counter() - start))
            previous = snapshot
    return Finding(prims, moving, len(times), Spread.of(times))


def shot_text(prims: int, moving: int) -> str:
    """A stage of `prims` meshes in groups, of which every (prims / moving)th slides."""
    head = (
        f"#usda 1.0\n(\n startTimeCode = 1\n endTimeCode = {_FRAMES}\n)\n"
        'def Camera "camera"\n{\n double3 xformOp:translate = (50, 50, 300)\n'
        ' uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    )
    parts = [head]
    slides = {index * prims // moving for index in range(moving)}
    for index in range(prims):
        if index % _GROUP == 0:
            parts.append(f'def Xform "Group_{index // _GROUP}"\n{{\n')
        x, y = index % _GROUP, index // _GROUP
        place = f" = ({x}, {y}, 0)"
        if index in slides:
            place = f".timeSamples = {{ 1: ({x}, {y}, 0), {_FRAMES}: ({x}, {y}, 9) }}"
        parts.append(_mesh_text(f"Mesh_{index}", place))
        if index % _GROUP == _GROUP - 1 or index == prims - 1:
            parts.append("}\n")
    return "".join(parts)


def _mesh_text(name: str, place: str) -> str:
    return (
        f'def Mesh "{name}"\n{{\n uniform token subdivisionScheme = "none"\n'
        " point3f[] points = [(0, 0, 0), (0.8, 0, 0), (0.8, 0.8, 0), (0, 0.8, 0)]\n"
        " int[] faceVertexCounts = [4]\n int[] faceVertexIndices = [0, 1, 2, 3]\n"
        " color3f[] primvars:displayColor = [(0.2, 0.5, 0.8)]\n"
        f" double3 xformOp:translate{place}\n"
        ' uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    )
