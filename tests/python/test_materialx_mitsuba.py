# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3 as judge of MaterialX's surface models, where its closures and ours coincide.

Those are a matt dielectric without a specular lobe, and a rough metal: GGX and Schlick's Fresnel,
both of the same roughness squared.
"""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Usd

import mitsuba_judge as judge
from mitsuba_judge import Look, Scene, ball, quad
from test_materialx_surfaces import source

for name in ("mitsuba", "flip_evaluator"):
    pytest.importorskip(name, reason=f"{name} is missing: pip install {name}")

RED = (0.7, 0.2, 0.1)
GOLD = (0.9, 0.6, 0.3)
ROUGHNESS = 0.5

MATT: dict[str, dict[str, Any]] = {
    "standard_surface": {"base": 1.0, "base_color": RED, "specular": 0.0},
    "open_pbr_surface": {"base_color": RED, "specular_weight": 0.0},
    "gltf_pbr": {"base_color": RED, "metallic": 0.0, "specular": 0.0, "roughness": 1.0},
    "UsdPreviewSurface": {"diffuseColor": RED, "ior": 1.0, "roughness": 1.0},
}
METAL: dict[str, dict[str, Any]] = {
    "standard_surface": {"base": 1.0, "base_color": GOLD, "metalness": 1.0,
                         "specular_roughness": ROUGHNESS},
    "open_pbr_surface": {"base_color": GOLD, "base_metalness": 1.0,
                         "specular_roughness": ROUGHNESS},
    "gltf_pbr": {"base_color": GOLD, "metallic": 1.0, "roughness": ROUGHNESS},
    "UsdPreviewSurface": {"specularColor": GOLD, "useSpecularWorkflow": 1,
                          "diffuseColor": (0.0, 0.0, 0.0), "roughness": ROUGHNESS},
}  # fmt: skip

LAMPS: list[Any] = [((0.5, 0.8, 0.0), 6.0), ((-0.4, 0.3, 0.2), 4.0)]


def material(model: str, inputs: dict[str, Any]) -> Any:
    _stage, made, report = source(model, inputs)
    assert not report.notices
    return made.read(Usd.TimeCode(1)).core()


def scene(matt: Any, metal: Any) -> Scene:
    """Two balls before a wall; the materials are the core's, None for Mitsuba."""
    diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(RED)}}
    principled = {
        "type": "principled",
        "base_color": {"type": "rgb", "value": list(GOLD)},
        "metallic": 1.0,
        "roughness": ROUGHNESS,
    }
    shapes = [
        quad((-6, -5, -4), (12, 0, 0), (0, 10, 0), Look((0.4, 0.45, 0.5))),
        ball((-0.9, 0, -2.5), 0.7, Look(given=(matt, diffuse)), 24, smooth=True),
        ball((0.9, 0, -2.5), 0.7, Look(given=(metal, principled)), 24, smooth=True),
    ]
    return Scene(shapes, LAMPS)


@pytest.fixture(scope="module")
def reference() -> NDArray[np.float32]:
    return judge.render_mitsuba(scene(None, None))


@pytest.mark.parametrize("model", MATT)
def test_a_matt_ball_and_a_metal_one(model: str, reference: NDArray[np.float32]) -> None:
    ours = judge.render_irt(scene(material(model, MATT[model]), material(model, METAL[model])))
    verdict = judge.compare(ours, reference)
    assert verdict.worst_region <= 0.01, verdict
    assert verdict.flip <= 0.02, verdict
