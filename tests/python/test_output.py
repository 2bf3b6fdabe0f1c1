# SPDX-License-Identifier: Apache-2.0
"""Output patterns, and the proof that they can be written to."""

import os
from pathlib import Path

import pytest

from irt_usd.errors import InputError
from irt_usd.images.atomic import atomic_file
from irt_usd.shot.frames import parse_frames
from irt_usd.shot.output import default_pattern, output_paths, parse_pattern, prepare_output


def names(pattern: str, frames: str) -> list[str]:
    return [str(path) for path in output_paths(parse_pattern(pattern), parse_frames(frames))]


@pytest.mark.parametrize(
    ("pattern", "frame", "expected"),
    [
        ("a/b.####.exr", "7", "a/b.0007.exr"),
        ("b.#.exr", "1001", "b.1001.exr"),
        ("b.###.###.exr", "1.25", "b.001.250.exr"),
        ("b.#.##.exr", "1.25", "b.1.25.exr"),
        ("b.$F4.exr", "12", "b.0012.exr"),
        ("b.$F.exr", "12", "b.12.exr"),
        ("b.%04d.exr", "12", "b.0012.exr"),
        ("b.%d.exr", "12", "b.12.exr"),
        ("b.####.exr", "-5", "b.-005.exr"),
        ("b.####.exr", "123456", "b.123456.exr"),
        ("shot_####/beauty.exr", "3", "shot_0003/beauty.exr"),
        ("still.exr", "1.5", "still.exr"),
        ("100%.####.EXR", "1", "100%.0001.EXR"),
    ],
)
def test_tokens(pattern: str, frame: str, expected: str) -> None:
    assert names(pattern, frame) == [expected]


def test_range_without_a_token_is_an_error() -> None:
    with pytest.raises(InputError, match=r"2 frames but no frame token.*####"):
        names("beauty.exr", "1:2")


def test_sub_frames_in_a_whole_token_name_the_clash() -> None:
    with pytest.raises(InputError, match=r"frames at 2 and 1.75 would both be b.0002.exr"):
        names("b.####.exr", "2,1.75")
    with pytest.raises(InputError, match=r"####\.##"):
        names("b.%04d.exr", "1.25")
    with pytest.raises(InputError, match=r"1.25"):
        names("b.####.#.exr", "1:2x0.25")


@pytest.mark.parametrize("pattern", ["b.####.####.$F.exr", "a.##/b.##.exr"])
def test_several_tokens_are_refused(pattern: str) -> None:
    with pytest.raises(InputError, match="several frame tokens"):
        parse_pattern(pattern)


@pytest.mark.parametrize("pattern", ["b.####.png", "b.####", "/dev/null", "dir/"])
def test_only_exr_is_written(pattern: str) -> None:
    with pytest.raises(InputError, match="OpenEXR"):
        parse_pattern(pattern)


def test_default_pattern_has_the_decimals_that_frames_need() -> None:
    assert default_pattern("x/chess.usda", parse_frames("1:10")).text == "out/chess.####.exr"
    assert default_pattern("chess.usd", parse_frames("1:2x0.25")).text == "out/chess.####.##.exr"
    assert default_pattern("a.%04d.usd", parse_frames("1")).text == "out/a._.####.exr"


def test_folders_are_created_and_said(tmp_path: Path) -> None:
    said: list[str] = []
    path = tmp_path / "new" / "deep" / "b.exr"
    prepare_output([path], "--output", said.append)
    assert said == [f"created {path.parent}"]
    assert list(path.parent.iterdir()) == []


def test_a_folder_is_no_output(tmp_path: Path) -> None:
    (tmp_path / "b.exr").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        prepare_output([tmp_path / "b.exr"], "--output", print)


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write in"):
        prepare_output([tmp_path / "file" / "b.exr"], "--output", print)


def test_too_long_a_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="too long"):
        prepare_output([tmp_path / ("x" * 300 + ".exr")], "--output", print)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied"):
        prepare_output([tmp_path / "b.exr"], "--output", print)


def test_inputs_and_devices_are_not_written_over(tmp_path: Path) -> None:
    stage = tmp_path / "shot.usda"
    stage.write_text("#usda 1.0\n")
    link = tmp_path / "link.json"
    link.symlink_to(stage)
    for path in (stage, link, tmp_path / "." / "shot.usda"):
        with pytest.raises(InputError, match="would overwrite"):
            prepare_output([path], "--stats", print, [stage])
    with pytest.raises(InputError, match="no regular file"):
        prepare_output([Path("/dev/null")], "--stats", print)
    assert stage.read_text() == "#usda 1.0\n"


def test_links_are_followed(tmp_path: Path) -> None:
    link, target = tmp_path / "link.exr", tmp_path / "new" / "b.exr"
    link.symlink_to(target)
    prepare_output([link], "--output", print)
    assert target.parent.is_dir()
    (tmp_path / "file").write_text("")
    link.unlink()
    link.symlink_to(tmp_path / "file" / "b.exr")
    with pytest.raises(InputError, match="cannot write in"):
        prepare_output([link], "--output", print)


def test_a_link_to_itself_is_written_over(tmp_path: Path) -> None:
    link = tmp_path / "b.json"
    link.symlink_to(link)
    prepare_output([link], "--stats", print, [tmp_path / "shot.usda"])
    with atomic_file(link) as file:
        file.write_text("{}")
    assert link.read_text() == "{}"
    assert not link.is_symlink()


def test_padding_with_spaces_is_refused() -> None:
    with pytest.raises(InputError, match="write %04d"):
        parse_pattern("b.%4d.exr")
    assert str(default_pattern("a%4d.usda", parse_frames("1")).path(parse_frames("1")[0]))
