# SPDX-License-Identifier: Apache-2.0
"""Shots whose materials are MaterialX's procedures: incremental, exact, and of every geometry."""

from pathlib import Path

import pytest

from irt_usd.shot.progress import shot_progress
from irt_usd.shot.settings import TraceSettings
from irt_usd.shot.verify import TABLE_HEADER, verify_shot
from materialx_documents import mtlx
from textured import shot_of

LOOK = mtlx(
    """
  <position name="where" type="vector3">
    <input name="space" type="string" value="{space}"/>
  </position>
  <multiply name="finer" type="vector3">
    <input name="in1" type="vector3" nodename="where"/>
    <input name="in2" type="float" value="3"/>
  </multiply>
  <fractal3d name="marble" type="color3">
    <input name="position" type="vector3" nodename="finer"/>
    <input name="amplitude" type="vector3" value="0.5,0.4,0.3"/>
  </fractal3d>
  <add name="light" type="color3">
    <input name="in1" type="color3" nodename="marble"/>
    <input name="in2" type="float" value="0.5"/>
  </add>
  <worleynoise3d name="holes" type="float">
    <input name="position" type="vector3" nodename="finer"/>
  </worleynoise3d>
  <clamp name="there" type="float"><input name="in" type="float" nodename="holes"/></clamp>
  <facingratio name="rim" type="float"/>
  <standard_surface name="S" type="surfaceshader">
    <input name="base" type="float" value="1"/>
    <input name="base_color" type="color3" nodename="light"/>
    <input name="specular_roughness" type="float" nodename="rim"/>
    {opacity}
  </standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
"""
)
SOLID = '<input name="opacity" type="color3" value="1,1,1"/>'
LACE = """<input name="opacity" type="color3" nodename="lace"/></standard_surface>
  <combine3 name="lace" type="color3"><input name="in1" type="float" nodename="there"/>
    <input name="in2" type="float" nodename="there"/>
    <input name="in3" type="float" nodename="there"/></combine3>
  <standard_surface name="unused" type="surfaceshader">"""

STAGE = """#usda 1.0
def Camera "Cam"
{
    double3 xformOp:translate = (0, 0.5, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def DistantLight "Key"
{
    float inputs:intensity = 3
    float inputs:angle = 0
    double3 xformOp:rotateXYZ = (-50, 30, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}
def "Look" (
    references = @look.mtlx@</MaterialX/Materials>
)
{
    over "M"
    {
        over "ND_standard_surface_surfaceshader"
        {
            float inputs:base.timeSamples = {1: 1, 3: 1, 4: 0.75}
        }
    }
}
def Xform "World" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </Look/M>
    def Sphere "Ball"
    {
        double radius = 0.8
        double3 xformOp:translate.timeSamples = {1: (-1.5, 0.5, 0), 2: (-1.25, 0.5, 0)}
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Mesh "Floor"
    {
        uniform token subdivisionScheme = "none"
        point3f[] points = [(-4, -1, -4), (4, -1, -4), (4, -1, 4), (-4, -1, 4)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 3, 2, 1]
    }
    def Points "Dots"
    {
        point3f[] points = [(0, 0, 0), (0.6, 0.4, 0.2), (0.4, 1.2, 0)]
        float[] widths = [0.8, 0.6, 0.7]
    }
    def BasisCurves "Cord"
    {
        uniform token type = "linear"
        int[] curveVertexCounts = [3]
        point3f[] points.timeSamples = {
            1: [(1, 0, 0), (1.6, 0.8, 0), (2.2, 0, 0)],
            3: [(1, 0, 0), (1.6, 1.0, 0), (2.2, 0, 0)],
        }
        float[] widths = [0.4] (
            interpolation = "constant"
        )
    }
    def PointInstancer "Many"
    {
        rel prototypes = </World/Many/Seed>
        int[] protoIndices = [0, 0]
        point3f[] positions.timeSamples = {
            1: [(-0.5, -0.7, 1), (1.4, -0.7, 1)],
            2: [(-0.5, -0.7, 1), (1.6, -0.6, 1)],
        }
        def Cube "Seed"
        {
            double size = 0.6
        }
    }
}
"""


@pytest.mark.parametrize("space", ["object", "world"])
@pytest.mark.parametrize("opacity", [SOLID, LACE], ids=["solid", "lace"])
def test_procedures_are_exact(tmp_path: Path, space: str, opacity: str) -> None:
    text = LOOK.replace("{space}", space).replace("{opacity}", opacity)
    (tmp_path / "look.mtlx").write_text(text)
    stage = tmp_path / f"{space}{len(opacity)}.usda"
    stage.write_text(STAGE)
    shot = shot_of(stage, frames="1:4", size=(32, 24))
    with shot_progress(4, TABLE_HEADER, True) as progress:
        verdict = verify_shot(shot, TraceSettings(samples=2), 64, progress)
    assert verdict.exact
    assert not [n for n in shot.report.notices if "MaterialX" in n.text or "shader" in n.text]
