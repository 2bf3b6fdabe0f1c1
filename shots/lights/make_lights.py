# SPDX-License-Identifier: Apache-2.0
"""Writes shots/lights: python -m shots.lights.make_lights [FOLDER].

One booth for each of UsdLux's lights and of what shapes them, each lit by its own light alone,
under a dome with a picture that shows behind them and in their mirrors. The lights change one after
the other, frame by frame.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from shots.kit.stage import bind, camera, material, new_stage, render_settings, save

FIRST, LAST = 1, 14
SIZE = (960, 640)
COLUMNS, ACROSS, UP = 4, 2.4, 2.2

Booth = Callable[[Usd.Stage, str], Usd.Prim]

IES = """IESNA:LM-63-2002
[TEST] shots/lights
[MANUFAC] none
TILT=NONE
1 1000 1 7 5 1 2 0 0 0
1 1 100
0 15 30 45 60 75 90
0 90 180 270 360
1.0 0.9 0.2 0.6 0.1 0.0 0.0
1.0 0.8 0.7 0.5 0.3 0.1 0.0
1.0 0.9 0.2 0.6 0.1 0.0 0.0
1.0 0.8 0.7 0.5 0.3 0.1 0.0
1.0 0.9 0.2 0.6 0.1 0.0 0.0
"""


def sky() -> NDArray[np.float32]:
    """A lat-long sky with a sun and a ground, (32, 64, 3), row 0 at the top."""
    up = np.sin(np.pi * (0.5 - (np.arange(32) + 0.5) / 32))[:, None, None]
    around = np.arange(64)[None, :, None]
    above = np.array([0.15, 0.3, 0.6]) + (1 - up) * np.array([0.3, 0.25, 0.1])
    below = np.array([0.12, 0.09, 0.06]) * (1 + 0.5 * ((around // 8) % 2))
    texels = np.where(up > 0, above, below) * np.ones((1, 64, 1))
    texels[8:10, 40:43] = (30, 24, 16)
    picture: NDArray[np.float32] = texels.astype(np.float32)
    return picture


def panes() -> NDArray[np.float32]:
    """A window of four colours, (2, 2, 3)."""
    return np.array([[[1, 0.2, 0.1], [0.2, 1, 0.2]], [[0.2, 0.3, 1], [1, 0.9, 0.2]]], np.float32)


PICTURES: dict[str, Callable[[], NDArray[np.float32]]] = {
    "sky.exr": sky,
    "panes.exr": panes,
    "panes_dim.exr": lambda: panes() * np.float32(0.25),
}
"""By file name, in the folder."""


def _hung(light: UsdLux.BoundableLightBase, height: float = 1.4) -> Usd.Prim:
    """Under the booth's ceiling, shining down."""
    light.AddTranslateOp().Set(Gf.Vec3d(0, height, 0.3))
    light.AddRotateXOp().Set(-90.0)
    return light.GetPrim()


