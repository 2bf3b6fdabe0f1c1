# SPDX-License-Identifier: Apache-2.0
"""Opening: every way a stage can be broken has one message that says where."""

import os
from pathlib import Path

import pytest

from conftest import MakeShot, WriteLayer
from irt_usd.errors import InputError
from irt_usd.stage import open_stage


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as refused:
        open_stage(str(path))
    assert refused.value.status == 2
    return str(refused.value)


def test_missing_file(tmp_path: Path) -> None:
    message = refusal(tmp_path / "none.usda")
    assert "none.usda: no such file" in message


def test_folder(tmp_path: Path) -> None:
    assert "a folder" in refusal(tmp_path)


def test_a_name_that_is_not_utf8(tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path / "shot") + b"\xff.usda")
    Path(path).write_text("#usda 1.0\n")
    with pytest.raises(InputError, match="rename it"):
        open_stage(path)
    named = tmp_path / "été.usda"
    named.write_text("#usda 1.0\n")
    assert open_stage(str(named))


@pytest.mark.parametrize("name", ["a.txt", "noextension"])
def test_not_usd_by_name(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("hello")
    assert "not a USD file" in refusal(path)


@pytest.mark.parametrize("name", ["a.usd", "a.usdc", "a.usda", "a.usdz"])
def test_not_usd_by_content(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(os.urandom(500))
    assert name in refusal(path)


def test_syntax_error_names_file_line_and_column(usda: WriteLayer) -> None:
    path = usda('def Sphere "S"\n{\n  double radius = (1\n}')
    assert f"{path}:8:1: " in refusal(path)


def test_syntax_error_in_a_referenced_layer(usda: WriteLayer) -> None:
    bad = usda('def X "y"\n{\n  double x = }', "bad.usda")
    message = refusal(usda('def Xform "W" (\n references = @bad.usda@</y>\n)\n{\n}'))
    assert f"{bad}:7:3: " in message
    assert "prim </W>" in message


@pytest.mark.parametrize("arc", ["references", "payload"])
def test_missing_asset_names_prim_and_asset(usda: WriteLayer, arc: str) -> None:
    message = refusal(usda(f'def Xform "W" (\n {arc} = @nope.usda@</X>\n)\n{{\n}}'))
    assert "prim </W>" in message
    assert "@nope.usda@" in message
    assert "shot.usda" in message


def test_reference_to_a_missing_prim(usda: WriteLayer) -> None:
    message = refusal(usda('def Xform "W" (\n references = </Nope>\n)\n{\n}'))
    assert "</Nope>" in message


def test_reference_cycle(usda: WriteLayer) -> None:
    child = 'def "C" (\n references = </W>\n)\n{\n}'
    message = refusal(usda(f'def Xform "W" (\n references = </W/C>\n)\n{{\n{child}\n}}'))
    assert "Cycle detected" in message
    assert "0x" not in message


def test_missing_sublayer(usda: WriteLayer) -> None:
    assert "missing.usda" in refusal(usda("", metadata="subLayers = [@missing.usda@]"))


def test_sublayer_cycle(usda: WriteLayer) -> None:
    usda("", "other.usda", metadata="subLayers = [@shot.usda@]")
    path = usda("", metadata="subLayers = [@other.usda@]")
    assert "cycle" in refusal(path)


def test_one_missing_asset_used_by_two_instances(usda: WriteLayer) -> None:
    usda('def Xform "P" (\n payload = @gone.usda@\n)\n{\n}', "proto.usda")
    instance = 'def Xform "{}" (\n references = @proto.usda@</P>\n instanceable = true\n)\n{{\n}}\n'
    assert "gone.usda" in refusal(usda(instance.format("I") + instance.format("J")))


def test_nothing_raw_on_stderr(usda: WriteLayer, capfd: pytest.CaptureFixture[str]) -> None:
    refusal(usda('def Xform "W" (\n references = @nope.usda@</X>\n)\n{\n}'))
    assert capfd.readouterr() == ("", "")


def test_usd_warnings_become_mentions(shot: MakeShot, capfd: pytest.CaptureFixture[str]) -> None:
    made = shot('def Sphere "S"\n{\n uniform token[] xformOpOrder = ["xformOp:nope"]\n}')
    assert "/S" in made.read().objects
    assert any("xformOp:nope" in text for text in made.notices("mentioned"))
    assert capfd.readouterr() == ("", "")
