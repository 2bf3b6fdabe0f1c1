# SPDX-License-Identifier: Apache-2.0
"""Lights: UsdLux's units as a delta light's, and what of a light is not rendered."""

from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from conftest import MakeShot, ReadShot
from irt_usd import _core
from irt_usd.choices import MISSING_ASSET
from irt_usd.errors import InputError
from irt_usd.stage import LightState, ReadOptions
from irt_usd.stage.lights import CAMERA_LIGHT

UNIT = "float inputs:intensity = 1\n"
OPS = 'uniform token[] xformOpOrder = ["xformOp:{}"]\n'


def light(kind: str, body: str, schemas: str = "") -> str:
    metadata = f'(\nprepend apiSchemas = ["{schemas}"]\n)' if schemas else ""
    return f'def {kind} "L" {metadata}\n{{\n{body}\n}}'


def lit(made: ReadShot, time: float = 1) -> LightState:
    return made.read(time).lights["/L"]


def energy(made: ReadShot) -> float:
    red, green, blue = lit(made).energy
    assert red == green == blue
    return red


@pytest.mark.parametrize("angle", [0.53, 30, 180])
def test_distant_irradiance(shot: MakeShot, angle: float) -> None:
    made = shot(light("DistantLight", f"{UNIT}float inputs:angle = {angle}"))
    assert energy(made) == pytest.approx(pi * sin(radians(angle) / 2) ** 2)


def test_distant_irradiance_is_the_integral_over_its_disk(shot: MakeShot) -> None:
    half = radians(20)
    steps = 4000
    width = half / steps
    angles = [(i + 0.5) * width for i in range(steps)]
    integral = sum(2 * pi * cos(a) * sin(a) * width for a in angles)
    made = shot(light("DistantLight", f"{UNIT}float inputs:angle = 40"))
    assert energy(made) == pytest.approx(integral, rel=1e-6)


@pytest.mark.parametrize(
    ("angle", "normalize", "expected"),
    [
        (0, 0, 1),
        (0, 1, 1),
        (0.53, 1, 1),
        (180, 1, 1),
        (270, 0, pi),
        (270, 1, 1 / 1.5),
        (720, 1, 0.5),
    ],
)
def test_distant_normalize(shot: MakeShot, angle: float, normalize: int, expected: float) -> None:
    body = f"{UNIT}float inputs:angle = {angle}\nbool inputs:normalize = {normalize}"
    assert energy(shot(light("DistantLight", body))) == pytest.approx(expected)


def test_distant_default_intensity_is_the_suns(shot: MakeShot) -> None:
    made = shot(light("DistantLight", "bool inputs:normalize = 1"))
    assert energy(made) == 50000


def test_distant_direction(shot: MakeShot) -> None:
    assert lit(shot(light("DistantLight", UNIT))).aim == (0, 0, -1)
    body = UNIT + "float xformOp:rotateY = 90\n" + OPS.format("rotateY")
    assert lit(shot(light("DistantLight", body))).aim == pytest.approx((-1, 0, 0))


@pytest.mark.parametrize(("radius", "scale"), [(0.5, 1), (0.5, 4), (2, 0.25)])
def test_sphere_intensity(shot: MakeShot, radius: float, scale: float) -> None:
    ops = f"float3 xformOp:scale = ({scale}, {scale}, {scale})\n" + OPS.format("scale")
    body = f"{UNIT}float inputs:radius = {radius}\n{ops}"
    assert energy(shot(light("SphereLight", body))) == pytest.approx(pi * (radius * scale) ** 2)
    normal = body + "bool inputs:normalize = 1"
    assert energy(shot(light("SphereLight", normal))) == 0.25


def test_sphere_position(shot: MakeShot) -> None:
    ops = "double3 xformOp:translate = (1, 2, 3)\n" + OPS.format("translate")
    state = lit(shot(light("SphereLight", UNIT + ops)))
    assert state.kind == "point"
    assert state.aim == (1, 2, 3)


def test_turning_a_sphere_light_is_no_change_of_energy(shot: MakeShot) -> None:
    ops = "float3 xformOp:rotateXYZ.timeSamples = {1: (0,0,0), 30: (77,123,45)}\n"
    made = shot(light("SphereLight", UNIT + ops + OPS.format("rotateXYZ")))
    assert len({lit(made, t).energy for t in range(1, 31)}) == 1


