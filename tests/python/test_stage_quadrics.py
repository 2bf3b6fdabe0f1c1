# SPDX-License-Identifier: Apache-2.0
"""Solids: keyed sizes, axes folded into the placement, what cannot be drawn."""

import numpy as np
import pytest

from conftest import MakeShot
from irt_usd import _core as core

KINDS = ["Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane", "Cylinder_1", "Capsule_1"]


@pytest.mark.parametrize("kind", KINDS)
def test_fallback_sizes(shot: MakeShot, kind: str) -> None:
    state = shot(f'def {kind} "S"\n{{\n}}').read().objects["/S"]
    sizes: dict[str, dict[str, object]] = {
        "Sphere": {"radius": 1.0},
        "Cube": {"size": 2.0},
        "Cylinder": {"radius": 1.0, "height": 2.0, "axis": "Z"},
        "Cone": {"radius": 1.0, "height": 2.0, "axis": "Z"},
        "Capsule": {"radius": 0.5, "height": 1.0, "axis": "Z"},
        "Plane": {"width": 2.0, "length": 2.0, "axis": "Z", "doubleSided": True},
        "Cylinder_1": {"radiusBottom": 1.0, "radiusTop": 1.0, "height": 2.0, "axis": "Z"},
        "Capsule_1": {"radiusBottom": 0.5, "radiusTop": 0.5, "height": 1.0, "axis": "Z"},
    }
    assert state.shape.attributes == {"typeName": kind, **sizes[kind]}


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
def test_the_cores_z_axis_lands_on_the_authored_axis_and_keeps_its_hand(
    shot: MakeShot, axis: str
) -> None:
    ops = 'double3 xformOp:scale = (2, 3, 5)\nuniform token[] xformOpOrder = ["xformOp:scale"]'
    body = f'def Cone "S"\n{{\nuniform token axis = "{axis}"\n{ops}\n}}'
    state = shot(body).read().objects["/S"]
    placed = state.shape.place(state.world_from_object)
    world = dict(zip("XYZ", state.world_from_object[:3, :3], strict=True))
    assert (placed[2, :3] == world[axis]).all()
    assert np.linalg.det(placed[:3, :3]) == pytest.approx(30)
    assert (placed[3] == state.world_from_object[3]).all()


@pytest.mark.parametrize(("axis", "extent"), [("X", (0, 6, 4)), ("Y", (4, 0, 6)), ("Z", (4, 6, 0))])
def test_plane_width_and_length(shot: MakeShot, axis: str, extent: tuple[int, int, int]) -> None:
    made = {}

    def plane(width: float, length: float) -> object:
        made["size"] = (width, length)
        return core.Quadric.sphere(1)

    body = (
        f'def Plane "S"\n{{\nuniform token axis = "{axis}"\ndouble width = 4\ndouble length = 6\n}}'
    )
    state = shot(body).read().objects["/S"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(core, "Quadric", type("Quadric", (), {"plane": staticmethod(plane)}))
        patch.setattr(core.Quadric, "sphere", lambda _: None, raising=False)
        state.shape.geometry()
    width, length = made["size"]
    placed = state.shape.place(state.world_from_object)
    found = np.abs(placed[0, :3] * width + placed[1, :3] * length)
    assert tuple(found) == extent


def test_keyed_radius(shot: MakeShot) -> None:
    made = shot('def Sphere "S"\n{\ndouble radius.timeSamples = {1: 1, 3: 2, 9: 2}\n}')
    first, second, third = (made.read(t).objects["/S"] for t in (1, 2, 3))
    radii = [s.shape.attributes["radius"] for s in (first, second, third)]
    assert radii == [1.0, 1.5, 2.0]
    assert made.read(5).objects["/S"] is third


def test_blocked_sample_means_the_fallback(shot: MakeShot) -> None:
    made = shot('def Sphere "S"\n{\ndouble radius.timeSamples = {1: 3, 2: None, 4: 3}\n}')
    radii = [made.read(t).objects["/S"].shape.attributes["radius"] for t in (1, 2, 3, 4)]
    assert radii == [3, 1, 1, 3]


@pytest.mark.parametrize("value", ["nan", "inf", "-1"])
def test_impossible_size_is_skipped_and_located(shot: MakeShot, value: str) -> None:
    made = shot(f'def Sphere "S"\n{{\ndouble radius = {value}\n}}\ndef Cube "C"\n{{\n}}')
    assert list(made.read().objects) == ["/C"]
    (text,) = made.notices("skipped")
    assert "/S.radius in " in text
    assert "shot.usda" in text


def test_wrong_type_means_the_fallback_and_is_located(shot: MakeShot) -> None:
    made = shot('def Sphere "S"\n{\nasset radius = @x@\n}\ndef Cube "C"\n{\nint size = 3\n}')
    objects = made.read().objects
    assert objects["/S"].shape.attributes["radius"] == 1
    assert objects["/C"].shape.attributes["size"] == 3.0
    (text,) = made.notices("skipped")
    assert "/S.radius in " in text


def test_no_size_is_mentioned(shot: MakeShot) -> None:
    made = shot('def Sphere "S"\n{\ndouble radius = 0\n}')
    assert not made.read().objects
    assert not made.notices("skipped")
    assert any("/S.radius" in text for text in made.notices("mentioned"))


def test_a_capsule_without_a_spine_is_a_ball(shot: MakeShot) -> None:
    state = shot('def Capsule "S"\n{\ndouble height = 0\n}').read().objects["/S"]
    state.add_to(core.ChangeSet())  # the core refuses lengths of 0
    assert state.shape.attributes["height"] == 0


@pytest.mark.parametrize("kind", ["Cylinder_1", "Capsule_1"])
def test_of_two_radii_one_may_be_zero(shot: MakeShot, kind: str) -> None:
    text = f'def {kind} "S"\n{{\ndouble radiusTop = 0\n}}'
    shot(text).read().objects["/S"].add_to(core.ChangeSet())
    made = shot(text.replace("}", "double radiusBottom = 0\n}"))
    assert not made.read().objects
    assert any("of no size" in notice for notice in made.notices("mentioned"))


def test_bad_axis_is_skipped(shot: MakeShot) -> None:
    made = shot('def Cone "S"\n{\nuniform token axis = "W"\n}')
    assert not made.read().objects
    assert "expected X, Y or Z" in made.notices("skipped")[0]


@pytest.mark.parametrize("kind", KINDS)
def test_core_record(shot: MakeShot, kind: str) -> None:
    state = shot(f'def {kind} "S"\n{{\n}}').read().objects["/S"]
    assert isinstance(state.shape.geometry(), core.Quadric)
