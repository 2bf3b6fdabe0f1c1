# SPDX-License-Identifier: Apache-2.0
"""The shots in the repository are what their scripts write, and hold what the docs say."""

import re
from collections import Counter
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, Usd, UsdGeom

from cli_support import irt
from shots.bench import make_bench
from shots.demo import make_demo
from shots.features import looks, make_features
from shots.features.images import TEXTURES
from shots.lights import make_lights
from shots.open_chess import make_open_chess
from shots.paper import make_paper
from shots.pipeline import make_pipeline

SHOTS = Path(make_demo.__file__).parents[1]
ASSETS = SHOTS.parents[1] / "shared/assets"


@pytest.mark.parametrize(
    ("name", "build"),
    [
        ("demo/chess.usda", make_demo.build),
        ("paper/chess.usda", partial(make_paper.chess, lights=1)),
        ("paper/chess_3_lights.usda", partial(make_paper.chess, lights=3)),
        ("paper/spheres.usda", make_paper.spheres),
        ("open_chess/open_chess.usda", make_open_chess.build),
        ("pipeline/pipeline.usda", make_pipeline.build),
        ("lights/lights.usda", make_lights.build),
        *[(f"features/{n}", make) for n, make in make_features.LAYERS.items()],
    ],
)
def test_shot_is_what_its_script_writes(name: str, build: Callable[[], Usd.Stage]) -> None:
    stored = Sdf.Layer.FindOrOpen(str(SHOTS / name))
    assert build().GetRootLayer().ExportToString() == stored.ExportToString()


def test_demo_is_a_whole_shot() -> None:
    stage = make_demo.build()
    assert stage.GetDefaultPrim()
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert stage.GetTimeCodesPerSecond() == 24
    assert stage.GetEndTimeCode() - stage.GetStartTimeCode() + 1 >= 48


def test_demo_holds_still_between_events() -> None:
    stage = make_demo.build()
    attributes = [attribute for prim in stage.Traverse() for attribute in prim.GetAttributes()]
    keyed = [attribute for attribute in attributes if attribute.ValueMightBeTimeVarying()]
    frames = range(make_demo.FIRST, make_demo.LAST + 1)
    values = [[attribute.Get(frame) for attribute in keyed] for frame in frames]
    still = sum(a == b for a, b in pairwise(values))
    assert still == 22
    assert len(keyed) == 5


def count_solids(stage: Usd.Stage) -> Counter[str]:
    kinds = (prim.GetTypeName() for prim in stage.Traverse() if prim.IsA(UsdGeom.Gprim))
    return Counter(str(kind) for kind in kinds)


def test_paper_scenes_have_the_paper_s_counts() -> None:
    chess, spheres = make_paper.chess(lights=1), make_paper.spheres()
    assert count_solids(chess).total() == 144
    assert count_solids(spheres) == {"Sphere": 125, "Plane": 1}
    pawn = chess.GetPrimAtPath("/World/white/pawn_f4")
    assert len(pawn.GetChildren()) == 7
    assert "Mesh" not in count_solids(chess)


def test_paper_edits_are_undone_in_odd_frames() -> None:
    for stage in (make_paper.chess(lights=1), make_paper.chess(lights=3), make_paper.spheres()):
        for prim in stage.Traverse():
            for attribute in prim.GetAttributes():
                odd = range(1, int(stage.GetEndTimeCode()) + 1, 2)
                assert len({str(attribute.Get(frame)) for frame in odd}) == 1, attribute.GetPath()


def test_benchmark_scenes_have_their_size() -> None:
    triangles, parade = make_bench.triangles(160, 5, 380), make_bench.instances()
    meshes = [UsdGeom.Mesh(prim) for prim in triangles.Traverse() if prim.IsA(UsdGeom.Mesh)]
    corners = [len(mesh.GetFaceVertexIndicesAttr().Get()) for mesh in meshes]
    faces = [len(mesh.GetFaceVertexCountsAttr().Get()) for mesh in meshes]
    assert sum(corners) - 2 * sum(faces) == 1_322_976
    assert sum(prim.IsInstance() for prim in parade.Traverse()) == 500