def test_zero_radius_is_mentioned(shot: MakeShot) -> None:
    made = shot(light("SphereLight", UNIT + "float inputs:radius = 0\nbool treatAsPoint = 1"))
    assert energy(made) == 0
    assert any("unless normalized" in text for text in made.notices("mentioned"))


def test_exposure_colour_and_temperature(shot: MakeShot) -> None:
    body = """
float inputs:intensity = 3
float inputs:exposure = 2
color3f inputs:color = (0.5, 1, 2)
bool inputs:enableColorTemperature = 1
float inputs:colorTemperature = 3000
bool inputs:normalize = 1
"""
    found = lit(shot(light("DistantLight", body))).energy
    tint = UsdLux.BlackbodyTemperatureAsRgb(3000)
    assert found == pytest.approx((6 * tint[0], 12 * tint[1], 24 * tint[2]))
    off = body.replace("enableColorTemperature = 1", "enableColorTemperature = 0")
    assert lit(shot(light("DistantLight", off))).energy == (6, 12, 24)


def test_shadow_enable(shot: MakeShot) -> None:
    assert lit(shot(light("SphereLight", UNIT))).casts_shadows
    off = light("SphereLight", UNIT + "bool inputs:shadow:enable = 0", "ShadowAPI")
    assert not lit(shot(off)).casts_shadows


@pytest.mark.parametrize(
    ("kind", "schema", "line"),
    [
        ("DistantLight", "ShapingAPI", "float inputs:shaping:cone:angle = 90"),
        ("DistantLight", "", "asset inputs:shaping:ies:file = @a.ies@"),
        ("DistantLight", "", "float inputs:shaping:focus = 2"),
        ("DomeLight", "ShapingAPI", "float inputs:shaping:cone:angle = 20"),
        ("DomeLight", "", "rel portals = </P>"),
        (
            "DomeLight_1",
            "",
            'token inputs:texture:format = "angular"\nasset inputs:texture:file = @a@',
        ),
        ("SphereLight", "", "rel light:filters = </F>"),
    ],
)
def test_what_is_not_rendered_is_reported(
    shot: MakeShot, kind: str, schema: str, line: str
) -> None:
    made = shot(light(kind, UNIT + line, schema))
    assert lit(made)
    (text,) = made.notices("unsupported")
    assert text.endswith(": /L")


@pytest.mark.parametrize("kind", ["DistantLight", "DomeLight"])
def test_shaping_that_says_nothing_is_not_reported(shot: MakeShot, kind: str) -> None:
    lines = "float inputs:shaping:cone:angle = 180\nfloat inputs:shaping:focus\n"
    made = shot(light(kind, UNIT + lines + "asset inputs:shaping:ies:file", "ShapingAPI"))
    assert lit(made)
    assert not made.notices("unsupported")


@pytest.mark.parametrize(
    "line",
    ["float inputs:intensity = nan", "float inputs:exposure = inf", "float inputs:radius = -1"],
)
def test_unusable_light(shot: MakeShot, line: str) -> None:
    made = shot(light("SphereLight", line))
    assert not made.read().lights
    (text,) = made.notices("skipped")
    assert "/L.inputs:" in text
    assert "shot.usda" in text


@pytest.mark.parametrize(
    "line",
    [
        'string inputs:intensity = "bright"',
        "color3f[] inputs:color = [(1, 1, 1)]",
        "double inputs:normalize = 1",
        "float2 inputs:color = (1, 1)",
    ],
)
def test_wrong_type_means_the_fallback_and_is_located(shot: MakeShot, line: str) -> None:
    made = shot(light("SphereLight", line))
    assert lit(made).energy == pytest.approx((pi / 4,) * 3)
    (text,) = made.notices("skipped")
    assert "/L.inputs:" in text


@pytest.mark.parametrize("exposure", [200, 5000])
def test_too_bright(shot: MakeShot, exposure: int) -> None:
    made = shot(light("SphereLight", f"{UNIT}float inputs:exposure = {exposure}"))
    assert not made.read().lights
    assert "single precision" in made.notices("skipped")[0]


def test_unusable_transform(shot: MakeShot) -> None:
    ops = "float3 xformOp:scale = (1, 1, {})\n" + OPS.format("scale")
    for value in ("nan", "0"):
        made = shot(light("DistantLight", UNIT + ops.format(value)))
        assert not made.read().lights
        assert "/L.xformOp:scale in " in made.notices("skipped")[0]


