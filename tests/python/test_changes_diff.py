# SPDX-License-Identifier: Apache-2.0
"""Change lists: every change with its values, what it makes stale, and its record for the core."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import CAMERA, MakeShot
from irt_usd.changes import Change, ChangeList, diff

MOVED = "double3 xformOp:translate.timeSamples = {1: (0,0,0), 2: (1,0,0)}\n"
ORDER = 'uniform token[] xformOpOrder = ["xformOp:translate"]\n'
BOUND = """
def Sphere "A" (
prepend apiSchemas = ["MaterialBindingAPI"]
)
{
rel material:binding = </M>
}
"""
MATERIAL = """
def Material "M"
{{
token outputs:surface.connect = </M/P.outputs:surface>
def Shader "P"
{{
uniform token info:id = "UsdPreviewSurface"
{}
token outputs:surface
}}
}}
"""


def prim(kind: str, body: str) -> str:
    return f'def {kind} "A"\n{{\n{body}\n}}\n'


def between(shot: MakeShot, body: str) -> ChangeList:
    made = shot(body, frames=(1, 2))
    first = made.read(1)
    return diff(first, made.read(2))


def only(changes: ChangeList) -> Change:
    (change,) = changes.changes
    return change


def test_from_nothing(shot: MakeShot) -> None:
    changes = diff(
        None, shot(prim("Sphere", "") + prim("SphereLight", "").replace("A", "B")).read()
    )
    assert changes.initial
    assert not changes.camera
    assert {c.attribute for c in changes.changes} == {"(added)"}
    assert [c.path for c in changes.changes] == ["/A", "irt:default", "/B"]
    assert changes.summary() == "1 object, 1 material, 1 light"


def test_nothing_changed(shot: MakeShot) -> None:
    changes = between(shot, prim("Sphere", "double radius.timeSamples = {1: 1, 2: 1}"))
    assert not changes.changes
    assert not changes.initial
    assert changes.summary() == "nothing"


def test_moved(shot: MakeShot) -> None:
    changes = between(shot, prim("Sphere", MOVED + ORDER))
    change = only(changes)
    assert (change.path, change.attribute) == ("/A", "world_from_object")
    assert change.invalidates == "visibility and shading"
    assert isinstance(change.old, np.ndarray)
    assert isinstance(change.new, np.ndarray)
    assert (change.old[3, 0], change.new[3, 0]) == (0, 1)
    assert changes.summary() == "1 moved"


@pytest.mark.parametrize(
    ("kind", "line", "attribute", "old", "new", "invalidates", "summary"),
    [
        (
            "Sphere",
            "double radius.timeSamples = {1: 1, 2: 2}",
            "radius",
            1.0,
            2.0,
            "visibility and shading",
            "1 deformed",
        ),
        (
            "Sphere",
            'token visibility.timeSamples = {1: "inherited", 2: "invisible"}',
            "visibility",
            "inherited",
            "invisible",
            "visibility and shading",
            "1 gone",
        ),
        (
            "Sphere",
            'token visibility.timeSamples = {1: "invisible", 2: "inherited"}',
            "visibility",
            "invisible",
            "inherited",
            "visibility and shading",
            "1 appeared",
        ),
        (
            "Sphere",
            "double radius.timeSamples = {1: 1, 2: nan}",
            "(removed)",
            None,
            None,
            "visibility and shading",
            "1 gone",
        ),
        (
            "SphereLight",
            "color3f inputs:color.timeSamples = {1: (1,1,1), 2: (1,0,0)}",
            "inputs:color",
            (1.0, 1.0, 1.0),
            (1.0, 0.0, 0.0),
            "light energy only (no rays)",
            "1 light energy",
        ),
        (
            "SphereLight",
            "float inputs:radius.timeSamples = {1: 1, 2: 2}",
            "inputs:radius",
            1.0,
            2.0,
            "light energy only (no rays)",
            "1 light energy",
        ),
        (
            "SphereLight",
            "float inputs:intensity.timeSamples = {1: 0, 2: 2}",
            "inputs:intensity",
            0.0,
            2.0,
            "shadow rays",
            "1 light",
        ),
        (
            "SphereLight",
            "float inputs:intensity.timeSamples = {1: 2, 2: 0}",
            "inputs:intensity",
            2.0,
            0.0,
            "light energy only (no rays)",
            "1 light energy",
        ),
        (
            "SphereLight",
            "bool inputs:shadow:enable.timeSamples = {1: 1, 2: 0}",
            "inputs:shadow:enable",
            True,
            False,
            "shadow rays",
            "1 light",
        ),
        (
            "SphereLight",
            'token visibility.timeSamples = {1: "inherited", 2: "invisible"}',
            "visibility",
            "inherited",
            "invisible",
            "light energy only (no rays)",
            "1 light",
        ),
        (
            "SphereLight",
            'token visibility.timeSamples = {1: "invisible", 2: "inherited"}',
            "visibility",
            "invisible",
            "inherited",
            "shadow rays",
            "1 light",
        ),
    ],
)
def test_one_change(
    shot: MakeShot,
    kind: str,
    line: str,
    attribute: str,
    old: object,
    new: object,
    invalidates: str,
    summary: str,
) -> None:
    changes = between(shot, prim(kind, line))
    change = only(changes)
    assert (change.path, change.attribute) == ("/A", attribute)
    assert (change.old, change.new) == (old, new)
    assert change.invalidates == invalidates
    assert changes.summary() == summary


def test_moved_light(shot: MakeShot) -> None:
    change = only(between(shot, prim("SphereLight", MOVED + ORDER)))
    assert change.attribute == "world_from_object"
    assert change.invalidates == "shadow rays"


def test_a_moved_distant_light_lights_as_before(shot: MakeShot) -> None:
    change = only(between(shot, prim("DistantLight", MOVED + ORDER)))
    assert change.attribute == "world_from_object"
    assert change.invalidates == "light energy only (no rays)"


@pytest.mark.parametrize(
    ("line", "attribute", "invalidates"),
    [
        (
            "color3f inputs:diffuseColor.timeSamples = {1: (1,1,1), 2: (1,0,0)}",
            "diffuseColor",
            "shading",
        ),
        (
            "color3f inputs:emissiveColor.timeSamples = {1: (1,1,1), 2: (1,0,0)}",
            "emissiveColor",
            "shading",
        ),
        ("float inputs:opacity.timeSamples = {1: 1, 2: 0.5}", "opacity", "spawned rays"),
        ("float inputs:roughness.timeSamples = {1: 1, 2: 0}", "roughness", "spawned rays"),
        ("float inputs:ior.timeSamples = {1: 1.5, 2: 1.25}", "ior", "spawned rays"),
    ],
)
def test_material(shot: MakeShot, line: str, attribute: str, invalidates: str) -> None:
    changes = between(shot, BOUND + MATERIAL.format(line))
    change = only(changes)
    assert (change.path, change.attribute) == ("/M", attribute)
    assert change.invalidates == invalidates
    assert changes.summary() == "1 material"


def test_normals_and_points(shot: MakeShot) -> None:
    body = """
