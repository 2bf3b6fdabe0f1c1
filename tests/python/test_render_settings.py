# SPDX-License-Identifier: Apache-2.0
"""UsdRender: settings, products and vars; framing; what options win over."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from cli_support import CAMERA, LAMP, SCENE, SIDE_CAMERA, failure, irt, stage_of, write_stage
from conftest import MakeShot
from irt_usd.images.exr import read_beauty
from irt_usd.stage import ReadOptions
from irt_usd.stage.framing import Framing

EXPOSED = CAMERA.replace(
    "float focalLength = 35",
    "float focalLength = 35\n    float exposure.timeSamples = {1: 0, 3: 0, 4: 2}",
)


def settings(body: str, *prims: str) -> str:
    inner = "\n".join(prims)
    return f'def RenderSettings "S"\n{{\n{body}\n}}\ndef Scope "Render"\n{{\n{inner}\n}}\n'


def product(name: str, *lines: str) -> str:
    body = "\n".join(lines)
    return f'def RenderProduct "{name}"\n{{\n{body}\n}}\n'


def var(name: str, source: str, kind: str = "raw") -> str:
    return (
        f'def RenderVar "{name}"\n{{\nstring sourceName = "{source}"\n'
        f'uniform token sourceType = "{kind}"\n}}\n'
    )


def stage(folder: Path, *parts: str) -> str:
    text = stage_of(*parts)
    return write_stage(folder, text.replace('upAxis = "Y"', 'upAxis = "Y"\n'
                       '    renderSettingsPrimPath = "/S"'))  # fmt: skip


def spec(path: Path) -> Any:
    image = oiio.ImageInput.open(str(path))
    assert image is not None, path
    return image.spec()


def test_three_products_render_over_one_scene(tmp_path: Path) -> None:
    out = tmp_path / "out"
    products = settings(
        "uniform int2 resolution = (40, 30)\nrel camera = </Cam>\n"
        "rel products = [</Render/A>, </Render/B>, </Render/C>]",
        product("A", f'token productName = "{out}/a.####.exr"',
                "rel orderedVars = [</Render/color>, </Render/Z>, </Render/N>]"),
        product("B", "rel camera = </Side>", "uniform int2 resolution = (24, 24)",
                f'token productName = "{out}/b.$F2.exr"'),
        product("C", f'token productName.timeSamples = {{1: "{out}/one.exr", 2: "{out}/two.exr",'
                f' 3: "{out}/three.exr", 4: "{out}/four.exr"}}',
                "rel orderedVars = [</Render/color>, </Render/ids>]"),
        var("color", "color"), var("Z", "depth"), var("N", "Neye"), var("ids", "primId"),
    )  # fmt: skip
    path = stage(tmp_path, EXPOSED, SIDE_CAMERA, SCENE, LAMP, products)
    result = irt("render", path)
    assert result.exit_code == 0, result.output
    names = sorted(file.name for file in out.iterdir())
    assert names == sorted(
        [*(f"a.000{n}.exr" for n in (1, 2, 3, 4)), *(f"b.0{n}.exr" for n in (1, 2, 3, 4)),
         "one.exr", "two.exr", "three.exr", "four.exr"]
    )  # fmt: skip
    assert spec(out / "a.0001.exr").channelnames == ("R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z")
    assert spec(out / "b.01.exr").width == 24
    verified = irt("verify", path)
    assert verified.exit_code == 0, verified.output

    alone = tmp_path / "alone.####.exr"
    for label, file in (("A", "a.0004.exr"), ("B", "b.04.exr")):
        size, camera = ("24x24", "/Side") if label == "B" else ("40x30", "/Cam")
        given = ("--size", size, "-c", camera, "-o", str(alone), "--strict", "-f", "1:4")
        single = stage_of(EXPOSED, SIDE_CAMERA, SCENE, LAMP)
        assert irt("render", write_stage(tmp_path, single, "s.usda"), *given).exit_code == 0
        ours, theirs = read_beauty(out / file), read_beauty(tmp_path / "alone.0004.exr")
        # Another camera is another render origin.
        np.testing.assert_allclose(ours, theirs, atol=0 if label == "A" else 2e-2)


def test_exposure_multiplies_what_is_written_and_traces_nothing(tmp_path: Path) -> None:
    still = SCENE.replace("3: (0.5, 1, 0)", "3: (1, 1, 0)")
    lamp = LAMP.replace("4: 30", "4: 60")
    path = write_stage(tmp_path, stage_of(EXPOSED, still, lamp))
    stats = tmp_path / "s.jsonl"
    out = str(tmp_path / "f.#.exr")
    result = irt("render", path, "--size", "48x27", "-f", "3:4", "-o", out, "--stats", str(stats),
                 "--exr-type", "float")  # fmt: skip
    assert result.exit_code == 0, result.output
    before, after = (read_beauty(tmp_path / f"f.{n}.exr") for n in (3, 4))
    np.testing.assert_array_equal(after, before * np.float32(4))
    import json

    frame = json.loads(stats.read_text().splitlines()[1])
    assert frame["restart"] is None
    assert sum(frame["rays"].values()) == frame["shadings"] == 0
    assert spec(tmp_path / "f.4.exr").getattribute("irt:exposureScale") == 4
    listed = irt("changes", path, "-f", "3:4").output
    assert "exposure: 0.0 -> 2.0  [what is written (no rays)]" in listed


@pytest.mark.parametrize(
    ("window", "start", "size"),
    [
        ("0.25,0.5,1,1", (12, 0), (36, 14)),
        ("0,0,0.5,0.5", (0, 14), (24, 13)),
        ("-0.1,-0.2,1.1,1.2", (-5, -5), (58, 37)),
    ],
)
def test_region_is_a_crop_of_the_whole(
    tmp_path: Path, window: str, start: tuple[int, int], size: tuple[int, int]
) -> None:
    path = write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP))
    for name, region in (("whole", "-0.5,-0.5,1.5,1.5"), ("part", window)):
        out = str(tmp_path / f"{name}.exr")
        arguments = ("--size", "48x27", "--region", region, "-f", "1", "-o", out)
        assert irt("render", path, *arguments).exit_code == 0
    part = spec(tmp_path / "part.exr")
    assert ((part.x, part.y), (part.width, part.height)) == (start, size)
    assert (part.full_x, part.full_y, part.full_width, part.full_height) == (0, 0, 48, 27)
    whole = spec(tmp_path / "whole.exr")
    x, y = start[0] - whole.x, start[1] - whole.y
    cropped = read_beauty(tmp_path / "whole.exr")[y : y + size[1], x : x + size[0]]
    assert np.array_equal(cropped, read_beauty(tmp_path / "part.exr"))


def test_windows_that_share_an_edge_share_no_pixel() -> None:
    left = Framing((33, 7), (0, 0, 0.4, 1))
    right = Framing((33, 7), (0.4, 0, 1, 1))
    assert left.start == (0, 0)
    assert left.size[0] + right.size[0] == 33
    assert right.start[0] == left.size[0]


@pytest.mark.parametrize(
    ("policy", "aperture", "pixel"),
    [
        ("expandAperture", (3.0, 1.0), 1.0),
        ("cropAperture", (2.0, 2 / 3), 1.0),
        ("adjustApertureWidth", (3.0, 1.0), 1.0),
        ("adjustApertureHeight", (2.0, 2 / 3), 1.0),
        ("adjustPixelAspectRatio", (2.0, 1.0), 2 / 3),
    ],
)
def test_conform_policies(policy: str, aperture: tuple[float, float], pixel: float) -> None:
    """A 2:1 aperture for a 3:1 image, and the other way round."""
    found, aspect = Framing((300, 100), policy=policy).conform((2.0, 1.0))
    assert found == pytest.approx(aperture)
    assert aspect == pytest.approx(pixel)
    width, height = found
    assert width / height == pytest.approx(3 * aspect)
    tall, _ = Framing((100, 100), policy=policy).conform((2.0, 1.0))
    expected = {"expandAperture": (2, 2), "cropAperture": (1, 1), "adjustApertureWidth": (1, 1),
                "adjustApertureHeight": (2, 2), "adjustPixelAspectRatio": (2, 1)}  # fmt: skip
    assert tall == pytest.approx(expected[policy])


def test_wide_pixels_show_a_wider_picture(shot: MakeShot) -> None:
    body = settings("uniform int2 resolution = (100, 100)\nuniform float pixelAspectRatio = 2\n"
                    'uniform token aspectRatioConformPolicy = "adjustApertureWidth"')  # fmt: skip
    state = shot(body, metadata='renderSettingsPrimPath = "/S"').read().camera
    left, right, bottom, top = state.window
    assert (right - left) / (top - bottom) == pytest.approx(2)
    assert state.pixel_aspect == 2


def test_product_overrides_settings_and_options_override_both(shot: MakeShot) -> None:
    body = settings(
        "uniform int2 resolution = (64, 48)\nrel products = [</Render/A>]\nrel camera = </cam>",
        product("A", "uniform int2 resolution = (32, 16)", "rel camera = </other>"),
    )
    cameras = 'def Camera "cam"\n{\n}\ndef Camera "other"\n{\n}\n'
    made = shot(cameras + body, metadata='renderSettingsPrimPath = "/S"')
    assert made.reader.views[0].framing.frame == (32, 16)
    assert made.reader.views[0].camera == "/other"
    given = ReadOptions(camera="cam", size=(8, 4), data_window=(0, 0, 0.5, 1))
    made = shot(cameras + body, metadata='renderSettingsPrimPath = "/S"', options=given)
    assert made.reader.views[0].framing.frame == (8, 4)
    assert made.reader.views[0].framing.size == (4, 4)
    assert made.reader.views[0].camera == "/cam"


def test_settings_by_name(shot: MakeShot) -> None:
    other = 'def RenderSettings "Other"\n{\nuniform int2 resolution = (12, 10)\n}\n'
    made = shot(other, options=ReadOptions(settings="Other"))
    assert made.reader.views[0].framing.frame == (12, 10)


def test_locked_camera_stands_still(tmp_path: Path) -> None:
    drifting = CAMERA.replace(
        "xformOp:translate = (0, 1, 8)", "xformOp:translate.timeSamples = {1: (0,1,8), 4: (1,1,8)}"
    )
    path = write_stage(tmp_path, stage_of(drifting, SCENE, LAMP))
    out = str(tmp_path / "f.#.exr")
    given = ("--size", "48x27", "--lock-camera", "1", "--require-locked", "-o", out)
    assert irt("render", path, *given).exit_code == 0
    still = write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP), "still.usda")
    assert irt("render", still, "--size", "48x27", "-o", str(tmp_path / "g.#.exr")).exit_code == 0
    for n in (1, 4):
        ours, theirs = read_beauty(tmp_path / f"f.{n}.exr"), read_beauty(tmp_path / f"g.{n}.exr")
        assert np.array_equal(ours, theirs)
    assert irt("verify", path, "--size", "48x27", "--lock-camera", "1").exit_code == 0


def test_settings_without_products_still_write_an_image(tmp_path: Path) -> None:
    path = stage(tmp_path, CAMERA, SCENE, LAMP, settings("uniform int2 resolution = (16, 9)"))
    assert irt("render", path, "-f", "1", "-o", str(tmp_path / "f.exr")).exit_code == 0
    assert spec(tmp_path / "f.exr").width == 16


def test_binding_purpose(shot: MakeShot) -> None:
    materials = "".join(
        f'def Material "{name}"\n{{\ntoken outputs:surface.connect = <shader.outputs:surface>\n'
        'def Shader "shader"\n{\nuniform token info:id = "UsdPreviewSurface"\n'
        "token outputs:surface\n}\n}\n"
        for name in ("full", "preview")
    )
    ball = ('def Sphere "Ball" (prepend apiSchemas = ["MaterialBindingAPI"])\n{\n'
            "rel material:binding:full = </full>\n"
            "rel material:binding:preview = </preview>\n}\n")  # fmt: skip
    body = materials + ball + settings('uniform token[] materialBindingPurposes = ["preview", ""]')
    assert shot(body, name="b.usda").read().objects["/Ball"].material == "/full"
    made = shot(body, metadata='renderSettingsPrimPath = "/S"')
    assert made.read().objects["/Ball"].material == "/preview"


def test_motion_blur_that_is_not_wanted_is_not_missed(shot: MakeShot) -> None:
    lens = 'def Camera "cam"\n{\nfloat shutter:close = 0.5\nfloat fStop = 2.8\n}\n'
    body = lens + settings(
        "uniform bool disableMotionBlur = 1\nuniform bool disableDepthOfField = 1"
    )
    made = shot(body, metadata='renderSettingsPrimPath = "/S"')
    assert not any("/cam" in notice.text for notice in made.report.notices)
    assert any("/cam" in notice.text for notice in shot(lens, name="b.usda").report.notices)


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ("uniform float pixelAspectRatio = 0", "pixelAspectRatio is 0.0; expected a positive"),
        ('uniform token aspectRatioConformPolicy = "squash"', "expected one of expandAperture"),
        ("uniform float4 dataWindowNDC = (1, 0, 0, 1)", "expected left, bottom, right, top"),
        ("uniform float4 dataWindowNDC = (0.5001, 0, 0.5002, 1)", "holds no pixel's centre"),
        ("rel camera = </Nowhere>", "no camera </Nowhere>"),
        ("rel camera = </Ball>", "the target of /S.camera"),
        ("uniform int2 resolution = (0, 10)", "an image of 0x10 pixels"),
    ],
)
def test_settings_that_show_nothing_are_refused(tmp_path: Path, body: str, what: str) -> None:
    path = stage(tmp_path, CAMERA, SCENE, LAMP, settings(body))
    message = failure("render", path, "-o", str(tmp_path / "f.####.exr"))
    assert what in message
    assert "/S" in message or "resolution" in message


def test_a_var_of_no_type_is_written_all_the_same(shot: MakeShot) -> None:
    body = settings("rel products = </Render/A>", product("A", "rel orderedVars = </Render/z>"))
    odd = 'def RenderVar "z"\n{\nstring sourceName = "depth"\nuniform token dataType = "film"\n}\n'
    body = body.replace('def RenderProduct "A"', odd + 'def RenderProduct "A"')
    made = shot(body, metadata='renderSettingsPrimPath = "/S"')
    (notice,) = made.notices("skipped")
    assert "dataType is film; expected a type such as color3f" in notice
    assert [v.source for v in made.reader.views[0].product.variables] == ["depth"]


def test_a_camera_given_stands_for_one_that_is_not_there(tmp_path: Path) -> None:
    path = stage(tmp_path, CAMERA, SCENE, LAMP, settings("rel camera = </Nowhere>"))
    given = ("-c", "Cam", "--dry-run", "-f", "1")
    assert irt("render", path, *given).exit_code == 0


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ('uniform token[] includedPurposes = ["render", "most"]', "includedPurposes holds 'most'"),
        ('uniform token[] materialBindingPurposes = ["best"]', "Purposes holds 'best'"),
        ("rel camera = [</cam>, </other>]", "more than one camera, the first is rendered"),
        ("rel products = </cam>", "a render product that does not exist: </cam>"),
    ],
)
def test_settings_that_are_partly_read(shot: MakeShot, body: str, what: str) -> None:
    cameras = 'def Camera "cam"\n{\n}\ndef Camera "other"\n{\n}\n'
    body = body if "camera" in body else f"rel camera = </cam>\n{body}"
    made = shot(cameras + settings(body), metadata='renderSettingsPrimPath = "/S"')
    made.read()
    (notice,) = made.notices("skipped")
    assert what in notice
    assert "/S." in notice


@pytest.mark.parametrize(
    ("lines", "what"),
    [
        ('string sourceName = "depth"\nuniform token sourceType = "film"', "sourceType is film"),
        ('string sourceName = "normal"\nstring driver:parameters:aov:name = "z"', "layer z"),
    ],
)
def test_vars_that_are_left_out(shot: MakeShot, lines: str, what: str) -> None:
    body = settings(
        "rel products = </Render/A>",
        product("A", "rel orderedVars = [</Render/z>, </Render/x>]"),
        var("z", "depth"),
        f'def RenderVar "x"\n{{\n{lines}\n}}\n',
    )
    made = shot(body, metadata='renderSettingsPrimPath = "/S"')
    (notice,) = made.notices("skipped")
    assert what in notice
    assert "/Render/x" in notice
    assert [v.path for v in made.reader.views[0].product.variables] == ["/Render/z"]


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("--settings", "/Nope"), "no RenderSettings '/Nope'"),
        (("--region", "0,0,1"), "expected left,bottom,right,top"),
        (("--region", "1,0,0,1"), "left must be below right"),
        (("--lock-camera", "1:3"), "expected one frame"),
    ],
)
def test_options_that_show_nothing_are_refused(
    tmp_path: Path, arguments: tuple[str, ...], what: str
) -> None:
    path = stage(tmp_path, CAMERA, SCENE, LAMP, settings(""))
    message = failure("render", path, "-o", str(tmp_path / "f.####.exr"), *arguments)
    assert what in message


def two_products(name_a: str, name_b: str) -> str:
    return settings(
        "uniform int2 resolution = (8, 8)\nrel products = [</Render/A>, </Render/B>]",
        product("A", name_a),
        product("B", name_b),
    )


def test_products_that_would_share_a_file_are_refused(tmp_path: Path) -> None:
    name = f'token productName = "{tmp_path}/x.####.exr"'
    path = stage(tmp_path, CAMERA, SCENE, LAMP, two_products(name, name))
    message = failure("render", path)
    assert "/Render/A" in message
    assert "/Render/B" in message
    constant = f'token productName = "{tmp_path}/x.exr"'
    path = stage(tmp_path, CAMERA, SCENE, LAMP, two_products(constant, name))
    message = failure("render", path)
    assert "productName" in message
    assert "no frame token" in message


def test_output_for_several_products_names_them(tmp_path: Path) -> None:
    path = stage(tmp_path, CAMERA, SCENE, LAMP, two_products("", ""))
    assert "<product>" in failure("render", path, "-o", str(tmp_path / "x.####.exr"))
    result = irt("render", path, "-f", "1", "-o", str(tmp_path / "<product>.exr"))
    assert result.exit_code == 0, result.output
    assert (tmp_path / "A.exr").exists()
    assert (tmp_path / "B.exr").exists()


def test_what_is_dangling_or_unknown_is_reported(tmp_path: Path) -> None:
    body = settings(
        "rel products = [</Render/A>, </Render/Gone>]\nuniform int2 resolution = (8, 8)",
        product("A", "rel orderedVars = [</Render/x>, </Render/Missing>]",
                f'token productName = "{tmp_path}/x.####.exr"'),
        var("x", "curvature"),
    )  # fmt: skip
    result = irt("render", stage(tmp_path, CAMERA, SCENE, LAMP, body))
    assert result.exit_code == 0, result.output
    assert "a render product that does not exist: </Render/Gone>" in result.stderr
    assert "a render var that does not exist: </Render/Missing>" in result.stderr
    assert "render vars of raw source 'curvature'" in result.stderr


def test_clipping_range(shot: MakeShot) -> None:
    lens = 'def Camera "cam"\n{\nfloat2 clippingRange = (2, 20)\n}\n'
    assert shot(lens).read().camera.clipping == (2, 20)
    assert shot("", name="b.usda").read().camera.clipping == (0, np.inf)
