# SPDX-License-Identifier: Apache-2.0
"""The scenes that benches trace, as the core's records.

`make bench` writes their stages with shots/bench/make_bench.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd import _core
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions
from irt_usd.stage import Snapshot
from irt_usd.stage.mesh import MeshShape
from irt_usd.stage.snapshot import ObjectState, Part

FILES = {
    "quadrics": "quadrics.usda",
    "triangles": "triangles.usdc",
    "pieces": "pieces.usdc",
    "instances": "instances.usda",
}
"""Stages by scene name, in a folder that is given."""


@dataclass(frozen=True)
class BenchScene:
    """One frame of a stage: what it shows, counted, and how it is seen."""

    name: str
    shot: Shot
    snapshot: Snapshot
    changes: _core.ChangeSet
    quadrics: int
    triangles: int
    instances: int

    @property
    def camera(self) -> _core.Camera:
        """The core's record."""
        return self.snapshot.camera.core()

    @property
    def contents(self) -> str:
        """Such as `144 quadrics`."""
        counts = (
            (self.instances, "instances"),
            (self.quadrics, "quadrics"),
            (self.triangles, "triangles"),
        )
        return ", ".join(f"{count:,} {kind}" for count, kind in counts if count)


def load_scene(name: str, folder: Path, size: tuple[int, int] | None) -> BenchScene:
    """Reads scene `name` from `folder`; `size` in pixels, None for the stage's own.

    Native instances become instances of the core's. Raises InputError if it is not there.
    """
    path = folder / FILES[name]
    if not path.is_file():
        raise InputError(
            f"{path}: no such file; in the source folder of irt, `make bench` writes the scenes,"
            f" and so does `python -m shots.bench.make_bench {folder}`"
        )
    shot = open_shot(ShotOptions(str(path), size=size), Report())
    frame = float(shot.frames[0])
    snapshot = shot.reader.read(frame)
    instances = _instances(shot.stage, snapshot.objects, Usd.TimeCode(frame))
    prototypes = {i.prototype: i for i in reversed(instances)}  # the first of each stands for all
    within = {path for i in instances for path in i.parts}
    own = [state for path, state in snapshot.objects.items() if path not in within]
    changes = _core.ChangeSet()
    for material in snapshot.materials.values():
        material.add_to(changes)
    for light in snapshot.lights.values():
        light.add_to(changes)
    for state in own:
        state.add_to(changes)
    shared = {name: model.core(snapshot.objects) for name, model in prototypes.items()}
    for instance in instances:
        changes.set_object(instance.path, shared[instance.prototype], instance.world)
    drawn = own + [snapshot.objects[p] for model in prototypes.values() for p in model.parts]
    return BenchScene(
        name,
        shot,
        snapshot,
        changes,
        quadrics=sum(not isinstance(state.shape, MeshShape) for state in drawn),
        triangles=sum(triangle_count(state) for state in drawn),
        instances=len(instances),
    )


def triangle_count(state: ObjectState) -> int:
    """Triangles of a mesh; 0 for a quadric."""
    if not isinstance(state.shape, MeshShape):
        return 0
    counts = np.asarray(state.shape.attributes["faceVertexCounts"])
    return int(np.maximum(counts - 2, 0).sum())


@dataclass(frozen=True)
class _Instance:
    """An instance prim: its prototype's name and the paths of its parts."""

    path: str
    prototype: str
    world: NDArray[np.float64]
    parts: list[str]

    def core(self, objects: Mapping[str, ObjectState]) -> _core.Prototype:
        """Its parts as a prototype in its own space."""
        prototype_from_world = np.linalg.inv(self.world)
        parts: list[Part] = []
        for path in self.parts:
            state = objects[path]
            placed = state.shape.place(state.world_from_object) @ prototype_from_world
            placed[:, 3] = (0, 0, 0, 1)  # what rounding may have touched
            name = path.removeprefix(self.path + "/")
            _, geometry, _, material, primvars, faces, role = state.part(name)
            parts.append((name, geometry, placed, material, primvars, faces, role))
        return _core.Prototype(parts)


def _instances(
    stage: Usd.Stage, objects: Mapping[str, ObjectState], time: Usd.TimeCode
) -> list[_Instance]:
    places = UsdGeom.XformCache(time)
    found = []
    for prim in stage.Traverse():
        if prim.IsInstance():
            path = str(prim.GetPath())
            world = np.array(places.GetLocalToWorldTransform(prim))
            parts = [name for name in objects if name.startswith(path + "/")]
            found.append(_Instance(path, str(prim.GetPrototype().GetPath()), world, parts))
    return found