def distant(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A sun of some size, coloured by temperature, which turns cold."""
    light = UsdLux.DistantLight.Define(stage, path)
    light.AddRotateXYZOp().Set(Gf.Vec3f(-50, 25, 0))
    light.CreateIntensityAttr(2.5)
    light.CreateNormalizeAttr(True)
    light.CreateAngleAttr(2.0)
    light.CreateEnableColorTemperatureAttr(True)
    kelvin = light.CreateColorTemperatureAttr()
    kelvin.Set(3000.0, 1)
    kelvin.Set(9000.0, 2)
    return light.GetPrim()


def sphere(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A ball of light of a given power, which doubles."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(6.0)
    light.CreateNormalizeAttr(True)
    exposure = light.CreateExposureAttr()
    exposure.Set(0.0, 2)
    exposure.Set(1.0, 3)
    return _hung(light)


def rect(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A rectangle with a picture, which is exchanged."""
    light = UsdLux.RectLight.Define(stage, path)
    light.CreateWidthAttr(0.8)
    light.CreateHeightAttr(0.4)
    light.CreateIntensityAttr(12.0)
    file = light.CreateTextureFileAttr()
    file.Set(Sdf.AssetPath("./panes.exr"), 3)
    file.Set(Sdf.AssetPath("./panes_dim.exr"), 4)
    return _hung(light)


def disk(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A disk that is blue off its axis, and narrows."""
    light = UsdLux.DiskLight.Define(stage, path)
    light.CreateRadiusAttr(0.3)
    light.CreateIntensityAttr(10.0)
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.CreateShapingFocusTintAttr(Gf.Vec3f(0.0, 0.1, 0.6))
    focus = shaping.CreateShapingFocusAttr()
    focus.Set(2.0, 4)
    focus.Set(12.0, 5)
    return _hung(light)


def cylinder(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A tube whose highlights go out."""
    light = UsdLux.CylinderLight.Define(stage, path)
    light.CreateLengthAttr(1.0)
    light.CreateRadiusAttr(0.05)
    light.CreateIntensityAttr(16.0)
    light.CreateColorAttr(Gf.Vec3f(0.6, 1.0, 0.7))
    light.CreateDiffuseAttr(0.8)
    specular = light.CreateSpecularAttr()
    specular.Set(1.0, 5)
    specular.Set(0.0, 6)
    return _hung(light)


def dome(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A sky with a picture, which turns."""
    light = UsdLux.DomeLight_1.Define(stage, path)
    light.CreateTextureFileAttr(Sdf.AssetPath("./sky.exr"))
    turn = light.AddRotateYOp()
    turn.Set(0.0, 6)
    turn.Set(70.0, 7)
    return light.GetPrim()


def mesh(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A tetrahedron tinted by its material's glow, which grows."""
    light = UsdGeom.Mesh.Define(stage, path)
    light.CreateFaceVertexCountsAttr([3, 3, 3, 3])
    light.CreateFaceVertexIndicesAttr([0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2])
    light.CreateSubdivisionSchemeAttr("none")
    corners = np.array([[1, 1, 1], [-1, -1, 1], [1, -1, -1], [-1, 1, -1]], np.float32)
    points = light.CreatePointsAttr()
    points.Set(Vt.Vec3fArray.FromNumpy(corners * np.float32(0.12)), 7)
    points.Set(Vt.Vec3fArray.FromNumpy(corners * np.float32(0.2)), 8)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 1.2, 0.3))
    UsdLux.MeshLightAPI.Apply(light.GetPrim())
    api = UsdLux.LightAPI(light.GetPrim())
    api.CreateIntensityAttr(30.0)
    look = material(stage, "/World/looks/glow", (0, 0, 0), emissive=(1.0, 0.35, 0.1))
    bind(light.GetPrim(), look)
    return light.GetPrim()


def spot(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A soft cone that widens."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(150.0)
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.CreateShapingConeSoftnessAttr(0.3)
    angle = shaping.CreateShapingConeAngleAttr()
    angle.Set(20.0, 8)
    angle.Set(32.0, 9)
    return _hung(light)


def profile(stage: Usd.Stage, path: str) -> Usd.Prim:
    """An IES profile that narrows."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(60.0)
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    shaping.CreateShapingIesFileAttr(Sdf.AssetPath("./profile.ies"))
    shaping.CreateShapingIesNormalizeAttr(True)
    scale = shaping.CreateShapingIesAngleScaleAttr()
    scale.Set(1.0, 9)
    scale.Set(0.5, 10)
    return _hung(light)


def faint(stage: Usd.Stage, path: str) -> Usd.Prim:
    """Shadows of a colour, that fade with the distance of what casts them."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(150.0)
    shadow = UsdLux.ShadowAPI.Apply(light.GetPrim())
    shadow.CreateShadowColorAttr(Gf.Vec3f(0.3, 0.0, 0.2))
    shadow.CreateShadowDistanceAttr(0.8)
    shadow.CreateShadowFalloffGammaAttr(1.5)
    falloff = shadow.CreateShadowFalloffAttr()
    falloff.Set(0.7, 10)
    falloff.Set(0.2, 11)
    return _hung(light)


def moving(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A light that the booth's ball is not linked to, and that moves."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(150.0)
    at = light.AddTranslateOp()
    at.Set(Gf.Vec3d(-0.3, 1.3, 0.3), 11)
    at.Set(Gf.Vec3d(0.4, 1.3, 0.3), 12)
    return light.GetPrim()


def shadowless(stage: Usd.Stage, path: str) -> Usd.Prim:
    """A light of which the booth's ball casts no shadow, and that dims and goes out."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(0.1)
    intensity = light.CreateIntensityAttr()
    intensity.Set(150.0, 12)
    intensity.Set(50.0, 13)
    visible = light.CreateVisibilityAttr()
    visible.Set(UsdGeom.Tokens.inherited, 13)
    visible.Set(UsdGeom.Tokens.invisible, 14)
    return _hung(light)


BOOTHS: tuple[Booth, ...] = (
    *(distant, sphere, rect, disk, cylinder, dome),
    *(mesh, spot, profile, faint, moving, shadowless),
)


def _furnish(stage: Usd.Stage, path: str, looks: dict[str, UsdShade.Material]) -> None:
    """Floor, wall, a ball, a mirror, and a post that throws a shadow."""
    shell = UsdGeom.Mesh.Define(stage, f"{path}/shell")
    x, y, z = 1.1, 1.8, 1.0
    corners = [(-x, 0, z), (x, 0, z), (x, 0, -z), (-x, 0, -z), (x, y, -z), (-x, y, -z)]
    shell.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*corner) for corner in corners]))
    shell.CreateFaceVertexCountsAttr([4, 4])
    shell.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 3, 2, 4, 5])
    shell.CreateSubdivisionSchemeAttr("none")
    bind(shell.GetPrim(), looks["shell"])
    for name, at, radius in (("ball", (-0.4, 0.3, 0.1), 0.3), ("mirror", (0.45, 0.25, 0.3), 0.25)):
        ball = UsdGeom.Sphere.Define(stage, f"{path}/{name}")
        ball.CreateRadiusAttr(radius)
        ball.AddTranslateOp().Set(Gf.Vec3d(*at))
        bind(ball.GetPrim(), looks[name])
    post = UsdGeom.Cylinder.Define(stage, f"{path}/post")
    post.CreateRadiusAttr(0.06)
    post.CreateHeightAttr(0.9)
    post.CreateAxisAttr("Y")
    post.AddTranslateOp().Set(Gf.Vec3d(0.1, 0.45, -0.4))
    bind(post.GetPrim(), looks["ball"])


def build() -> Usd.Stage:
    """Return the shot; its pictures and its profile resolve once it is saved in the folder."""
    stage = new_stage(FIRST, LAST, "Written by shots/lights/make_lights.py; edit that instead.")
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.meters)
    looks = {
        "shell": material(stage, "/World/looks/shell", (0.5, 0.5, 0.5), roughness=0.6),
        "ball": material(stage, "/World/looks/ball", (0.6, 0.55, 0.5), roughness=0.35),
        "mirror": material(
            stage, "/World/looks/mirror", (0.9, 0.9, 0.9), roughness=0.0, metallic=1.0
        ),
    }
    for index, make in enumerate(BOOTHS):
        path = f"/World/{make.__name__}"
        booth = UsdGeom.Xform.Define(stage, path)
        column, row = index % COLUMNS, index // COLUMNS
        across = (column - (COLUMNS - 1) / 2) * ACROSS
        booth.AddTranslateOp().Set(Gf.Vec3d(across, (1 - row) * UP - 0.9, 0))
        _furnish(stage, path, looks)
        light = UsdLux.LightAPI(make(stage, f"{path}/light"))
        linked = light.GetLightLinkCollectionAPI()
        linked.CreateIncludeRootAttr(False)
        linked.CreateIncludesRel().SetTargets([path])
        shadows = light.GetShadowLinkCollectionAPI()
        shadows.CreateIncludeRootAttr(False)
        shadows.CreateIncludesRel().SetTargets([path])
        if make is moving:
            linked.CreateExcludesRel().SetTargets([f"{path}/ball"])
        if make is shadowless:
            shadows.CreateExcludesRel().SetTargets([f"{path}/ball"])
    eye, target = (0.0, 1.2, 13.0), (0.0, 0.0, 0.0)
    prim = camera(stage, "/World/camera", eye, target, 46.0, SIZE[0] / SIZE[1])
    render_settings(stage, *SIZE, prim)
    return stage


def write(folder: Path) -> None:
    """Write the shot, its pictures and its profile into `folder`."""
    save(build(), folder / "lights.usda")
    (folder / "profile.ies").write_text(IES)
    for name, make in PICTURES.items():
        texels = make()
        height, width, channels = texels.shape
        out = oiio.ImageOutput.create(str(folder / name))
        assert out is not None, oiio.geterror()
        out.open(str(folder / name), oiio.ImageSpec(width, height, channels, oiio.HALF))
        out.write_image(texels)
        out.close()


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
