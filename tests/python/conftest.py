# SPDX-License-Identifier: Apache-2.0
"""Fixtures shared by the Python tests."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest
from pxr import Usd

from irt_usd.report import Report
from irt_usd.stage import ReadOptions, ShotReader, Snapshot, open_stage

CAMERA = """
def Camera "cam"
{
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""

WriteLayer = Callable[..., Path]


@dataclass
class ReadShot:
    """A stage on disk, and a reader of it."""

    path: Path
    stage: Usd.Stage
    report: Report
    reader: ShotReader

    def read(self, time: float = 1.0) -> Snapshot:
        return self.reader.read(time)

    def notices(self, severity: str) -> list[str]:
        return [n.text for n in self.report.notices if n.severity == severity]


MakeShot = Callable[..., ReadShot]


@pytest.fixture
def usda(tmp_path: Path) -> WriteLayer:
    """Writes a layer of the given text (one statement a line) and returns its path."""

    def write(body: str, name: str = "shot.usda", metadata: str = "") -> Path:
        path = tmp_path / name
        path.write_text(f"#usda 1.0\n(\n{metadata}\n)\n{body}\n")
        return path

    return write


@pytest.fixture
def shot(usda: WriteLayer) -> MakeShot:
    """Opens a stage of the given text, with a camera unless it has one, and analyses it."""

    def make(
        body: str,
        frames: Sequence[float] = (1.0,),
        metadata: str = "",
        options: ReadOptions | None = None,
        name: str = "shot.usda",
    ) -> ReadShot:
        path = usda(body if "def Camera" in body else body + CAMERA, name, metadata)
        stage = open_stage(str(path))
        report = Report()
        reader = ShotReader(stage, options or ReadOptions(), report, frames)
        return ReadShot(path, stage, report, reader)

    return make
