# SPDX-License-Identifier: Apache-2.0
"""Cameras: which one, what it sees, how large the image is."""

import numpy as np
import pytest
from pxr import UsdGeom

from conftest import MakeShot, ReadShot
from irt_usd.errors import InputError
from irt_usd.stage import ReadOptions, list_cameras

LENS = """
float focalLength = 35
float horizontalAperture = 24
float verticalAperture = 18
float horizontalApertureOffset = 2
float verticalApertureOffset = -1
"""
SQUARE = ReadOptions(size=(400, 300))


def camera(body: str, name: str = "cam") -> str:
    return f'def Camera "{name}"\n{{\n{body}\n}}\n'


def window_of_usd(made: ReadShot) -> tuple[float, float, float, float]:
    prim = made.stage.GetPrimAtPath("/cam")
    frustum = UsdGeom.Camera(prim).GetCamera(1).frustum
    low, high = frustum.window.min, frustum.window.max
    return low[0], high[0], low[1], high[1]


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
def test_window_is_usds_where_the_aspects_agree(shot: MakeShot, projection: str) -> None:
    made = shot(camera(f'{LENS}token projection = "{projection}"'), options=SQUARE)
    state = made.read().camera
    assert state.orthographic == (projection == "orthographic")
    assert state.window == pytest.approx(window_of_usd(made), rel=1e-6)


def test_window_keeps_the_horizontal_aperture(shot: MakeShot) -> None:
    wide = shot(camera(LENS), options=ReadOptions(size=(400, 100))).read().camera.window
    square = shot(camera(LENS), options=SQUARE).read().camera.window
    assert wide[:2] == square[:2]
    assert wide[3] - wide[2] == pytest.approx((square[3] - square[2]) / 3)
    assert wide[2] + wide[3] == pytest.approx(square[2] + square[3])


def test_default_size_has_the_cameras_aspect(shot: MakeShot) -> None:
    assert shot(camera(LENS)).reader.views[0].framing.size == (960, 720)
    assert shot(camera("")).reader.views[0].framing.size == (960, 700)


SETTINGS = """
def RenderSettings "R"
{
uniform int2 resolution = (64, 48)
rel camera = </b>
}
"""


def test_render_settings(shot: MakeShot) -> None:
    cameras = camera("", "a") + camera("", "b")
    made = shot(cameras + SETTINGS, metadata='renderSettingsPrimPath = "/R"')
    assert made.reader.views[0].framing.size == (64, 48)
    assert made.reader.views[0].camera == "/b"
    named = ReadOptions(camera="a", size=(8, 8))
    made = shot(cameras + SETTINGS, metadata='renderSettingsPrimPath = "/R"', options=named)
    assert made.reader.views[0].framing.size == (8, 8)
    assert made.reader.views[0].camera == "/a"


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10, 10**6)])
def test_impossible_sizes(shot: MakeShot, size: tuple[int, int]) -> None:
    with pytest.raises(InputError, match=f"{size[0]}x{size[1]} pixels"):
        shot("", options=ReadOptions(size=size))


def with_settings(lines: str) -> str:
    return f'def RenderSettings "R"\n{{\n{lines}\n}}\n'


AUTHORED = 'renderSettingsPrimPath = "/R"'


@pytest.mark.parametrize(
    ("body", "what"),
    [
        (with_settings("uniform int2 resolution = (0, 10)"), "resolution: an image of 0x10"),
        (camera("float verticalAperture = 1e30"), "the apertures of /cam: an image of 960x"),
    ],
)
def test_impossible_sizes_of_the_stage(shot: MakeShot, body: str, what: str) -> None:
    with pytest.raises(InputError, match=what):
        shot(body, metadata=AUTHORED)


@pytest.mark.parametrize(
    ("line", "severity"),
    [
        ('string resolution = "large"', "skipped"),
        ("float dataWindowNDC = 1", "skipped"),
        ('token pixelAspectRatio = "wide"', "skipped"),
    ],
)
def test_render_settings_that_are_not_followed(shot: MakeShot, line: str, severity: str) -> None:
    made = shot(with_settings(line), metadata=AUTHORED, options=SQUARE)
    assert "/R" in "".join(made.notices(severity))


def test_blocked_render_settings(shot: MakeShot) -> None:
    lines = "uniform int2 resolution = None\nuniform float4 dataWindowNDC = None"
    made = shot(with_settings(lines), metadata=AUTHORED)
    assert made.reader.views[0].framing.size[0] == 960
    assert not any("/R" in notice.text for notice in made.report.notices)


def test_render_settings_that_are_not_there(shot: MakeShot) -> None:
    made = shot("", metadata=AUTHORED)
    assert "renderSettingsPrimPath" in "".join(made.notices("skipped"))


TWO = camera("", "a") + 'def Xform "G"\n{\n' + camera("", "a") + camera("", "b") + "}\n"


