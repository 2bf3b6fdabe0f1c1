# SPDX-License-Identifier: Apache-2.0
"""Options that a pipeline asks for: previews, dry runs, log files, output paths."""

import re
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import PyOpenColorIO as ocio  # noqa: N813
import pytest

from cli_support import CAMERA, LAMP, MOVING_SHOT, SCENE, SIZE, failure, irt, stage_of, write_stage
from irt_usd.images.color import BUILTIN_CONFIG
from irt_usd.images.exr import read_beauty

PROFILE = """ocio_profile_version: 2
environment: {}
search_path: ""
roles: {scene_linear: lin, default: lin, aces_interchange: aces}
file_rules:
  - !<Rule> {name: Default, colorspace: lin}
displays:
  Panel:
    - !<View> {name: Plain, colorspace: lin}
    - !<View> {name: Half, colorspace: dim}
  Projector:
    - !<View> {name: Half, colorspace: dim}
active_displays: [Panel, Projector]
colorspaces:
  - !<ColorSpace> {name: lin, encoding: scene-linear}
  - !<ColorSpace> {name: aces, encoding: scene-linear}
  - !<ColorSpace>
    name: dim
    from_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
"""  # noqa: E501


TEXTURED = """def Sphere "Globe" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </M>
}
def Material "M"
{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./skin.1001.png@
        float3 outputs:rgb
    }
}
"""


def png(path: Path) -> np.ndarray:
    image = oiio.ImageInput.open(str(path))
    assert image is not None, path
    assert image.spec().format == oiio.UINT8
    return np.asarray(image.read_image(0, 0, 0, 3, oiio.UINT8))


def test_previews_are_the_frame_through_display_and_view(tmp_path: Path) -> None:
    path = write_stage(tmp_path)
    out = str(tmp_path / "out" / "f.#.exr")
    given = (*SIZE, "-f", "1:2", "-o", out, "--preview", "--exr-type", "float")
    result = irt("render", path, *given)
    assert result.exit_code == 0, result.output
    names = sorted(file.name for file in (tmp_path / "out").iterdir())
    assert names == ["f.1.exr", "f.1.png", "f.2.exr", "f.2.png"]
    config = ocio.Config.CreateFromFile(BUILTIN_CONFIG)
    transform = ocio.DisplayViewTransform(
        src="lin_rec709_scene", display="sRGB - Display", view="ACES 2.0 - SDR 100 nits (Rec.709)"
    )
    shown = config.getProcessor(transform).getDefaultCPUProcessor()
    beauty = np.ascontiguousarray(read_beauty(tmp_path / "out" / "f.2.exr"))
    shown.applyRGB(beauty)
    expected = np.rint(np.clip(beauty, 0, 1) * 255).astype(np.uint8)
    np.testing.assert_array_equal(png(tmp_path / "out" / "f.2.png"), expected)
    first = (tmp_path / "out" / "f.1.png").read_bytes()
    assert irt("render", path, *given).exit_code == 0
    assert (tmp_path / "out" / "f.1.png").read_bytes() == first


def test_previews_by_a_config_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "c.ocio").write_text(PROFILE)
    monkeypatch.setenv("OCIO", str(tmp_path / "c.ocio"))
    path, out = write_stage(tmp_path), str(tmp_path / "f.exr")
    render = ("render", path, *SIZE, "-f", "1", "-o", out, "--preview", "--exr-type", "float")
    for options, factor in (
        ((), 1.0),
        (("--view", "Half"), 0.5),
        (("--display", "Projector"), 0.5),
    ):
        result = irt(*render, *options)
        assert result.exit_code == 0, result.output
        linear = np.clip(read_beauty(tmp_path / "f.exr") * factor, 0, 1)
        np.testing.assert_allclose(png(tmp_path / "f.png"), linear * 255, atol=0.51)
    said = failure(*render, "--display", "Wall")
    assert "--display Wall" in said
    assert "Projector" in said
    said = failure(*render, "--display", "Projector", "--view", "Plain")
    assert "--view Plain" in said
    assert "Half" in said
    # A rendering space that the config lacks is OpenColorIO's own.
    stage = 'def RenderSettings "S"\n{\ntoken renderingColorSpace = "lin_ap1_scene"\n}\n'
    other = write_stage(tmp_path, stage_of(CAMERA, SCENE, LAMP, stage), "s.usda")
    result = irt("render", other, *render[2:], "-s", "S")
    assert result.exit_code == 0, result.output


