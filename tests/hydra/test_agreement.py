# SPDX-License-Identifier: Apache-2.0
"""One stage, camera and settings give the same film through the command line and through Hydra."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from irt_usd.report import Report
from irt_usd.shot.frames import parse_frames
from irt_usd.shot.session import open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer

HERE = Path(__file__).parent
SHOTS = HERE.parents[1] / "shots"
BUILD = Path(os.environ["IRT_HYDRA_BUILD"])
SIZE = (192, 108)

CASES = {
    "every kind of prim": (HERE / "shot.usda", "/World/cam", (1,)),
}


def through_hydra(
    stage: Path, camera: str, times: tuple[int, ...], path: str, folder: Path
) -> NDArray[np.float32]:
    """Films (frames, h, w, 4), row 0 on top."""
    film = folder / "film.raw"
    command = [BUILD / "tests/irt_hydra_render", stage, camera, *map(str, SIZE), film, path]
    environment = {**os.environ, "PXR_PLUGINPATH_NAME": str(BUILD / "plugin/resources")}
    subprocess.run([*map(str, command), *map(str, times)], check=True, env=environment)
    width, height = SIZE
    return np.fromfile(film, np.float32).reshape(len(times), height, width, 4)[:, ::-1]


@pytest.mark.parametrize("name", CASES)
def test_both_doors_give_the_same_film(name: str, tmp_path: Path) -> None:
    stage, camera, times = CASES[name]
    frames = ",".join(map(str, times))
    shot = open_shot(ShotOptions(str(stage), camera, frames, SIZE), Report())
    films = through_hydra(stage, shot.views[0].camera, times, "index", tmp_path)
    tracer = ShotTracer(shot, TraceSettings(aovs=()), shot.frames, "none")
    for frame, film in zip(parse_frames(frames), films, strict=True):
        tracer.trace(frame)
        ours = tracer.film().beauty
        different = (ours.view(np.uint32) != film.view(np.uint32)).any(axis=-1)
        assert not different.any(), f"{name}, frame {frame}: {different.sum()} pixels differ"