def test_visibility_of_lights(shot: MakeShot) -> None:
    keys = 'token visibility.timeSamples = {1: "inherited", 2: "invisible"}'
    made = shot(light("SphereLight", UNIT + keys))
    assert "/L" in made.read(1).lights
    assert not made.read(2).lights
    assert made.read(2).hidden == {"/L"}


def test_other_lights_give_way_to_the_camera_light(shot: MakeShot) -> None:
    made = shot(light("PortalLight", UNIT))
    state = made.read().lights[CAMERA_LIGHT]
    assert state.energy == (pi, pi, pi)
    assert state.aim == (0, 0, -1)
    assert made.reader.camera_light
    assert any("PortalLight lights" in text for text in made.notices("unsupported"))
    assert any("light at the camera" in text for text in made.notices("mentioned"))


def test_camera_light_can_be_turned_off(shot: MakeShot) -> None:
    made = shot("", options=ReadOptions(camera_light=False))
    assert not made.read().lights
    assert any("none at the camera" in text for text in made.notices("mentioned"))


def test_a_hidden_light_is_no_reason_for_a_camera_light(shot: MakeShot) -> None:
    made = shot(light("SphereLight", UNIT + 'token visibility = "invisible"'))
    assert not made.read().lights
    assert not made.reader.camera_light


def test_camera_light_follows_the_camera(shot: MakeShot) -> None:
    camera = 'def Camera "cam"\n{\nfloat xformOp:rotateY.timeSamples = {1: 0, 3: 90}\n'
    made = shot(camera + OPS.format("rotateY") + "}")
    first, second = made.read(1), made.read(3)
    assert first.lights[CAMERA_LIGHT].aim == (0, 0, -1)
    assert second.lights[CAMERA_LIGHT].aim == pytest.approx((-1, 0, 0))
    assert made.read(4).lights is second.lights


def test_core_record(shot: MakeShot) -> None:
    from irt_usd import _core as core

    for kind in ("SphereLight", "DistantLight"):
        records = lit(shot(light(kind, UNIT))).core()
        assert list(records) == ["/L"]
        assert isinstance(records["/L"], core.Light)


SCALE = "float3 xformOp:scale = (2, 3, 4)\n" + OPS.format("scale")


@pytest.mark.parametrize(
    ("kind", "size", "power", "normalized"),
    [
        ("RectLight", "float inputs:width = 2\nfloat inputs:height = 3\n", 6, 1),
        ("RectLight", "float inputs:width = 2\nfloat inputs:height = 3\n" + SCALE, 36, 1),
        ("DiskLight", "float inputs:radius = 2\n", 4 * pi, 1),
        ("DiskLight", "float inputs:radius = 2\n" + SCALE, 24 * pi, 1),
        ("CylinderLight", "float inputs:radius = 2\nfloat inputs:length = 3\n", 12, 1 / pi),
        ("DomeLight", "", 1, 1),
    ],
)
def test_area_intensities(
    shot: MakeShot, kind: str, size: str, power: float, normalized: float
) -> None:
    assert energy(shot(light(kind, UNIT + size))) == pytest.approx(power)
    normal = shot(light(kind, UNIT + size + "bool inputs:normalize = 1"), name="n.usda")
    assert energy(normal) == pytest.approx(normalized)


def test_modifiers(shot: MakeShot) -> None:
    body = (
        UNIT
        + """
float inputs:diffuse = 0.5
float inputs:specular = 0
float inputs:shaping:cone:angle = 30
float inputs:shaping:cone:softness = 0.25
float inputs:shaping:focus = 2
color3f inputs:shadow:color = (1, 0, 0)
float inputs:shadow:distance = 3
"""
    )
    found = lit(shot(light("SphereLight", body))).modifiers
    assert found == {
        "diffuse": 0.5,
        "specular": 0.0,
        "cone_angle": 30.0,
        "cone_softness": 0.25,
        "focus": 2.0,
        "shadow_color": (1.0, 0.0, 0.0),
        "shadow_distance": 3.0,
        "profile": "uniform",
        "axis": (0.0, 0.0, -1.0),
        "side": (1.0, 0.0, 0.0),
    }
    applied = shot(light("SphereLight", UNIT, "ShapingAPI"), name="applied.usda")
    assert lit(applied).modifiers["cone_angle"] == 90


