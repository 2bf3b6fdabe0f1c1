# SPDX-License-Identifier: Apache-2.0
"""Writes shots/features: python -m shots.features.make_features [FOLDER].

One exhibit for each kind of geometry and material that irt reads, on one floor, all its files in
the folder: features.usda, what it references and clips, a MaterialX file, textures. Exhibits change
one after the other; between them the shot holds still.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from shots.features import geometry, looks
from shots.features.images import TEXTURES
from shots.kit.motion import ease
from shots.kit.stage import (
    bind,
    camera,
    distant_light,
    material,
    new_stage,
    render_settings,
    save,
    sphere_light,
)

FIRST, LAST = 1001, 1048
SIZE = (960, 540)
COLUMNS, ACROSS, BACK = 7, 1.9, 2.7

SKEL, DEFORM, RISE, CLIMB, FAN = (
    (1003, 1006),
    (1007, 1009),
    (1010, 1012),
    (1013, 1015),
    (1016, 1018),
)
CLIP = (1037, 1040)
RADIUS = (1042, 1045)


def build() -> Usd.Stage:
    """Return the shot; its references resolve once it is saved in the folder."""
    stage = new_stage(FIRST, LAST, "Written by shots/features/make_features.py; edit that instead.")
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.meters)
    made = looks.make(stage)
    floor = UsdGeom.Plane.Define(stage, "/World/floor")
    floor.CreateAxisAttr("Y")
    floor.CreateWidthAttr(40)
    floor.CreateLengthAttr(40)
    bind(floor.GetPrim(), material(stage, "/World/looks/floor", (0.3, 0.3, 0.3), roughness=0.7))
    for index, (name, make) in enumerate(_exhibits(stage, made)):
        path = f"/World/{name}"
        stand = UsdGeom.Xform.Define(stage, path)
        column, row = index % COLUMNS, index // COLUMNS
        x = (column - (COLUMNS - 1) / 2) * ACROSS
        stand.AddTranslateOp().Set(Gf.Vec3d(x, 0, (row - 1) * BACK))
        make(f"{path}/it")
    sphere_light(stage, "/World/lights/key", (-5, 9, 7), 0.3, 420.0, 5000)
    distant_light(stage, "/World/lights/sky", (0.4, -0.8, -0.5), 2.2, (0.8, 0.9, 1.0))
    view = camera(stage, "/World/camera", (0, 9.0, 11.0), (0, 0.25, 0.3), 32, SIZE[0] / SIZE[1])
    render_settings(stage, *SIZE, view)
    return stage


def _exhibits(stage: Usd.Stage, made: geometry.Looks) -> list[tuple[str, Callable[[str], object]]]:
    return [
        ("star", lambda p: geometry.star(stage, p, made)),
        ("subsets", lambda p: geometry.subsets(stage, p, made)),
        ("creased", lambda p: geometry.creased(stage, p, made, DEFORM)),
        ("loop", lambda p: geometry.loop(stage, p, made)),
        ("fan", lambda p: geometry.topology(stage, p, FAN)),
        ("clipped", lambda p: _clipped(stage, p)),
        ("cloud", lambda p: geometry.cloud(stage, p, RISE)),
        ("curves", lambda p: geometry.curves(stage, p, made)),
        ("rings", lambda p: geometry.instancers(stage, p, made, CLIMB)),
        ("lamps", lambda p: _lamps(stage, p)),
        ("arm", lambda p: geometry.arm(stage, p, made, SKEL)),
        ("solids", lambda p: geometry.solids(stage, p, made)),
        ("turned", lambda p: _panel(stage, p, made["turned"])),
        ("bumpy", lambda p: _panel(stage, p, made["bumpy"])),
        ("leaf", lambda p: _panel(stage, p, made["leaf"])),
        ("tiles", lambda p: _panel(stage, p, made["tiles"], width=2)),
        ("vertex", lambda p: _tinted(stage, p, made["vertex"])),
        ("glass", lambda p: _glass(stage, p, made["glass"])),
        ("hidden", lambda p: geometry.hidden(stage, p, RADIUS)),
    ]


def _panel(stage: Usd.Stage, path: str, look: UsdShade.Material, width: float = 1) -> UsdGeom.Mesh:
    """A leaning square with texture coordinates from 0 to `width` and 0 to 1."""
    at = [(-0.7, 0.0, 0.4), (0.7, 0.0, 0.4), (0.7, 1.2, -0.4), (-0.7, 1.2, -0.4)]
    prim = geometry.mesh(stage, path, at, [[0, 1, 2, 3]], "bilinear")
    st = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
    )
    corners = [(0, 0), (width, 0), (width, 1), (0, 1)]
    st.Set(Vt.Vec2fArray([Gf.Vec2f(*corner) for corner in corners]))
    st.SetIndices(Vt.IntArray([0, 1, 2, 3]))
    bind(prim.GetPrim(), look)
    return prim


def _tinted(stage: Usd.Stage, path: str, look: UsdShade.Material) -> None:
    """A square with a colour a vertex."""
    prim = _panel(stage, path, look)
    tint = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
        "tint", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
    )
    tint.Set(geometry.points([(0.8, 0.1, 0.1), (0.1, 0.8, 0.1), (0.1, 0.1, 0.8), (0.8, 0.8, 0.1)]))


def _glass(stage: Usd.Stage, path: str, look: UsdShade.Material) -> None:
    ball = UsdGeom.Sphere.Define(stage, path)
    ball.CreateRadiusAttr(0.5)
    ball.AddTranslateOp().Set(Gf.Vec3d(0, 0.5, 0))
    bind(ball.GetPrim(), look)


def _lamps(stage: Usd.Stage, path: str) -> None:
    """Three native instances of a payload with a variant."""
    UsdGeom.Xform.Define(stage, path)
    for i, x in enumerate((-0.6, 0.0, 0.6)):
        lamp = UsdGeom.Xform.Define(stage, f"{path}/lamp_{i}")
        lamp.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0.3 * (i % 2)))
        lamp.GetPrim().GetPayloads().AddPayload("./lamp.usda")
        lamp.GetPrim().GetVariantSet("shade").SetVariantSelection("round" if i == 1 else "cone")
        lamp.GetPrim().SetInstanceable(True)


def _lamp() -> Usd.Stage:
    """The lamp, its shade a variant."""
    stage = Usd.Stage.CreateInMemory()
    lamp = UsdGeom.Xform.Define(stage, "/Lamp").GetPrim()
    stage.SetDefaultPrim(lamp)
    post = UsdGeom.Cylinder.Define(stage, "/Lamp/post")
    post.CreateAxisAttr("Y")
    post.CreateRadiusAttr(0.05)
    post.CreateHeightAttr(0.8)
    post.AddTranslateOp().Set(Gf.Vec3d(0, 0.4, 0))
    post.CreateDisplayColorAttr([Gf.Vec3f(0.15, 0.15, 0.15)])
    shades = lamp.GetVariantSets().AddVariantSet("shade")
    for name in ("cone", "round"):
        shades.AddVariant(name)
        shades.SetVariantSelection(name)
        with shades.GetVariantEditContext():
            shade: UsdGeom.Cone | UsdGeom.Sphere
            if name == "cone":
                shade = UsdGeom.Cone.Define(stage, "/Lamp/shade")
                shade.CreateAxisAttr("Y")
                shade.CreateHeightAttr(0.4)
                shade.CreateRadiusAttr(0.25)
            else:
                shade = UsdGeom.Sphere.Define(stage, "/Lamp/shade")
                shade.CreateRadiusAttr(0.22)
            shade.AddTranslateOp().Set(Gf.Vec3d(0, 0.9, 0))
            shade.CreateDisplayColorAttr([Gf.Vec3f(0.8, 0.6, 0.3)])
    shades.SetVariantSelection("cone")
    return stage


def _clipped(stage: Usd.Stage, path: str) -> None:
    """A mesh whose points come from a value clip."""
    prim = geometry.mesh(stage, path, geometry.CUBE, geometry.CUBE_FACES)
    prim.GetPrim().RemoveProperty("points")
    prim.CreateDisplayColorAttr([Gf.Vec3f(0.5, 0.35, 0.15)])
    clips = Usd.ClipsAPI(prim)
    clips.SetClipAssetPaths([Sdf.AssetPath("./clip.samples.usda")])
    clips.SetClipManifestAssetPath(Sdf.AssetPath("./clip.topology.usda"))
    clips.SetClipPrimPath("/Cube")
    clips.SetClipActive([(0, 0)])
    first, last = CLIP
    clips.SetClipTimes([(FIRST, 0), (first, 0), (last, last - first), (LAST, last - first)])


def _clip_topology() -> Usd.Stage:
    """The manifest: which attributes the clip gives values to."""
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Mesh.Define(stage, "/Cube")
    stage.SetDefaultPrim(prim.GetPrim())
    prim.CreatePointsAttr()
    return stage


def _clip_samples() -> Usd.Stage:
    """A cube that leans over."""
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Mesh.Define(stage, "/Cube")
    stage.SetDefaultPrim(prim.GetPrim())
    for time, share in ease(0, CLIP[1] - CLIP[0]).items():
        leaning = np.array(geometry.CUBE) + np.array(geometry.CUBE)[:, 1:2] * (0.5 * share, 0, 0)
        prim.CreatePointsAttr().Set(geometry.points(leaning), time)
    return stage


LAYERS: dict[str, Callable[[], Usd.Stage]] = {
    "features.usda": build,
    "lamp.usda": _lamp,
    "clip.topology.usda": _clip_topology,
    "clip.samples.usda": _clip_samples,
}
"""What makes each layer, by file name."""


def write(folder: Path) -> None:
    """Write every file of the shot."""
    for name, make in LAYERS.items():
        save(make(), folder / name)
    (folder / "varnish.mtlx").write_text(looks.VARNISH)
    (folder / "textures").mkdir(exist_ok=True)
    for name, image in TEXTURES.items():
        if not oiio.ImageBuf(image).write(str(folder / "textures" / name)):
            raise OSError(f"{folder / 'textures' / name}: {oiio.geterror()}")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
