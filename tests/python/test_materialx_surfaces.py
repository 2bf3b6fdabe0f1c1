# SPDX-License-Identifier: Apache-2.0
"""Each surface model's inputs, one by one, against what the mapping of docs/materialx.md says."""

from typing import Any

import pytest
from pxr import Sdf, Usd, UsdShade

from graph_values import surface_value
from irt_usd.materialx.document import standard_library
from irt_usd.materialx.expressions import Expressions, Value
from irt_usd.materialx.material import MaterialXSource
from irt_usd.materialx.surfaces import MODELS
from irt_usd.report import Report
from irt_usd.stage.color import StageColors
from irt_usd.stage.graph import DEFAULTS, OTHER_DEFAULTS

TYPES = {
    "float": Sdf.ValueTypeNames.Float,
    "color3": Sdf.ValueTypeNames.Color3f,
    "boolean": Sdf.ValueTypeNames.Bool,
    "integer": Sdf.ValueTypeNames.Int,
    "vector3": Sdf.ValueTypeNames.Float3,
    "string": Sdf.ValueTypeNames.String,
}
IDS = {
    "standard_surface": "ND_standard_surface_surfaceshader",
    "open_pbr_surface": "ND_open_pbr_surface_surfaceshader",
    "gltf_pbr": "ND_gltf_pbr_surfaceshader",
    "UsdPreviewSurface": "ND_UsdPreviewSurface_surfaceshader",
    "surface_unlit": "ND_surface_unlit",
}

STANDARD = {
    "diffuseColor": (0.8,) * 3,
    "specularColor": (0.04,) * 3,
    "roughness": 0.2,
    "clearcoat": 0.0,
    "clearcoatRoughness": 0.1,
    "emissiveColor": (0.0,) * 3,
    "opacity": 1.0,
    "ior": 1.5,
    "transmissionColor": (1.0,) * 3,
}
OPEN_PBR = {**STANDARD, "roughness": 0.3, "clearcoatRoughness": 0.0, "ior": 1.6}
GLTF = {**STANDARD, "diffuseColor": (0.0,) * 3, "specularColor": (1.0,) * 3, "roughness": 1.0,
        "clearcoatRoughness": 0.0}  # fmt: skip
PREVIEW = {**{k: v for k, v in STANDARD.items() if k != "transmissionColor"},
            "diffuseColor": (0.18,) * 3, "specularColor": (0.0,) * 3, "roughness": 0.5,
           "clearcoatRoughness": 0.01, "metallic": 0.0, "opacityThreshold": 0.0}  # fmt: skip

RED = (0.5, 0.25, 0.125)


def scaled(colour: tuple[float, ...], factor: float) -> tuple[float, ...]:
    return tuple(factor * c for c in colour)


