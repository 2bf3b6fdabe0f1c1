# SPDX-License-Identifier: Apache-2.0
"""Frame ranges: the grammar of `--frames`, exact in decimals.

7                 one frame
1001:1100         both ends included; 105:101 counts down
1:48x2  1-48x2    every second frame (OpenUSD, Deadline, fileseq)
1-48:2            the same (Open Job Description)
1,5,9:12          a list of any of these
1:2x0.25          sub-frames
"""

import re
from collections.abc import Iterable, Sequence
from decimal import Decimal

from irt_usd.errors import InputError

Frame = Decimal
"""A time code as written: exact, so that 1:2x0.1 meets 1.3 and file names never show 1.2999."""

MAX_FRAMES = 1_000_000
"""Longer ranges are taken for slips of the keyboard."""

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_PART = re.compile(
    rf"(?P<first>{_NUMBER})"
    rf"(?:(?P<dash>-)(?P<last_dash>{_NUMBER})(?:[x:](?P<step_dash>{_NUMBER}))?"
    rf"|:(?P<last>{_NUMBER})(?:x(?P<step>{_NUMBER}))?)?"
)
_EXAMPLES = "write 7, 1001:1100, 1:48x2, 1-48:2, 1:2x0.25 or a list such as 1,5,9:12"


def parse_frames(text: str) -> tuple[Frame, ...]:
    """The frames of a `--frames` value, in the order written, each once.

    Raises InputError where the text is not a range, or is an empty one.
    """
    if not text.strip():
        raise InputError(f"--frames: the range is empty; {_EXAMPLES}")
    frames: dict[Frame, None] = {}
    for part in text.split(","):
        for frame in _parse_part(part.strip(), text):
            frames.setdefault(frame)
        if len(frames) > MAX_FRAMES:
            raise InputError(f"--frames {text}: more than {MAX_FRAMES} frames; split the range")
    return tuple(frames)


def _parse_part(part: str, text: str) -> Iterable[Frame]:
    match = _PART.fullmatch(part)
    if match is None:
        raise InputError(f"--frames {text}: '{part}' is not a frame range; {_EXAMPLES}")
    first = _number(match["first"])
    last_text = match["last"] or match["last_dash"]
    if last_text is None:
        return (first,)
    return _spread(first, _number(last_text), match["step"] or match["step_dash"], part, text)


def _spread(
    first: Frame, last: Frame, step_text: str | None, part: str, text: str
) -> Iterable[Frame]:
    """first, first + step, ... up to and including last; a step counts either way."""
    down = last < first
    step = Decimal(1) if step_text is None else _number(step_text)
    if step == 0:
        raise InputError(f"--frames {text}: the step of '{part}' is 0; leave it out for 1")
    if step < 0 and not down:
        raise InputError(
            f"--frames {text}: '{part}' is empty: it counts up with a step of {step};"
            f" swap its ends to count down"
        )
    step = -abs(step) if down else step
    count = int((last - first) / step) + 1
    if count > MAX_FRAMES:
        raise InputError(f"--frames {text}: '{part}' has {count} frames; at most {MAX_FRAMES}")
    return (first + step * index for index in range(count))


def _number(text: str) -> Frame:
    value = Decimal(text)
    if len(value.as_tuple().digits) > 15:
        raise InputError(f"--frames: {text} has more digits than a time code can hold (15)")
    return value + 0  # -0 is 0


def frames_from_stage(start: float, end: float, file: str) -> tuple[Frame, ...]:
    """Every whole step from the startTimeCode to the endTimeCode of the stage in `file`.

    Raises InputError where the stage's range is empty, not finite or too long.
    """
    ends = f"startTimeCode {start:g}, endTimeCode {end:g}"
    exact_start, exact_end = Decimal(repr(start)), Decimal(repr(end))
    if not (exact_start.is_finite() and exact_end.is_finite()) or end < start:
        raise InputError(
            f"{file}: the stage's own range is empty: {ends}; mend them or give --frames"
        )
    count = int(exact_end - exact_start) + 1
    if count > MAX_FRAMES:
        raise InputError(
            f"{file}: the stage's own range, {ends}, has more than {MAX_FRAMES} frames, the most"
            f" that irt takes at once; mend it or give --frames"
        )
    return tuple((exact_start + index).normalize() + 0 for index in range(count))


def format_frame(frame: Frame) -> str:
    """The shortest plain decimal: 1001, 1.25, -3."""
    return f"{frame.normalize():f}"


def count_frames(count: int) -> str:
    """1 frame, 2 frames."""
    return f"{count} frame" if count == 1 else f"{count} frames"


def format_frames(frames: Sequence[Frame]) -> str:
    """The normalised range, which parses back to the same frames: 1:9x2,12."""
    parts: list[str] = []
    index = 0
    while index < len(frames):
        end = _run_end(frames, index)
        if end - index >= 3:
            parts.append(_format_run(frames[index], frames[index + 1], frames[end - 1]))
            index = end
        else:
            parts.append(format_frame(frames[index]))
            index += 1
    return ",".join(parts)


def _run_end(frames: Sequence[Frame], start: int) -> int:
    """The end of the longest run of even steps from `start`."""
    end = start + 2
    while end < len(frames) and frames[end] - frames[end - 1] == frames[start + 1] - frames[start]:
        end += 1
    return min(end, len(frames))


def _format_run(first: Frame, second: Frame, last: Frame) -> str:
    step = abs(second - first)
    suffix = "" if step == 1 else f"x{format_frame(step)}"
    return f"{format_frame(first)}:{format_frame(last)}{suffix}"
