# SPDX-License-Identifier: Apache-2.0
"""Frames of a shot into films: read, diff, update."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core, interrupt
from irt_usd.aovs import MOTION, aov, beauty_parts, sources
from irt_usd.changes import ChangeList, diff, whole_changes
from irt_usd.errors import InputError, MachineError
from irt_usd.images.aovs import Plane, derived, exposed
from irt_usd.images.cryptomatte import manifest
from irt_usd.images.exr import Film
from irt_usd.shot.foresight import foresee
from irt_usd.shot.frames import Frame, format_frame
from irt_usd.shot.products import view_aovs, view_layers
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage import ShotReader, Snapshot

if TYPE_CHECKING:
    from irt_usd.checkpoint.container import Container

History = Literal["shot", "any", "none"]
"""What histories are kept for: the changes that the shot itself makes, any change, or none."""

_SHADOW = "the shadow of something transparent"


@dataclass(frozen=True)
class TracedFrame:
    """What a frame took: its change list, Renderer.update's statistics, seconds by phase.

    Both are of the first view; `updates` are the statistics of all.
    """

    frame: Frame
    snapshot: Snapshot
    changes: ChangeList
    update: Mapping[str, Any]
    seconds: dict[str, float]

    @property
    def updates(self) -> list[Mapping[str, Any]]:
        """Statistics by view."""
        return [self.update, *self.update["more_views"]]

    def unchanged(self, view: int) -> bool:
        """Whether the view's film is the one of the frame before."""
        same_picture = not (self.changes.cameras[view] or any(self.changes.exposures))
        return self.changes.core.empty and same_picture and not self.changes.initial


