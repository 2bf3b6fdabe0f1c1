# SPDX-License-Identifier: Apache-2.0
"""How a stage is opened: asset path, population mask, session layer."""

from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Usd

from cli_support import run
from conftest import CAMERA, WriteLayer
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage import OpenOptions, ReadOptions, ShotReader, Snapshot, open_stage

BALL = 'def Sphere "S"\n{\n}\n'

PAYLOAD = 'def Xform "P" (\n payload = @search/pay.usda@\n)\n{\n}\n'


def read(path: Path, mask: tuple[str, ...] = (), asset_path: tuple[str, ...] = ()) -> Snapshot:
    stage = open_stage(str(path), OpenOptions(mask=mask, asset_path=asset_path))
    return ShotReader(stage, ReadOptions(), Report(), [1.0]).read(1.0)


@pytest.fixture
def searched(tmp_path: Path) -> Callable[[str], Path]:
    """Folders with a layer of the same name and a sphere named after the folder."""

    def make(name: str) -> Path:
        (tmp_path / name / "search").mkdir(parents=True)
        layer = tmp_path / name / "search" / "pay.usda"
        layer.write_text(
            f'#usda 1.0\n(\n defaultPrim = "X"\n)\ndef "X"\n{{\ndef Sphere "{name}"\n{{\n}}\n}}\n'
        )
        return tmp_path / name

    return make


def test_asset_path_is_searched_in_order(usda: WriteLayer, searched: Callable[[str], Path]) -> None:
    path = usda(PAYLOAD + CAMERA)
    first, second = str(searched("first")), str(searched("second"))
    assert list(read(path, asset_path=(first, second)).objects) == ["/P/first"]
    assert list(read(path, asset_path=(second, first)).objects) == ["/P/second"]


def test_the_stages_own_folder_comes_first(
    usda: WriteLayer, searched: Callable[[str], Path], tmp_path: Path
) -> None:
    path = usda(PAYLOAD + CAMERA)
    elsewhere = str(searched("elsewhere"))
    (searched("own") / "search").rename(tmp_path / "search")
    assert list(read(path, asset_path=(elsewhere,)).objects) == ["/P/own"]


def test_asset_path_that_is_none(usda: WriteLayer, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--asset-path .*nowhere: no such folder"):
        read(usda(BALL + CAMERA), asset_path=(str(tmp_path / "nowhere"),))


def test_all_folders_searched_are_told(usda: WriteLayer, searched: Callable[[str], Path]) -> None:
    other = str(searched("other"))
    path = usda(PAYLOAD.replace("search/pay", "search/gone") + CAMERA)
    with pytest.raises(InputError) as refused:
        read(path, asset_path=(other,))
    assert other in str(refused.value)
    assert str(path.parent) in str(refused.value)


MASKED = """
def Xform "World"
{
    def Sphere "A" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        rel material:binding = </Looks/Red>
    }
    def Sphere "B"
    {
    }
}
def Scope "Looks"
{
    def Material "Red"
    {
        token outputs:surface.connect = </Looks/Red/Shader.outputs:surface>
        def Shader "Shader"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (1, 0, 0)
            token outputs:surface
        }
    }
}
"""


def test_a_mask_keeps_what_its_prims_are_bound_to(usda: WriteLayer) -> None:
    path = usda(MASKED + CAMERA)
    snapshot = read(path, mask=("/World/A", "/cam"))
    assert list(snapshot.objects) == ["/World/A"]
    assert snapshot.objects["/World/A"].material == "/Looks/Red"


@pytest.mark.parametrize("path", ["World", "/World/A.radius", "/World/Nope", "not a path"])
def test_masks_that_name_no_prim(usda: WriteLayer, path: str) -> None:
    with pytest.raises(InputError, match="--mask"):
        read(usda(MASKED + CAMERA), mask=(path,))


def test_session_layer_is_the_strongest(usda: WriteLayer, tmp_path: Path) -> None:
    path = usda('def Sphere "S"\n{\n double radius = 1\n}\n' + CAMERA)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "ball.usda").write_text('#usda 1.0\ndef Sphere "B"\n{\n}\n')
    session = usda(
        'over "S"\n{\n double radius = 3\n}\ndef "R" (\n references = @./ball.usda@</B>\n)\n{\n}\n',
        "sub/session.usda",
        "endTimeCode = 12\nstartTimeCode = 10",
    )
    stage = open_stage(str(path), OpenOptions(session_layer=str(session)))
    assert stage.GetEndTimeCode() == 12
    snapshot = ShotReader(stage, ReadOptions(), Report(), [10.0]).read(10.0)
    assert snapshot.objects["/S"].shape.attributes["radius"] == 3
    assert "/R" in snapshot.objects


@pytest.mark.parametrize("text", [None, "def Sphere {"])
def test_session_layers_that_cannot_be_read(usda: WriteLayer, text: str | None) -> None:
    path = usda(BALL + CAMERA)
    session = path.with_name("session.usda")
    if text is not None:
        session.write_text(f"#usda 1.0\n{text}\n")
    with pytest.raises(InputError, match=r"session\.usda"):
        open_stage(str(path), OpenOptions(session_layer=str(session)))


def test_variants_are_chosen_by_a_session_layer(usda: WriteLayer) -> None:
    variants = """def Xform "V" (
    variants = {
        string size = "small"
    }
    prepend variantSets = "size"
)
{
    variantSet "size" = {
        "small" {
            def Sphere "S"
            {
                double radius = 1
            }
        }
        "large" {
            def Sphere "L"
            {
                double radius = 5
            }
        }
    }
}
"""
    path = usda(variants + CAMERA)
    over = 'over "V" (\n variants = {\n  string size = "large"\n }\n)\n{\n}\n'
    session = usda(over, "session.usda")

    def objects(stage: Usd.Stage) -> list[str]:
        return list(ShotReader(stage, ReadOptions(), Report(), [1.0]).read(1.0).objects)

    assert objects(open_stage(str(path))) == ["/V/S"]
    assert objects(open_stage(str(path), OpenOptions(session_layer=str(session)))) == ["/V/L"]


def test_the_environments_search_path_comes_last(
    usda: WriteLayer,
    searched: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, option = usda(PAYLOAD + CAMERA), searched("option")
    monkeypatch.setenv("PXR_AR_DEFAULT_SEARCH_PATH", str(searched("environment")))

    for name in ("environment", "option"):
        layer = tmp_path / name / "search" / "pay.usda"
        layer.write_text(layer.read_text().replace("Sphere", "Camera"))

    def cameras(*options: str) -> list[str]:
        listed = run("render", str(path), "--list-cameras", *options)
        assert listed.returncode == 0, listed.stderr
        return listed.stdout.split()

    assert cameras() == ["/P/environment", "/cam"]
    assert cameras("--asset-path", str(option)) == ["/P/option", "/cam"]
