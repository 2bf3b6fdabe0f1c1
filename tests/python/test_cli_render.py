# SPDX-License-Identifier: Apache-2.0
"""`irt render` on small shots, in process."""

import json
from pathlib import Path
from typing import Any

import OpenImageIO as oiio  # noqa: N813
import pytest

from cli_support import (
    CAMERA,
    FRAMES,
    MOVING_SHOT,
    SCENE,
    SHOT,
    SIDE_CAMERA,
    SIZE,
    failure,
    irt,
    stage_of,
    write_stage,
)


@pytest.fixture
def shot(tmp_path: Path) -> str:
    return write_stage(tmp_path)


def render(shot: str, out: Path, *options: str) -> list[bytes]:
    """Renders into `out`; the files' bytes, in order."""
    result = irt("render", shot, *SIZE, "-o", str(out / "b.####.exr"), *options)
    assert result.exit_code == 0, result.output
    return [path.read_bytes() for path in sorted(out.iterdir())]


def spec_of(path: Path) -> Any:
    image = oiio.ImageInput.open(str(path))
    assert image is not None
    return image.spec()


def test_whole_shot_by_default(shot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = irt("render", shot, *SIZE)
    assert result.exit_code == 0, result.output
    names = [path.name for path in sorted((tmp_path / "out").iterdir())]
    assert names == [f"shot.{frame:04d}.exr" for frame in range(1, FRAMES + 1)]
    assert "frames 1:4, 48x27, camera /Cam" in result.output
    assert "100%" in result.output
    assert "Error:" not in result.output
    assert "\r" not in result.output


def test_lines_say_what_changed(shot: str, tmp_path: Path) -> None:
    result = irt("render", shot, *SIZE, "-o", str(tmp_path / "b.#.exr"))
    lines = [line for line in result.output.splitlines() if "%  " in line]
    assert [line.split("%")[0].strip() for line in lines] == ["25", "50", "75", "100"]
    assert "1 moved" in lines[1]
    assert "nothing" in lines[2]
    assert "light energy" in lines[3]


def test_same_bytes_however_it_is_run(shot: str, tmp_path: Path) -> None:
    first = render(shot, tmp_path / "a")
    assert len(first) == FRAMES
    assert render(shot, tmp_path / "b") == first
    assert render(shot, tmp_path / "c", "--threads", "1") == first
    assert render(shot, tmp_path / "d", "--threads", "3", "--history", "none") == first
    assert render(shot, tmp_path / "e", "-f", "2:4") == first[1:]
    assert render(shot, tmp_path / "f", "-f", "4:1") == first


def test_moving_camera_has_the_same_bytes_without_history(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, MOVING_SHOT)
    full = render(shot, tmp_path / "a")
    assert render(shot, tmp_path / "b", "--history", "none") == full


def test_statistics(shot: str, tmp_path: Path) -> None:
    stats = tmp_path / "stats" / "s.jsonl"
    render(shot, tmp_path / "a", "--stats", str(stats))
    frames = [json.loads(line) for line in stats.read_text().splitlines()]
    assert [frame["frame"] for frame in frames] == [1, 2, 3, 4]
    assert frames[0]["restart"] is None
    for frame in frames:
        assert set(frame["seconds"]) == {
            "usd", "diff", "apply", "bvh", "detect", "trace", "shade", "combine", "film", "write",
            "total",
        }  # fmt: skip
        assert set(frame["cells"]["spread"]) == {"rays", "seconds"}
        assert set(frame["rays"]) == {"primary", "reflected", "refracted", "shadow"}
        assert len(frame["cells"]["rays"]) == 64
        assert frame["file"].endswith(f"b.{frame['frame']:04d}.exr")
        assert frame["time_code"] == float(frame["frame"])
        assert frame["history"] == "shot"
    assert frames[2]["retraced_rays"] == 0
    assert frames[2]["changes"] == {"summary": "nothing", "count": 0, "camera": False}
    assert frames[1]["changes"]["count"] == 1
    assert list(stats.parent.iterdir()) == [stats]


def test_aovs_and_header(shot: str, tmp_path: Path) -> None:
    aovs = ("depth", "normal", "position", "albedo", "objectId", "depth")
    render(shot, tmp_path / "a", *(f"--aov={name}" for name in aovs), "-f", "2")
    spec = spec_of(tmp_path / "a" / "b.0002.exr")
    assert set(spec.channelnames) >= {"R", "G", "B", "A", "Z", "normal.X", "position.Z", "albedo.G"}
    assert (spec.width, spec.height) == (48, 27)
    assert spec["irt:frame"] == "2"
    assert spec["imageCounter"] == 2
    assert spec["irt:camera"] == spec["cameraLabel"] == "/Cam"
    assert spec["nominalFocalLength"] == 35
    assert spec["framesPerSecond"] == (24, 1)
    assert spec["irt:samples"] == 1
    assert spec["irt:renderOrigin"] == "0.0 1.0 8.0"
    assert len(spec["irt:numericFingerprint"]) == 16
    assert spec["worldToCamera"][12:15] == (0, -1, 8)
    assert len(spec["worldToNDC"]) == 16


@pytest.mark.parametrize(
    ("old", "new", "focal_length"),
    [
        ("focalLength = 35", "focalLength.timeSamples = { 1: None, 3: 35 }", 50),
        ("focalLength = 35", "verticalAperture.timeSamples = { 1: None, 3: 20 }", 50),
        (
            "float focalLength = 35",
            'token projection = "orthographic"\n    string focalLength = "long"',
            50,
        ),
        ("endTimeCode = 4", "endTimeCode = 4\n    framesPerSecond = inf", 35),
        ("endTimeCode = 4", "endTimeCode = 4\n    framesPerSecond = 1e30", 35),
    ],
)
def test_header_of_odd_stages(tmp_path: Path, old: str, new: str, focal_length: float) -> None:
    """The header tells what was rendered: fallbacks where values are blocked or of other types."""
    render(write_stage(tmp_path, SHOT.replace(old, new)), tmp_path / "a", "-f", "1")
    assert spec_of(tmp_path / "a" / "b.0001.exr")["nominalFocalLength"] == focal_length


def test_frame_number_beyond_the_headers_integers(shot: str, tmp_path: Path) -> None:
    render(shot, tmp_path / "a", "-f", "3000000000")
    spec = spec_of(tmp_path / "a" / "b.3000000000.exr")
    assert spec["irt:frame"] == "3000000000"
    assert "imageCounter" not in [attribute.name for attribute in spec.extra_attribs]


def test_float_pixels(shot: str, tmp_path: Path) -> None:
    render(shot, tmp_path / "a", "--exr-type", "float", "-f", "1")
    assert str(spec_of(tmp_path / "a" / "b.0001.exr").format) == "float"


def test_sub_frames_and_lists(shot: str, tmp_path: Path) -> None:
    pattern = str(tmp_path / "a" / "b.####.##.exr")
    assert irt("render", shot, *SIZE, "-o", pattern, "-f", "3,1:2x0.25").exit_code == 0
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names[:3] == ["b.0001.00.exr", "b.0001.25.exr", "b.0001.50.exr"]
    assert len(names) == 6


def test_skip_existing(shot: str, tmp_path: Path) -> None:
    whole = render(shot, tmp_path / "a")
    kept = tmp_path / "b" / "b.0002.exr"
    kept.parent.mkdir()
    kept.write_bytes(b"kept")
    again = render(shot, tmp_path / "b", "--skip-existing")
    assert again == [whole[0], b"kept", whole[2], whole[3]]
    result = irt("render", shot, *SIZE, "-o", str(tmp_path / "b" / "b.####.exr"), "--skip-existing")
    assert result.exit_code == 0
    assert "4 frames exist already" in result.output


def test_stage_without_a_range_is_one_frame(tmp_path: Path) -> None:
    text = stage_of(CAMERA, SCENE).replace("startTimeCode = 1", "").replace("endTimeCode = 4", "")
    shot = write_stage(tmp_path, text)
    assert irt("render", shot, *SIZE, "-o", str(tmp_path / "still.exr")).exit_code == 0
    assert (tmp_path / "still.exr").is_file()


def test_frames_outside_the_stage_are_mentioned(shot: str, tmp_path: Path) -> None:
    result = irt("render", shot, *SIZE, "-f", "100:101", "-o", str(tmp_path / "b.#.exr"))
    assert result.exit_code == 0
    assert "the stage's own range, 1 to 4" in result.output


def test_camera_that_moves_is_said_and_carried_through(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, MOVING_SHOT)
    stats = tmp_path / "s.jsonl"
    pattern = str(tmp_path / "out" / "b.#.exr")
    result = irt("render", shot, *SIZE, "-o", pattern, "--stats", str(stats))
    assert result.exit_code == 0
    assert "camera moves at frames 3:" in result.output
    restarts = [json.loads(line)["restart"] for line in stats.read_text().splitlines()]
    assert restarts[0] is None
    assert "camera" in restarts[2]


def test_locked_camera_required(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, MOVING_SHOT)
    pattern = str(tmp_path / "out" / "b.#.exr")
    message = failure("render", shot, *SIZE, "-o", pattern, "--require-locked")
    assert "/Cam moves at frames 3" in message
    assert not (tmp_path / "out").exists()
    locked = irt("render", shot, *SIZE, "-o", pattern, "--require-locked", "-f", "1:2")
    assert locked.exit_code == 0


def test_list_cameras(tmp_path: Path) -> None:
    two = stage_of(CAMERA, SIDE_CAMERA, SCENE)
    result = irt("render", write_stage(tmp_path, two), "--list-cameras")
    assert (result.exit_code, result.output) == (0, "/Cam\n/Side\n")


def test_no_light_is_said(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, stage_of(CAMERA, SCENE))
    lit = irt("render", shot, *SIZE, "-f", "1", "-o", str(tmp_path / "lit.exr"))
    dark = irt("render", shot, *SIZE, "-f", "1", "-o", str(tmp_path / "d.exr"), "--no-camera-light")
    assert (lit.exit_code, dark.exit_code) == (0, 0)
    assert "light at the camera" in lit.output
    lit_bytes, dark_bytes = ((tmp_path / name).read_bytes() for name in ("lit.exr", "d.exr"))
    assert lit_bytes != dark_bytes


def test_quiet_and_verbose(shot: str, tmp_path: Path) -> None:
    pattern = str(tmp_path / "new" / "b.#.exr")
    quiet = irt("render", shot, *SIZE, "-o", pattern, "-q")
    assert (quiet.exit_code, quiet.output) == (0, "")
    pattern = str(tmp_path / "newer" / "b.#.exr")
    assert f"created {tmp_path / 'newer'}" in irt("render", shot, *SIZE, "-o", pattern, "-v").output


NO_RANGE = MOVING_SHOT.replace("startTimeCode = 1", "").replace("endTimeCode = 4", "")


def test_frames_of_a_stage_without_a_range_may_be_split(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, NO_RANGE)
    whole = render(shot, tmp_path / "a", "-f", "1:4")
    assert render(shot, tmp_path / "b", "-f", "4") == whole[3:]


def test_a_camera_broken_at_the_start_alone(tmp_path: Path) -> None:
    shot = write_stage(tmp_path, MOVING_SHOT.replace("1: (0, 1, 8)", "1: (nan, 1, 8)"))
    render(shot, tmp_path / "a", "-f", "2")
    assert spec_of(tmp_path / "a" / "b.0002.exr")["irt:renderOrigin"] == "0.0 1.0 8.0"
    assert "/Cam.xformOp:translate" in failure("render", shot, "-o", str(tmp_path / "c.#.exr"))


def test_one_frame_that_exists(shot: str, tmp_path: Path) -> None:
    render(shot, tmp_path / "a", "-f", "2")
    pattern = str(tmp_path / "a" / "b.####.exr")
    result = irt("render", shot, *SIZE, "-o", pattern, "--skip-existing", "-f", "2:3")
    assert "1 frame exists already and is skipped" in result.output
    assert "done: 1 frame in" in result.output


def test_opening_options_show_in_the_header(shot: str, tmp_path: Path) -> None:
    text = '#usda 1.0\nover "Ball"\n{\n double radius = 2\n}\n'
    options = ["--session-layer", write_stage(tmp_path, text, "s.usda"), "--camera", "/Cam"]
    options += ["--mask", "/Ball, /Lamp", "--purposes", "proxy", "--missing-asset", "warn"]
    render(shot, tmp_path / "o", "-f", "1", *options)
    spec = spec_of(tmp_path / "o" / "b.0001.exr")
    assert spec["irt:sessionLayer"] == "s.usda"
    assert spec["irt:mask"] == "/Ball /Lamp"
    assert spec["irt:purposes"] == "default proxy"
    assert spec["irt:missingAsset"] == "warn"


def test_opening_options_reach_every_command(shot: str, tmp_path: Path) -> None:
    missing = write_stage(tmp_path, "#usda 1.0\n(\n subLayers = [@gone.usda@]\n)\n", "s.usda")
    for command in ("render", "verify", "changes"):
        assert "gone.usda" in failure(command, shot, "--session-layer", missing)


@pytest.mark.parametrize(
    "options", [("--purposes", "all"), ("--mask", ","), ("--missing-asset", "ignore")]
)
def test_opening_options_that_are_wrong(shot: str, options: tuple[str, ...]) -> None:
    assert options[0] in failure("changes", shot, *options)
