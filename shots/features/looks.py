# SPDX-License-Identifier: Apache-2.0
"""The materials of shots/features: UsdPreviewSurface networks, and one from a MaterialX file."""

from pxr import Gf, Sdf, Usd, UsdShade

from shots.features.geometry import Looks
from shots.kit.motion import ramp
from shots.kit.stage import material, set_keys

ROOT = "/World/looks"
_TYPES = Sdf.ValueTypeNames


class Keyed:
    """The frames, first and last, of what changes in materials."""

    turn = (1020, 1023)
    bump = (1024, 1027)
    swap = 1028
    coat = (1030, 1032)
    mtlx = (1033, 1035)


def make(stage: Usd.Stage) -> Looks:
    """Define every material; by name."""
    looks = {
        "red": _constant(stage, "red", (0.6, 0.08, 0.06)),
        "green": _constant(stage, "green", (0.12, 0.4, 0.12)),
        "blue": _constant(stage, "blue", (0.08, 0.16, 0.5)),
        "plum": _constant(stage, "plum", (0.35, 0.1, 0.3)),
        "gold": material(stage, f"{ROOT}/gold", (0.9, 0.65, 0.25), roughness=0.3, metallic=1.0),
        "glass": material(stage, f"{ROOT}/glass", (0.9, 0.95, 0.95), roughness=0.02, opacity=0.1),
    }
    shader = _shader(looks["plum"])
    set_keys(shader.CreateInput("clearcoat", _TYPES.Float).GetAttr(), ramp(*Keyed.coat, 0.0, 1.0))
    shader.CreateInput("clearcoatRoughness", _TYPES.Float).Set(0.05)
    looks["specular"] = _constant(stage, "specular", (0.05, 0.05, 0.06))
    shader = _shader(looks["specular"])
    shader.CreateInput("useSpecularWorkflow", _TYPES.Int).Set(1)
    shader.CreateInput("specularColor", _TYPES.Color3f).Set(Gf.Vec3f(0.6, 0.5, 0.2))
    looks["turned"] = _turned(stage)
    looks["bumpy"] = _bumpy(stage)
    looks["leaf"] = _leaf(stage)
    looks["tiles"] = _tiles(stage)
    looks["vertex"] = _vertex(stage)
    looks["varnish"] = _varnish(stage)
    return looks


def _constant(stage: Usd.Stage, name: str, color: tuple[float, float, float]) -> UsdShade.Material:
    return material(stage, f"{ROOT}/{name}", color, roughness=0.4)


def _shader(look: UsdShade.Material) -> UsdShade.Shader:
    return UsdShade.Shader(look.GetPrim().GetChild("surface"))


def _node(look: UsdShade.Material, name: str, identifier: str) -> UsdShade.Shader:
    node = UsdShade.Shader.Define(look.GetPrim().GetStage(), look.GetPath().AppendChild(name))
    node.CreateIdAttr(identifier)
    return node


def _st(look: UsdShade.Material) -> UsdShade.ConnectableAPI:
    reader = _node(look, "st", "UsdPrimvarReader_float2")
    reader.CreateInput("varname", _TYPES.String).Set("st")
    reader.CreateOutput("result", _TYPES.Float2)
    return reader.ConnectableAPI()


def _texture(
    look: UsdShade.Material, name: str, file: str, st: UsdShade.ConnectableAPI, space: str
) -> UsdShade.Shader:
    texture = _node(look, name, "UsdUVTexture")
    texture.CreateInput("file", _TYPES.Asset).Set(f"./textures/{file}")
    texture.CreateInput("sourceColorSpace", _TYPES.Token).Set(space)
    texture.CreateInput("st", _TYPES.Float2).ConnectToSource(st, "result")
    texture.CreateInput("wrapS", _TYPES.Token).Set("repeat")
    texture.CreateInput("wrapT", _TYPES.Token).Set("mirror")
    texture.CreateOutput("rgb", _TYPES.Float3)
    for channel in "ra":
        texture.CreateOutput(channel, _TYPES.Float)
    return texture


def _connect(
    look: UsdShade.Material, name: str, kind: Sdf.ValueTypeName, node: UsdShade.Shader, output: str
) -> None:
    _shader(look).CreateInput(name, kind).ConnectToSource(node.ConnectableAPI(), output)


