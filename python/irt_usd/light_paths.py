# SPDX-License-Identifier: Apache-2.0
"""Light path expressions (Heckbert 1990; Hydra's `lpe:`), those that this renderer can tell apart.

An expression is a camera, what scatters, and a source:

    C .*  L                  all light                  C .* <L.'/Lights/Key'>   of one light
    C     [LO]               sources that are seen      C .* [<L.'a'><L.'b'>]    of some
    C .   [LO], C [DS] L     direct light               C .* O                   emission alone
    C .+  [LO]               all that was scattered     C .* [LO], C .*          both
    C . .+ [LO], C [DS][DS]+ L   indirect light

`.` and `[DS]` (or `[RT]`, `<.D>`, in any order) are an event of any kind: diffuse and specular,
reflected and transmitted light cannot be told apart. A light's label is a prim path, which stands
for the lights at and below it, or the bare name of a prim.
"""

import re
from dataclasses import dataclass
from typing import Literal

Events = Literal["any", "none", "once", "more", "some"]
"""How often light was scattered: whatever; never; once; twice or more; once or more."""

_EVENTS: dict[tuple[int, bool], Events] = {
    (0, True): "any",
    (0, False): "none",
    (1, False): "once",
    (1, True): "some",
    (2, True): "more",
}
"""By the least number, and whether there may be more."""

_ANY_EVENT = r"(?:\.|\[(?:DS|SD|RT|TR|DSV|VDS)\]|<\.\.?>|<\.\[(?:DS|SD)\]>|<\[(?:RT|TR)\]\.?>)"
_SCATTER = re.compile(rf"{_ANY_EVENT}(?P<many>[*+]?)")
_SOURCE = re.compile(r"L|O|<L\.*>|<O\.*>|<L\.*'(?P<label>[^']+)'>")


@dataclass(frozen=True)
class LightPaths:
    """What an expression asks for."""

    events: Events
    emission: bool
    """Whether light that surfaces emit counts."""
    labels: tuple[str, ...] | None
    """Of the lights that count; None: all."""


def parse(expression: str) -> LightPaths:
    """What `expression` says, with or without "lpe:". Raises ValueError, saying what is not known.

    Blanks do not count.
    """
    text = re.sub(r"\s", "", expression.removeprefix("color").strip().removeprefix("lpe:"))
    text = text.removeprefix("lpe:")
    if not text.startswith("C"):
        raise ValueError("it does not begin with the camera, C")
    at, least, more = 1, 0, False
    while match := _SCATTER.match(text, at):
        many = match["many"]
        least += many != "*"
        more = more or bool(many)
        at = match.end()
    events = _EVENTS.get((least, more))
    if events is None:
        raise ValueError(f"{least} events{' or more' if more else ''} are not told apart")
    if at == len(text):
        if not more:
            raise ValueError("it names no source; end it with L, O or [LO]")
        return LightPaths(events, True, None)
    return LightPaths(events, *_sources(text[at:]))


def _sources(text: str) -> tuple[bool, tuple[str, ...] | None]:
    inner = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    emission, lights = False, False
    labels: list[str] = []
    at = 0
    while at < len(inner):
        match = _SOURCE.match(inner, at)
        if match is None or (inner is text and at > 0):
            raise ValueError(f"'{inner[at:]}' is not known as an event or source")
        if match["label"] is not None:
            labels.append(match["label"])
        elif "O" in match[0]:
            emission = True
        else:
            lights = True
        at = match.end()
    if not inner:
        raise ValueError("it names no source")
    return emission, None if lights else tuple(labels)
