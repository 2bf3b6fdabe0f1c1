# SPDX-License-Identifier: Apache-2.0
"""`--missing-asset`: what becomes of a shot whose layers name files that are not there."""

from pathlib import Path

import pytest

from conftest import CAMERA, WriteLayer
from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage import OpenOptions, ReadOptions, ShotReader, Snapshot, open_stage

BALL = 'def Sphere "S"\n{\n}\n'

REFERENCE = 'def Xform "W" (\n references = @./no/ref.usda@</X>\n)\n{\n}\n'
PAYLOAD = 'def Xform "P" (\n payload = @search/pay.usda@\n)\n{\n}\n'
TARGET = 'def Xform "T" (\n references = </Nothing>\n)\n{\n}\n'
SUBLAYER = "subLayers = [@under.usda@]"
CLIPS = """def Sphere "C" (
    clips = {
        dictionary default = {
            asset[] assetPaths = [@./clip.usda@]
            string primPath = "/C"
            double2[] active = [(0, 0)]
            double2[] times = [(0, 0), (9, 9)]
        }
    }
)
{
}
"""


def read(
    path: Path,
    policy: MissingAsset,
    mask: tuple[str, ...] = (),
    asset_path: tuple[str, ...] = (),
) -> tuple[Snapshot, list[str]]:
    report = Report()
    options = OpenOptions(mask=mask, asset_path=asset_path, missing_asset=policy)
    stage = open_stage(str(path), options, report)
    reader = ShotReader(stage, ReadOptions(missing_asset=policy), report, [1.0])
    return reader.read(1.0), [n.text for n in report.notices if n.severity == "skipped"]


CASES = pytest.mark.parametrize(
    ("body", "metadata", "place", "authored"),
    [
        (REFERENCE, "", "prim </W>, references of </W>", "@./no/ref.usda@"),
        (PAYLOAD, "", "prim </P>, payload of </P>", "@search/pay.usda@"),
        (TARGET, "", "prim </T>", "</Nothing>"),
        ("", SUBLAYER, "subLayers of ", "@under.usda@"),
        (CLIPS, "", "clips of /C", "@./clip.usda@"),
    ],
)


@CASES
def test_fail_names_prim_arc_asset_and_where_it_was_sought(
    usda: WriteLayer, body: str, metadata: str, place: str, authored: str, tmp_path: Path
) -> None:
    path = usda(BALL + body + CAMERA, metadata=metadata)
    with pytest.raises(InputError) as refused:
        read(path, "fail")
    message = str(refused.value)
    assert place in message
    assert authored in message
    assert str(tmp_path) in message
    assert "--missing-asset fallback" in message


@CASES
@pytest.mark.parametrize("policy", ["fallback", "warn"])
def test_the_rest_renders(
    usda: WriteLayer,
    policy: MissingAsset,
    body: str,
    metadata: str,
    place: str,
    authored: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    snapshot, skipped = read(usda(BALL + body + CAMERA, metadata=metadata), policy)
    assert "/S" in snapshot.objects
    (notice,) = skipped
    assert place in notice
    assert authored in notice
    assert capfd.readouterr() == ("", "")


def test_fallback_says_it_once_and_warn_each_time(usda: WriteLayer) -> None:
    two = REFERENCE + REFERENCE.replace('"W"', '"V"')
    path = usda(BALL + two + CAMERA)
    assert len(read(path, "fallback")[1]) == 1
    assert len(read(path, "warn")[1]) == 2


def test_strict_refuses_either(usda: WriteLayer) -> None:
    path = usda(REFERENCE + CAMERA)
    report = Report(strict=True)
    open_stage(str(path), OpenOptions(missing_asset="fallback"), report)
    with pytest.raises(InputError, match=r"ref\.usda"):
        report.enforce("nothing was rendered")


@pytest.mark.parametrize(
    ("body", "metadata"),
    [
        ('def Xform "W" (\n references = @broken.usda@</y>\n)\n{\n}\n', ""),
        ("", "subLayers = [@broken.usda@]"),
        ('def Xform "W" (\n references = @notes.txt@</y>\n)\n{\n}\n', ""),
        ('def Xform "W" (\n references = </W>\n)\n{\n}\n', ""),
    ],
)
def test_what_is_damaged_is_refused_in_any_case(
    usda: WriteLayer, tmp_path: Path, body: str, metadata: str
) -> None:
    usda("def Sphere {", "broken.usda")
    (tmp_path / "notes.txt").write_text("hello")
    path = usda(BALL + body + CAMERA, metadata=metadata)
    with pytest.raises(InputError, match="does not compose"):
        read(path, "fallback")
