# SPDX-License-Identifier: Apache-2.0
"""What a million instances take: `python instances.py [array | nest | native] [COUNT]`.

array: entries of one point instancer. nest: an instancer of COUNT instancers of COUNT balls (1000).
native: COUNT instanceable prims of a stage, read as `irt render` reads them.
"""

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf

from irt_usd import _core
from irt_usd.report import Report
from irt_usd.shot.frames import parse_frames
from irt_usd.shot.session import open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer


def resident_bytes() -> int:
    """Of this process."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmRSS"))


def rows_of(count: int, side: float) -> np.ndarray:
    """Places in a cube of that side, (count, 4, 3)."""
    rows = np.zeros((count, 4, 3))
    rows[:, :3] = np.eye(3)
    rows[:, 3] = np.random.default_rng(1).uniform(-side / 2, side / 2, (count, 3))
    return rows


def ball() -> _core.Prototype:
    """Of diameter 1."""
    return _core.Prototype([("ball", _core.Quadric.sphere(0.5), np.eye(4), "/m", {}, ())])


def array_of(count: int, moved: int | None) -> _core.InstanceArray:
    """Balls in a cube of side 1000; `moved` is in front of all others."""
    rows = rows_of(count, 1000)
    if moved is not None:
        rows[moved, 3] = (0.0, 0.0, 1190.0)
    return _core.InstanceArray([ball()], rows)


def nest_of(count: int, moved: int | None) -> _core.InstanceArray:
    """Clusters of balls in a cube of side 1000; the cluster `moved` is in front of all others."""
    inner: Any = _core.InstanceArray([ball()], rows_of(count, 60))
    cluster = _core.Prototype([("cluster", inner, np.eye(4), "", {}, ())])
    rows = rows_of(count, 940)
    if moved is not None:
        rows[moved, 3] = (0.0, 0.0, 1100.0)
    return _core.InstanceArray([cluster], rows)


def change(instances: _core.InstanceArray) -> _core.ChangeSet:
    """The scene: the instances, a material and a light."""
    changes = _core.ChangeSet()
    changes.set_material("/m", _core.Material())
    changes.set_light("/l", _core.Light.distant((0, 0, -1), (1, 1, 1)))
    changes.set_object("/I", instances, np.eye(4))
    return changes


def trace(make: Any, count: int, total: int) -> None:
    """Prints bytes an instance, and the counts and seconds of the update that moves one."""
    place = np.eye(4)
    place[3, 2] = 1200.0
    renderer = _core.Renderer(
        _core.Camera(place, (-0.5, 0.5, -0.5, 0.5)),
        _core.ViewSettings(64, 64),
        threads=1,
        cost_model=False,
    )
    before, start = resident_bytes(), time.perf_counter()
    renderer.update(change(make(count, None)))
    print(f"{total:,} instances, first frame in {time.perf_counter() - start:.2f} s")
    print(f"{(resident_bytes() - before) / total:.2f} bytes an instance")
    done = renderer.update(change(make(count, 5)))
    for name in ("all_rays", "flagged_rays", "tested_rays", "retraced_rays", "changed_rays"):
        print(f"{name} {done[name]}")
    print({phase: round(seconds, 4) for phase, seconds in done["seconds"].items()})


def write_native(path: Path, count: int) -> None:
    """A stage of so many instanceable prims of one prototype."""
    layer = Sdf.Layer.CreateNew(str(path))
    with Sdf.ChangeBlock():
        kind = Sdf.CreatePrimInLayer(layer, "/Kind")
        kind.specifier = Sdf.SpecifierClass
        sphere = Sdf.CreatePrimInLayer(layer, "/Kind/ball")
        sphere.specifier, sphere.typeName = Sdf.SpecifierDef, "Sphere"
        camera = Sdf.CreatePrimInLayer(layer, "/cam")
        camera.specifier, camera.typeName = Sdf.SpecifierDef, "Camera"
        Sdf.CreatePrimInLayer(layer, "/I").specifier = Sdf.SpecifierDef
        places = rows_of(count, 1000)[:, 3]
        for name, place in [
            ("/cam", (0, 0, 1200)),
            *((f"/I/i{i}", p) for i, p in enumerate(places)),
        ]:
            prim = Sdf.CreatePrimInLayer(layer, name)
            translate = Sdf.AttributeSpec(prim, "xformOp:translate", Sdf.ValueTypeNames.Double3)
            translate.default = tuple(map(float, place))
            order = Sdf.AttributeSpec(
                prim, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform
            )
            order.default = ["xformOp:translate"]
            if name == "/cam":
                continue
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "Xform"
            prim.instanceable = True
            prim.inheritPathList.explicitItems = [Sdf.Path("/Kind")]
    layer.Save()


def native(count: int) -> None:
    """Prints what each step of reading and tracing that stage takes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "native.usdc"
        write_native(path, count)
        start, before = time.perf_counter(), resident_bytes()
        shot = open_shot(ShotOptions(str(path), frames="1", size=(64, 64)), Report())
        opened, memory = time.perf_counter(), resident_bytes()
        print(
            f"opened and analysed in {opened - start:.1f} s, {(memory - before) / count:.0f} bytes"
        )
        tracer = ShotTracer(shot, TraceSettings(threads=1), shot.frames)
        tracer.trace(parse_frames("1")[0])
        print(
            f"read and traced in {time.perf_counter() - opened:.1f} s,"
            f" {(resident_bytes() - memory) / count:.0f} bytes an instance more"
        )


def main() -> None:
    """Runs what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", nargs="?", default="array", choices=("array", "nest", "native"))
    parser.add_argument("count", nargs="?", type=int)
    options = parser.parse_args()
    count = options.count or (1000 if options.kind == "nest" else 1_000_000)
    if options.kind == "native":
        native(count)
    elif options.kind == "nest":
        trace(nest_of, count, count * count)
    else:
        trace(array_of, count, count)


if __name__ == "__main__":
    main()
