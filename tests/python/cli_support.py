# SPDX-License-Identifier: Apache-2.0
"""Small stages and ways to run `irt` on them, in process and as a program."""

import os
import re
import subprocess
import sys
from pathlib import Path

from click.testing import CliRunner, Result

import irt_usd
from irt_usd.cli.main import cli

SIZE = ("--size", "48x27")
FRAMES = 4
"""Of `SHOT`: the ball moves at 2 and 4, the lamp dims at 4, frame 3 is frame 2."""

_HEAD = """#usda 1.0
(
    startTimeCode = 1
    endTimeCode = 4
    upAxis = "Y"
)

"""

CAMERA = """def Camera "Cam"
{
    float focalLength = 35
    double3 xformOp:translate = (0, 1, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

"""

MOVING_CAMERA = """def Camera "Cam"
{
    float focalLength = 35
    double3 xformOp:translate.timeSamples = {
        1: (0, 1, 8),
        2: (0, 1, 8),
        3: (0.25, 1, 8),
        4: (0.25, 1, 8),
    }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

"""

SIDE_CAMERA = CAMERA.replace('"Cam"', '"Side"')

SCENE = """def Sphere "Ball"
{
    color3f[] primvars:displayColor = [(0.8, 0.2, 0.1)]
    double radius = 1
    double3 xformOp:translate.timeSamples = {
        1: (0, 1, 0),
        2: (0.5, 1, 0),
        3: (0.5, 1, 0),
        4: (1, 1, 0),
    }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

def Plane "Floor"
{
    uniform token axis = "Y"
    double width = 20
    double length = 20
}

"""

LAMP = """def SphereLight "Lamp"
{
    float inputs:intensity.timeSamples = {
        1: 60,
        3: 60,
        4: 30,
    }
    float inputs:radius = 0.5
    double3 xformOp:translate = (3, 6, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}

"""

SHOT = _HEAD + CAMERA + SCENE + LAMP
MOVING_SHOT = _HEAD + MOVING_CAMERA + SCENE + LAMP


def stage_of(*parts: str) -> str:
    """A stage of the parts, four frames long."""
    return _HEAD + "".join(parts)


def write_stage(folder: Path, text: str = SHOT, name: str = "shot.usda") -> str:
    """Writes a stage and returns its path."""
    path = folder / name
    path.write_text(text)
    return str(path)


def irt(*arguments: str) -> Result:
    """`irt` in this process."""
    return CliRunner().invoke(cli, arguments, prog_name="irt")


def failure(*arguments: str, status: int = 2) -> str:
    """The one message of a command that must fail with `status`."""
    result = irt(*arguments)
    assert result.exit_code == status, result.output
    assert "Traceback" not in result.output
    assert len(re.findall(r"^(?:irt: e|E)rror: ", result.stderr, re.MULTILINE)) == 1, result.stderr
    return result.stderr


def command(*arguments: str) -> list[str]:
    """The command line of `irt` as a program."""
    return [sys.executable, "-m", "irt_usd", *arguments]


def environment() -> dict[str, str]:
    """In which this very irt_usd is found."""
    package = str(Path(irt_usd.__file__).parents[1])
    paths = [package, os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def run(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """`irt` as a program."""
    return subprocess.run(
        command(*arguments),
        capture_output=True,
        text=True,
        timeout=120,
        cwd=cwd,
        env=environment(),
        check=False,
    )
