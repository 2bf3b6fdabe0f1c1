# SPDX-License-Identifier: Apache-2.0
"""Meshes that are lights: levels, what is seen of them, edits."""

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import MakeShot, ReadShot
from irt_usd import _core
from irt_usd.stage import LightState
from textured import picture

UNIT = "float inputs:intensity = 2\n"
QUAD = """
uniform token subdivisionScheme = "none"
point3f[] points = [(-1, -2, 0), (1, -2, 0), (1, 2, 0), (-1, 2, 0)]
int[] faceVertexCounts = [4]
int[] faceVertexIndices = [0, 1, 2, 3]
"""
MATERIAL = """
def Material "M"
{
    token outputs:surface.connect = </M/P.outputs:surface>
    def Shader "P"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0, 0, 0)
        color3f inputs:emissiveColor = (0.25, 0.5, 1)
        token outputs:surface
    }
}
"""
BOUND = "rel material:binding = </M>\n"


def mesh(body: str = "", mode: str = "", apis: str = '"MeshLightAPI", "MaterialBindingAPI"') -> str:
    sync = f'uniform token light:materialSyncMode = "{mode}"\n' if mode else ""
    head = f'def Mesh "L" (prepend apiSchemas = [{apis}])\n'
    return f"{head}{{\n{QUAD}{UNIT}{sync}{body}\n}}\n{MATERIAL}"


def lit(made: ReadShot, time: float = 1) -> LightState:
    return made.read(time).lights["/L"]


def far_field(state: LightState, direction: Any) -> float:
    areas = np.array(state.modifiers["facets"])[:, :3]
    return float(np.maximum(areas @ np.array(direction), 0).sum() * state.energy[0])


def test_a_quad_sends_its_area_times_radiance_to_its_front(shot: MakeShot) -> None:
    state = lit(shot(mesh("double3 xformOp:translate = (5, 6, 7)\n" + OPS)))
    assert state.kind == "point"
    assert state.aim == pytest.approx((5, 6, 7))
    assert far_field(state, (0, 0, 1)) == pytest.approx(16)
    assert far_field(state, (0.6, 0, 0.8)) == pytest.approx(16 * 0.8)
    assert far_field(state, (0, 0, -1)) == 0
    assert state.modifiers["unlit"] == state.modifiers["shadowless"] == ("/L",)


OPS = 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
SCALE = 'float3 xformOp:scale = (2, 3, 5)\nuniform token[] xformOpOrder = ["xformOp:scale"]\n'


def test_size_and_normalize(shot: MakeShot) -> None:
    assert far_field(lit(shot(mesh(SCALE))), (0, 0, 1)) == pytest.approx(96)
    normal = shot(mesh(SCALE + "bool inputs:normalize = 1"), name="n.usda")
    assert far_field(lit(normal), (0, 0, 1)) == pytest.approx(2)


def test_a_closed_surface_sends_what_it_projects() -> None:
    """A sphere of many facets is seen as a disk from everywhere; a cube exactly as it projects."""
    steps = 24
    polar = np.linspace(0, pi, steps + 1)
    around = np.linspace(0, 2 * pi, 2 * steps + 1)
    p, a = np.meshgrid(polar, around, indexing="ij")
    points = np.stack([np.sin(p) * np.sin(a), np.cos(p), np.sin(p) * np.cos(a)], -1)
    row = np.arange(steps)[:, None] * (2 * steps + 1) + np.arange(2 * steps)
    faces = np.stack([row, row + 2 * steps + 1, row + 2 * steps + 2, row + 1], -1).reshape(-1, 4)
    ball = _core.Mesh(
        points.reshape(-1, 3).astype("f4"),
        np.full(len(faces), 4, np.int32),
        faces.ravel().astype(np.int32),
    )
    centre, area, facets = _core.mesh_light(ball, np.eye(4), "/ball")
    np.testing.assert_allclose(centre, 0, atol=1e-6)
    assert area == pytest.approx(4 * pi, rel=0.01)
    assert len(facets) < 400
    random = np.random.default_rng(1).normal(size=(100, 3))
    for way in random / np.linalg.norm(random, axis=1)[:, None]:
        assert np.maximum(facets[:, :3] @ way, 0).sum() == pytest.approx(area / 4, rel=0.01)


