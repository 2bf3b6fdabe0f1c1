# SPDX-License-Identifier: Apache-2.0
"""Writes shots/pipeline/pipeline.usda: python -m shots.pipeline.make_pipeline [PATH].

What a pipeline puts around a shot, the demo's chess position: a second camera, render settings
with three products (other resolutions, vars, data windows and time-sampled names), and three render
passes of the same position.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdRender

from shots.kit.stage import camera, new_stage, save

FIRST, LAST = 1004, 1008
OUT = "out/pipeline"

VARS = {
    "color": ("color4f", "color"),
    "Z": ("float", "depth"),
    "N": ("normal3f", "Neye"),
    "P": ("point3f", "position"),
    "id": ("int", "primId"),
    "albedo": ("color3f", "albedo"),
}
"""By the name of the layer: data type and source."""


def build() -> Usd.Stage:
    """The stage, in memory; it lies beside the demo's folder."""
    stage = new_stage(FIRST, LAST, "Written by shots/pipeline/make_pipeline.py")
    stage.GetRootLayer().subLayerPaths = ["../demo/chess.usda"]
    hero = "/World/camera"
    eye, target = (-42.0, 30.0, -34.0), (0.0, 0.0, 0.0)
    witness = camera(stage, "/World/witness", eye, target, focal_mm=40, aspect=1.0)
    for name, (data, source) in VARS.items():
        var = UsdRender.Var.Define(stage, f"/Render/vars/{name}")
        var.CreateDataTypeAttr(data)
        var.CreateSourceNameAttr(source)
    settings = UsdRender.Settings.Define(stage, "/Render/settings")
    settings.CreateCameraRel().SetTargets([hero])
    settings.CreateResolutionAttr(Gf.Vec2i(640, 360))
    settings.CreateDisableMotionBlurAttr(True)
    settings.CreateDisableDepthOfFieldAttr(True)
    products = [
        _product(stage, "beauty", ("color", "Z", "N"), "####"),
        _product(stage, "ids", ("color", "id", "albedo"), "{frame:04d}"),
        _product(stage, "witness", ("color", "P"), "take_{frame}"),
    ]
    half, square = products[1], products[2]
    half.CreateResolutionAttr(Gf.Vec2i(320, 180))
    half.CreateDataWindowNDCAttr(Gf.Vec4f(-0.1, -0.1, 1.1, 1.1))
    square.CreateResolutionAttr(Gf.Vec2i(256, 256))
    square.CreateCameraRel().SetTargets([witness.GetPath()])
    settings.CreateProductsRel().SetTargets([product.GetPath() for product in products])
    _passes(stage, settings)
    stage.SetMetadata("renderSettingsPrimPath", settings.GetPath().pathString)
    return stage


def _product(
    stage: Usd.Stage, name: str, layers: Sequence[str], frame_name: str
) -> UsdRender.Product:
    product = UsdRender.Product.Define(stage, f"/Render/products/{name}")
    names = product.CreateProductNameAttr()
    if "{" in frame_name:
        for frame in range(FIRST, LAST + 1):
            names.Set(f"{OUT}/{name}.{frame_name.format(frame=frame)}.exr", frame)
    else:
        names.Set(f"{OUT}/{name}.####.exr")
    targets = [Sdf.Path(f"/Render/vars/{layer}") for layer in layers]
    product.CreateOrderedVarsRel().SetTargets(targets)
    return product


def _passes(stage: Usd.Stage, settings: UsdRender.Settings) -> None:
    """Both sides by themselves, the other one held out or hidden; and the board alone."""
    white, black = "/World/white", "/World/black"
    for name, collections in (
        ("white", {"matte": ([black], [])}),
        ("black", {"cameraVisibility": ([], [white])}),
        ("board", {"prune": ([white, black], [])}),
    ):
        render_pass = UsdRender.Pass.Define(stage, f"/Render/passes/{name}")
        render_pass.CreateRenderSourceRel().SetTargets([settings.GetPath()])
        for collection, (includes, excludes) in collections.items():
            api = Usd.CollectionAPI(render_pass.GetPrim(), collection)
            for path in includes:
                api.CreateIncludesRel().AddTarget(path)
            for path in excludes:
                api.CreateExcludesRel().AddTarget(path)


if __name__ == "__main__":
    default = Path(__file__).parent / "pipeline.usda"
    save(build(), Path(sys.argv[1]) if len(sys.argv) > 1 else default)
