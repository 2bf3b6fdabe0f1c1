# SPDX-License-Identifier: Apache-2.0
"""What AOVs cost, what of writing tracing hides, and what two cameras of one shot share."""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender

from irt_usd.aovs import AOVS
from irt_usd.bench.timing import Spread, interleave, ratios, sums
from irt_usd.report import Report
from irt_usd.shot.output import output_paths, parse_pattern
from irt_usd.shot.progress import shot_progress
from irt_usd.shot.render import TABLE_HEADER, OutputOptions, render_shot
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer

ALL_AOVS = (*AOVS, "primvars:displayColor", "lpe:C.*L", "lpe:C.[LO]", "lpe:C..+[LO]")
"""One of each kind, those of fixed names all."""


@dataclass(frozen=True)
class AovCosts:
    """Seconds and ratios, by what they are of."""

    stage: str
    frames: int
    seconds: dict[str, Spread]
    shares: dict[str, Spread]

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        return {
            "stage": self.stage,
            "frames": self.frames,
            "seconds": {name: vars(spread) for name, spread in self.seconds.items()},
            "shares": {name: vars(spread) for name, spread in self.shares.items()},
        }

    def rows(self) -> Iterator[str]:
        """Lines of a table."""
        for name, of in self.seconds.items():
            yield f"{name:<44} {of.median:9.3f} s  ({of.low:.3f} to {of.high:.3f})"
        for name, of in self.shares.items():
            low, middle, high = (f"{100 * x:.1f}" for x in (of.low, of.median, of.high))
            yield f"{name:<44} {middle:>9} %  ({low} to {high})"


def measure_aovs(
    options: ShotOptions, settings: TraceSettings, repeats: int, say: Callable[[str], None]
) -> AovCosts:
    """Measures a shot, in rounds. Raises InputError as rendering does."""
    plain = replace(settings, aovs=())
    full = replace(settings, aovs=ALL_AOVS)
    wanting = replace(options, aovs=ALL_AOVS)
    bare, rich = open_shot(options, Report()), open_shot(wanting, Report())
    seconds: dict[str, Spread] = {}
    shares: dict[str, Spread] = {}

    say("tracing, without AOVs and with all")
    found = interleave(
        {
            "first frame, no AOVs": lambda: _trace(bare, plain, first=True),
            "first frame, all AOVs": lambda: _trace(rich, full, first=True),
            "shot, no AOVs": lambda: _trace(bare, plain, first=False),
            "shot, all AOVs": lambda: _trace(rich, full, first=False),
        },
        repeats,
    )
    seconds |= {name: Spread.of(values) for name, values in found.items()}
    for what in ("first frame", "shot"):
        more = ratios(found[f"{what}, all AOVs"], found[f"{what}, no AOVs"])
        shares[f"all AOVs, of the time of the {what}"] = _less_one(more)

    say("tracing and writing")
    with tempfile.TemporaryDirectory() as folder:
        written = [_render(rich, full, Path(folder)) for _ in range(repeats)]
    clock, traced, encoded = map(list, zip(*written, strict=True))
    seconds["shot written, all AOVs: by the clock"] = Spread.of(clock)
    seconds["shot written, all AOVs: tracing"] = Spread.of(traced)
    seconds["shot written, all AOVs: writing"] = Spread.of(encoded)
    hidden = [t + w - c for c, t, w in zip(clock, traced, encoded, strict=True)]
    shares["writing hidden behind tracing"] = ratios(hidden, encoded)

    say("two cameras, together and one by one")
    with tempfile.TemporaryDirectory() as folder:
        stage, cameras = _two_cameras(bare, Path(folder))
        pair = replace(options, stage=stage, camera=None, settings=None)
        found = interleave(
            {
                "both cameras in one run": lambda: _run(pair, plain),
                "the first camera alone": lambda: _run(_only(pair, cameras[0]), plain),
                "the second camera alone": lambda: _run(_only(pair, cameras[1]), plain),
            },
            repeats,
        )
    seconds |= {name: Spread.of(values) for name, values in found.items()}
    apart = sums(found["the first camera alone"], found["the second camera alone"])
    together = ratios(found["both cameras in one run"], apart)
    shares["saved by two cameras in one run"] = _less_one(together, -1)
    return AovCosts(options.stage, len(bare.frames), seconds, shares)


