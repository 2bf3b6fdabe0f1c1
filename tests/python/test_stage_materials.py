# SPDX-License-Identifier: Apache-2.0
"""Materials: constants wherever they are, display colours where there is nothing else."""

import pytest

from conftest import MakeShot, ReadShot
from irt_usd.stage import MaterialState
from irt_usd.stage.display_color import DEFAULT_MATERIAL
from irt_usd.stage.graph import DEFAULTS


def bound(kind: str, name: str, material: str = "/M", inside: str = "") -> str:
    return f"""
def {kind} "{name}" (
prepend apiSchemas = ["MaterialBindingAPI"]
)
{{
rel material:binding = <{material}>
{inside}
}}
"""


def preview(inputs: str, identifier: str = "UsdPreviewSurface") -> str:
    return f"""
def Shader "P"
{{
uniform token info:id = "{identifier}"
{inputs}
token outputs:surface
}}
"""


BOUND = bound("Sphere", "S")

TRIANGLE = """
uniform token subdivisionScheme = "none"
point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]
int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0,1,2]
"""


def material(inputs: str, interface: str = "", extra: str = "") -> str:
    surface = "token outputs:surface.connect = </M/P.outputs:surface>"
    return f'{BOUND}\ndef Material "M"\n{{\n{interface}\n{surface}\n{preview(inputs)}\n{extra}\n}}'


def worn(made: ReadShot, time: float = 1, path: str = "/S") -> MaterialState:
    snapshot = made.read(time)
    return snapshot.materials[snapshot.objects[path].material]


def test_constants(shot: MakeShot) -> None:
    inputs = """
color3f inputs:diffuseColor = (0.5, 0.25, 0.125)
float inputs:roughness = 0.0625
float inputs:opacity = 0.5
float inputs:ior = 1.25
int inputs:useSpecularWorkflow = 1
"""
    made = shot(material(inputs))
    state = worn(made)
    assert state.path == "/M"
    assert state.attributes == {
        **DEFAULTS,
        "diffuseColor": (0.5, 0.25, 0.125),
        "roughness": 0.0625,
        "opacity": 0.5,
        "ior": 1.25,
        "useSpecularWorkflow": 1,
    }
    assert not made.notices("unsupported")


def test_interface_inputs_are_followed(shot: MakeShot) -> None:
    interface = "color3f inputs:tint = (0.5, 0, 0)\ncolor3f inputs:outer.connect = </M.inputs:tint>"
    inputs = "color3f inputs:diffuseColor.connect = </M.inputs:outer>"
    made = shot(material(inputs, interface))
    assert worn(made).attributes["diffuseColor"] == (0.5, 0, 0)
    assert not made.notices("unsupported")


def test_displacement_is_not_rendered(shot: MakeShot) -> None:
    made = shot(material("float inputs:displacement = 0.5"))
    assert worn(made).attributes == DEFAULTS
    (text,) = made.notices("unsupported")
    assert "displacement" in text


def test_presence(shot: MakeShot) -> None:
    made = shot(material('token inputs:opacityMode = "presence"'))
    assert worn(made).attributes == {**DEFAULTS, "opacityMode": "presence"}
    assert not made.notices("unsupported")


def test_an_unknown_opacity_mode(shot: MakeShot) -> None:
    made = shot(material('token inputs:opacityMode = "holes"'))
    assert worn(made).attributes == DEFAULTS
    (text,) = made.notices("skipped")
    assert "opacityMode is holes; expected transparent, presence; transparent is rendered" in text


def test_occlusion_is_for_renderers_that_find_none(shot: MakeShot) -> None:
    made = shot(material("float inputs:occlusion = 0.5"))
    assert worn(made).attributes == DEFAULTS
    assert not made.notices("unsupported")


@pytest.mark.parametrize("line", ["float inputs:clearcoat = 0", "float inputs:occlusion = 1"])
def test_defaults_are_not_reported(shot: MakeShot, line: str) -> None:
    assert not shot(material(line)).notices("unsupported")


@pytest.mark.parametrize(
    "line", ["float inputs:roughness = nan", 'string inputs:roughness = "rough"']
)
def test_unusable_value(shot: MakeShot, line: str) -> None:
    made = shot(material(line))
    assert worn(made).attributes == DEFAULTS
    (text,) = made.notices("skipped")
    assert "/M/P.inputs:roughness in " in text


def test_out_of_range_is_clamped(shot: MakeShot) -> None:
    made = shot(material("float inputs:roughness = 2"))
    assert worn(made).attributes["roughness"] == 1
    assert any("clamped" in text for text in made.notices("mentioned"))


def test_animated_input(shot: MakeShot) -> None:
    inputs = "color3f inputs:diffuseColor.connect = </M.inputs:tint>"
    keys = "color3f inputs:tint.timeSamples = {1: (0,0,0), 3: (1,1,1), 5: (1,1,1)}"
    made = shot(material(inputs, keys))
    assert worn(made, 2).attributes["diffuseColor"] == (0.5, 0.5, 0.5)
    third = made.read(3)
    assert made.read(4).materials is third.materials


def test_inherited_binding(shot: MakeShot) -> None:
    body = material("float inputs:roughness = 0.25")
    child = bound("Xform", "S", inside='def Cube "C"\n{\n}')
    made = shot(body.replace(BOUND, child))
    assert worn(made, path="/S/C").path == "/M"


def test_missing_material(shot: MakeShot) -> None:
    made = shot(BOUND)
    assert worn(made).path == DEFAULT_MATERIAL
    (text,) = made.notices("skipped")
    assert "</M> of /S.material:binding in " in text
    assert "shot.usda" in text


