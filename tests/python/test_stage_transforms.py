# SPDX-License-Identifier: Apache-2.0
"""Transforms: composed as USD composes them, and refused where nothing can be drawn under them."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Usd, UsdGeom

from conftest import CAMERA, MakeShot
from irt_usd.changes import diff
from irt_usd.report import Report
from irt_usd.stage import ReadOptions, ShotReader, open_stage

SCALE = 'double3 xformOp:scale = {}\nuniform token[] xformOpOrder = ["xformOp:scale"]'
MATRIX = 'matrix4d xformOp:transform = {}\nuniform token[] xformOpOrder = ["xformOp:transform"]'
SPIN = 'float xformOp:rotateZ{} = {}\nuniform token[] xformOpOrder = [{}"xformOp:rotateZ"]'


@pytest.mark.parametrize(
    ("ops", "what"),
    [
        (SCALE.format("(1, nan, 1)"), "NaN"),
        (SCALE.format("(1, inf, 1)"), "infinity"),
        (SCALE.format("(1, 0, 1)"), "singular"),
        (MATRIX.format("((1,2,3,0),(2,4,6,0),(0,0,1,0),(0,0,0,1))"), "singular"),
        (MATRIX.format("((1,0,0,1),(0,1,0,0),(0,0,1,0),(0,0,0,1))"), "projective"),
    ],
)
def test_unusable_transform_of_an_ancestor(shot: MakeShot, ops: str, what: str) -> None:
    made = shot(f'def Xform "G"\n{{\n{ops}\ndef Sphere "S"\n{{\n}}\n}}\ndef Sphere "T"\n{{\n}}')
    assert list(made.read().objects) == ["/T"]
    (text,) = made.notices("skipped")
    assert what in text
    assert "/G.xformOp:" in text
    assert "shot.usda" in text


@pytest.mark.parametrize("scale", ["(1e-6, 1e-6, 1e-6)", "(1e9, 1e9, 1e9)", "(1, 1, 1e-9)"])
def test_extreme_scales_are_fine(shot: MakeShot, scale: str) -> None:
    ops = SCALE.format(scale)
    assert shot(f'def Sphere "S"\n{{\n{ops}\n}}').read().objects


def test_a_transform_broken_at_one_frame(shot: MakeShot) -> None:
    ops = SCALE.replace(" = {}", ".timeSamples = {{1: (1,1,1), 2: (0,1,1), 3: (1,1,1)}}").format()
    made = shot(f'def Sphere "S"\n{{\n{ops}\n}}')
    assert [len(made.read(t).objects) for t in (1, 2, 3, 2)] == [1, 0, 1, 0]
    assert len(made.notices("skipped")) == 1


def test_reset_xform_stack(shot: MakeShot) -> None:
    ops = SPIN.format("", 0, '"!resetXformStack!", ')
    child = f'def Sphere "S"\n{{\n{ops}\n}}'
    outer = "double3 xformOp:translate.timeSamples = {1: (1,0,0), 2: (2,0,0)}"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    made = shot(f'def Xform "G"\n{{\n{outer}\n{order}\n{child}\n}}')
    first = made.read(1).objects["/G/S"]
    assert (first.world_from_object == np.eye(4)).all()
    assert made.read(2).objects["/G/S"] is first


def test_splined_op(shot: MakeShot) -> None:
    spline = "double xformOp:translateX.spline = {\n1: 0; post linear,\n11: 10,\n}"
    order = 'uniform token[] xformOpOrder = ["xformOp:translateX"]'
    made = shot(f'def Sphere "S"\n{{\n{spline}\n{order}\n}}')
    places = [made.read(t).objects["/S"].world_from_object[3, 0] for t in (1, 6, 11)]
    assert places[0] == 0
    assert 0 < places[1] < 10
    assert places[2] == 10


def test_moving_ancestor_moves_descendants_only(shot: MakeShot) -> None:
    outer = "double3 xformOp:translate.timeSamples = {1: (1,0,0), 2: (2,0,0), 3: (2,0,0)}"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    still = 'def Sphere "T"\n{\n}'
    made = shot(f'def Xform "G"\n{{\n{outer}\n{order}\ndef Sphere "S"\n{{\n}}\n}}\n{still}')
    one, two, three = (made.read(t) for t in (1, 2, 3))
    assert one.objects["/T"] is two.objects["/T"]
    assert one.objects["/G/S"] is not two.objects["/G/S"]
    assert two.objects is three.objects
    assert two.objects["/G/S"].world_from_object[3, 0] == 2


NUMBER = st.floats(-100, 100, width=32)


@st.composite
def random_chain(draw: st.DrawFn) -> str:
    """Nested prims with random ops, some keyed, some resetting the stack."""
    text = 'def Sphere "leaf"\n{\n}'
    for level in range(draw(st.integers(1, 5))):
        names, lines = [], []
        for name, arity in (("translate", 3), ("rotateXYZ", 3), ("scale", 3), ("rotateY", 1)):
            if not draw(st.booleans()):
                continue
            low = 0.5 if name == "scale" else -100
            number = st.floats(low, 100, width=32)

            def value(number: st.SearchStrategy[float] = number, arity: int = arity) -> str:
                parts = [repr(draw(number)) for _ in range(arity)]
                return parts[0] if arity == 1 else f"({', '.join(parts)})"

            names.append(f'"xformOp:{name}"')
            typed = "float" if arity == 1 else "float3"
            if draw(st.booleans()):
                keys = ", ".join(f"{t}: {value()}" for t in (1, 4, 7))
                lines.append(f"{typed} xformOp:{name}.timeSamples = {{{keys}}}")
            else:
                lines.append(f"{typed} xformOp:{name} = {value()}")
        if draw(st.integers(0, 5)) == 0:
            names.insert(0, '"!resetXformStack!"')
        lines.append(f"uniform token[] xformOpOrder = [{', '.join(names)}]")
        kind = draw(st.sampled_from(["Xform", "Scope", "Cube"]))
        body = "\n".join(lines)
        text = f'def {kind} "n{level}"\n{{\n{body}\n{text}\n}}'
    return text


@settings(max_examples=60, deadline=None)
@given(random_chain(), st.lists(st.sampled_from([1.0, 2.5, 4.0, 7.0, 9.0]), min_size=2, max_size=5))
def test_shot_equals_usd_and_equals_a_fresh_reading(chain: str, times: list[float]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.usda"
        path.write_text(f"#usda 1.0\n{chain}\n{CAMERA}")
        stage = open_stage(str(path))
        reader = ShotReader(stage, ReadOptions(), Report(), times)
        for time in times:
            snapshot = reader.read(time)
            cache = UsdGeom.XformCache(Usd.TimeCode(time))
            for name, state in snapshot.objects.items():
                expected = np.array(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(name)))
                assert state.world_from_object == pytest.approx(expected)
            fresh = ShotReader(open_stage(str(path)), ReadOptions(), Report(), [time]).read(time)
            assert not diff(fresh, snapshot).changes