def test_choosing(shot: MakeShot) -> None:
    assert shot(TWO, options=ReadOptions(camera="b")).reader.views[0].camera == "/G/b"
    assert shot(TWO, options=ReadOptions(camera="/a")).reader.views[0].camera == "/a"
    assert list_cameras(shot(TWO, options=ReadOptions(camera="b")).stage) == ["/a", "/G/a", "/G/b"]
    assert shot(camera("", "only")).reader.views[0].camera == "/only"


@pytest.mark.parametrize(
    ("wanted", "what"),
    [(None, "several cameras"), ("a", "several cameras are named 'a'"), ("c", "no camera 'c'")],
)
def test_choice_that_names_none_or_several(shot: MakeShot, wanted: str | None, what: str) -> None:
    with pytest.raises(InputError, match=what) as refused:
        shot(TWO, options=ReadOptions(camera=wanted))
    assert "/G/b" in str(refused.value)
    assert "shot.usda" in str(refused.value)


def test_no_camera(shot: MakeShot) -> None:
    with pytest.raises(InputError, match="no camera"):
        shot("# not a def Camera")


@pytest.mark.parametrize(
    "line",
    [
        "float focalLength = 0",
        "float focalLength = nan",
        "float horizontalAperture = 0",
        "float horizontalAperture = -1",
        "float verticalApertureOffset = inf",
        'token projection = "fisheye"',
        'float3 xformOp:scale = (1, 0, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]',
        'float3 xformOp:scale = (1, nan, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]',
    ],
)
def test_camera_that_shows_nothing(shot: MakeShot, line: str) -> None:
    with pytest.raises(InputError) as refused:
        shot(camera(line), options=SQUARE).read()
    assert "/cam." + line.split(" = ")[0].split(" ")[1] in str(refused.value)
    assert "shot.usda" in str(refused.value)


def test_moves(shot: MakeShot) -> None:
    keys = "double3 xformOp:translate.timeSamples = {1: (0,0,9), 3: (0,0,9), 5: (0,0,8)}\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    made = shot(camera(keys + order), frames=(1, 2, 3, 4, 5, 6))
    assert made.reader.camera_moves == [[4, 5]]
    assert made.read(1).camera is not made.read(5).camera
    assert made.read(5).camera is made.read(6).camera
    assert made.read(5).camera.world_from_camera[3].tolist() == [0, 0, 8, 1]


def test_zoom_is_a_move_and_a_moved_parent_is(shot: MakeShot) -> None:
    zoom = "float focalLength.timeSamples = {1: 50, 2: 60}"
    assert shot(camera(zoom), frames=(1, 2, 3)).reader.camera_moves == [[2]]
    rig = 'def Xform "rig"\n{\nfloat xformOp:rotateY.timeSamples = {1: 0, 2: 9}\n'
    order = 'uniform token[] xformOpOrder = ["xformOp:rotateY"]\n'
    assert shot(rig + order + camera("") + "}", frames=(1, 2, 3)).reader.camera_moves == [[2]]


def test_finding_moves_leaves_other_prims_alone(shot: MakeShot) -> None:
    keys = "double3 xformOp:translate.timeSamples = {1: (1,0,0), 2: (2,0,0)}\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
    inner = camera("") + 'def Xform "G"\n{\ndef Sphere "S"\n{\n}\n}\n'
    made = shot(f'def Xform "rig"\n{{\n{keys}{order}{inner}}}', frames=(1, 2))
    assert made.reader.camera_moves == [[2]]
    assert made.read(2).objects["/rig/G/S"].world_from_object[3, 0] == 2
    assert made.read(1).objects["/rig/G/S"].world_from_object[3, 0] == 1


def test_locked_camera_does_not_move(shot: MakeShot) -> None:
    focus = "float focusDistance.timeSamples = {1: 5, 2: 6}\nfloat fStop = 0"
    made = shot(camera(focus), frames=(1, 2, 3))
    assert made.reader.camera_moves == [[]]


@pytest.mark.parametrize(
    ("line", "what", "severity"),
    [
        ("float4[] clippingPlanes = [(1, 0, 0, 0)]", "clippingPlanes", "unsupported"),
        ("float fStop = 2.8", "depth of field", "unsupported"),
        ("double shutter:close = 0.5", "motion blur", "mentioned"),
        ("", "", ""),
    ],
)
def test_what_a_camera_does_not_get(shot: MakeShot, line: str, what: str, severity: str) -> None:
    made = shot(camera(line))
    texts = [t for s in ("unsupported", "mentioned") for t in made.notices(s) if "/cam" in t]
    if not what:
        assert not texts
        return
    assert len(texts) == 1
    assert what in made.notices(severity)[0 if severity == "unsupported" else -2]


def test_core_record(shot: MakeShot) -> None:
    from irt_usd import _core as core

    state = shot(camera(LENS)).read().camera
    assert isinstance(state.core(), core.Camera)
    assert not np.asarray(state.world_from_camera).flags.writeable