CASES: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("standard_surface", {}, {}),
    ("standard_surface", {"base": 0.5}, {"diffuseColor": (0.4,) * 3}),
    ("standard_surface", {"base_color": RED}, {"diffuseColor": RED}),
    ("standard_surface", {"metalness": 1.0, "base_color": RED},
     {"diffuseColor": (0.0,) * 3, "specularColor": RED}),
    ("standard_surface", {"metalness": 0.5, "base_color": RED},
     {"diffuseColor": scaled(RED, 0.5), "specularColor": (0.27, 0.145, 0.0825)}),
    ("standard_surface", {"specular": 0.5}, {"specularColor": (0.02,) * 3}),
    ("standard_surface", {"specular_color": RED}, {"specularColor": scaled(RED, 0.04)}),
    ("standard_surface", {"specular_roughness": 0.75}, {"roughness": 0.75}),
    ("standard_surface", {"specular_IOR": 2.0}, {"specularColor": (1 / 9,) * 3}),
    ("standard_surface", {"transmission": 1.0},
     {"opacity": 0.0, "diffuseColor": (1.0,) * 3, "ior": 1.5}),
    ("standard_surface", {"transmission": 0.5, "transmission_color": RED, "specular_IOR": 1.25},
     {"opacity": 0.5, "ior": 1.25, "transmissionColor": RED, "diffuseColor": (0.65, 0.525, 0.4625),
      "specularColor": (1 / 81,) * 3}),
    ("standard_surface", {"transmission": 1.0, "thin_walled": True},
     {"opacity": 0.0, "diffuseColor": (1.0,) * 3, "ior": 1.0}),
    ("standard_surface", {"subsurface": 0.5, "subsurface_color": RED},
     {"diffuseColor": (0.65, 0.525, 0.4625)}),
    ("standard_surface", {"coat": 0.5, "coat_color": (0.5, 1.0, 1.0), "coat_roughness": 0.25},
     {"clearcoat": 0.5, "clearcoatRoughness": 0.25, "diffuseColor": (0.6, 0.8, 0.8),
      "specularColor": (0.03, 0.04, 0.04)}),
    ("standard_surface", {"coat": 1.0, "coat_affect_color": 1.0},
     {"clearcoat": 1.0, "diffuseColor": (0.64,) * 3}),
    ("standard_surface", {"coat": 1.0, "coat_affect_roughness": 1.0, "coat_roughness": 0.5},
     {"clearcoat": 1.0, "clearcoatRoughness": 0.5, "roughness": 0.6}),
    ("standard_surface", {"coat": 1.0, "coat_IOR": 2.0}, {"clearcoat": 1.0, "ior": 2.0}),
    ("standard_surface", {"emission": 2.0, "emission_color": RED},
     {"emissiveColor": scaled(RED, 2.0)}),
    ("standard_surface", {"opacity": (0.5, 0.5, 0.5)}, {"opacity": 0.5, "opacityMode": "presence"}),
    ("standard_surface", {"opacity": (0.5,) * 3, "transmission": 0.5, "transmission_color": RED},
     {"opacity": 0.25, "diffuseColor": (0.65, 0.525, 0.4625),
      "transmissionColor": tuple((2 + c) / 3 for c in RED)}),
    ("open_pbr_surface", {}, {}),
    ("open_pbr_surface", {"base_weight": 0.5}, {"diffuseColor": (0.4,) * 3}),
    ("open_pbr_surface", {"base_metalness": 1.0, "base_color": RED, "specular_weight": 0.5},
     {"diffuseColor": (0.0,) * 3, "specularColor": scaled(RED, 0.5)}),
    ("open_pbr_surface", {"specular_weight": 0.5, "specular_color": RED},
     {"specularColor": scaled(RED, 0.02)}),
    ("open_pbr_surface", {"specular_ior": 2.0}, {"specularColor": (1 / 9,) * 3}),
    ("open_pbr_surface", {"transmission_weight": 1.0, "specular_ior": 1.5},
     {"opacity": 0.0, "diffuseColor": (1.0,) * 3, "ior": 1.5}),
    ("open_pbr_surface", {"subsurface_weight": 1.0, "subsurface_color": RED},
     {"diffuseColor": RED}),
    ("open_pbr_surface", {"coat_weight": 0.5, "coat_color": (0.5, 1, 1), "coat_roughness": 0.25},
     {"clearcoat": 0.5, "clearcoatRoughness": 0.25, "diffuseColor": (0.6, 0.8, 0.8),
      "specularColor": (0.03, 0.04, 0.04)}),
    ("open_pbr_surface", {"emission_luminance": 2.0, "emission_color": RED},
     {"emissiveColor": scaled(RED, 2.0)}),
    ("open_pbr_surface", {"geometry_opacity": 0.25}, {"opacity": 0.25, "opacityMode": "presence"}),
    ("gltf_pbr", {}, {}),
    ("gltf_pbr", {"metallic": 0.0, "base_color": RED},
     {"diffuseColor": RED, "specularColor": (0.04,) * 3}),
    ("gltf_pbr", {"metallic": 0.0, "specular": 0.5, "specular_color": RED},
     {"diffuseColor": (1.0,) * 3, "specularColor": scaled(RED, 0.02)}),
    ("gltf_pbr", {"roughness": 0.25}, {"roughness": 0.25}),
    ("gltf_pbr", {"metallic": 0.0, "transmission": 1.0, "base_color": RED},
     {"opacity": 0.0, "diffuseColor": RED, "specularColor": (0.04,) * 3, "ior": 1.0,
      "transmissionColor": RED}),
    ("gltf_pbr", {"metallic": 0.0, "transmission": 1.0, "thickness": 1.0, "ior": 2.0},
     {"opacity": 0.0, "diffuseColor": (1.0,) * 3, "specularColor": (1 / 9,) * 3, "ior": 2.0}),
    ("gltf_pbr", {"alpha": 0.25}, {}),
    ("gltf_pbr", {"alpha": 0.25, "alpha_mode": 2}, {"opacity": 0.25, "opacityMode": "presence"}),
    ("gltf_pbr", {"alpha": 0.25, "alpha_mode": 1},
     {"opacity": 0.0, "opacityThreshold": 0.5}),
    ("gltf_pbr", {"alpha": 0.5, "alpha_mode": 1}, {"opacityThreshold": 0.5}),
    ("gltf_pbr", {"clearcoat": 0.5, "clearcoat_roughness": 0.25},
     {"clearcoat": 0.5, "clearcoatRoughness": 0.25}),
    ("gltf_pbr", {"emissive": RED, "emissive_strength": 2.0}, {"emissiveColor": scaled(RED, 2.0)}),
    ("UsdPreviewSurface", {}, {}),
    *[("UsdPreviewSurface", {name: value}, {name: value})
      for name, value in (("diffuseColor", RED), ("emissiveColor", RED), ("metallic", 0.5),
                          ("roughness", 0.25), ("clearcoat", 0.5), ("clearcoatRoughness", 0.25),
                          ("opacity", 0.5), ("opacityThreshold", 0.5), ("ior", 2.0),
                          ("normal", (0.5, 0.0, 0.5)))],
    ("UsdPreviewSurface", {"useSpecularWorkflow": 1, "specularColor": RED},
     {"useSpecularWorkflow": 1, "specularColor": RED}),
    ("UsdPreviewSurface", {"opacityMode": 1}, {"opacityMode": "presence"}),
    ("surface_unlit", {"opacity": 0.5}, {"opacity": 0.5, "opacityMode": "presence"}),
    ("surface_unlit", {"opacity": 0.5, "transmission": 0.5},
     {"opacity": 0.25, "opacityMode": "transparent"}),
    ("surface_unlit", {"emission": 2.0, "emission_color": RED},
     {"emissiveColor": scaled(RED, 2.0), "diffuseColor": (0.0,) * 3, "specularColor": (0.0,) * 3}),
]  # fmt: skip

