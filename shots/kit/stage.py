# SPDX-License-Identifier: Apache-2.0
"""Stages, cameras, materials and lights. Lengths are centimetres, y is up, colour scene-linear."""

from collections.abc import Mapping
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdRender, UsdShade, Vt

Vec3 = tuple[float, float, float]
Keys = Mapping[int, float]
"""Values by frame."""

FRAMES_PER_SECOND = 24


def new_stage(first: int, last: int, comment: str) -> Usd.Stage:
    """Return an empty stage in memory with the default prim /World and frames `first` to `last`."""
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().comment = comment
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.LinearUnits.centimeters)
    stage.SetTimeCodesPerSecond(FRAMES_PER_SECOND)
    stage.SetFramesPerSecond(FRAMES_PER_SECOND)
    stage.SetStartTimeCode(first)
    stage.SetEndTimeCode(last)
    return stage


def save(stage: Usd.Stage, path: Path) -> None:
    """Write the stage's root layer to `path`, in the format of its suffix."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not stage.GetRootLayer().Export(str(path)):
        raise OSError(f"cannot write {path}")


def render_settings(stage: Usd.Stage, width: int, height: int, camera: Usd.Prim) -> None:
    """Author the stage's render settings."""
    settings = UsdRender.Settings.Define(stage, "/Render/settings")
    settings.CreateResolutionAttr(Gf.Vec2i(width, height))
    settings.CreateCameraRel().SetTargets([camera.GetPath()])
    stage.SetMetadata("renderSettingsPrimPath", "/Render/settings")


def camera(
    stage: Usd.Stage, path: str, eye: Vec3, target: Vec3, focal_mm: float, aspect: float
) -> Usd.Prim:
    """Define a locked camera at `eye` that looks at `target`; returns its prim.

    The film is 36 mm wide; `aspect` is width over height.
    """
    prim = UsdGeom.Camera.Define(stage, path)
    view = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*eye), Gf.Vec3d(*target), Gf.Vec3d(0, 1, 0))
    prim.AddTransformOp().Set(view.GetInverse())
    prim.CreateHorizontalApertureAttr(36.0)
    prim.CreateVerticalApertureAttr(36.0 / aspect)
    prim.CreateFocalLengthAttr(focal_mm)
    prim.CreateClippingRangeAttr(Gf.Vec2f(1, 10000))
    return prim.GetPrim()


def material(
    stage: Usd.Stage,
    path: str,
    diffuse: Vec3,
    *,
    roughness: float = 0.5,
    metallic: float = 0.0,
    opacity: float | Keys = 1.0,
    emissive: Vec3 = (0, 0, 0),
) -> UsdShade.Material:
    """Define a UsdPreviewSurface material; `opacity` may be keyed."""
    result = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    color, number = Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.Float
    shader.CreateInput("diffuseColor", color).Set(diffuse)
    shader.CreateInput("roughness", number).Set(roughness)
    if metallic:
        shader.CreateInput("metallic", number).Set(metallic)
    if opacity != 1.0:
        set_keys(shader.CreateInput("opacity", number).GetAttr(), opacity)
        shader.CreateInput("ior", number).Set(1.5)
    if any(emissive):
        shader.CreateInput("emissiveColor", color).Set(emissive)
    output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    result.CreateSurfaceOutput().ConnectToSource(output)
    return result


def bind(prim: Usd.Prim, what: UsdShade.Material) -> None:
    """Bind a material to `prim` and all below it."""
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(what)


def set_keys(attribute: Usd.Attribute, value: float | Keys) -> None:
    """Set a constant, or a time sample for each frame of a mapping."""
    if isinstance(value, Mapping):
        for frame, sample in value.items():
            attribute.Set(sample, frame)
    else:
        attribute.Set(value)


def distant_light(
    stage: Usd.Stage,
    path: str,
    toward: Vec3,
    irradiance: float,
    color: Vec3,
    *,
    shadows: bool = True,
) -> Usd.Prim:
    """Define a distant light that travels along `toward`, normalised.

    `irradiance` is that of a surface which faces the light.
    """
    light = UsdLux.DistantLight.Define(stage, path)
    turn = Gf.Rotation(Gf.Vec3d(0, 0, -1), Gf.Vec3d(*toward).GetNormalized())
    light.AddOrientOp().Set(Gf.Quatf(turn.GetQuat()))
    light.CreateNormalizeAttr(True)
    light.CreateIntensityAttr(irradiance)
    light.CreateColorAttr(color)
    if not shadows:
        UsdLux.ShadowAPI.Apply(light.GetPrim()).CreateShadowEnableAttr(False)
    return light.GetPrim()


def sphere_light(
    stage: Usd.Stage, path: str, position: Vec3, radius: float, intensity: float, kelvin: float
) -> Usd.Prim:
    """Define a sphere light of the given radiance, coloured by temperature."""
    light = UsdLux.SphereLight.Define(stage, path)
    light.AddTranslateOp().Set(Gf.Vec3d(*position))
    light.CreateRadiusAttr(radius)
    light.CreateIntensityAttr(intensity)
    light.CreateEnableColorTemperatureAttr(True)
    light.CreateColorTemperatureAttr(kelvin)
    return light.GetPrim()


def point3f(values: list[Vec3]) -> Vt.Vec3fArray:
    """Return positions or normals as USD's array type."""
    return Vt.Vec3fArray([Gf.Vec3f(*value) for value in values])