def _turned(stage: Usd.Stage) -> UsdShade.Material:
    """A texture that turns, and one that gives way to another."""
    look = _constant(stage, "turned", (0.5, 0.5, 0.5))
    place = _node(look, "place", "UsdTransform2d")
    place.CreateInput("in", _TYPES.Float2).ConnectToSource(_st(look), "result")
    place.CreateInput("scale", _TYPES.Float2).Set(Gf.Vec2f(2, 2))
    place.CreateInput("translation", _TYPES.Float2).Set(Gf.Vec2f(0.1, 0))
    set_keys(place.CreateInput("rotation", _TYPES.Float).GetAttr(), ramp(*Keyed.turn, 0.0, 30.0))
    place.CreateOutput("result", _TYPES.Float2)
    color = _texture(look, "color", "checks.png", place.ConnectableAPI(), "sRGB")
    file = color.GetInput("file").GetAttr()
    file.Set("./textures/checks.png", Keyed.swap - 1)
    file.Set("./textures/checks_warm.png", Keyed.swap)
    _connect(look, "diffuseColor", _TYPES.Color3f, color, "rgb")
    return look


def _bumpy(stage: Usd.Stage) -> UsdShade.Material:
    """A normal map whose strength is keyed, and a roughness map."""
    look = _constant(stage, "bumpy", (0.3, 0.32, 0.36))
    st = _st(look)
    bump = _texture(look, "bump", "bumps.png", st, "raw")
    scale = bump.CreateInput("scale", _TYPES.Float4).GetAttr()
    bias = bump.CreateInput("bias", _TYPES.Float4).GetAttr()
    for frame, k in ramp(*Keyed.bump, 0.5, 2.0).items():
        scale.Set(Gf.Vec4f(k, k, 2, 1), frame)
        bias.Set(Gf.Vec4f(-k / 2, -k / 2, -1, 0), frame)
    _connect(look, "normal", _TYPES.Normal3f, bump, "rgb")
    _connect(
        look, "roughness", _TYPES.Float, _texture(look, "rough", "stripes.png", st, "raw"), "r"
    )
    return look


def _leaf(stage: Usd.Stage) -> UsdShade.Material:
    """A cut-out."""
    look = _constant(stage, "leaf", (0.2, 0.4, 0.1))
    image = _texture(look, "image", "leaf.png", _st(look), "auto")
    _connect(look, "diffuseColor", _TYPES.Color3f, image, "rgb")
    _connect(look, "opacity", _TYPES.Float, image, "a")
    _shader(look).CreateInput("opacityThreshold", _TYPES.Float).Set(0.5)
    return look


def _tiles(stage: Usd.Stage) -> UsdShade.Material:
    """Two UDIM tiles."""
    look = _constant(stage, "tiles", (0.5, 0.5, 0.5))
    image = _texture(look, "image", "tiles.<UDIM>.png", _st(look), "sRGB")
    _connect(look, "diffuseColor", _TYPES.Color3f, image, "rgb")
    return look


def _vertex(stage: Usd.Stage) -> UsdShade.Material:
    """Colour from a primvar."""
    look = _constant(stage, "vertex", (0.5, 0.5, 0.5))
    reader = _node(look, "tint", "UsdPrimvarReader_float3")
    reader.CreateInput("varname", _TYPES.String).Set("tint")
    reader.CreateOutput("result", _TYPES.Float3)
    _connect(look, "diffuseColor", _TYPES.Color3f, reader, "result")
    return look


def _varnish(stage: Usd.Stage) -> UsdShade.Material:
    """A MaterialX standard surface from a file of its own, its coat keyed from here."""
    prim = stage.DefinePrim(f"{ROOT}/mtlx", "Scope")
    prim.GetReferences().AddReference("./varnish.mtlx", "/MaterialX/Materials")
    look = UsdShade.Material(stage.OverridePrim(f"{ROOT}/mtlx/varnished_wood"))
    coat = look.CreateInput("coat_roughness", _TYPES.Float)
    set_keys(coat.GetAttr(), ramp(*Keyed.mtlx, 0.05, 0.4))
    return look


VARNISH = """<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <nodegraph name="wood">
    <image name="grain" type="color3">
      <input name="file" type="filename" colorspace="srgb_texture"
             value="textures/checks_warm.png" />
    </image>
    <multiply name="stained" type="color3">
      <input name="in1" type="color3" nodename="grain" />
      <input name="in2" type="color3" value="0.8, 0.6, 0.5" />
    </multiply>
    <output name="color" type="color3" nodename="stained" />
  </nodegraph>
  <standard_surface name="varnish" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="wood" output="color" />
    <input name="specular_roughness" type="float" value="0.5" />
    <input name="coat" type="float" value="1.0" />
    <input name="coat_roughness" type="float" value="0.05" />
  </standard_surface>
  <surfacematerial name="varnished_wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="varnish" />
  </surfacematerial>
</materialx>
"""
