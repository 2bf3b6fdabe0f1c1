# SPDX-License-Identifier: Apache-2.0
"""Prims that USD fails to read: skipped and reported, each alone; a camera's is fatal."""

import pytest
from pxr import Tf

from conftest import MakeShot
from irt_usd.errors import InputError
from irt_usd.stage.lights import LightSource
from irt_usd.stage.quadrics import QuadricSource

WRONG = 'string xformOp:translate = "abc"\nuniform token[] xformOpOrder = ["xformOp:translate"]\n'
WRONG_ORDER = 'string xformOpOrder = "abc"\n'


def test_an_op_of_the_wrong_type_skips_prim_and_descendants(shot: MakeShot) -> None:
    made = shot(
        f'def Xform "G"\n{{\n{WRONG}def Sphere "S"\n{{\n}}\n}}\ndef Sphere "T"\n{{\n}}\n'
        f'def SphereLight "L"\n{{\n{WRONG}}}'
    )
    snapshot = made.read()
    assert list(snapshot.objects) == ["/T"]
    assert not snapshot.lights
    (text,) = made.notices("skipped")
    assert "the transform cannot be read" in text
    for name in ("/G", "/L"):
        assert f"{name}.xformOp:translate in {made.path} at frame 1" in text


def test_an_op_order_of_the_wrong_type_is_not_fatal(shot: MakeShot) -> None:
    made = shot(f'def Sphere "S"\n{{\n{WRONG_ORDER}}}\ndef Sphere "T"\n{{\n}}')
    assert "/T" in made.read().objects


def test_a_camera_with_an_op_of_the_wrong_type_is_fatal(shot: MakeShot) -> None:
    with pytest.raises(InputError, match=r"/cam\.xformOp:translate in .*shot\.usda"):
        shot(f'def Camera "cam"\n{{\n{WRONG}}}').read()


def fail(*_arguments: object) -> None:
    Tf.RaiseRuntimeError("a damaged crate")


@pytest.mark.parametrize("method", ["__init__", "read"])
def test_any_error_of_one_prim_skips_it(
    shot: MakeShot, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    monkeypatch.setattr(QuadricSource, method, fail)
    monkeypatch.setattr(LightSource, method, fail)
    mesh = 'def Mesh "M"\n{\npoint3f[] points = [(0,0,0), (1,0,0), (0,1,0)]\n'
    mesh += "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n}\n"
    made = shot(mesh + 'def Sphere "S"\n{\n}\ndef SphereLight "L"\n{\n}\n')
    assert list(made.read().objects) == ["/M"]
    (text,) = made.notices("skipped")
    assert "a damaged crate" in text
    assert f"/S in {made.path}" in text
    assert f"/L in {made.path}" in text


def test_lights_that_give_no_light_are_mentioned(shot: MakeShot) -> None:
    keys = "float inputs:intensity.timeSamples = {1: 1, 2: 0}"
    made = shot(f'def SphereLight "L"\n{{\n{keys}\n}}', frames=(1, 2))
    made.read(1)
    assert not made.notices("mentioned")
    made.read(2)
    (text,) = made.notices("mentioned")
    assert text.startswith("note: no light gives light")
    assert text.endswith("frame 2")


def test_an_energy_out_of_range_names_the_file(shot: MakeShot) -> None:
    made = shot('def SphereLight "L"\n{\nfloat inputs:exposure = 1000\n}')
    made.read()
    (text,) = made.notices("skipped")
    assert f"/L.inputs:intensity in {made.path}" in text