def test_light_linking(shot: MakeShot) -> None:
    """Collections that include collections, and what lies inside instances."""
    body = (
        'def Xform "Set" (prepend apiSchemas = ["CollectionAPI:key"])\n{\n'
        "rel collection:key:includes = [</Set/A>, </I>]\n"
        'def Sphere "A"\n{\n}\ndef Sphere "B"\n{\n}\n}\n'
        'def Xform "I" (instanceable = true\nreferences = </P>)\n{\n}\n'
        'class Xform "P"\n{\ndef Sphere "S"\n{\n}\n}\n'
    )
    line = (
        "bool collection:lightLink:includeRoot = 0\n"
        "rel collection:lightLink:includes = </Set.collection:key>\n"
    )
    made = shot(body + light("SphereLight", UNIT + line))
    assert lit(made).modifiers["unlit"] == ("/Set/B",)
    excludes = "rel collection:lightLink:excludes = </Set/A>"
    made = shot(body + light("SphereLight", UNIT + excludes), name="x.usda")
    assert lit(made).modifiers["unlit"] == ("/Set/A",)


IES = """IESNA:LM-63-2002
[TEST] made up
TILT=NONE
1 1000 2 3 1 1 2 0 0 0
1 1 100
0 45 90
0
100 50 0
"""


def test_ies(shot: MakeShot, tmp_path: Path) -> None:
    (tmp_path / "a.ies").write_text(IES)
    line = "asset inputs:shaping:ies:file = @./a.ies@\n"
    web = lit(shot(light("SphereLight", UNIT + line))).modifiers["ies"]
    assert web == ((0, 45, 90), (0,), (200, 100, 0))
    normal = light("SphereLight", UNIT + line + "bool inputs:shaping:ies:normalize = 1")
    vertical, _, values = lit(shot(normal, name="n.usda")).modifiers["ies"]
    steps = np.radians((np.arange(9000) + 0.5) / 100)
    curve = np.interp(np.degrees(steps), vertical, values)
    mean = float(np.sum(curve * np.sin(steps)) * np.radians(0.01) / 2)
    assert mean == pytest.approx(1, rel=1e-4)


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (None, "No such file"),
        ("hello", "no TILT= line"),
        (IES.replace("NONE", "other.tlt"), "names another file"),
        (IES.replace("100 50 0", "100"), "candelas are said to follow"),
        (IES.replace("0 45 90", "0 45 45"), "do not ascend"),
        (IES.replace("100 50 0", "x"), "expected numbers"),
        (IES.replace("1 1 2 0", "1 2 2 0"), "expected 1 (type C)"),
    ],
)
def test_bad_ies(shot: MakeShot, tmp_path: Path, content: str | None, what: str) -> None:
    if content is not None:
        (tmp_path / "a.ies").write_text(content)
    body = light("SphereLight", UNIT + "asset inputs:shaping:ies:file = @./a.ies@\n")
    with pytest.raises(InputError, match=r"IES files; .*--missing-asset fallback") as caught:
        shot(body)
    assert what.lower() in str(caught.value).lower()
    assert "/L.inputs:shaping:ies:file in" in str(caught.value)
    for policy in MISSING_ASSET[1:]:
        made = shot(body, options=ReadOptions(missing_asset=policy))
        assert "ies" not in lit(made).modifiers
        (text,) = made.notices("skipped")
        assert what.lower() in text.lower()
        assert "/L.inputs:shaping:ies:file" in text


@pytest.mark.parametrize(
    ("scale", "vertical", "values"),
    [
        (0.0, (0, 45, 90), (200, 100, 0)),
        (0.5, (0, 22.5, 45), (200, 100, 0)),
        (3.0, (0, 135, 180), (200, 100, 200 / 3)),
        (-0.5, (0, 90, 112.5, 135), (200, 200, 100, 0)),
        (-2.0, (0,), (0,)),
    ],
)
def test_ies_angle_scale(
    shot: MakeShot, tmp_path: Path, scale: float, vertical: Any, values: Any
) -> None:
    """Above 0 angles are divided by it from 0 on, below 0 by its size from 180 on."""
    (tmp_path / "a.ies").write_text(IES)
    line = (
        f"asset inputs:shaping:ies:file = @./a.ies@\nfloat inputs:shaping:ies:angleScale = {scale}"
    )
    web = lit(shot(light("SphereLight", UNIT + line))).modifiers["ies"]
    assert web[0] == pytest.approx(vertical)
    assert web[2] == pytest.approx(values)


