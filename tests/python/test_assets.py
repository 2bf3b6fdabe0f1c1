# SPDX-License-Identifier: Apache-2.0
"""The USD Assets Working Group's test assets: every layer renders, and what is said of it is known.

They are not part of this repository: https://github.com/usd-wg/assets, beside it as shared/assets.
"""

import re
from pathlib import Path

import pytest

from framing import CAMERA, framing_layer
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.session import open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer
from irt_usd.stage import OpenOptions, open_stage

ROOT = Path(__file__).parents[3] / "shared" / "assets"
LAYERS = sorted(
    str(path.relative_to(ROOT))
    for folder in ("test_assets", "McUsd")
    for path in (ROOT / folder).rglob("*.usd*")
)

REFUSED = {
    "framesPerSecond/framesPerSecond_-1.usda": 'invalid value for field "framesPerSecond"',
    "framesPerSecond/framesPerSecond_0.usda": 'invalid value for field "framesPerSecond"',
}
"""Layers that USD itself cannot read."""

EXPECTED: dict[str, list[str]] = {
    "payload_invalid": [r"missing payloads.*/World/invalid_payload.*@file_does_not_exist\.usda@"],
    "reference_invalid": [r"missing references.*@file_does_not_exist\.usda@"],
    "sublayer_invalid": [r"missing sublayers.*@file_does_not_exist\.usda@"],
    "reference_prim_in_other_file": [
        r"missing references.*@file_does_not_exist\.usda@",
        r"missing prims to refer to.*/World/Cube_does_not_exist",
    ],
    "reference_prim_in_same_file": [r"missing prims to refer to.*</World/cube>"],
    "start_end_timeCodes_swapped": [r"the stage's own range, 100 to 0"],
    "empty_mesh": [r"empty mesh: /mesh"],
    "pointsTypes": [r"the points are no array of 3-vectors", r"empty mesh"],
    "weird_matrix_transform": [r"the transform is projective"],
    "TextureFileFormatTests/_scene": [r"without a file, its fallback rendered"],
}
"""By a part of a layer's path, what is said of layers that are wrong, or of what is to come."""

ALWAYS = ("no lights that irt renders: a light at the camera instead",)

pytestmark = pytest.mark.skipif(not LAYERS, reason=f"{ROOT} is not there: the assets are not tried")


@pytest.mark.parametrize("name", LAYERS)
def test_layer(name: str, tmp_path: Path) -> None:
    path = str(ROOT / name)
    refusal = next((text for part, text in REFUSED.items() if part in name), None)
    if refusal is not None:
        with pytest.raises(InputError, match=refusal):
            open_stage(path)
        return
    stage = open_stage(path, OpenOptions(missing_asset="fallback"))
    time = stage.GetStartTimeCode()
    options = ShotOptions(
        path,
        camera=CAMERA,
        frames=f"{time:.0f}",
        size=(120, 90),
        session_layer=str(framing_layer(stage, tmp_path, time)),
        missing_asset="fallback",
    )
    del stage
    report = Report()
    shot = open_shot(options, report)
    tracer = ShotTracer(shot, TraceSettings(), shot.frames, "none")
    tracer.trace(shot.frames[0])
    assert bool(tracer.film().beauty[..., 3].any()) == ("empty_mesh" not in name)
    expected = [text for part, texts in EXPECTED.items() if part in name for text in texts]
    said = [notice.text for notice in report.notices]
    said = [text for text in said if not any(always in text for always in ALWAYS)]
    unexplained = [text for text in said if not any(re.search(e, text) for e in expected)]
    assert not unexplained
    assert not [e for e in expected if not any(re.search(e, text) for text in said)]
