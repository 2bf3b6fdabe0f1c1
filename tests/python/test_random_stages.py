# SPDX-License-Identifier: Apache-2.0
"""Random USD shots, read, followed frame by frame, and verified against each frame from nothing."""

from pathlib import Path

import pytest

import random_stages
from irt_usd.report import Report
from irt_usd.shot.progress import QuietProgress
from irt_usd.shot.session import open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.verify import Verdict, verify_shot


def verdict_of(seed: int, folder: Path) -> Verdict:
    path = random_stages.write(seed, folder)
    complexity = ("low", "medium", "high")[seed % 3]
    options = ShotOptions(str(path), size=(40, 30), complexity=complexity)
    shot = open_shot(options, Report())
    aovs = ("depth", "normal", "position", "albedo", "objectId")
    settings = TraceSettings(aovs=aovs, samples=1 + seed % 2)
    return verify_shot(shot, settings, 20, QuietProgress())


@pytest.mark.parametrize("seed", range(12))
def test_random_stages_are_exact(seed: int, tmp_path: Path) -> None:
    verdict = verdict_of(seed, tmp_path)
    assert verdict.exact, verdict.sentence()
