# SPDX-License-Identifier: Apache-2.0
"""The frame-range grammar."""

from decimal import Decimal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from irt_usd.errors import InputError
from irt_usd.shot.frames import (
    format_frame,
    format_frames,
    frames_from_stage,
    parse_frames,
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("7", "7"),
        ("1:4", "1 2 3 4"),
        ("1-4", "1 2 3 4"),
        ("1:8x3", "1 4 7"),
        ("1-8x3", "1 4 7"),
        ("1-8:3", "1 4 7"),
        ("105:101", "105 104 103 102 101"),
        ("105:101x2", "105 103 101"),
        ("105:101x-2", "105 103 101"),
        ("1,5,9:12", "1 5 9 10 11 12"),
        ("9:10, 1", "9 10 1"),
        ("1:2x0.25", "1 1.25 1.5 1.75 2"),
        ("0:0.5x0.1", "0 0.1 0.2 0.3 0.4 0.5"),
        ("-2:1", "-2 -1 0 1"),
        ("-5--3", "-5 -4 -3"),
        ("-0", "0"),
        ("3,1:4,2", "3 1 2 4"),
        ("5:5", "5"),
        ("1:2x5", "1"),
        ("+7", "7"),
        ("1001.0", "1001"),
        (".5", "0.5"),
    ],
)
def test_ranges(text: str, expected: str) -> None:
    assert " ".join(map(format_frame, parse_frames(text))) == expected


@pytest.mark.parametrize(
    "text",
    [
        "", " ", ",", "1,", "a", "1:", ":4", "1:4x", "1:4x0", "1:4x-1", "1:4:2", "1..4", "1e3",
        "nan", "inf", "1:2:3:4", "１", "1 2", "1:1e9", "0:99999999", "1x2", "0.1234567890123456",
    ],
)  # fmt: skip
def test_what_is_no_range_is_refused_by_name(text: str) -> None:
    with pytest.raises(InputError, match="--frames") as caught:
        parse_frames(text)
    assert caught.value.status == 2


def test_steps_do_not_drift() -> None:
    frames = parse_frames("0:1000x0.1")
    assert len(frames) == 10001
    assert frames[3] == Decimal("0.3")
    assert float(frames[-2]) == 999.9


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("1:48x2", "1:47x2"),
        ("1-4,5,6", "1:6"),
        ("1,3,5,6", "1:5x2,6"),
        ("4,2", "4,2"),
        ("4:1", "4:1"),
        ("1:2x0.25", "1:2x0.25"),
        ("1,2", "1,2"),
    ],
)
def test_normal_form(text: str, normal: str) -> None:
    assert format_frames(parse_frames(text)) == normal


frame_lists = st.lists(
    st.one_of(
        st.integers(-20, 20).map(Decimal),
        st.decimals(-9, 9, places=2),
    ).map(lambda value: value + 0),
    min_size=1,
    unique=True,
)


@given(frame_lists)
@settings(deadline=None)
def test_normal_form_parses_to_the_same_frames(frames: list[Decimal]) -> None:
    assert list(parse_frames(format_frames(frames))) == frames


def test_range_of_a_stage() -> None:
    assert format_frames(frames_from_stage(1001.0, 1003.0, "a.usda")) == "1001:1003"
    assert format_frames(frames_from_stage(0.5, 3.0, "a.usda")) == "0.5:2.5"
    assert format_frames(frames_from_stage(10.0, 10.0, "a.usda")) == "10"


@pytest.mark.parametrize(
    "ends", [(2.0, 1.0), (float("nan"), 1.0), (0.0, float("inf")), (0.0, 1e12)]
)
def test_empty_range_of_a_stage_is_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="give --frames"):
        frames_from_stage(*ends, "a.usda")
