# SPDX-License-Identifier: Apache-2.0
"""Every layer of the USD working group's schema tests can be opened and read."""

from pathlib import Path

import pytest
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage import ReadOptions, ShotReader, list_cameras, open_stage

ROOT = Path(__file__).parents[3] / "shared/assets/test_assets/schemaTests"
LAYERS = sorted(ROOT.rglob("*.usd*"))


def test_assets_are_there() -> None:
    if not LAYERS:
        pytest.skip(f"no USD layers below {ROOT}: the schema tests were not tried")


@pytest.mark.parametrize("path", LAYERS, ids=lambda path: path.stem)
def test_layer(path: Path) -> None:
    stage = open_stage(str(path))
    if not list_cameras(stage):
        stage.SetEditTarget(Usd.EditTarget(stage.GetSessionLayer()))
        UsdGeom.Camera.Define(stage, "/test_camera")
    report = Report()
    reader = ShotReader(stage, ReadOptions(), report, [1.0, 2.0])
    first, second = reader.read(1.0), reader.read(2.0)
    gprims = [p for p in stage.Traverse() if p.IsA(UsdGeom.Gprim)]
    assert first.objects or report.notices or not gprims
    assert first.camera is second.camera
