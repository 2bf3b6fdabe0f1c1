# SPDX-License-Identifier: Apache-2.0
"""Levels of every kind of light beside Mitsuba 3's area emitters: within 1 % at unoccluded points.

A point of a white matt floor, seen from right above it, is lit from beyond ten times the light's
size, straight from above and from the side.
"""

from dataclasses import dataclass
from math import cos, hypot, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from textured import picture, write_image

pytest.importorskip("mitsuba", reason="mitsuba is missing: pip install mitsuba")

STAGE = """#usda 1.0
(
    upAxis = "Y"
)
def Camera "C"
{
    token projection = "orthographic"
    float horizontalAperture = 0.001
    float verticalAperture = 0.001
    float2 clippingRange = (0.001, 1)
    double3 xformOp:translate = (0, 0.01, 0)
    float xformOp:rotateX = -90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
}
def Plane "Floor" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    token axis = "Y"
    double width = 1
    double length = 1
    rel material:binding = </M>
}
def Material "M"
{
    token outputs:surface.connect = </M/P.outputs:surface>
    def Shader "P"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 1, 1)
        int inputs:useSpecularWorkflow = 1
        float inputs:roughness = 1
        token outputs:surface
    }
}
"""
OPS = 'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]\n'
CUBE = """
uniform token subdivisionScheme = "none"
point3f[] points = [(-1,-1,-1), (1,-1,-1), (1,1,-1), (-1,1,-1), (-1,-1,1), (1,-1,1), (1,1,1), (-1,1,1)]
int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
int[] faceVertexIndices = [0,3,2,1, 4,5,6,7, 0,1,5,4, 2,3,7,6, 0,4,7,3, 1,2,6,5]
"""  # noqa: E501


@dataclass(frozen=True)
class Kind:
    """A light that shines down: its USD type, its sizes, Mitsuba's shape, extent and area."""

    name: str
    sizes: str
    shape: dict[str, Any]
    extent: float
    area: float
    apis: str = ""


def turned(mi: Any, *scale: float) -> Any:
    """Mitsuba's flat shapes face +z; the light's -z axis points down."""
    return mi.ScalarTransform4f().rotate([1, 0, 0], 90).scale(list(scale))


def kind(name: str, size: float) -> Kind:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    if name == "sphere":
        body = f"float inputs:radius = {size}\n"
        return Kind(
            "SphereLight", body, {"type": "sphere", "radius": size}, 2 * size, 4 * pi * size**2
        )
    if name == "disk":
        body = f"float inputs:radius = {size}\n"
        shape = {"type": "disk", "to_world": turned(mi, size, size, 1)}
        return Kind("DiskLight", body, shape, 2 * size, pi * size**2)
    if name == "rect":
        body = f"float inputs:width = {2 * size}\nfloat inputs:height = {size}\n"
        shape = {"type": "rectangle", "to_world": turned(mi, size, size / 2, 1)}
        return Kind("RectLight", body, shape, hypot(2 * size, size), 2 * size**2)
    if name == "cylinder":
        body = f"float inputs:length = {2 * size}\nfloat inputs:radius = {size / 4}\n"
        ends = {"p0": [-size, 0, 0], "p1": [size, 0, 0], "radius": size / 4}
        return Kind("CylinderLight", body, {"type": "cylinder", **ends}, 2 * size, pi * size**2)
    assert name == "mesh"
    body = CUBE + f"float3 xformOp:scale = ({size}, {size}, {size})\n"
    shape = {"type": "cube", "to_world": mi.ScalarTransform4f().scale([size] * 3)}
    return Kind("Mesh", body, shape, 2 * size * 3**0.5, 24 * size**2, '"MeshLightAPI"')


def irt_level(folder: Path, light: str, **options: Any) -> Any:
    """Irradiance of the floor's point by the light's text, by channel."""
    path = folder / f"stage{len(list(folder.glob('stage*')))}.usda"
    path.write_text(STAGE + light)
    return picture(path, size=(1, 1), **options)[0, 0].astype(float) * pi


def mitsuba_level(*emitters: Any) -> Any:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    transform = mi.ScalarTransform4f
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 64, "bsdf_samples": 0},
        "sensor": {
            "type": "orthographic",
            "to_world": transform().look_at([0, 0.01, 0], [0, 0, 0], [0, 0, 1])
            @ transform().scale([1e-3, 1e-3, 1]),
            "near_clip": 1e-4,
            "film": {
                "type": "hdrfilm",
                "width": 1,
                "height": 1,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "stratified", "sample_count": SAMPLES},
        },
        "floor": {
            "type": "rectangle",
            "to_world": transform().rotate([1, 0, 0], -90).scale([0.5, 0.5, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}},
        },
    }
    scene |= {f"light{i}": emitter for i, emitter in enumerate(emitters)}
    return np.array(mi.render(mi.load_dict(scene), spp=SAMPLES))[0, 0].astype(float) * pi


