# SPDX-License-Identifier: Apache-2.0
"""`.mtlx` files compose, under the paths that USD's own plugin gives their prims."""

import zipfile
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdShade

from conftest import WriteLayer
from irt_usd.errors import InputError
from irt_usd.stage import open_stage
from materialx_documents import material, mtlx

BASE = '<input name="base" type="float" value="{}"/>'
GRAPH = """
<nodegraph name="NG">
  <input name="gain" type="float" value="2"/>
  <image name="i" type="color3">
    <input name="file" type="filename" value="tex/a.png" colorspace="srgb_texture"/>
  </image>
  <multiply name="m" type="color3">
    <input name="in1" type="color3" nodename="i"/>
    <input name="in2" type="float" interfacename="gain"/>
  </multiply>
  <output name="o" type="color3" nodename="m"/>
</nodegraph>"""
BY_GRAPH = '<input name="base_color" type="color3" nodegraph="NG" output="o"/>'
BINDING = "</MaterialX/Materials>"


def value(stage: Usd.Stage, path: str) -> object:
    return stage.GetAttributeAtPath(path).Get()


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as refused:
        open_stage(str(path))
    return str(refused.value)


@pytest.mark.parametrize("arc", ["references", "payload"])
def test_by_reference_and_payload(usda: WriteLayer, tmp_path: Path, arc: str) -> None:
    (tmp_path / "look.mtlx").write_text(material(BASE.format(0.25)))
    stage = open_stage(str(usda(f'def "L" (\n {arc} = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    shader = UsdShade.Material.Get(stage, "/L/M").ComputeSurfaceSource("mtlx")[0]
    assert shader.GetPath() == "/L/M/ND_standard_surface_surfaceshader"
    assert shader.GetIdAttr().Get() == "ND_standard_surface_surfaceshader"
    assert shader.GetInput("base").GetValueProducingAttributes()[0].Get() == 0.25
    assert not stage.GetCompositionErrors()


def test_by_sublayer(usda: WriteLayer, tmp_path: Path) -> None:
    (tmp_path / "look.mtlx").write_text(material(BASE.format(0.25)))
    stage = open_stage(str(usda("", metadata="subLayers = [@look.mtlx@]")))
    assert value(stage, "/MaterialX/Materials/M.inputs:base") == 0.25


def test_variants_that_refer_to_several(usda: WriteLayer, tmp_path: Path) -> None:
    for name, base in (("a", 0.25), ("b", 0.5)):
        (tmp_path / f"{name}.mtlx").write_text(material(BASE.format(base)))
    arcs = "".join(f' "{v}" (\n references = @{v}.mtlx@{BINDING}\n) {{\n}}\n' for v in ("a", "b"))
    head = 'variants = {\n string v = "b"\n}\nprepend variantSets = "v"'
    stage = open_stage(str(usda(f'def "L" (\n{head}\n)\n{{\nvariantSet "v" = {{\n{arcs}}}\n}}')))
    assert value(stage, "/L/M.inputs:base") == 0.5


def test_two_openings_share_the_layer(usda: WriteLayer, tmp_path: Path) -> None:
    (tmp_path / "look.mtlx").write_text(material(BASE.format(0.25)))
    path = usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')
    first = open_stage(str(path))
    second = open_stage(str(path))
    of_first, of_second = (
        [layer for layer in stage.GetUsedLayers() if layer.realPath.endswith("look.mtlx")]
        for stage in (first, second)
    )
    assert of_first == of_second != []
    del of_first, of_second
    del first, second
    (tmp_path / "look.mtlx").write_text(material(BASE.format(0.75)))
    assert value(open_stage(str(path)), "/L/M.inputs:base") == 0.75


def test_a_file_beside_a_layer_elsewhere(usda: WriteLayer, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/look.mtlx").write_text(material(BY_GRAPH, GRAPH))
    usda(f'def "L" (\n references = @./look.mtlx@{BINDING}\n)\n{{\n}}', "sub/asset.usda")
    (tmp_path / "sub/tex").mkdir()
    (tmp_path / "sub/tex/a.png").touch()
    stage = open_stage(str(usda('def "A" (\n references = @sub/asset.usda@</L>\n)\n{\n}')))
    file = stage.GetAttributeAtPath("/A/M/NG/i.inputs:file")
    assert file.Get().resolvedPath == str(tmp_path / "sub/tex/a.png")
    assert file.GetColorSpace() == "srgb_texture"


def test_a_package(usda: WriteLayer, tmp_path: Path) -> None:
    (tmp_path / "look.mtlx").write_text(mtlx('<xi:include href="part/more.mtlx"/>'))
    (tmp_path / "part").mkdir()
    (tmp_path / "part/more.mtlx").write_text(material(BASE.format(0.25)))
    usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}', "root.usda")
    package = tmp_path / "p.usdz"
    writer = Sdf.ZipFileWriter.CreateNew(str(package))
    for name in ("root.usda", "look.mtlx", "part/more.mtlx"):
        writer.AddFile(str(tmp_path / name), name)
    writer.Save()
    assert zipfile.is_zipfile(package)
    assert value(open_stage(str(package)), "/L/M.inputs:base") == 0.25


def test_node_graphs(usda: WriteLayer, tmp_path: Path) -> None:
    (tmp_path / "look.mtlx").write_text(material(BY_GRAPH, GRAPH))
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    connected = UsdShade.Shader.Get(stage, "/L/M/ND_standard_surface_surfaceshader")
    producers = connected.GetInput("base_color").GetValueProducingAttributes()
    assert [str(p.GetPath()) for p in producers] == ["/L/M/NG/m.outputs:out"]
    ids = {n: value(stage, f"/L/M/NG/{n}.info:id") for n in ("i", "m")}
    assert ids == {"i": "ND_image_color3", "m": "ND_multiply_color3FA"}
    gain = UsdShade.Shader.Get(stage, "/L/M/NG/m").GetInput("in2").GetValueProducingAttributes()
    assert gain[0].Get() == 2.0


def test_nodes_outside_graphs(usda: WriteLayer, tmp_path: Path) -> None:
    value_input = '<input name="value" type="color3" value="1,2,3"/>'
    nodes = f'<constant name="c" type="color3">{value_input}</constant>'
    direct = '<input name="base_color" type="color3" nodename="c"/>'
    (tmp_path / "look.mtlx").write_text(material(direct, nodes))
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    assert value(stage, "/L/M/NodeGraphs/c.inputs:value") == (1, 2, 3)


def test_a_node_that_the_document_defines(usda: WriteLayer, tmp_path: Path) -> None:
    nodes = """
    <nodedef name="ND_twice" node="twice">
      <input name="in" type="float" value="1"/><output name="out" type="float"/>
    </nodedef>
    <nodegraph name="IM_twice" nodedef="ND_twice">
      <add name="a" type="float"><input name="in1" type="float" interfacename="in"/>
        <input name="in2" type="float" interfacename="in"/></add>
      <output name="out" type="float" nodename="a"/>
    </nodegraph>
    <nodegraph name="NG">
      <twice name="t" type="float"><input name="in" type="float" value="0.125"/></twice>
      <twice name="u" type="float"><input name="in" type="float" nodename="t"/></twice>
      <output name="o" type="float" nodename="u"/>
    </nodegraph>"""
    inputs = '<input name="base" type="float" nodegraph="NG" output="o"/>'
    (tmp_path / "look.mtlx").write_text(material(inputs, nodes))
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    add = UsdShade.Shader.Get(stage, "/L/M/NG/u/a").GetInput("in1")
    assert str(add.GetValueProducingAttributes()[0].GetPath()) == "/L/M/NG/t/a.outputs:out"
    inner = UsdShade.Shader.Get(stage, "/L/M/NG/t/a").GetInput("in1")
    assert inner.GetValueProducingAttributes()[0].Get() == 0.125


def test_looks_variants_and_collections(usda: WriteLayer, tmp_path: Path) -> None:
    looks = """
    <variantset name="tone"><variant name="dark">
      <input name="base" type="float" value="0.125"/></variant></variantset>
    <collection name="C" includegeom="/ball"/>
    <look name="lk"><materialassign name="A" material="M" collection="C">
      <variantassign name="v" variantset="tone" variant="dark"/></materialassign></look>"""
    (tmp_path / "look.mtlx").write_text(
        material("", "").replace("</materialx>", looks + "</materialx>")
    )
    body = (
        'def "L" (\n references = @look.mtlx@</ModelRoot>\n'
        ' variants = {\n string LookVariant = "lk"\n}\n)\n{\n def Sphere "ball"\n {\n }\n}'
    )
    stage = open_stage(str(usda(body)))
    ball = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/L/ball"))
    bound = ball.ComputeBoundMaterial()[0]
    assert bound.GetPath() == "/L/Materials/A"
    assert bound.GetInput("base").Get() == 0.125


def test_materials_that_inherit(usda: WriteLayer, tmp_path: Path) -> None:
    more = '<surfacematerial name="N" type="material" inherit="M"/>'
    text = material(BASE.format(0.25)).replace("</materialx>", more + "</materialx>")
    (tmp_path / "look.mtlx").write_text(text)
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    assert value(stage, "/L/N.inputs:base") == 0.25


def test_file_prefix_older_version_and_document_colour_space(
    usda: WriteLayer, tmp_path: Path
) -> None:
    attributes = 'version="1.36" colorspace="acescg" fileprefix="tex/"'
    file_parameter = '<parameter name="file" type="filename" value="a.png"/>'
    text = mtlx(f'<image name="i" type="color3">{file_parameter}</image>', attributes)
    direct = '<input name="base_color" type="color3" nodename="i"/>'
    surface = material(direct).split(">", 2)[2]
    (tmp_path / "look.mtlx").write_text(text.replace("</materialx>", surface))
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    file = stage.GetAttributeAtPath("/L/M/NodeGraphs/i.inputs:file")
    assert file.Get().path == "tex/a.png"
    assert file.GetColorSpace() == "acescg"


def test_an_animated_value(usda: WriteLayer, tmp_path: Path) -> None:
    curve = '<input name="base" type="float" value="0" valuerange="1,3" valuecurve="0.5, 0.25, 1"/>'
    (tmp_path / "look.mtlx").write_text(material(curve))
    stage = open_stage(str(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}')))
    base = stage.GetAttributeAtPath("/L/M.inputs:base")
    assert [base.Get(t) for t in (1, 2, 3)] == [0.5, 0.25, 1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<materialx><a", "not a MaterialX document"),
        (mtlx('<xi:include href="none.mtlx"/>'), "xi:include none.mtlx: no such file"),
        (mtlx('<xi:include href="look.mtlx"/>'), "cycle"),
        (material(BASE.format("dark")), 'value "dark" is no float'),
        (
            material('<input name="base" type="float" nodegraph="No" output="o"/>'),
            "no node graph No",
        ),
        (material('<input name="base" type="float" nodename="no"/>'), "no node no"),
    ],
)
def test_bad_documents(usda: WriteLayer, tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "look.mtlx").write_text(text)
    message = refusal(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}'))
    assert said in message
    assert "look.mtlx" in message
    assert "prim </L>" in message


def test_a_missing_document(usda: WriteLayer) -> None:
    message = refusal(usda(f'def "L" (\n references = @look.mtlx@{BINDING}\n)\n{{\n}}'))
    assert "look.mtlx" in message
    assert "prim </L>" in message
