# SPDX-License-Identifier: Apache-2.0
"""Times of tables 1, 3 and 4. What is compared is measured in turns."""

import statistics
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from irt_usd import _core, interrupt
from irt_usd.bench.paper.scenes import PaperScene
from irt_usd.bench.timing import Spread, ratios
from irt_usd.changes import diff
from irt_usd.errors import MachineError
from irt_usd.images.exr import Film, write_exr

CELLS = 64


@dataclass
class EditTimes:
    """Seconds of one edit, round by round: apply, BVH, detect, trace and film, by the clock.

    `ours_processor` and `full_processor`: processor seconds of all threads for the whole call, its
    thread and statistics included, which weighs on short updates; other work on the machine hardly
    shows in them.

    `files`: what a whole frame takes besides, be it an update or a full trace: reading the stage,
    comparing, copying the film, writing the EXR.
    """

    ours: list[float] = field(default_factory=list)
    full: list[float] = field(default_factory=list)
    undo_ours: list[float] = field(default_factory=list)
    undo_full: list[float] = field(default_factory=list)
    ours_processor: list[float] = field(default_factory=list)
    full_processor: list[float] = field(default_factory=list)
    files: list[float] = field(default_factory=list)
    cell_seconds: list[list[float]] = field(default_factory=list)

    @property
    def seconds(self) -> float:
        """Median of the update."""
        return statistics.median(self.ours)

    @property
    def ratio(self) -> Spread:
        """Full trace over update."""
        return ratios(self.full, self.ours)

    @property
    def undo_ratio(self) -> Spread:
        """The same of the edit that leads back."""
        return ratios(self.undo_full, self.undo_ours)

    @property
    def processor_ratio(self) -> Spread:
        """Full trace over update, in processor seconds."""
        return ratios(self.full_processor, self.ours_processor)

    @property
    def whole_frame_ratio(self) -> Spread:
        """Full trace over update, each with the frame's files."""
        return ratios(
            [a + b for a, b in zip(self.full, self.files, strict=True)],
            [a + b for a, b in zip(self.ours, self.files, strict=True)],
        )


@dataclass(frozen=True)
class SceneTimes:
    """Of one scene; `empty` are updates that change nothing."""

    edits: Mapping[str, EditTimes]
    empty: list[float]

    @property
    def full_seconds(self) -> float:
        """Median of all full traces."""
        traces = [s for edit in self.edits.values() for s in edit.full + edit.undo_full]
        return statistics.median(traces)


def time_edits(scene: PaperScene, repeats: int) -> SceneTimes:
    """Edits and undoings, by one renderer that keeps a history and one that keeps none.

    Both live through all rounds, as in a session; the one without keeps the trees of unchanged
    objects, but no rays. A round that is not counted warms both up, and their films are compared.
    """
    kept, bare = scene.renderer(), scene.renderer(history=False)
    for renderer in (kept, bare):
        renderer.update(scene.initial)
    nothing = _core.ChangeSet()
    empty: list[float] = []
    times = {name: EditTimes() for name in scene.edits}
    with tempfile.TemporaryDirectory(prefix="irt-bench-") as folder:
        for turn in range(repeats + 1):
            warm = turn == 0
            for name, edit in scene.edits.items():
                entry = EditTimes() if warm else times[name]
                ours, full = _in_turns(kept, bare, edit.change, turn)
                if warm:
                    _compare(kept, bare, f"{scene.name}, {name}")
                entry.ours.append(ours.seconds)
                entry.full.append(full.seconds)
                entry.ours_processor.append(ours.processor)
                entry.full_processor.append(full.processor)
                entry.cell_seconds.append(ours.cells)
                entry.files.append(_frame_files(scene, edit.frame, kept, Path(folder)))
                ours, full = _in_turns(kept, bare, edit.undo, turn)
                entry.undo_ours.append(ours.seconds)
                entry.undo_full.append(full.seconds)
            empty.append(_update(kept, nothing).seconds)
    return SceneTimes(times, empty)


@dataclass(frozen=True)
class InitialTimes:
    """Seconds, and processor seconds, of an initial step and of a full trace without a history."""

    recorded: float
    traced: float
    recorded_processor: float
    traced_processor: float


def overhead(recorded: Sequence[float], traced: Sequence[float]) -> float:
    """Of recording, medians over medians; 0: none."""
    return statistics.median(recorded) / statistics.median(traced) - 1


def time_initial(scene: PaperScene, turn: int) -> InitialTimes:
    """Both from a new scene by a new renderer, in an order that `turn` changes."""
    times = {}
    for history in (True, False) if turn % 2 else (False, True):
        times[history] = _update(scene.renderer(history=history), scene.initial)
    recorded, traced = times[True], times[False]
    return InitialTimes(recorded.seconds, traced.seconds, recorded.processor, traced.processor)


def time_initial_cells(scene: PaperScene) -> list[float]:
    """Seconds by the clock of each cell's initial step, every cell a task of its own.

    Cells are otherwise recorded several together, a group a thread; asking for as many threads as
    cells makes as many tasks, which run on the threads the machine has.
    """
    return _update(scene.renderer(threads=CELLS), scene.initial).cells


def spread(values: Sequence[float]) -> float:
    """(max - min) / max, as in the paper's table 4."""
    return (max(values) - min(values)) / max(values) if max(values) > 0 else 0.0


def medians(rounds: Sequence[Sequence[float]]) -> list[float]:
    """Cell by cell."""
    return [statistics.median(values) for values in zip(*rounds, strict=True)]


@dataclass(frozen=True)
class _Update:
    """Seconds of one update: by the clock, of all processors, and by the clock in each cell."""

    seconds: float
    processor: float
    cells: list[float]


def _update(renderer: _core.Renderer, changes: _core.ChangeSet) -> _Update:
    interrupt.check()
    start = time.process_time()
    update = renderer.update(changes)
    processor = time.process_time() - start
    return _Update(update["seconds"]["total"], processor, update["cells"]["seconds"])


def _in_turns(
    kept: _core.Renderer, bare: _core.Renderer, changes: _core.ChangeSet, turn: int
) -> tuple[_Update, _Update]:
    if turn % 2:
        full = _update(bare, changes)
        return _update(kept, changes), full
    ours = _update(kept, changes)
    return ours, _update(bare, changes)


def _compare(kept: _core.Renderer, bare: _core.Renderer, what: str) -> None:
    if not np.array_equal(kept.beauty().view(np.uint32), bare.beauty().view(np.uint32)):
        raise MachineError(f"{what}: the update's film is not the full trace's")


def _frame_files(scene: PaperScene, frame: int, renderer: _core.Renderer, folder: Path) -> float:
    start = time.perf_counter()
    diff(scene.base, scene.read(frame)).core  # noqa: B018 - builds the change set
    write_exr(folder / "frame.exr", Film(renderer.beauty().copy(), {}), {})
    return time.perf_counter() - start