uniform token subdivisionScheme = "none"
int[] faceVertexCounts = [3]
int[] faceVertexIndices = [0, 1, 2]
point3f[] points{} [(0,0,0), (1,0,0), (0,1,0)]{}
normal3f[] normals{} [(0,0,1), (0,0,1), (0,0,1)]{}
"""
    keyed = (".timeSamples = {1:", ", 2: [(0,0,2), (1,0,0), (0,1,0)]}")
    normals = only(between(shot, prim("Mesh", body.format(" =", "", *keyed))))
    assert (normals.attribute, normals.invalidates) == ("normals", "spawned rays")
    points = only(between(shot, prim("Mesh", body.format(*keyed, " =", ""))))
    assert (points.attribute, points.invalidates) == ("points", "visibility and shading")


def test_camera(shot: MakeShot) -> None:
    camera = (
        f'def Camera "A"\n{{\n{MOVED}{ORDER}float focalLength.timeSamples = {{1: 50, 2: 60}}\n}}\n'
    )
    body = camera + prim("SphereLight", "").replace("A", "L")
    changes = between(shot, body)
    assert changes.camera
    assert {c.attribute for c in changes.changes} == {"focalLength", "world_from_object"}
    assert {c.invalidates for c in changes.changes} == {"everything (restart)"}
    assert changes.summary() == "camera"


def test_many_at_once_are_in_order_of_kind_and_path(shot: MakeShot) -> None:
    spheres = "".join(prim("Sphere", MOVED + ORDER).replace('"A"', f'"{n}"') for n in "CBA")
    light = prim("SphereLight", "float inputs:intensity.timeSamples = {1: 1, 2: 2}")
    changes = between(shot, spheres + light.replace('"A"', '"0L"'.replace("0", "l")))
    assert [c.path for c in changes.changes] == ["/A", "/B", "/C", "/lL"]
    assert changes.summary() == "3 moved, 1 light energy"


def test_readings_by_different_readers_agree(shot: MakeShot) -> None:
    body = prim("Sphere", MOVED + ORDER)
    first, second = shot(body), shot(body, name="again.usda")
    assert not diff(first.read(2), second.read(2)).changes
    assert diff(first.read(1), second.read(2)).summary() == "1 moved"


def test_core_takes_every_change(shot: MakeShot) -> None:
    from irt_usd import _core as core

    blink = 'token visibility.timeSamples = {1: "inherited", 2: "invisible", 3: "inherited"}\n'
    keyed = "double radius.timeSamples = {1: 1, 2: 1, 3: 1, 4: 2}\n"
    colour = "color3f[] primvars:displayColor.timeSamples = {4: [(1,0,0)], 5: [(0,1,0)]}\n"
    lamp = "color3f inputs:color.timeSamples = {5: (1,1,1), 6: (0,0,1)}\n" + blink
    body = (
        prim("Sphere", blink + keyed + colour)
        + prim("Cube", MOVED + ORDER).replace('"A"', '"B"')
        + prim(
            "SphereLight",
            "float inputs:intensity = 30\n" + lamp + ORDER + MOVED.replace("(0,0,0)", "(0,0,5)"),
        ).replace('"A"', '"L"')
    )
    made = shot(body + CAMERA, frames=(1, 2, 3, 4, 5, 6, 7))
    settings = core.ViewSettings(24, 18)

    def film(changes: ChangeList, renderer: Any) -> NDArray[np.float32]:
        renderer.update(changes.core)
        return np.array(renderer.beauty())

    previous = None
    renderer = None
    films = []
    for time in (1, 2, 3, 4, 5, 6, 7):
        snapshot = made.read(time)
        renderer = renderer or core.Renderer(snapshot.camera.core(), settings, threads=1)
        changes = diff(previous, snapshot)
        assert changes.core.empty == (not changes.changes)
        films.append(film(changes, renderer))
        fresh = core.Renderer(snapshot.camera.core(), settings, threads=1)
        assert films[-1].tobytes() == film(diff(None, snapshot), fresh).tobytes()
        previous = snapshot
    assert films[0].any()
    assert (films[0] != films[1]).any()
    assert films[5].tobytes() == films[6].tobytes()