INTENSITY = 3.0
SAMPLES = 1024
MODES = {
    "plain": "",
    "normalized": "bool inputs:normalize = 1\n",
    "exposed": "float inputs:exposure = 1.5\n",
    "warm": "bool inputs:enableColorTemperature = 1\nfloat inputs:colorTemperature = 2700\n"
    "color3f inputs:color = (1, 0.5, 0.25)\n",
}


def radiance(mode: str, area: float) -> Any:
    """UsdLux's luminance."""
    if mode == "normalized":
        return np.full(3, INTENSITY / area)
    if mode == "exposed":
        return np.full(3, INTENSITY * 2**1.5)
    if mode == "warm":
        tint = np.array(UsdLux.BlackbodyTemperatureAsRgb(2700), float)
        return INTENSITY * tint * (1, 0.5, 0.25)
    return np.full(3, INTENSITY)


@pytest.mark.parametrize("size", [0.25, 3.0])
@pytest.mark.parametrize("name", ["sphere", "disk", "rect", "cylinder", "mesh"])
def test_area_lights(tmp_path: Path, name: str, size: float) -> None:
    import mitsuba as mi

    light = kind(name, size)
    places = [(11.0, 0.0), (20.0, 30.0), (45.0, -20.0)]
    for mode, (times, degrees) in zip([*MODES, "plain", "normalized"], places * 2, strict=True):
        away = times * light.extent
        side, up = away * sin(radians(degrees)), away * cos(radians(degrees))
        scaled = "xformOp:scale" in light.sizes
        ops = OPS if not scaled else OPS.replace('rotateX"]', 'rotateX", "xformOp:scale"]')
        apis = f"(prepend apiSchemas = [{light.apis}])" if light.apis else ""
        head = f'def {light.name} "L" {apis}\n'
        text = (
            f"{head}{{\nfloat inputs:intensity = {INTENSITY}\n{light.sizes}{MODES[mode]}"
            f"double3 xformOp:translate = ({side}, {up}, 0)\nfloat xformOp:rotateX = -90\n{ops}}}\n"
        )
        color = radiance(mode, light.area)
        shape = dict(light.shape)
        place = mi.ScalarTransform4f().translate([side, up, 0])
        shape["to_world"] = place @ shape.get("to_world", mi.ScalarTransform4f())
        shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": color.tolist()}}
        found, judged = irt_level(tmp_path, text), mitsuba_level(shape)
        np.testing.assert_allclose(found, judged, rtol=0.01, err_msg=f"{mode} at {times} sizes")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("angle", [0.53, 12.0])
def test_distant_lights(tmp_path: Path, mode: str, angle: float) -> None:
    """A far ball of the same angle has the same level."""
    half, far = radians(angle) / 2, 1000.0
    text = (
        f'def DistantLight "L"\n{{\nfloat inputs:intensity = {INTENSITY}\n{MODES[mode]}'
        f"float inputs:angle = {angle}\nfloat xformOp:rotateX = -60\n"
        'uniform token[] xformOpOrder = ["xformOp:rotateX"]\n}\n'
    )
    ball = {
        "type": "sphere",
        "radius": far * sin(half),
        "center": [0, far * sin(radians(60)), far * cos(radians(60))],
        "emitter": {
            "type": "area",
            "radiance": {"type": "rgb", "value": radiance(mode, pi * sin(half) ** 2).tolist()},
        },
    }
    np.testing.assert_allclose(irt_level(tmp_path, text), mitsuba_level(ball), rtol=0.01)


@pytest.mark.parametrize("mode", ["plain", "exposed", "warm"])
def test_even_domes(tmp_path: Path, mode: str) -> None:
    text = f'def DomeLight "L"\n{{\nfloat inputs:intensity = {INTENSITY}\n{MODES[mode]}}}\n'
    value = radiance(mode, 1).tolist()
    judged = mitsuba_level({"type": "constant", "radiance": {"type": "rgb", "value": value}})
    np.testing.assert_allclose(irt_level(tmp_path, text), judged, rtol=0.01)


@pytest.mark.parametrize("seed", [1, 2])
def test_pictured_domes(tmp_path: Path, seed: int) -> None:
    """Skies of soft clouds: a picture turned, its place and level at once."""
    import mitsuba as mi

    coarse = np.random.default_rng(seed).random((4, 8, 3)).astype(np.float32)
    texels = np.kron(coarse, np.ones((16, 16, 1), np.float32))
    write_image(tmp_path / "sky.exr", texels)
    text = (
        'def DomeLight "L"\n{\nasset inputs:texture:file = @./sky.exr@\n'
        "float xformOp:rotateX = 70\n"
        'uniform token[] xformOpOrder = ["xformOp:rotateX"]\n}\n'
    )
    sky = {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(texels)),
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 70),
    }
    found = irt_level(tmp_path, text, dome_samples=512)
    np.testing.assert_allclose(found, mitsuba_level(sky), rtol=0.01)
