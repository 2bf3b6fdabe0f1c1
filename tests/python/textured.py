# SPDX-License-Identifier: Apache-2.0
"""Pictures of a unit square whose material only emits: a pixel is what the network gives there."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from irt_usd.report import Report
from irt_usd.shot.frames import parse_frames
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer

_STAGE = """#usda 1.0
(
    upAxis = "Y"
)
def Camera "Cam"
{
    token projection = "orthographic"
    float horizontalAperture = 10
    float verticalAperture = 10
    double3 xformOp:translate = (0.5, 0.5, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Mesh "Square" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    uniform token subdivisionScheme = "none"
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    PRIMVARS
    rel material:binding = </M>
}
def Material "M"
{
    token outputs:surface.connect = </M/P.outputs:surface>
    INTERFACE
    def Shader "P"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0, 0, 0)
        int inputs:useSpecularWorkflow = 1
        INPUTS
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        float2 inputs:st.connect = </M/X.outputs:result>
        TEXTURE
        float3 outputs:rgb
        float outputs:r
        float outputs:g
        float outputs:b
        float outputs:a
    }
    def Shader "X"
    {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </M/S.outputs:result>
        TRANSFORM
        float2 outputs:result
    }
    def Shader "S"
    {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
    SHADERS
}
EXTRA
"""

ST = 'texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (\ninterpolation = "vertex"\n)'
EMITTED = "color3f inputs:emissiveColor.connect = </M/T.outputs:rgb>"


def write_stage(folder: Path, **parts: str) -> Path:
    """The square's stage; `parts` by their names in the text above, in lower case."""
    given = {"primvars": ST, "inputs": EMITTED, **parts}
    text = _STAGE
    for name in ("PRIMVARS", "INTERFACE", "INPUTS", "TEXTURE", "TRANSFORM", "SHADERS", "EXTRA"):
        text = text.replace(f"{name}\n", given.get(name.lower(), "") + "\n", 1)
    # A name of its own: USD keeps the layers that are open.
    path = folder / f"square{len(list(folder.glob('square*.usda')))}.usda"
    path.write_text(text)
    return path


def shot_of(path: Path | str, report: Report | None = None, **options: Any) -> Shot:
    given = {"frames": "1", "size": (8, 8), "camera_light": False, **options}
    return open_shot(ShotOptions(str(path), **given), report or Report())


def picture(path: Path | str, report: Report | None = None, **options: Any) -> np.ndarray:
    """RGB of a frame, (h, w, 3), row 0 on top."""
    shot = shot_of(path, report, **options)
    tracer = ShotTracer(shot, TraceSettings(), shot.frames, "none")
    tracer.trace(parse_frames(options.get("frames", "1"))[0])
    rgb: np.ndarray = tracer.film().beauty[..., :3]
    return rgb


def write_image(path: Path, pixels: np.ndarray, metadata: Mapping[str, Any] | None = None) -> Path:
    """`pixels` (h, w, c) in their own type."""
    height, width, channels = pixels.shape
    kinds = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}
    spec = oiio.ImageSpec(width, height, channels, kinds[str(pixels.dtype)])
    spec.attribute("oiio:UnassociatedAlpha", 1)
    for name, value in (metadata or {}).items():
        spec[name] = value
    out = oiio.ImageOutput.create(str(path))
    assert out is not None, oiio.geterror()
    assert out.open(str(path), spec), out.geterror()
    assert out.write_image(pixels), out.geterror()
    out.close()
    return path


def blocks(corners: Any, side: int = 8) -> np.ndarray:
    """An image of 2x2 blocks of one value each, (bottom left, bottom right, top left, top right),
    `side` texels each: magnified, the middle of a block is the block's value."""
    bottom_left, bottom_right, top_left, top_right = (np.asarray(c) for c in corners)
    rows = np.array([[top_left, top_right], [bottom_left, bottom_right]])
    return np.ascontiguousarray(rows.repeat(side, axis=0).repeat(side, axis=1))


def block_middles(image: np.ndarray) -> np.ndarray:
    """(4, 3): the picture at the middles of the blocks, in the order of `blocks`."""
    height, width, _ = image.shape
    low, high = (height // 4, width // 4), (3 * height // 4, 3 * width // 4)
    return np.array(
        [
            image[high[0], low[1]],
            image[high[0], high[1]],
            image[low[0], low[1]],
            image[low[0], high[1]],
        ]
    )


def srgb(code: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, from [0, 1] to linear."""
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
