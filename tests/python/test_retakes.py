# SPDX-License-Identifier: Apache-2.0
"""A version of a shot from the history of another: the files of a whole new render."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cli_support import SHOT, SIZE, irt, write_stage

EDITS: dict[str, Callable[[str], str]] = {
    "a colour": lambda text: text.replace("(0.8, 0.2, 0.1)", "(0.1, 0.2, 0.8)"),
    "a light's energy": lambda text: text.replace("1: 60,", "1: 45,"),
    "a size": lambda text: text.replace("double width = 20", "double width = 4"),
    "an object for some frames": lambda text: text.replace("2: (0.5, 1, 0)", "2: (0.5, 2, 0)"),
    "an object more": lambda text: text + 'def Cube "Box"\n{\n    double size = 0.5\n}\n',
    "an object less": lambda text: text.replace('def Plane "Floor"', 'over "Floor"'),
    "a light more": lambda text: (
        text + 'def DistantLight "Sun"\n{\n    float inputs:intensity = 1\n}\n'
    ),
    "nothing": lambda text: text,
}


def render(stage: str, output: Path, *options: str) -> Any:
    return irt("render", stage, *SIZE, "--output", str(output / "a.####.exr"), *options)


def pixels(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.exr")}


@pytest.fixture
def versions(tmp_path: Path) -> Callable[..., str]:
    """Renders version 1 with a checkpoint, and writes version 2, whose stage is returned."""

    def make(edit: Callable[[str], str], history: str = "any") -> str:
        first = write_stage(tmp_path, SHOT, "v1.usda")
        kept = ("--checkpoint", str(tmp_path / "c1"), "--history", history)
        assert render(first, tmp_path / "v1", *kept).exit_code == 0
        return write_stage(tmp_path, edit(SHOT), "v2.usda")

    return make


@pytest.mark.parametrize("edit", EDITS)
def test_a_retake_is_a_new_render(edit: str, versions: Callable[..., str], tmp_path: Path) -> None:
    stage = versions(EDITS[edit])
    stats = ("--stats", str(tmp_path / "stats.jsonl"))
    told = render(
        stage, tmp_path / "v2", "--from", str(tmp_path / "c1"), "--history", "any", *stats
    )
    assert told.exit_code == 0, told.output
    assert "starts from frame 4 of" in told.stderr
    assert render(stage, tmp_path / "new").exit_code == 0
    assert pixels(tmp_path / "v2") == pixels(tmp_path / "new")
    first = json.loads((tmp_path / "stats.jsonl").read_text().splitlines()[0])
    assert first["restart"] is None or first["restart"].startswith("cost:")


def test_textures_of_one_name_in_two_places(tmp_path: Path) -> None:
    import numpy as np

    from irt_usd.images.exr import Film, write_exr

    look = """def Material "Look"
{
    token outputs:surface.connect = </Look/S.outputs:surface>
    def Shader "S"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </Look/T.outputs:rgb>
        token outputs:surface
    }
    def Shader "T"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./t.exr@
        float3 outputs:rgb
    }
}
"""
    bound = 'def Plane "Floor" (prepend apiSchemas = ["MaterialBindingAPI"])\n{\n    rel material:'
    text = SHOT.replace('def Plane "Floor"\n{', f"{look}\n{bound}binding = </Look>")
    stages = []
    for version, value in ((1, 0.5), (2, 0.125)):
        folder = tmp_path / f"{version}"
        folder.mkdir()
        stages.append(write_stage(folder, text))
        write_exr(folder / "t.exr", Film(np.full((4, 4, 4), value, np.float32), {}), {})
    kept = ("--checkpoint", str(tmp_path / "c1"), "--history", "any")
    assert render(stages[0], tmp_path / "v1", *kept).exit_code == 0
    assert render(stages[1], tmp_path / "v2", "--from", str(tmp_path / "c1")).exit_code == 0
    assert render(stages[1], tmp_path / "new").exit_code == 0
    assert pixels(tmp_path / "v2") == pixels(tmp_path / "new")
    assert pixels(tmp_path / "v2") != pixels(tmp_path / "v1")


def test_a_history_for_the_shot_alone(versions: Callable[..., str], tmp_path: Path) -> None:
    stage = versions(EDITS["a size"], "shot")
    refused = render(stage, tmp_path / "v2", "--from", str(tmp_path / "c1"))
    assert refused.exit_code == 5
    assert "cannot serve those of /Floor;" in refused.stderr
    stage = write_stage(tmp_path, EDITS["an object for some frames"](SHOT), "v3.usda")
    told = render(stage, tmp_path / "v3", "--from", str(tmp_path / "c1"))
    assert told.exit_code == 0, told.output
    assert render(stage, tmp_path / "new").exit_code == 0
    assert pixels(tmp_path / "v3") == pixels(tmp_path / "new")


def test_what_cannot_be_started_from(versions: Callable[..., str], tmp_path: Path) -> None:
    stage = versions(EDITS["a colour"])
    start = ("--from", str(tmp_path / "c1"))
    told = render(stage, tmp_path / "v2", *start, "--samples", "2")
    assert told.exit_code == 5
    assert "setting samples: 1 then, 2 now" in told.stderr
    assert render(stage, tmp_path / "v2", *start, "--history", "none").exit_code == 2
    assert render(stage, tmp_path / "v2", "--from", str(tmp_path / "x")).exit_code == 2
    first = tmp_path / "v1.usda"
    first.write_text(first.read_text().replace("radius = 1", "radius = 1.5"))
    told = render(stage, tmp_path / "v2", *start)
    assert told.exit_code == 5
    assert "file v1.usda: has changed" in told.stderr
    first.unlink()
    assert "cannot be opened" in render(stage, tmp_path / "v2", *start).stderr


def test_frames_whose_scene_stayed_are_kept(versions: Callable[..., str], tmp_path: Path) -> None:
    stage = versions(EDITS["an object for some frames"])
    aovs = ("--aov", "objectId", "--aov", "depth")
    kept = ("--checkpoint", str(tmp_path / "c1"), "--history", "any", "--resume", "never")
    assert render(str(tmp_path / "v1.usda"), tmp_path / "v1", *kept, *aovs).exit_code == 0
    options = ("--from", str(tmp_path / "c1"), "--reuse-output", *aovs)
    told = render(stage, tmp_path / "v2", *options)
    assert told.exit_code == 0, told.output
    assert [line.split()[1] for line in told.stdout.splitlines() if line.endswith("kept")] == [
        "1",
        "3",
        "4",
    ]
    assert render(stage, tmp_path / "new", *aovs).exit_code == 0
    assert pixels(tmp_path / "v2") == pixels(tmp_path / "new")
    (tmp_path / "v1" / "a.0003.exr").write_bytes(b"")
    told = render(stage, tmp_path / "v2", *options)
    assert told.stdout.count("kept") == 2
    assert pixels(tmp_path / "v2") == pixels(tmp_path / "new")
    assert render(stage, tmp_path / "v2", *options, "--samples", "2").exit_code == 5


def test_a_retake_resumes(versions: Callable[..., str], tmp_path: Path) -> None:
    stage = versions(EDITS["a colour"])
    options = ("--from", str(tmp_path / "c1"), "--checkpoint", str(tmp_path / "c2"))
    assert render(stage, tmp_path / "v2", *options).exit_code == 0
    told = render(stage, tmp_path / "v2", *options)
    assert "4 frames kept" in told.stderr
    assert "starts from" not in told.stderr