@pytest.mark.parametrize(
    "body",
    [
        "token outputs:ri:surface.connect = </M/P.outputs:surface>" + preview("", "Other"),
        "token outputs:surface.connect = </M/P.outputs:surface>" + preview("", "Other"),
    ],
)
def test_other_surfaces_fall_back_to_display_color(shot: MakeShot, body: str) -> None:
    coloured = BOUND.replace("rel ", "color3f[] primvars:displayColor = [(1, 0, 0)]\nrel ")
    made = shot(f'{coloured}\ndef Material "M"\n{{\n{body}\n}}')
    assert worn(made).attributes["diffuseColor"] == (1, 0, 0)
    assert any("displayColor rendered instead" in text for text in made.notices("unsupported"))


def test_display_color_and_opacity(shot: MakeShot) -> None:
    body = (
        "color3f[] primvars:displayColor = [(1, 0.5, 0)]\nfloat[] primvars:displayOpacity = [0.5]"
    )
    state = worn(shot(f'def Sphere "S"\n{{\n{body}\n}}'))
    assert state.path == "/S.primvars:displayColor"
    assert state.attributes == {**DEFAULTS, "diffuseColor": (1, 0.5, 0), "opacity": 0.5}


def test_inherited_display_color(shot: MakeShot) -> None:
    body = "color3f[] primvars:displayColor = [(1, 0.5, 0)]"
    made = shot(f'def Xform "G"\n{{\n{body}\ndef Sphere "S"\n{{\n}}\n}}\ndef Sphere "T"\n{{\n}}')
    assert worn(made, path="/G/S").attributes["diffuseColor"] == (1, 0.5, 0)
    assert worn(made, path="/T").attributes == DEFAULTS


def test_animated_display_color(shot: MakeShot) -> None:
    keys = "color3f[] primvars:displayColor.timeSamples = {1: [(0,0,0)], 3: [(1,1,1)]}"
    made = shot(f'def Sphere "S"\n{{\n{keys}\n}}')
    assert worn(made, 2).attributes["diffuseColor"] == (0.5, 0.5, 0.5)
    assert made.read(1).objects is made.read(2).objects


def test_varying_display_color(shot: MakeShot) -> None:
    primvar = 'color3f[] primvars:displayColor = [(1,0,0), (0,1,0)] (\ninterpolation = "vertex"\n)'
    made = shot(
        f'def Mesh "S"\n{{\n{TRIANGLE}\n{primvar.replace("(0,1,0)]", "(0,1,0), (0,0,1)]")}\n}}'
    )
    surface = worn(made).surface
    assert surface.connected == {"diffuseColor": (0, "rgb")}
    assert surface.primvars == {"displayColor"}
    assert not made.notices("skipped")


FACES = """
point3f[] points = [(0,0,0),(1,0,0),(0,1,0)]
int[] faceVertexCounts = [3, 3]
int[] faceVertexIndices = [0,1,2,2,1,0]
uniform token subdivisionScheme = "none"
"""


def subset(indices: str, family: str = "materialBind", name: str = "G") -> str:
    inside = f'uniform token familyName = "{family}"\nint[] indices{indices}'
    return bound("GeomSubset", name).replace("{", "{\n" + inside, 1)


def test_geom_subsets(shot: MakeShot) -> None:
    body = f'def Mesh "S"\n{{\n{FACES}\n{subset(" = [1]")}\n}}'
    made = shot(material("").replace(BOUND, body))
    state = made.read().objects["/S"]
    assert state.material == DEFAULT_MATERIAL
    assert state.shape.face_materials == ("/M",)
    assert state.attributes["/S/G.material:binding"] == "/M"
    assert not made.notices("unsupported") + made.notices("skipped")


def test_subsets_of_other_families_bind_nothing(shot: MakeShot) -> None:
    body = f'def Mesh "S"\n{{\n{FACES}\n{subset(" = [1]", "parts")}\n}}'
    made = shot(material("").replace(BOUND, body))
    assert made.read().objects["/S"].shape.face_materials == ()


def test_wrong_subsets_are_named(shot: MakeShot) -> None:
    body = f'def Mesh "S"\n{{\n{FACES}\n{subset(" = [1, 2]")}\n}}'
    made = shot(material("").replace(BOUND, body))
    assert made.read().objects["/S"].shape.face_materials == ("/M",)
    (text,) = made.notices("skipped")
    assert "a subset names faces that are not there: expected 0 to 1" in text
    assert "/S/G.indices" in text


def test_subsets_over_time(shot: MakeShot) -> None:
    body = f'def Mesh "S"\n{{\n{FACES}\n{subset(".timeSamples = { 1: [0], 2: [0], 3: [1] }")}\n}}'
    made = shot(material("").replace(BOUND, body), frames=(1, 2, 3))
    first, second, third = (made.read(time).objects["/S"] for time in (1, 2, 3))
    assert first is second
    assert third is not first


def test_instances_bind_by_their_own_paths(shot: MakeShot) -> None:
    proto = material("").replace(BOUND, "")
    child = bound("Sphere", "S", "/P/M")
    tree = f'def Xform "P"\n{{\n{child}\n{proto.replace("</M", "</P/M")}\n}}'
    instances = "".join(
        f'\ndef Xform "{n}" (\nreferences = </P>\ninstanceable = true\n)\n{{\n}}' for n in "IJ"
    )
    made = shot(tree + instances)
    assert worn(made, path="/I/S").path == "/I/M"
    assert worn(made, path="/J/S").path == "/J/M"
    assert set(made.read().objects) == {"/P/S", "/I/S", "/J/S"}


def test_core_record(shot: MakeShot) -> None:
    from irt_usd import _core as core

    assert isinstance(worn(shot(material(""))).core(), core.Material)
