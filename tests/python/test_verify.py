# SPDX-License-Identifier: Apache-2.0
"""`irt verify`: that it finds nothing where nothing is, and a single bit where one is."""

import json
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli_support import CAMERA, MOVING_SHOT, SCENE, SHOT, SIZE, irt, stage_of, write_stage
from irt_usd.images.exr import Film
from irt_usd.shot.tracer import ShotTracer
from irt_usd.shot.verify import FLOAT_MAX, Difference, compare_films

KEYS = {
    "frames",
    "pixels",
    "differing_pixels",
    "max_abs_difference",
    "first_difference",
    "restarts",
    "seconds_update",
    "seconds_full",
    "brute_force_pixels",
    "brute_force_differing",
    "per_frame",
}


def verify(folder: Path, text: str, *options: str) -> tuple[int, str, dict[str, Any]]:
    """Status, output and verdict."""
    path = folder / "verdict.json"
    result = irt("verify", write_stage(folder, text), *SIZE, "--json", str(path), *options)
    verdict = json.loads(path.read_text()) if path.exists() else {}
    return result.exit_code, result.output, verdict


def test_a_shot_is_exact(tmp_path: Path) -> None:
    status, output, verdict = verify(tmp_path, SHOT, "--samples", "2")
    assert status == 0, output
    assert set(verdict) == KEYS
    assert (verdict["frames"], verdict["pixels"]) == (4, 4 * 48 * 27)
    assert (verdict["differing_pixels"], verdict["max_abs_difference"]) == (0, 0)
    assert verdict["first_difference"] is None
    assert (verdict["brute_force_pixels"], verdict["brute_force_differing"]) == (64, 0)
    assert verdict["seconds_full"] > 0
    assert [frame["frame"] for frame in verdict["per_frame"]] == [1, 2, 3, 4]
    for frame in verdict["per_frame"]:
        assert set(frame) >= {"flagged_rays", "retraced_rays", "changed_rays", "all_rays"}
    assert verdict["per_frame"][2]["retraced_rays"] == 0
    assert verdict["per_frame"][2]["all_rays"] > 0
    assert "exact: 4 frames" in output


def test_a_moving_camera_is_exact_and_restarts(tmp_path: Path) -> None:
    status, output, verdict = verify(tmp_path, MOVING_SHOT)
    assert status == 0, output
    reasons = [frame["restart"] for frame in verdict["per_frame"]]
    assert reasons[0] is None
    assert "camera" in reasons[2]
    assert verdict["restarts"] == reasons.count("camera changed") == 1


def test_light_at_the_camera_is_exact(tmp_path: Path) -> None:
    assert verify(tmp_path, stage_of(CAMERA, SCENE))[0] == 0


def test_frames_backwards_are_exact(tmp_path: Path) -> None:
    assert verify(tmp_path, SHOT, "-f", "4:1x0.5")[0] == 0


def test_one_bit_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    honest = ShotTracer.film

    def film(tracer: ShotTracer, view: int = 0) -> Film:
        made = honest(tracer, view)
        if len(tracer._shot.frames) == 1:  # the judge's
            made.aovs["depth"].view(np.uint32)[5, 7] ^= 1
        return made

    monkeypatch.setattr(ShotTracer, "film", film)
    status, output, verdict = verify(tmp_path, SHOT)
    assert status == 4
    assert verdict["differing_pixels"] == 4
    assert verdict["first_difference"] == {"frame": 1, "x": 7, "y": 5, "channel": "depth"}
    assert "DIFFERENT: 4 of 4 frames" in output
    assert verify(tmp_path, SHOT, "--aov", "depth")[0] == 4


def test_the_twin_is_heard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("irt_usd.shot.verify._same_bits", lambda a, b: False)
    status, output, verdict = verify(tmp_path, SHOT, "--brute-force-pixels", "3")
    assert status == 4
    assert (verdict["differing_pixels"], verdict["brute_force_differing"]) == (0, 12)
    assert "brute force: 12 of 12" in output


def films() -> tuple[Film, Film]:
    def one() -> Film:
        ids = np.arange(12, dtype=np.uint32).reshape(3, 4)
        return Film(np.ones((3, 4, 4), np.float32), {"objectId": ids})

    return one(), one()


FRAME = Decimal("1.5")


def test_equal_films() -> None:
    assert compare_films(FRAME, *films()) == (0, 0.0, None)


def test_first_difference_is_by_row_then_channel() -> None:
    a, b = films()
    b.beauty[2, 0, 0] = 3
    b.beauty[1, 3, 2] = 1.25
    b.beauty[1, 3, 3] = 0
    assert compare_films(FRAME, a, b) == (2, 2.0, Difference(FRAME, 3, 1, "B"))


def test_bits_are_compared_not_values() -> None:
    a, b = films()
    a.beauty[0, 0, 0], b.beauty[0, 0, 0] = 0.0, -0.0
    assert compare_films(FRAME, a, b) == (1, 0.0, Difference(FRAME, 0, 0, "R"))
    a.beauty[0, 0, 0] = b.beauty[0, 0, 0] = np.nan
    assert compare_films(FRAME, a, b)[0] == 0
    b.beauty[0, 0, 0] = 1
    assert compare_films(FRAME, a, b)[1] == FLOAT_MAX


def test_ids_count_without_magnitude() -> None:
    a, b = films()
    b.aovs["objectId"][2, 3] += 1
    assert compare_films(FRAME, a, b) == (1, 0.0, Difference(FRAME, 3, 2, "objectId"))