USUAL = {
    "standard_surface": STANDARD,
    "open_pbr_surface": OPEN_PBR,
    "gltf_pbr": GLTF,
    "UsdPreviewSurface": {**PREVIEW, "useSpecularWorkflow": 0},
    "surface_unlit": {},
}


def source(
    model: str, inputs: dict[str, Any], connect: bool = False
) -> tuple[Usd.Stage, MaterialXSource, Report]:
    """A material of USD's own; with `connect`, its values come by way of nodes."""
    stage = Usd.Stage.CreateInMemory()
    UsdShade.Material.Define(stage, "/M")
    shader = UsdShade.Shader.Define(stage, "/M/S")
    shader.CreateIdAttr(IDS[model])
    definition = standard_library().getNodeDef(IDS[model])
    for name, value in inputs.items():
        kind = str(definition.getActiveInput(name).getType())
        port = shader.CreateInput(name, TYPES[kind])
        if connect and kind in ("float", "color3"):
            reader = UsdShade.Shader.Define(stage, f"/M/{name}")
            reader.CreateIdAttr(f"ND_geompropvalue_{kind}")
            reader.CreateInput("geomprop", TYPES["string"]).Set(name)
            reader.CreateOutput("out", TYPES[kind])
            port.ConnectToSource(reader.ConnectableAPI(), "out")
        else:
            port.Set(value)
    report = Report()
    colors = StageColors(stage, report)
    return stage, MaterialXSource("/M", shader, report, colors, None), report