def test_previews_spare_the_textures_of_the_shot(tmp_path: Path) -> None:
    image = oiio.ImageBuf(oiio.ImageSpec(2, 2, 3, "uint8"))
    assert image.write(str(tmp_path / "skin.1001.png"))
    before = (tmp_path / "skin.1001.png").read_bytes()
    path = write_stage(tmp_path, stage_of(CAMERA, LAMP, SCENE, TEXTURED))
    given = (*SIZE, "-f", "1001", "-o", str(tmp_path / "skin.####.exr"), "--preview")
    assert "skin.1001.png: would overwrite" in failure("render", path, *given)
    assert (tmp_path / "skin.1001.png").read_bytes() == before


def test_display_and_view_are_of_previews(tmp_path: Path) -> None:
    assert "add --preview" in failure("render", write_stage(tmp_path), "--view", "Raw")


def test_a_dry_run_tells_and_does_nothing(tmp_path: Path) -> None:
    path = write_stage(tmp_path)
    out, stats, log = tmp_path / "out" / "f.#.exr", tmp_path / "s.jsonl", tmp_path / "x.log"
    result = irt("render", path, *SIZE, "-o", str(out), "--dry-run", "--stats", str(stats),
                 "--log-file", str(log), "--preview")  # fmt: skip
    assert result.exit_code == 0, result.output
    assert sorted(file.name for file in tmp_path.iterdir()) == ["shot.usda"]
    rows = [line for line in result.output.splitlines() if re.match(r" +\d ", line)]
    assert [re.split(r"  +", row.strip())[2] for row in rows] == [
        "everything", "update", "nothing", "update",
    ]  # fmt: skip
    assert all(f"f.{n}.exr" in row for n, row in enumerate(rows, start=1))
    assert f"would create {tmp_path / 'out'}" in result.output

    full = irt("render", path, *SIZE, "-o", str(out), "--dry-run", "--history", "none")
    assert full.output.count("everything") == 4
    assert irt("render", path, *SIZE, "-f", "2", "-o", str(out)).exit_code == 0
    assert "f.2.exr (exists)" in irt("render", path, *SIZE, "-o", str(out), "--dry-run").output
    rest = irt("render", path, *SIZE, "-o", str(out), "--dry-run", "--skip-existing").output
    assert "f.2.exr" not in rest


def test_a_dry_run_of_a_camera_that_moves(tmp_path: Path) -> None:
    path = write_stage(tmp_path, MOVING_SHOT)
    said = irt("render", path, *SIZE, "-o", str(tmp_path / "f.#.exr"), "--dry-run").output
    assert re.search(r"^ +3 .*everything", said, re.MULTILINE)


def test_a_dry_run_refuses_what_a_run_refuses(tmp_path: Path) -> None:
    path = write_stage(tmp_path)
    assert "no frame token" in failure("render", path, *SIZE, "-o", "f.exr", "--dry-run")
    assert "no camera 'Nope'" in failure("render", path, "-c", "Nope", "--dry-run")


def test_a_log_file_holds_all_that_is_said(tmp_path: Path) -> None:
    path, log = write_stage(tmp_path), tmp_path / "irt.log"
    given = (*SIZE, "-o", str(tmp_path / "f.#.exr"), "--log-file", str(log), "-q")
    assert irt("render", path, *given).exit_code == 0
    lines = log.read_text().splitlines()
    assert all(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ ", line) for line in lines)
    text = log.read_text()
    assert all(re.search(rf"Z +{n}  ", text) for n in range(1, 5))
    assert "done: 4 frames" in text

    assert irt("render", path, *given, "-c", "Nope").exit_code == 2
    added = log.read_text().removeprefix(text)
    assert "irt: error: " in added
    assert "no camera 'Nope'" in added


def test_a_log_file_writes_over_nothing(tmp_path: Path) -> None:
    path = write_stage(tmp_path)
    before = Path(path).read_bytes()
    said = failure("render", path, *SIZE, "-o", str(tmp_path / "f.#.exr"), "--log-file", path)
    assert "no log of irt's" in said
    assert Path(path).read_bytes() == before
    said = failure("render", path, *SIZE, "--log-file", str(tmp_path / "gone" / "x.log"))
    assert "--log-file" in said
    assert "No such file" in said


def test_output_paths_are_made_unless_that_is_refused(tmp_path: Path) -> None:
    path, folder = write_stage(tmp_path), tmp_path / "a" / "b"
    given = ("render", path, *SIZE, "-f", "1", "-o", str(folder / "f.exr"))
    said = failure(*given, "--no-make-output-path")
    assert str(folder) in said
    assert "--make-output-path" in said
    assert not folder.exists()
    assert irt(*given, "--make-output-path").exit_code == 0
    assert irt(*given, "--no-make-output-path").exit_code == 0


def test_help_says_who_wins() -> None:
    said = " ".join(irt("render", "--help").output.split())
    assert "Command-line options win" in said
