# SPDX-License-Identifier: Apache-2.0
"""The same direct-light image by Mitsuba 3: a primary and a shadow ray a path, Lambert, one light.

Ours shades with all of UsdPreviewSurface, at roughness 1 and ior 1, which leaves Lambert but for
Schlick's (1 - cos)^5: under 0.3 % for light less than 90 degrees from the view.
"""

import importlib.util
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core
from irt_usd.bench.scenes import BenchScene
from irt_usd.bench.timing import Figure, Spread, interleave, ratios
from irt_usd.errors import InputError
from irt_usd.stage.mesh import MeshShape

VARIANTS: dict[str, tuple[float | None, float | None]] = {
    "scalar_rgb": (2.0, None),
    "llvm_ad_rgb": (None, 1.0),
}
"""Floor and aim of our paths a second over each variant's."""

SAMPLES = 4
REFLECTANCE = (0.6, 0.5, 0.4)

_BLOCK = 8
"""Pixels a side over which images are averaged before they are compared: the samplers differ."""


@dataclass(frozen=True)
class PeerResult:
    """Paths a second of ours and of Mitsuba's variants, on the same threads, by the clock.

    `differences`: mean over blocks of 8 by 8 pixels of |ours - theirs|, over the mean of theirs.
    `absent`: variants that could not run, and why.
    """

    scene: str
    size: tuple[int, int]
    samples: int
    threads: int
    version: str | None
    seconds: dict[str, Spread]
    paths_per_second: dict[str, float]
    differences: dict[str, float]
    figures: tuple[Figure, ...]
    absent: dict[str, str]

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        fields = asdict(self)
        fields["figures"] = [figure.to_json() for figure in self.figures]
        return fields


@dataclass(frozen=True)
class DirectScene:
    """Triangle meshes under one point light, for ours and for a peer."""

    scene: BenchScene
    points: list[NDArray[np.float32]]
    """World space, (n, 3), a mesh each."""
    triangles: list[NDArray[np.int32]]
    """(m, 3), counter-clockwise from outside."""
    light_position: tuple[float, float, float]
    light_intensity: tuple[float, float, float]

    @classmethod
    def of(cls, scene: BenchScene) -> "DirectScene":
        """The meshes of `scene` under its first point light. Raises InputError without one."""
        light = next((x for x in scene.snapshot.lights.values() if x.kind == "point"), None)
        if light is None:
            raise InputError(f"{scene.shot.options.stage}: no sphere light to compare under")
        points, triangles = [], []
        for state in scene.snapshot.objects.values():
            if isinstance(state.shape, MeshShape):
                local = np.asarray(state.shape.attributes["points"], dtype=np.float64)
                world = state.world_from_object
                points.append((local @ world[:3, :3] + world[3, :3]).astype(np.float32))
                triangles.append(fans(state.shape))
        return cls(scene, points, triangles, light.aim, light.energy)

    def bench(self) -> _core.TraceBench:
        """Ours."""
        changes = _core.ChangeSet()
        matt = _core.Material(diffuse_color=REFLECTANCE, roughness=1.0, ior=1.0)
        changes.set_material("/matt", matt)
        changes.set_light("/light", _core.Light.point(self.light_position, self.light_intensity))
        for i, (points, triangles) in enumerate(zip(self.points, self.triangles, strict=True)):
            mesh = _core.Mesh(points, np.full(len(triangles), 3, np.int32), triangles.ravel())
            changes.set_object(f"/mesh_{i}", mesh, np.eye(4), "/matt")
        settings = _core.ViewSettings(*self.scene.shot.size, samples=SAMPLES, max_depth=0)
        origin = self.scene.shot.render_origin
        return _core.TraceBench(changes, self.scene.camera, settings, render_origin=origin)

    def save(self, path: Path, threads: int) -> None:
        """Writes what the worker reads."""
        camera = self.scene.snapshot.camera
        left, right, bottom, top = camera.window
        if camera.orthographic or (left, bottom) != (-right, -top):
            raise InputError(
                f"{self.scene.shot.options.stage}: the comparison needs a perspective camera"
                " without aperture offsets"
            )
        settings = {
            "size": self.scene.shot.size,
            "samples": SAMPLES,
            "threads": threads,
            "meshes": len(self.points),
            "world_from_camera": camera.world_from_camera.tolist(),
            "fov_degrees": 2 * math.degrees(math.atan(right)),
            "light_position": self.light_position,
            "light_intensity": self.light_intensity,
            "reflectance": REFLECTANCE,
        }
        arrays: dict[str, Any] = {"settings": np.array(json.dumps(settings))}
        for i, (points, triangles) in enumerate(zip(self.points, self.triangles, strict=True)):
            arrays[f"points_{i}"] = points
            arrays[f"triangles_{i}"] = triangles.astype(np.uint32)
        np.savez(path, **arrays)