@pytest.mark.parametrize("connect", [False, True], ids=["constant", "connected"])
@pytest.mark.parametrize(("model", "inputs", "differing"), CASES, ids=lambda v: str(v)[:60])
def test_inputs(
    model: str, inputs: dict[str, Any], differing: dict[str, Any], connect: bool
) -> None:
    _stage, made, _ = source(model, inputs, connect)
    surface = made.read(Usd.TimeCode(1)).surface
    expected = {"useSpecularWorkflow": 1, **USUAL[model], **differing}
    for name, value in expected.items():
        found = surface_value(surface, name, inputs)
        if not isinstance(value, str):
            value = pytest.approx(value, rel=1e-6, abs=1e-7)
        assert found == value, name


@pytest.mark.parametrize("model", MODELS)
def test_what_is_left_out_is_reported_once(model: str) -> None:
    """Each input that is not expressed, with the one that gives it its weight."""
    definition = standard_library().getNodeDef(IDS[model])
    for name, left_out in MODELS[model].unexpressed.items():
        kind = str(definition.getActiveInput(name).getType())
        value: Any = {"float": 0.375, "color3": RED, "vector3": (1.0, 0.0, 0.0)}[kind]
        inputs = {name: value} | ({left_out.weight: 0.5} if left_out.weight else {})
        _stage, _, report = source(model, inputs)
        assert sum(f"{model} {name} (" in n.text for n in report.notices) == 1, name
        if left_out.weight:
            _stage, _, quiet = source(model, {name: value})
            assert not any(f"{model} {name} (" in n.text for n in quiet.notices), name


@pytest.mark.parametrize("model", MODELS)
def test_nothing_is_reported_of_defaults(model: str) -> None:
    _stage, _, report = source(model, {})
    assert not report.notices


@pytest.mark.parametrize("model", MODELS)
def test_every_input_is_known(model: str) -> None:
    """Whatever a definition has is mapped, left out by name, or of no consequence here."""
    of_no_consequence = {
        "standard_surface": {
            "specular_rotation", "coat_rotation", "tangent", "transmission_scatter_anisotropy",
            "subsurface_radius", "subsurface_scale", "subsurface_anisotropy", "sheen_color",
            "sheen_roughness", "thin_film_IOR",
        },
        "open_pbr_surface": {
            "transmission_scatter_anisotropy", "transmission_dispersion_abbe_number",
            "subsurface_radius", "subsurface_radius_scale", "subsurface_scatter_anisotropy",
            "fuzz_color", "fuzz_roughness", "thin_film_thickness", "thin_film_ior",
            "geometry_tangent", "geometry_coat_tangent",
        },
        "gltf_pbr": {
            "tangent", "occlusion", "iridescence_ior", "iridescence_thickness", "sheen_roughness",
            "attenuation_distance", "anisotropy_rotation",
        },
        "UsdPreviewSurface": {"occlusion", "useSpecularWorkflow"},
        "surface_unlit": set(),
    }  # fmt: skip
    asked: set[str] = set()

    def get(name: str) -> Value:
        asked.add(name)
        return Value(index=0)

    MODELS[model].mapping(Expressions(), get)
    declared = {i.getName() for i in standard_library().getNodeDef(IDS[model]).getActiveInputs()}
    known = asked | set(MODELS[model].unexpressed) | of_no_consequence[model]
    assert declared - known - {MODELS[model].normal} == set()


def test_names_are_those_of_the_surface() -> None:
    for model in MODELS:
        _stage, made, _ = source(model, {})
        surface = made.read(Usd.TimeCode(1)).surface
        assert set(surface.constants) | set(surface.connected) <= set(DEFAULTS | OTHER_DEFAULTS)