def test_material_sync_modes(shot: MakeShot) -> None:
    """The glow tints the light, or does not, or nothing but the light's own radiance is there."""
    tinted = lit(shot(mesh(BOUND)))
    assert tinted.energy == pytest.approx((0.5, 1, 2))
    made = shot(mesh(BOUND, "independent"), name="i.usda")
    assert lit(made).energy == (2, 2, 2)
    assert made.read().objects["/L"].material == "/M"
    for body in (mesh(BOUND, "noMaterialResponse"), mesh()):
        made = shot(body, name=f"{len(body)}.usda")
        assert lit(made).energy == (2, 2, 2)
        name = made.read().objects["/L"].material
        surface = made.read().materials[name].surface
        assert surface.constant("emissiveColor") == (2, 2, 2)
        assert surface.constant("diffuseColor") == (0, 0, 0)


def test_light_api_on_a_mesh_has_no_material_response(shot: MakeShot) -> None:
    made = shot(mesh(BOUND, apis='"LightAPI", "MaterialBindingAPI"'))
    assert lit(made).energy == (2, 2, 2)
    assert made.read().objects["/L"].material != "/M"


def test_the_radiance_that_is_seen_is_the_lights(tmp_path: Path) -> None:
    path = tmp_path / "shot.usda"
    camera = 'def Camera "C"\n{\ndouble3 xformOp:translate = (0, 0, 9)\n' + OPS + "}\n"
    path.write_text("#usda 1.0\n" + mesh("color3f inputs:color = (1, 0.5, 0.25)") + camera)
    np.testing.assert_allclose(picture(path)[4, 4], (2, 1, 0.5), rtol=1e-6)


def test_a_mesh_light_that_moves_deforms_dims_and_hides(shot: MakeShot) -> None:
    keys = """
point3f[] points.timeSamples = {
1: [(-1, -2, 0), (1, -2, 0), (1, 2, 0), (-1, 2, 0)],
2: [(-1, -2, 0), (1, -2, 0), (1, 3, 0), (-1, 3, 0)]}
float inputs:exposure.timeSamples = {2: 0, 3: 1}
token visibility.timeSamples = {3: "inherited", 4: "invisible"}
"""
    body = mesh(keys).replace(QUAD.splitlines()[2], "")
    made = shot(body, frames=(1, 2, 3, 4))
    whole = [far_field(lit(made, t), (0, 0, 1)) for t in (1, 2, 3)]
    assert whole == pytest.approx([16, 20, 40])
    assert lit(made, 2).aim == pytest.approx((0, 0.5, 0))
    assert "/L" not in made.read(4).lights
    assert "/L" not in made.read(4).objects
    assert lit(made, 3).energy == (4, 4, 4)
    assert made.read(3).materials["/L.light:radiance"].attributes["emissiveColor"] == (4, 4, 4)


@pytest.mark.parametrize(
    "body",
    [
        mesh().replace("[0, 1, 2, 3]", "[0, 1, 2, 9]"),
        mesh().replace("(-1, 2, 0)", "(nan, 2, 0)"),
    ],
)
def test_a_mesh_that_cannot_be_drawn_is_no_light(shot: MakeShot, body: str) -> None:
    made = shot(body)
    assert not made.read().lights
    (text,) = made.notices("skipped")
    assert "/L" in text


@pytest.mark.parametrize("normalize", [0, 1])
def test_a_mesh_without_area_gives_no_light(shot: MakeShot, normalize: int) -> None:
    flat = mesh(f"bool inputs:normalize = {normalize}").replace("2, 0)", "0, 0)")
    made = shot(flat.replace("-2, 0", "0, 0"))
    assert lit(made).energy == (0, 0, 0)
    assert any("no size" in text for text in made.notices("mentioned"))


@pytest.mark.parametrize("kind", ["Sphere", "Points", "BasisCurves"])
def test_lights_of_other_geometry_are_reported(shot: MakeShot, kind: str) -> None:
    made = shot(f'def {kind} "L" (prepend apiSchemas = ["LightAPI"])\n{{\n}}\n')
    assert any("lights made of" in text for text in made.notices("unsupported"))


@pytest.mark.parametrize(
    "body",
    [
        'def GeometryLight "L"\n{\n}\n',
        'def Volume "L" (prepend apiSchemas = ["VolumeLightAPI"])\n{\n}\n',
    ],
)
def test_geometry_and_volume_lights_are_reported(shot: MakeShot, body: str) -> None:
    made = shot(body)
    assert any("/L" in text for text in made.notices("unsupported"))
