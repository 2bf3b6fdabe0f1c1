# SPDX-License-Identifier: Apache-2.0
"""UsdRenderPass: which pass, its settings, and its collections, told in pictures."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from cli_support import CAMERA, LAMP, SCENE, failure, irt, stage_of, write_stage
from conftest import MakeShot
from irt_usd.changes import diff
from irt_usd.stage import ReadOptions, Snapshot

SIZE = ("--size", "48x27", "-f", "1")
WHERE = """double3 xformOp:translate = ({}, 1, 0)
uniform token[] xformOpOrder = ["xformOp:translate"]"""

PAIR = """def Sphere "A"
{
    double radius = 0.4
}
def Cube "B"
{
    double size = 0.5
}
"""
INSTANCES = f"""
class Xform "_Pair"
{{
{PAIR}
}}
def Xform "One" (
    instanceable = true
    inherits = </_Pair>
)
{{
}}
def Xform "Two" (
    instanceable = true
    inherits = </_Pair>
)
{{
}}
def PointInstancer "Many"
{{
    rel prototypes = [</Many/P>, </Elsewhere>]
    int[] protoIndices = [0, 1]
    point3f[] positions = [(0, 0, 0), (2, 0, 0)]
    def Xform "P"
    {{
{PAIR}
    }}
}}
def Xform "Elsewhere"
{{
    def Sphere "C"
    {{
        double radius = 0.4
    }}
}}
def Scope "Sets" (
    prepend apiSchemas = ["CollectionAPI:inner", "CollectionAPI:outer"]
)
{{
    rel collection:inner:includes = [</One/A>, </Two>]
    rel collection:outer:includes = </Sets.collection:inner>
    rel collection:outer:excludes = </Two/B>
}}
"""


ONLY_MANY = """uniform bool collection:renderVisibility:includeRoot = 0
rel collection:renderVisibility:includes = </Many>
rel collection:renderVisibility:excludes = </Many/P/A>"""

CIRCLE = """rel collection:matte:includes = </P.collection:prune>
rel collection:prune:includes = </P.collection:matte>"""


def render_pass(body: str = "", name: str = "P") -> str:
    return f'def RenderPass "{name}"\n{{\n{body}\n}}\n'


def picture(folder: Path, text: str, *options: str) -> Any:
    path = write_stage(folder, stage_of(CAMERA, LAMP, text))
    out = folder / "f.exr"
    result = irt("render", path, *SIZE, "-o", str(out), "--strict", "--exr-type", "float", *options)
    assert result.exit_code == 0, result.output
    image = oiio.ImageInput.open(str(out))
    assert image is not None
    return np.asarray(image.read_image(0, 0, 0, 4, oiio.FLOAT))


def test_collections_of_a_pass_in_pictures(tmp_path: Path) -> None:
    whole = picture(tmp_path, SCENE)
    without = picture(tmp_path, SCENE.replace('def Sphere "Ball"', 'over "Ball"'))
    ball = np.any(whole != without, axis=2)
    pictures = {}
    for name, body in {
        "prune": "rel collection:prune:includes = </Ball>",
        "renderVisibility": "rel collection:renderVisibility:excludes = </Ball>",
        "expression": "uniform bool collection:renderVisibility:includeRoot = 0\n"
        'uniform pathExpression collection:renderVisibility:membershipExpression = "//Floor //Lamp"'
        "",
        "cameraVisibility": "rel collection:cameraVisibility:excludes = </Ball>",
        "matte": "rel collection:matte:includes = </Ball>",
        "none": "",
    }.items():
        pictures[name] = picture(tmp_path, SCENE + render_pass(body), "--pass", "P")
    np.testing.assert_array_equal(pictures["none"], whole)
    for name in ("prune", "renderVisibility", "expression"):
        np.testing.assert_array_equal(pictures[name], without)
    held = pictures["matte"]
    black = (held == 0).all(axis=2) & (whole[..., 3] == 1)
    assert black.sum() > 30
    np.testing.assert_array_equal(held[~black], whole[~black])
    hidden = pictures["cameraVisibility"]
    # Where the ball was, the floor or nothing is; its shadow stays.
    np.testing.assert_array_equal(hidden[~black], whole[~black])
    assert (hidden[black] != whole[black]).any()
    assert (hidden != without).any()
    assert ball[black].all()
    assert not (ball & ~black).all()


def test_a_shot_of_a_pass_is_exact(tmp_path: Path) -> None:
    mirror = SCENE + render_pass(
        "rel collection:cameraVisibility:excludes = </Ball>\n"
        "rel collection:matte:includes = </Floor>"
    )
    path = write_stage(tmp_path, stage_of(CAMERA, LAMP, mirror))
    result = irt("verify", path, "--size", "48x27", "--pass", "/P")
    assert result.exit_code == 0, result.output


def roles(snapshot: Snapshot) -> dict[str, tuple[bool, bool]]:
    return {path: state.role for path, state in snapshot.objects.items()}


def test_collections_reach_into_instances(shot: MakeShot) -> None:
    def read(body: str) -> dict[str, tuple[bool, bool]]:
        options = ReadOptions(render_pass="P")
        return roles(shot(INSTANCES + render_pass(body), options=options).read())

    assert set(read("")) == {"/One/A", "/One/B", "/Two/A", "/Two/B", "/Many", "/Elsewhere/C"}
    nested = read("rel collection:matte:includes = </Sets.collection:outer>")
    assert {path for path, role in nested.items() if role == (True, True)} == {"/One/A", "/Two/A"}
    pruned = read("rel collection:prune:includes = [</One/A>, </Two>, </Many>]")
    assert set(pruned) == {"/One/B", "/Elsewhere/C"}
    unseen = read("rel collection:cameraVisibility:excludes = [</One>, </Many>]")
    hidden = {path for path, role in unseen.items() if role == (False, False)}
    assert hidden == {"/One/A", "/One/B", "/Many"}


@pytest.mark.parametrize(
    ("body", "parts"),
    [
        ("", {"/Many/P/A", "/Many/P/B", "/Elsewhere/C"}),
        ("rel collection:prune:includes = </Many/P/B>", {"/Many/P/A", "/Elsewhere/C"}),
        ("rel collection:renderVisibility:excludes = </Elsewhere>", {"/Many/P/A", "/Many/P/B"}),
        # Prototypes elsewhere go by the instancer that shows them.
        (ONLY_MANY, {"/Many/P/B", "/Elsewhere/C"}),
    ],
)  # fmt: skip
def test_parts_of_prototypes(shot: MakeShot, body: str, parts: set[str]) -> None:
    made = shot(INSTANCES + render_pass(body), options=ReadOptions(render_pass="P"))
    shape: Any = made.read().objects["/Many"].shape
    assert {path for p in shape.prototypes for path in p.states} == parts


def test_lights_and_materials_of_a_pass(shot: MakeShot) -> None:
    text = SCENE + LAMP + 'def DomeLight "Sky" {}\n' + render_pass(
        "rel collection:renderVisibility:excludes = </Lamp>\n"
        "rel collection:cameraVisibility:excludes = </Sky>"
    )  # fmt: skip
    made = shot(text, options=ReadOptions(render_pass="P"))
    lights = made.read().lights
    assert list(lights) == ["/Sky"]
    assert not lights["/Sky"].camera_visible
    dark = SCENE + LAMP + render_pass("rel collection:prune:includes = </Lamp>")
    made = shot(dark, options=ReadOptions(render_pass="P"), name="dark.usda")
    assert not made.read().lights
    assert not made.reader.camera_light


def test_a_pass_renders_with_its_source(shot: MakeShot) -> None:
    text = (
        'def RenderSettings "Big"\n{\nuniform int2 resolution = (32, 18)\n}\n'
        'def RenderSettings "Small"\n{\nuniform int2 resolution = (16, 9)\n}\n'
        + SCENE
        + render_pass("rel renderSource = </Big>")
    )
    for settings, size in ((None, (32, 18)), ("Small", (16, 9))):
        made = shot(text, options=ReadOptions(render_pass="P", settings=settings))
        assert made.reader.views[0].framing.frame == size


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("rel renderSource = </Gone>", "renderSource is </Gone>; expected one RenderSettings"),
        ("rel renderSource = </Ball>", "renderSource is </Ball>; expected one RenderSettings"),
        ("rel renderSource = [</Ball>, </P>]", "expected one RenderSettings"),
        ('uniform token collection:matte:expansionRule = "some"', "collection matte cannot be"),
        (CIRCLE, "circular"),
    ],
)  # fmt: skip
def test_passes_that_cannot_be_rendered(tmp_path: Path, body: str, said: str) -> None:
    path = write_stage(tmp_path, stage_of(CAMERA, LAMP, SCENE, render_pass(body)))
    message = failure("render", path, *SIZE, "--pass", "P", "-o", str(tmp_path / "f.exr"))
    assert said in message
    assert "/P." in message
    assert "shot.usda" in message


def test_what_a_pass_makes_of_prims_is_a_change(shot: MakeShot) -> None:
    text = SCENE + LAMP + 'def DomeLight "Sky"\n{\n}\n' + render_pass(
        "rel collection:matte:includes = </Ball>\n"
        "rel collection:cameraVisibility:excludes = [</Floor>, </Sky>]"
    )  # fmt: skip
    plain = shot(text).read()
    passed = shot(text, options=ReadOptions(render_pass="P")).read()
    told = {(c.path, c.attribute) for c in diff(plain, passed).changes}
    assert {("/Ball", "irt:matte"), ("/Floor", "irt:cameraVisible")} <= told
    assert ("/Sky", "irt:cameraVisible") in told


def test_which_pass(tmp_path: Path) -> None:
    path = write_stage(tmp_path, stage_of(CAMERA, LAMP, SCENE, render_pass()))
    message = failure("render", path, "--pass", "Q")
    assert "no RenderPass 'Q'" in message
    assert "/P" in message
    path = write_stage(tmp_path, stage_of(CAMERA, LAMP, SCENE))
    assert "it has none" in failure("render", path, "--pass", "Q")


def test_what_is_said_of_a_pass(shot: MakeShot) -> None:
    body = (
        "rel inputPasses = </Q>\nrel collection:matte:includes = [</Gone>, </P.collection:none>]\n"
        'uniform pathExpression collection:renderVisibility:membershipExpression = "//Ball"'
    )
    text = SCENE + render_pass(body) + render_pass(name="Q")
    made = shot(text, options=ReadOptions(render_pass="P"))
    (gone,) = made.notices("skipped")
    assert "</Gone> of /P.collection:matte:includes" in gone
    assert "</P.collection:none>" in gone
    said = " ".join(made.notices("mentioned"))
    assert "inputPasses" in said
    assert "without renderSource" in said
    assert "membershipExpression" in said