def test_ies_profiles_may_come_and_go(shot: MakeShot, tmp_path: Path) -> None:
    (tmp_path / "a.ies").write_text(IES)
    (tmp_path / "b.ies").write_text(IES.replace("100 50 0", "10 5 0"))
    line = "asset inputs:shaping:ies:file.timeSamples = {1: @./a.ies@, 2: @./b.ies@, 3: @@}"
    made = shot(light("SphereLight", UNIT + line), frames=(1, 2, 3))
    assert [lit(made, t).modifiers.get("ies", [None] * 3)[2] for t in (1, 2, 3)] == [
        (200, 100, 0),
        (20, 10, 0),
        None,
    ]


@pytest.mark.parametrize(
    "line",
    [
        "float inputs:specular = nan",
        "float inputs:diffuse = -1",
        "float inputs:shadow:falloffGamma = -2",
        "color3f inputs:shadow:color = (0, inf, 0)",
        "float inputs:shaping:focus = nan",
    ],
)
def test_modifiers_that_cannot_be_rendered_give_way(shot: MakeShot, line: str) -> None:
    made = shot(light("SphereLight", UNIT + line))
    assert not set(lit(made).modifiers) - {"profile", "axis", "side"}
    (text,) = made.notices("skipped")
    assert "its default is rendered" in text
    assert "/L.inputs:" in text


def test_shadow_falloff(shot: MakeShot) -> None:
    lines = "float inputs:shadow:falloff = 2\nfloat inputs:shadow:falloffGamma = 0.5\n"
    assert not lit(shot(light("SphereLight", UNIT + lines))).modifiers  # without a distance
    lines += "float inputs:shadow:distance = 3"
    for kind in ("SphereLight", "DistantLight", "DomeLight"):
        found = lit(shot(light(kind, UNIT + lines), name=f"{kind}.usda")).modifiers
        assert found == {
            "shadow_distance": 3.0,
            "shadow_falloff": 2.0,
            "shadow_falloff_gamma": 0.5,
        }


def test_shadow_linking(shot: MakeShot) -> None:
    """Nested collections, instances' prims, and arrays as one."""
    body = (
        'def Xform "Set" (prepend apiSchemas = ["CollectionAPI:key", "CollectionAPI:all"])\n{\n'
        "rel collection:key:includes = [</Set/A>, </I>]\n"
        "rel collection:all:includes = [</Set.collection:key>, </P/Swarm>]\n"
        'def Sphere "A"\n{\n}\ndef Sphere "B"\n{\n}\n}\n'
        'def Xform "I" (instanceable = true\nreferences = </C>)\n{\n}\n'
        'class Xform "C"\n{\ndef Sphere "S"\n{\n}\ndef Sphere "T"\n{\n}\n}\n'
        'def Xform "P"\n{\ndef PointInstancer "Swarm"\n{\nrel prototypes = </P/Swarm/Ball>\n'
        "int[] protoIndices = [0, 0]\npoint3f[] positions = [(0, 0, 0), (3, 0, 0)]\n"
        'def Sphere "Ball"\n{\n}\n}\n}\n'
    )
    line = (
        "bool collection:shadowLink:includeRoot = 0\n"
        "rel collection:shadowLink:includes = </Set.collection:all>\n"
        "rel collection:shadowLink:excludes = </I/T>\n"
        "rel collection:lightLink:excludes = </P/Swarm>\n"
    )
    made = shot(body + light("DistantLight", UNIT + line))
    assert lit(made).modifiers == {"shadowless": ("/I/T", "/Set/B"), "unlit": ("/P/Swarm",)}
    assert not made.notices("unsupported")


def test_dome_is_a_sky_and_lights_that_share_its_irradiance(shot: MakeShot) -> None:
    made = shot(light("DomeLight", UNIT), options=ReadOptions(dome_samples=64))
    records = lit(made).core()
    assert len(records) == 65
    directions = np.array(_core.sky_directions(64, (0, 1, 0)))
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1)
    for normal in np.array([[0, 1, 0], [1, 0, 0], [0.6, 0, 0.8], [-0.48, 0.6, 0.64]]):
        irradiance = np.maximum(-directions @ normal, 0).sum() * 4 * pi / 64
        assert irradiance == pytest.approx(pi, rel=0.02)