def _less_one(ratio: Spread, sign: float = 1) -> Spread:
    values = [sign * (value - 1) for value in (ratio.low, ratio.high)]
    return Spread(sign * (ratio.median - 1), min(values), max(values))


def _trace(shot: Shot, settings: TraceSettings, first: bool) -> float:
    """Seconds by the clock to trace, films with all AOVs included; no file is read or written."""
    frames = shot.frames[:1] if first else shot.frames
    tracer = ShotTracer(shot, settings, frames, "none" if first else "shot")
    taken = 0.0
    for frame in frames:
        traced = tracer.trace(frame)
        start = perf_counter()
        for view in range(len(shot.views)):
            tracer.film(view)
        taken += traced.update["seconds"]["total"] + perf_counter() - start
    return taken


def _render(shot: Shot, settings: TraceSettings, folder: Path) -> tuple[float, float, float]:
    """Seconds by the clock, of tracing, of writing."""
    paths = output_paths(parse_pattern(str(folder / "frame.####.exr")), shot.frames)
    output = OutputOptions([(path,) * len(shot.views) for path in paths])
    start = perf_counter()
    with shot_progress(len(paths) * len(shot.views), TABLE_HEADER, quiet=True) as progress:
        written = render_shot(shot, shot.frames, settings, output, progress)
    clock = perf_counter() - start
    writing = sum(stats["seconds"]["write"] for stats in written)
    return clock, sum(stats["seconds"]["total"] for stats in written) - writing, writing


def _run(options: ShotOptions, settings: TraceSettings) -> float:
    """Seconds from a stage's name to the last film of the shot."""
    start = perf_counter()
    shot = open_shot(options, Report())
    tracer = ShotTracer(shot, settings, shot.frames)
    for frame in shot.frames:
        tracer.trace(frame)
    return perf_counter() - start


def _only(pair: ShotOptions, camera: str) -> ShotOptions:
    return replace(pair, camera=camera, settings=f"/irtBench/Only{camera.rsplit('/', 1)[1]}")


def _two_cameras(shot: Shot, folder: Path) -> tuple[str, tuple[str, str]]:
    """A stage over the shot's whose render settings have its camera, and one a little aside."""
    width, height = shot.size
    path = folder / "pair.usda"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(Path(shot.options.stage).resolve()))
    for key in ("startTimeCode", "endTimeCode", "framesPerSecond", "timeCodesPerSecond"):
        if shot.stage.HasAuthoredMetadata(key):
            stage.SetMetadata(key, shot.stage.GetMetadata(key))
    UsdGeom.Scope.Define(stage, "/irtBench")
    names = ("First", "Second")
    places = []
    for index, name in enumerate(names):
        state = shot.reader.read(float(shot.frames[0])).cameras[0]
        camera = UsdGeom.Camera.Define(stage, f"/irtBench/{name}")
        world = state.world_from_camera.copy()
        world[3, :3] += 0.05 * index * world[0, :3]
        camera.AddTransformOp().Set(Gf.Matrix4d(*map(float, world.ravel())))
        for attribute in ("focalLength", "horizontalAperture", "verticalAperture", "projection"):
            camera.GetPrim().GetAttribute(attribute).Set(state.attributes[attribute])
        places.append(str(camera.GetPath()))
    for label, shown in (("Both", names), *((f"Only{name}", (name,)) for name in names)):
        settings = UsdRender.Settings.Define(stage, f"/irtBench/{label}")
        settings.GetResolutionAttr().Set(Gf.Vec2i(width, height))
        for name in shown:
            product = UsdRender.Product.Define(stage, f"/irtBench/{label}/{name}")
            product.GetCameraRel().SetTargets([Sdf.Path(f"/irtBench/{name}")])
            settings.GetProductsRel().AddTarget(product.GetPath())
    stage.SetMetadata("renderSettingsPrimPath", "/irtBench/Both")
    stage.GetRootLayer().Save()
    return str(path), (places[0], places[1])