def test_features_have_the_files_their_script_writes() -> None:
    folder = SHOTS / "features"
    assert (folder / "varnish.mtlx").read_text() == looks.VARNISH
    assert {file.name for file in (folder / "textures").iterdir()} == TEXTURES.keys()
    for name, texels in TEXTURES.items():
        stored = oiio.ImageBuf(str(folder / "textures" / name)).get_pixels(oiio.UINT8)
        assert stored is not None
        assert np.array_equal(stored, texels), name


def test_features_are_exact_and_wholly_rendered(tmp_path: Path) -> None:
    verdict = tmp_path / "verdict.json"
    result = irt(
        "verify", str(SHOTS / "features/features.usda"), "--size", "120x68", "--json", str(verdict)
    )
    assert result.exit_code == 0, result.output
    assert "not supported" not in result.output


def test_lights_have_the_files_their_script_writes() -> None:
    folder = SHOTS / "lights"
    assert (folder / "profile.ies").read_text() == make_lights.IES
    for name, make in make_lights.PICTURES.items():
        stored = oiio.ImageBuf(str(folder / name)).get_pixels(oiio.HALF)
        assert stored is not None
        assert np.array_equal(stored, make().astype(np.float16)), name


def test_lights_are_exact_wholly_rendered_and_change_in_every_frame(tmp_path: Path) -> None:
    stage = str(SHOTS / "lights/lights.usda")
    result = irt("verify", stage, "--size", "96x64", "--dome-samples", "8")
    assert result.exit_code == 0, result.output
    assert "not supported" not in result.output
    assert "skipped" not in result.output
    assert changing_frames(stage) == set(range(make_lights.FIRST + 1, make_lights.LAST + 1))


def changing_frames(*arguments: str) -> set[int]:
    """The frames in which `irt changes` finds a change, after the first."""
    result = irt("changes", *arguments)
    assert result.exit_code == 0, result.output
    found = re.findall(r"^(\d+): (.*)", result.output, re.MULTILINE)
    return {int(frame) for frame, what in found if what not in ("nothing", "first frame")}


def keyed(*spans: tuple[int, int]) -> set[int]:
    """The frames after the first of each span."""
    return {frame for first, last in spans for frame in range(first + 1, last + 1)}


def test_every_feature_changes_when_it_is_keyed_and_only_then() -> None:
    m, k = make_features, looks.Keyed
    spans = (m.SKEL, m.DEFORM, m.RISE, m.CLIMB, m.FAN, m.CLIP, m.RADIUS, k.turn, k.bump, k.coat)
    expected = keyed(*spans, k.mtlx, (k.swap - 1, k.swap))
    assert changing_frames(str(SHOTS / "features/features.usda")) == expected


@pytest.mark.skipif(not ASSETS.is_dir(), reason=f"{ASSETS}: the shared assets are not there")
def test_open_chess_changes_when_it_is_keyed_and_only_then() -> None:
    m = make_open_chess
    stage = str(SHOTS / "open_chess/open_chess.usda")
    expected = keyed(m.PAWN_TAKES, m.BISHOP_LEAVES, m.KEY_WARMS, m.VARNISH_DULLS)
    assert changing_frames(stage, "--asset-path", str(ASSETS)) == expected


@pytest.mark.parametrize("name", ["white", "black", "board"])
def test_pipeline_renders_each_pass_of_each_product_exactly(name: str) -> None:
    path = str(SHOTS / "pipeline/pipeline.usda")
    result = irt("verify", path, "--pass", name, "--size", "32x18", "-f", "1005:1006")
    assert result.exit_code == 0, result.output


def test_pipeline_writes_its_products_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = irt("render", str(SHOTS / "pipeline/pipeline.usda"), "--complexity", "low")
    assert result.exit_code == 0, result.output
    names = [
        name
        for n in range(1004, 1009)
        for name in (f"beauty.{n}.exr", f"ids.{n}.exr", f"witness.take_{n}.exr")
    ]
    assert sorted(file.name for file in (tmp_path / "out/pipeline").iterdir()) == sorted(names)
    windows = {}
    for name in names[:3]:
        image = oiio.ImageInput.open(str(tmp_path / "out/pipeline" / name))
        assert image is not None
        spec = image.spec()
        windows[name] = (spec.x, spec.y, spec.width, spec.height, spec.full_width, spec.full_height)
    assert list(windows.values()) == [
        (0, 0, 640, 360, 640, 360),
        (-32, -18, 384, 216, 320, 180),
        (0, 0, 256, 256, 256, 256),
    ]