def fans(shape: MeshShape) -> NDArray[np.int32]:
    """A mesh's triangles as the core cuts them: fans from each face's first vertex; (m, 3)."""
    counts = np.asarray(shape.attributes["faceVertexCounts"])
    indices = np.asarray(shape.attributes["faceVertexIndices"])
    sizes = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, sizes)
    step = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes) + 1
    corners = np.stack([first, first + step, first + step + 1], axis=-1)
    return np.asarray(indices[corners], dtype=np.int32)


def is_installed() -> bool:
    """Whether Mitsuba can be imported."""
    return importlib.util.find_spec("mitsuba") is not None


def compare(
    scene: BenchScene, repeats: int, threads: int, on_round: Callable[[str], None]
) -> PeerResult:
    """Renders the direct-light image of `scene` with ours and every variant, in turns."""
    direct = DirectScene.of(scene)
    on_round(f"{scene.name}: building trees for the direct-light image")
    bench = direct.bench()
    bench.render(threads)
    ours = bench.beauty()[..., :3]
    timers: dict[str, Callable[[], float]] = {"irt": lambda: bench.render(threads)}
    differences: dict[str, float] = {}
    absent: dict[str, str] = {}
    version = None
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        direct.save(folder / "scene.npz", threads)
        for variant in VARIANTS:
            on_round(f"{scene.name}: starting Mitsuba's {variant}")
            worker = Worker(variant, folder)
            stack.callback(worker.close)
            if worker.version is None:
                absent[variant] = worker.failure
                continue
            version = worker.version
            differences[variant] = difference(ours, np.load(folder / f"{variant}.npy"))
            timers[variant] = worker.render
        on_round(f"{scene.name}: timing the direct-light image")
        interleave(timers, 1)
        seconds = interleave(timers, repeats)
    width, height = scene.shot.size
    paths = width * height * SAMPLES
    spreads = {name: Spread.of(values) for name, values in seconds.items()}
    return PeerResult(
        scene.name,
        scene.shot.size,
        SAMPLES,
        threads,
        version,
        spreads,
        {name: paths / spread.median for name, spread in spreads.items()},
        differences,
        tuple(
            Figure(f"irt over {name}", ratios(seconds[name], seconds["irt"]), *VARIANTS[name])
            for name in seconds
            if name != "irt"
        ),
        absent,
    )


class Worker:
    """A process that renders with one variant on request. `version` is None if it failed."""

    def __init__(self, variant: str, folder: Path) -> None:
        files = [str(folder / "scene.npz"), str(folder / f"{variant}.npy")]
        self._errors = (folder / f"{variant}.log").open("w+", encoding="utf-8")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "irt_usd.bench.mitsuba_worker", variant, *files],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
        )
        self.version = self._read()

    @property
    def failure(self) -> str:
        """The last line of what it complained of."""
        self._errors.seek(0)
        lines = self._errors.read().strip().splitlines()
        return lines[-1] if lines else "it ended without a word"

    def render(self) -> float:
        """Seconds of one render. Raises OSError if the process has ended."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        answer = self._read()
        if answer is None:
            raise OSError(f"Mitsuba ended: {self.failure}")
        return float(answer)

    def close(self) -> None:
        """Ends the process."""
        self._process.communicate()
        self._errors.close()

    def _read(self) -> str | None:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip() or None


def difference(ours: NDArray[np.float32], theirs: NDArray[np.float32]) -> float:
    """Mean difference of two (height, width, 3) images over blocks, relative to the mean."""
    ours, theirs = _blocks(ours), _blocks(theirs)
    return float(np.abs(ours - theirs).mean() / theirs.mean())


def _blocks(image: NDArray[np.float32]) -> NDArray[np.float32]:
    height, width = (side // _BLOCK * _BLOCK for side in image.shape[:2])
    tiles = image[:height, :width].reshape(height // _BLOCK, _BLOCK, width // _BLOCK, _BLOCK, 3)
    return np.asarray(tiles.mean(axis=(1, 3), dtype=np.float64), dtype=np.float32)