class ShotTracer:
    """Traces a shot's frames in the order asked for.

    One renderer is kept over the shot and told what changed. With history "shot" it keeps what the
    changes in `frames`, the only ones that will be asked for, in that order, can reach; with "any"
    everything. With "none" every frame is a full trace by a new one. `cells`: those that are
    rendered, None: all.
    """

    def __init__(
        self,
        shot: Shot,
        settings: TraceSettings,
        frames: Sequence[Frame],
        history: History = "shot",
        cells: Sequence[int] | None = None,
    ) -> None:
        self._shot = shot
        self._settings = settings
        self._frames = frames
        self._history = history
        self._cells = cells
        self._renderer: _core.Renderer | None = None
        self._previous: Snapshot | None = None
        self._ages: dict[int, NDArray[np.float32]] = {}
        self._retaking = False
        self.foreign = False
        """Whether the history is kept for another version's changes."""
        self._neighbours: ShotReader | None = None
        self._changes: ChangeList | None = None
        self._restarts: list[str] = []

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
        previous = self._previous if self._history != "none" else None
        changes = diff(previous, snapshot)
        compared = time.perf_counter()
        update = self._update(frame, snapshot, changes, previous, on_progress)
        for view in range(len(self._shot.views)):
            if "irt.age" in self.aovs(view):
                self._ages[view] = self._age(view)
        self._previous, self._changes = snapshot, changes
        everything = "the first frame" if previous is None else ""
        self._restarts = [
            everything
            or (changes.cause(snapshot.cameras[v].path) if changes.cameras[v] else "")
            or str(u["restart"] or "")
            for v, u in enumerate((update, *update["more_views"]))
        ]
        seconds = {
            "usd": read - start,
            "diff": compared - read,
            **update["seconds"],
            "total": time.perf_counter() - start,
        }
        return TracedFrame(frame, snapshot, changes, update, seconds)

    def film(self, view: int = 0) -> Film:
        """A copy of a view's film as the last update left it, exposed as its camera is."""
        if self._previous is None:
            raise ValueError("no frame has been traced")
        camera = self._previous.cameras[view]
        framing = self._shot.views[view].framing

        def plane(name: str) -> Plane:
            return self.renderer.aov(name, view)

        aovs: dict[str, Plane] = {}
        causes: Sequence[str] = ()
        for name in self.aovs(view):
            if name == "irt.age":
                aovs[name] = self._ages[view]
            elif name == "irt.cause":
                aovs[name], causes = self._causes(view)
            elif name in MOTION:
                aovs[name] = self._motion(view, MOTION[name])
            else:
                aovs[name] = derived(name, plane, camera.world_from_camera, camera.exposure)
        beauty = exposed(self.renderer.beauty(view), camera.exposure)
        layers = view_layers(self._shot.views[view], self._settings)
        manifests = {
            name: manifest(plane(name).view(np.uint32), partial(self.renderer.names, name))
            for name in aovs
            if aov(name).kind == "cryptomatte"
        }
        return Film(beauty.copy(), aovs, framing.start, framing.frame, layers, manifests, causes)

    def _motion(self, view: int, step: int) -> NDArray[np.float32]:
        """How far each pixel's point is elsewhere `step` frames from here, in pixels."""
        if self._neighbours is None:
            self._neighbours = self._shot.reread()
        assert self._previous is not None
        time = self._previous.time
        here = self._neighbours.read(time)
        try:
            there = self._neighbours.read(time + step)
        except InputError as error:
            self._shot.report.mentioned(
                f"no motion is known: the frame beside cannot be read: {error}", f"{time + step:g}"
            )
            there = here
        changes = diff(here, there)
        camera = there.cameras[view].core() if changes.cameras[view] else None
        return self.renderer.motion(changes.moved, camera, view)

    def _causes(self, view: int) -> tuple[NDArray[np.float32], Sequence[str]]:
        """By pixel 0 or the number, from 1, of what changed it, and what the numbers stand for."""
        codes = self.renderer.aov("irt.cause", view)
        named = {int(code): self._cause(int(code), view) for code in np.unique(codes) if code != 0}
        texts = sorted(set(named.values()))
        numbers = np.zeros(codes.shape, np.float32)
        for code, text in named.items():
            numbers[codes == code] = texts.index(text) + 1
        return numbers, texts

    def _cause(self, code: int, view: int) -> str:
        name = self.renderer.cause_name(code)
        if name:
            return self._changes.cause(name) if self._changes is not None else name
        return self._restarts[view] or _SHADOW

    @property
    def scene(self) -> Snapshot:
        """The scene of the last frame."""
        if self._previous is None:
            raise ValueError("no frame has been traced")
        return self._previous

    def save(self, arrays: _core.ArrayWriter) -> Snapshot:
        """Adds to `arrays` what `restore` needs; the result is the scene it goes with."""
        if self._history != "none":
            self.renderer.save(arrays)
            for view, age in self._ages.items():
                arrays.add(f"age{view}", age)
        return self.scene

    def restore(self, frame: Frame, container: "Container") -> Snapshot:
        """Goes on as the tracer that was saved after `frame`; the result is that frame's scene.

        Raises RuntimeError where the arrays are of another scene; then nothing is restored.
        """
        snapshot = self._shot.reader.read(float(frame))
        if self._history == "none":
            return snapshot
        renderer = self._new_renderer(snapshot, self._foresee())
        renderer.restore(diff(None, snapshot).core, container.file, container.places())
        self._renderer, self._previous = renderer, snapshot
        for view in range(len(self._shot.views)):
            if "irt.age" in self.aovs(view):
                shape = renderer.aov("irt.retraced", view).shape
                self._ages[view] = container.array(f"age{view}").reshape(shape)
        return snapshot

    def retake(
        self, snapshot: Snapshot, container: "Container", foreseen: _core.Foreseen | None
    ) -> None:
        """Starts from `snapshot`, a scene of another version, and the history it was saved with.

        `foreseen`: what that history was kept for. Raises RuntimeError as `restore` does.
        """
        renderer = self._new_renderer(snapshot, foreseen)
        renderer.restore(diff(None, snapshot).core, container.file, container.places())
        self._renderer, self._previous, self._retaking = renderer, snapshot, True
        self.foreign = foreseen is not None

    def forget(self) -> None:
        """The next frame is the first."""
        self._renderer = self._previous = None
        self._ages.clear()

    def aovs(self, view: int) -> tuple[str, ...]:
        """Names of a view's AOVs."""
        return view_aovs(self._shot.views[view], self._settings)

    def _age(self, view: int) -> NDArray[np.float32]:
        """Frames since a ray of each pixel was retraced."""
        fresh = self.renderer.aov("irt.retraced", view) > 0
        before = self._ages.get(view)
        if before is None or self._history == "none":
            return np.zeros(fresh.shape, dtype=np.float32)
        return np.where(fresh, np.float32(0), before + np.float32(1))

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
        previous: Snapshot | None,
        on_progress: Callable[[float], None] | None,
    ) -> dict[str, Any]:
        first = previous is None
        core = changes.core
        if previous is not None and self._retaking:
            core = whole_changes(previous, snapshot)
            self._retaking = False

        def progress(part: float) -> None:
            interrupt.check()
            if on_progress is not None:
                on_progress(part)

        try:
            if first:
                self._renderer = self._new_renderer(snapshot, self._foresee())
            told = [
                (
                    camera.core() if moved and not first else None,
                    self._history != "none" and self._next_can_use_history(frame, view),
                )
                for view, (camera, moved) in enumerate(
                    zip(snapshot.cameras, changes.cameras, strict=True)
                )
            ]
            (moved_to, keep), *more = told
            return self.renderer.update(
                core, moved_to, progress, keep_history=keep, more_views=more
            )
        except ValueError as error:
            raise InputError(
                f"{self._shot.options.stage}: frame {format_frame(frame)} cannot be rendered:"
                f" {error}"
            ) from error
        except MemoryError as error:
            raise MachineError(
                f"out of memory at frame {format_frame(frame)}; try a smaller --size"
            ) from error

    def _foresee(self) -> _core.Foreseen | None:
        return foresee(self._shot, self._frames) if self._history == "shot" else None

    def _new_renderer(self, snapshot: Snapshot, foreseen: _core.Foreseen | None) -> _core.Renderer:
        views = range(len(self._shot.views))
        renderer = _core.Renderer(
            snapshot.camera.core(),
            self._view_settings(0),
            render_origin=self._shot.render_origin,
            isa=self._settings.isa,
            threads=self._settings.threads,
            history=self._history != "none",
            foreseen=foreseen,
            cell_order=self._cells,
        )
        for view in views[1:]:
            renderer.add_view(snapshot.cameras[view].core(), self._view_settings(view))
        return renderer

    def _view_settings(self, view: int) -> _core.ViewSettings:
        settings, framing = self._settings, self._shot.views[view].framing
        return _core.ViewSettings(
            *framing.size,
            samples=settings.samples,
            max_depth=settings.max_depth,
            throughput_cutoff=settings.throughput_cutoff,
            mirror_roughness=settings.mirror_roughness,
            aovs=sources(self.aovs(view)),
            start=framing.start,
            frame=framing.frame,
            parts=beauty_parts(self.aovs(view)),
        )

    def _next_can_use_history(self, frame: Frame, view: int) -> bool:
        """Whether there is a next frame, and the view's camera rests until then."""
        index = self._frames.index(frame) + 1
        if index == len(self._frames):
            return self._history == "any"
        all_frames = self._shot.frames
        first, last = all_frames.index(frame) + 1, all_frames.index(self._frames[index]) + 1
        return not any(f in self._shot.camera_moves[view] for f in all_frames[first:last])
