# SPDX-License-Identifier: Apache-2.0
"""Composition arcs, retiming and stage metadata: mostly USD's own work, and no pixel lost on it."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf

from conftest import CAMERA, MakeShot, WriteLayer
from irt_usd.errors import InputError
from irt_usd.stage import open_stage

BALL = """
def Sphere "Ball"
{
    double radius = 1
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def places(made: object, time: float = 1.0) -> dict[str, list[float]]:
    objects = made.read(time).objects  # type: ignore[attr-defined]
    return {path: state.world_from_object[3, :3].tolist() for path, state in objects.items()}


def shifted(name: str, arcs: str, x: float, body: str = "") -> str:
    return (
        f'def Xform "{name}" (\n{arcs}\n)\n{{\n'
        f" double3 xformOp:translate = ({x}, 0, 0)\n"
        f' uniform token[] xformOpOrder = ["xformOp:translate"]\n{body}\n}}\n'
    )


def test_nested_references_and_payloads(shot: MakeShot, usda: WriteLayer) -> None:
    usda(f'def Xform "A"\n{{\n{BALL}\n}}', "a.usda", 'defaultPrim = "A"')
    usda(shifted("B", " payload = @a.usda@", 10), "b.usda", 'defaultPrim = "B"')
    usda(f'def Xform "C"\n{{\n{shifted("D", " references = @b.usda@", 100)}\n}}', "c.usda")
    over = 'over "D"\n{\nover "Ball"\n{\n double radius = 3\n}\n}'
    made = shot(shifted("E", " references = @c.usda@</C>", 1000, over))
    # Transforms of one prim do not add up: the strongest opinion on it stands.
    assert places(made) == {"/E/D/Ball": [1101, 0, 0]}
    assert made.read().objects["/E/D/Ball"].shape.attributes["radius"] == 3


def test_inherits_and_specializes(shot: MakeShot) -> None:
    made = shot(
        'class Sphere "_class"\n{\n double radius = 4\n}\n'
        'def Sphere "general"\n{\n double radius = 5\n}\n'
        'def "I" (\n inherits = </_class>\n)\n{\n}\n'
        'def "S" (\n specializes = </general>\n)\n{\n}\n'
        'def Sphere "J" (\n inherits = </_class>\n)\n{\n double radius = 6\n}\n'
    )
    radii = {p: s.shape.attributes["radius"] for p, s in made.read().objects.items()}
    assert radii == {"/general": 5, "/I": 4, "/S": 5, "/J": 6}


def test_variants_in_variants(shot: MakeShot) -> None:
    inner = (
        'def Sphere "{0}" (\n variants = {{\n string size = "{1}"\n }}\n'
        ' prepend variantSets = "size"\n)\n{{\n variantSet "size" = {{\n'
        '  "big" {{\n   double radius = 9\n  }}\n'
        '  "small" {{\n   double radius = 2\n  }}\n }}\n}}\n'
    )
    outer = (
        'def Xform "V" (\n variants = {\n string kind = "two"\n }\n'
        ' prepend variantSets = "kind"\n)\n{\n variantSet "kind" = {\n'
        f'  "one" {{\n{inner.format("A", "big")}\n  }}\n'
        f'  "two" {{\n{inner.format("B", "small")}\n  }}\n }}\n}}\n'
    )
    objects = shot(outer).read().objects
    assert {p: s.shape.attributes["radius"] for p, s in objects.items()} == {"/V/B": 2}


MOVER = """
def Sphere "Ball"
{
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 100: (100, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


@pytest.mark.parametrize(
    ("offset", "at_24"), [("", 24), ("(offset = 10)", 14), ("(offset = 4; scale = 2)", 10)]
)
@pytest.mark.parametrize("arc", ["references", "payload", "subLayers"])
def test_layer_offsets_and_scales(
    shot: MakeShot, usda: WriteLayer, arc: str, offset: str, at_24: float
) -> None:
    usda(MOVER, "m.usda", 'defaultPrim = "Ball"')
    if arc == "subLayers":
        made = shot("", metadata=f"subLayers = [@m.usda@ {offset}]")
    else:
        made = shot(f'def "Ball" (\n {arc} = @m.usda@ {offset}\n)\n{{\n}}\n')
    assert places(made, 24)["/Ball"] == pytest.approx([at_24, 0, 0])


def test_layers_of_another_rate_are_retimed(shot: MakeShot, usda: WriteLayer) -> None:
    usda(MOVER, "m.usda", 'defaultPrim = "Ball"\ntimeCodesPerSecond = 48')
    made = shot(
        'def "Ball" (\n references = @m.usda@\n)\n{\n}\n', metadata="timeCodesPerSecond = 24"
    )
    assert places(made, 10) == {"/Ball": [20, 0, 0]}


@pytest.mark.parametrize("up", ["Y", "Z"])
@pytest.mark.parametrize("metres", [0.01, 1, 0.0254])
@pytest.mark.parametrize("rate", [1, 23.976, 24, 60])
def test_conventions_change_nothing(
    shot: MakeShot, usda: WriteLayer, up: str, metres: float, rate: float
) -> None:
    """Nor does USD convert what is referred to from a layer of other units or up axis."""
    usda(BALL, "b.usda", 'upAxis = "Y"\nmetersPerUnit = 1')
    head = f'upAxis = "{up}"\nmetersPerUnit = {metres}\ntimeCodesPerSecond = {rate}'
    body = BALL + 'def "R" (\n references = @b.usda@</Ball>\n)\n{\n}\n'
    made = shot(body, metadata=head)
    plain = shot(body, name="plain.usda")
    assert places(made) == places(plain) == {"/Ball": [1, 0, 0], "/R": [1, 0, 0]}
    ours, theirs = made.read().camera, plain.read().camera
    assert np.array_equal(ours.world_from_camera, theirs.world_from_camera)
    assert ours.window == theirs.window


def test_times_outside_the_samples_are_held(shot: MakeShot) -> None:
    made = shot(MOVER)
    assert [places(made, t)["/Ball"][0] for t in (-1e9, -1, 0, 50.5, 100, 101, 1e9)] == [
        *(0, 0, 0, 50.5, 100, 100, 100)
    ]


def damaged_usdc(path: Path, damage: str) -> None:
    layer = Sdf.Layer.CreateNew(str(path))
    layer.ImportFromString("#usda 1.0\n" + BALL + MOVER.replace("Ball", "Other"))
    layer.Save()
    del layer
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) * 2 // 3]
    elif damage == "header":
        content[:8] = b"PXR-USDX"
    elif damage == "offset":
        content[16:24] = b"\xff" * 8
    path.unlink()
    path.write_bytes(bytes(content))


@pytest.mark.parametrize("damage", ["cut", "header", "offset"])
@pytest.mark.parametrize("arc", ["root", "references", "subLayers"])
def test_damaged_usdc(usda: WriteLayer, tmp_path: Path, damage: str, arc: str) -> None:
    path = tmp_path / f"{damage}_{arc}.usdc"
    damaged_usdc(path, damage)
    stage = path
    if arc == "references":
        stage = usda(f'def "R" (\n references = @{path.name}@</Ball>\n)\n{{\n}}\n' + CAMERA)
    elif arc == "subLayers":
        stage = usda(CAMERA, metadata=f"subLayers = [@{path.name}@]")
    with pytest.raises(InputError, match=path.name):
        open_stage(str(stage))
