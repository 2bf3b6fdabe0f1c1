# SPDX-License-Identifier: Apache-2.0
"""Frames of a shot into films: read, diff, update."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from irt_usd import _core, interrupt
from irt_usd.changes import ChangeList, diff
from irt_usd.errors import InputError, MachineError
from irt_usd.images.exr import Film
from irt_usd.shot.foresight import foresee
from irt_usd.shot.frames import Frame, format_frame
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage import Snapshot

History = Literal["full", "none"]


@dataclass(frozen=True)
class TracedFrame:
    """What a frame took: its change list, Renderer.update's statistics, seconds by phase."""

    frame: Frame
    snapshot: Snapshot
    changes: ChangeList
    update: Mapping[str, Any]
    seconds: dict[str, float]

    @property
    def unchanged(self) -> bool:
        """Whether the film is the one of the frame before."""
        return self.changes.core.empty and not self.changes.camera


class ShotTracer:
    """Traces a shot's frames in the order asked for.

    With history "full" one renderer is kept over the shot and told what changed, in `frames`, the
    only ones that will be asked for, in that order; with "none" every frame is a full trace by a
    new one.
    """

    def __init__(
        self,
        shot: Shot,
        settings: TraceSettings,
        frames: Sequence[Frame],
        history: History = "full",
    ) -> None:
        self._shot = shot
        self._settings = settings
        self._frames = frames
        self._history = history
        self._renderer: _core.Renderer | None = None
        self._previous: Snapshot | None = None

    def trace(
        self, frame: Frame, on_progress: Callable[[float], None] | None = None
    ) -> TracedFrame:
        """Brings the film to `frame`; a safe point for interruptions before and while it traces.

        Raises InputError for what cannot be read or rendered.
        """
        interrupt.check()
        start = time.perf_counter()
        snapshot = self._shot.reader.read(float(frame))
        self._shot.report.enforce(self._consequence(frame))
        read = time.perf_counter()
        previous = self._previous if self._history == "full" else None
        changes = diff(previous, snapshot)
        compared = time.perf_counter()
        update = self._update(frame, snapshot, changes, previous is None, on_progress)
        self._previous = snapshot
        seconds = {
            "usd": read - start,
            "diff": compared - read,
            **update["seconds"],
            "total": time.perf_counter() - start,
        }
        return TracedFrame(frame, snapshot, changes, update, seconds)

    def film(self) -> Film:
        """A copy of the film as the last update left it."""
        renderer = self.renderer
        aovs = {name: renderer.aov(name).copy() for name in self._settings.aovs}
        return Film(renderer.beauty().copy(), aovs)

    def _consequence(self, frame: Frame) -> str:
        """Of a frame that strictness refuses."""
        name = f"frame {format_frame(frame)} cannot be rendered whole"
        if self._previous is None:
            return f"{name}; nothing was rendered"
        return f"{name}: it and those after it were not rendered, those before it stay"

    @property
    def renderer(self) -> _core.Renderer:
        """The renderer of the last frame."""
        if self._renderer is None:
            raise ValueError("no frame has been traced")
        return self._renderer

    def _update(
        self,
        frame: Frame,
        snapshot: Snapshot,
        changes: ChangeList,
        first: bool,
        on_progress: Callable[[float], None] | None,
    ) -> dict[str, Any]:
        def progress(part: float) -> None:
            interrupt.check()
            if on_progress is not None:
                on_progress(part)

        try:
            camera = snapshot.camera.core()
            if first:
                self._renderer = self._new_renderer(camera)
            moved = camera if changes.camera and not first else None
            keep = self._history == "full" and self._next_can_use_history(frame)
            return self.renderer.update(changes.core, moved, progress, keep_history=keep)
        except ValueError as error:
            raise InputError(
                f"{self._shot.options.stage}: frame {format_frame(frame)} cannot be rendered:"
                f" {error}"
            ) from error
        except MemoryError as error:
            raise MachineError(
                f"out of memory at frame {format_frame(frame)}; try a smaller --size"
            ) from error

    def _new_renderer(self, camera: _core.Camera) -> _core.Renderer:
        settings = self._settings
        width, height = self._shot.size
        view = _core.ViewSettings(
            width,
            height,
            samples=settings.samples,
            max_depth=settings.max_depth,
            throughput_cutoff=settings.throughput_cutoff,
            mirror_roughness=settings.mirror_roughness,
            aovs=settings.aovs,
        )
        return _core.Renderer(
            camera,
            view,
            render_origin=self._shot.render_origin,
            isa=settings.isa,
            threads=settings.threads,
            history=self._history == "full",
            foreseen=foresee(self._shot, self._frames) if self._history == "full" else None,
        )

    def _next_can_use_history(self, frame: Frame) -> bool:
        """Whether there is a next frame, and the camera rests until then."""
        index = self._frames.index(frame) + 1
        if index == len(self._frames):
            return False
        all_frames = self._shot.frames
        first, last = all_frames.index(frame) + 1, all_frames.index(self._frames[index]) + 1
        return not any(f in self._shot.camera_moves for f in all_frames[first:last])
