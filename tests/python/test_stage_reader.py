# SPDX-License-Identifier: Apache-2.0
"""The reader: what is listed, what is read again, and that a shot equals its frames."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import CAMERA, MakeShot
from irt_usd.changes import diff
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage import ReadOptions, ShotReader, open_stage
from irt_usd.stage.values import Value, same_bits

SPHERE = 'def Sphere "{}"\n{{\n{}\n}}\n'


def test_no_frames(shot: MakeShot) -> None:
    with pytest.raises(InputError, match="no frames"):
        shot("", frames=())


def test_nothing_that_varies(shot: MakeShot) -> None:
    made = shot(SPHERE.format("S", ""), frames=(1, 2))
    one, two = made.read(1), made.read(2)
    assert (one.time, two.time) == (1, 2)
    assert one.objects is two.objects
    assert one.materials is two.materials
    assert one.lights is two.lights
    assert one.camera is two.camera


def test_values_that_may_vary_and_do_not(shot: MakeShot) -> None:
    made = shot(SPHERE.format("S", "double radius.timeSamples = {1: 2, 5: 2}"))
    assert made.read(1).objects is made.read(3).objects


@pytest.mark.parametrize(
    ("a", "b", "same"),
    [
        (0.0, 0.0, True),
        (0.0, -0.0, False),
        (1, 1.0, False),
        ((1.0, 0.0), (1.0, -0.0), False),
        (np.zeros(2), np.array([0.0, -0.0]), False),
        (np.zeros(2), np.zeros(2, np.float32), False),
        (np.zeros((2, 3)), np.zeros((3, 2)), False),
        (np.array(["a"]), np.array(["a"]), True),
        (np.zeros((2, 3)).T, np.zeros((3, 2)), True),
        (None, None, True),
    ],
)
def test_values_are_compared_by_bits(a: Value, b: Value, same: bool) -> None:
    assert same_bits(a, b) == same


def test_inherited_visibility(shot: MakeShot) -> None:
    keys = 'token visibility.timeSamples = {1: "inherited", 2: "invisible", 3: "inherited"}\n'
    made = shot(
        'def Xform "G"\n{\n' + keys + SPHERE.format("S", "") + "}\n" + SPHERE.format("T", "")
    )
    assert [sorted(made.read(t).objects) for t in (1, 2, 3)] == [
        ["/G/S", "/T"],
        ["/T"],
        ["/G/S", "/T"],
    ]
    assert made.read(2).hidden == {"/G/S"}
    assert made.read(1).objects["/G/S"] is made.read(3).objects["/G/S"]


def test_a_static_invisible_prim_stays_hidden(shot: MakeShot) -> None:
    blinking = 'token visibility.timeSamples = {1: "inherited", 2: "invisible"}'
    made = shot(SPHERE.format("S", 'token visibility = "invisible"') + SPHERE.format("T", blinking))
    assert made.read(1).hidden == {"/S"}
    assert made.read(2).hidden == {"/S", "/T"}


def test_purposes(shot: MakeShot) -> None:
    body = "".join(
        f'def Xform "{p}"\n{{\nuniform token purpose = "{p}"\n{SPHERE.format("S", "")}}}\n'
        for p in ("default", "render", "proxy", "guide")
    )
    assert sorted(shot(body).read().objects) == ["/default/S", "/render/S"]
    options = ReadOptions(purposes=("default", "proxy"))
    assert sorted(shot(body, options=options).read().objects) == ["/default/S", "/proxy/S"]


@pytest.mark.parametrize(
    ("purpose", "count"),
    [
        ("uniform token purpose", 0),
        ("uniform token purpose = None", 0),
        ('uniform token purpose = "default"', 1),
    ],
)
def test_a_purpose_without_a_value_is_inherited(shot: MakeShot, purpose: str, count: int) -> None:
    child = SPHERE.format("S", purpose)
    body = f'def Xform "X"\n{{\nuniform token purpose = "guide"\n{child}}}\n'
    assert len(shot(body).read().objects) == count


def test_a_purpose_of_another_type_is_none(shot: MakeShot) -> None:
    assert list(shot(SPHERE.format("S", "int purpose = 1")).read().objects) == ["/S"]


def test_inactive_and_abstract_prims(shot: MakeShot) -> None:
    body = 'def Sphere "S" (\nactive = false\n)\n{\n}\nclass Sphere "C"\n{\n}\nover "O"\n{\n}\n'
    assert not shot(body).read().objects


def test_native_instances_are_objects_of_their_own(shot: MakeShot) -> None:
    proto = 'class Xform "P"\n{\n' + SPHERE.format("S", "") + "}\n"
    order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    ops = "double3 xformOp:translate = ({}, 0, 0)\n" + order
    instance = 'def Xform "{}" (\nreferences = </P>\ninstanceable = true\n)\n{{\n{}\n}}\n'
    body = proto + instance.format("I", ops.format(1)) + instance.format("J", ops.format(2))
    objects = shot(body).read().objects
    assert {p: s.world_from_object[3, 0] for p, s in objects.items()} == {"/I/S": 1, "/J/S": 2}


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("HermiteCurves", "Hermite curves"),
        ("NurbsCurves", "NURBS curves"),
        ("NurbsPatch", "NURBS patches"),
        ("Volume", "volumes"),
    ],
)
def test_unsupported_prims_are_reported_once_and_the_rest_renders(
    shot: MakeShot, kind: str, name: str
) -> None:
    other = f'def {kind} "A"\n{{\n{SPHERE.format("inner", "")}}}\ndef {kind} "B"\n{{\n}}\n'
    made = shot(other + SPHERE.format("S", ""))
    assert "/S" in made.read().objects
    assert f"not supported: {name}: /A, /B" in made.notices("unsupported")


def test_strict_lists_everything(shot: MakeShot) -> None:
    body = SPHERE.format("S", "double radius = nan") + 'def Volume "P"\n{\n}\n'
    made = shot(body)
    made.read()
    made.report.enforce("refused")
    made.report.strict = True
    with pytest.raises(InputError) as refused:
        made.report.enforce("refused")
    assert "/S.radius" in str(refused.value)
    assert "volumes: /P" in str(refused.value)


def test_notices_are_taken_once() -> None:
    report = Report()
    report.skipped("a", "/A")
    assert [n.text for n in report.take_new()] == ["skipped: a: /A"]
    for path in "ABCDEFG":
        report.skipped("a", f"/{path}")
    assert [n.text for n in report.take_new()] == [
        "skipped: a: /B, /C, /D, /E, /F and 1 more"  # further prims, not /A again
    ]
    assert not report.take_new()
    report.unsupported("b", "/A")
    report.take_new()
    report.unsupported("b", "/B")
    assert not report.take_new()
    assert report.notices[0].text == "skipped: a: /A, /B, /C, /D, /E and 2 more"


CHOICES = st.sampled_from
KEYED = {
    "double radius": ["1", "2", "2.5"],
    "double3 xformOp:translate": ["(0,0,0)", "(1,0,0)", "(0,2,0)"],
    "token visibility": ['"inherited"', '"invisible"'],
    "color3f[] primvars:displayColor": ["[(1,0,0)]", "[(0,1,0)]"],
}
LIT = {
    "float inputs:intensity": ["1", "2"],
    "double3 xformOp:translate": ["(0,0,0)", "(1,0,0)"],
    "token visibility": ['"inherited"', '"invisible"'],
}


@st.composite
def random_shot(draw: st.DrawFn) -> str:
    """Spheres in groups and lights, each attribute absent, constant or keyed."""

    def attributes(of: dict[str, list[str]]) -> str:
        lines = ['uniform token[] xformOpOrder = ["xformOp:translate"]']
        for name, values in of.items():
            how = draw(CHOICES(["absent", "constant", "keyed"]))
            if how == "constant" or (how == "absent" and "xformOp" in name):
                lines.append(f"{name} = {draw(CHOICES(values))}")
            elif how == "keyed":
                keys = ", ".join(f"{t}: {draw(CHOICES(values))}" for t in (1, 3, 5))
                lines.append(f"{name}.timeSamples = {{{keys}}}")
        return "\n".join(lines)

    text = ""
    for i in range(draw(st.integers(1, 3))):
        group = {k: v for k, v in KEYED.items() if "radius" not in k}
        inner = SPHERE.format("S", attributes(KEYED)) + SPHERE.format("T", attributes(KEYED))
        text += f'def Xform "G{i}"\n{{\n{attributes(group)}\n{inner}}}\n'
    for i in range(draw(st.integers(0, 2))):
        text += f'def SphereLight "L{i}"\n{{\n{attributes(LIT)}\n}}\n'
    return text


@settings(max_examples=60, deadline=None)
@given(random_shot(), st.lists(CHOICES([1.0, 2.0, 3.0, 4.5, 5.0, 9.0]), min_size=2, max_size=6))
def test_a_shot_equals_its_frames(body: str, times: list[float]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.usda"
        path.write_text(f"#usda 1.0\n{body}\n{CAMERA}")
        reader = ShotReader(open_stage(str(path)), ReadOptions(), Report(), times)
        for time in times:
            found = reader.read(time)
            fresh = ShotReader(open_stage(str(path)), ReadOptions(), Report(), [time]).read(time)
            assert not diff(fresh, found).changes
            assert not diff(found, fresh).changes
            assert fresh.hidden == found.hidden
