# SPDX-License-Identifier: Apache-2.0
"""Output patterns: which file a frame is written to, and whether it can be."""

import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from irt_usd.errors import InputError
from irt_usd.images.atomic import followed
from irt_usd.shot.frames import Frame, format_frame

_TOKEN = re.compile(
    r"(?P<hashes>\#+)(?:\.(?P<decimals>\#+))?"
    r"|\$F(?P<houdini>[0-9]?)"
    r"|%(?:0(?P<printf>[1-9]))?d"
)
_PADDED_WITH_SPACES = re.compile("%([1-9])d")
_TOKENS = "####, ###.### for sub-frames, $F4 or %04d"


@dataclass(frozen=True)
class OutputPattern:
    """A file name with at most one frame token.

    `width` counts the whole token as usdrecord does: `###.###` is 7 wide with 3 decimals. `origin`
    is the option, or whatever else, that the name comes from.
    """

    text: str
    span: tuple[int, int] | None
    width: int = 0
    decimals: int = 0
    origin: str = "--output"

    def path(self, frame: Frame) -> Path:
        """The file of one frame; the frame must fit the token (see `output_paths`)."""
        if self.span is None:
            return Path(self.text)
        start, end = self.span
        return Path(f"{self.text[:start]}{frame:0{self.width}.{self.decimals}f}{self.text[end:]}")


def parse_pattern(text: str, origin: str = "--output") -> OutputPattern:
    """Raises InputError where the tokens are several or odd, or it is no EXR file's name."""
    if not text.lower().endswith(".exr"):
        raise InputError(f"{origin} {text}: irt writes OpenEXR files; end the name in .exr")
    spaces = _PADDED_WITH_SPACES.search(text)
    if spaces:
        raise InputError(
            f"{origin} {text}: {spaces.group()} pads with spaces; write %0{spaces[1]}d"
        )
    tokens = list(_TOKEN.finditer(text))
    if not tokens:
        return OutputPattern(text, None, origin=origin)
    if len(tokens) > 1:
        found = ", ".join(token.group() for token in tokens)
        raise InputError(f"{origin} {text}: several frame tokens ({found}); leave one")
    (token,) = tokens
    if token["hashes"]:
        decimals = len(token["decimals"] or "")
        return OutputPattern(text, token.span(), len(token.group()), decimals, origin)
    width = int(token["houdini"] or token["printf"] or 1)
    return OutputPattern(text, token.span(), width, origin=origin)


def default_pattern(stage_path: str, frames: Sequence[Frame], product: str = "") -> OutputPattern:
    """out/<stage's name>.####.exr, with as many decimals as the frames need.

    `product`: what tells one image of the stage from another; stands before the frame.
    """
    decimals = max((-_exponent(frame) for frame in frames), default=0)
    token = "####" if decimals <= 0 else f"####.{'#' * decimals}"
    stem = _PADDED_WITH_SPACES.sub("_", _TOKEN.sub("_", Path(stage_path).stem))
    name = f"{stem}.{product}" if product else stem
    return parse_pattern(f"out/{name}.{token}.exr")


def _exponent(frame: Frame) -> int:
    return int(frame.normalize().as_tuple().exponent)


def output_paths(pattern: OutputPattern, frames: Sequence[Frame]) -> list[Path]:
    """The file of each frame, no two alike.

    Raises InputError where a range has no token, or a frame does not fit the token.
    """
    if pattern.span is None and len(frames) > 1:
        raise InputError(
            f"{pattern.origin} {pattern.text}: {len(frames)} frames but no frame token, so each"
            f" would overwrite the last; put one in the name ({_TOKENS})"
        )
    paths = [pattern.path(frame) for frame in frames]
    if pattern.span is not None:
        taken: dict[Path, Frame] = {}
        for frame, path in zip(frames, paths, strict=True):
            other = taken.setdefault(path, frame)
            if other != frame or -_exponent(frame) > pattern.decimals:
                _refuse_sub_frame(pattern, frame, other, path)
    return paths


def _refuse_sub_frame(pattern: OutputPattern, frame: Frame, other: Frame, path: Path) -> None:
    names = format_frame(frame)
    clash = f"would be {path.name}"
    if other != frame:
        names = f"{format_frame(other)} and {names}"
        clash = f"would both be {path.name}"
    needed = "#" * max(1, -_exponent(frame))
    raise InputError(
        f"{pattern.origin} {pattern.text}: frames at {names} {clash}; use a token with"
        f" enough decimals, such as ####.{needed}"
    )


def prepare_output(
    paths: Sequence[Path],
    option: str,
    note: Callable[[str], None],
    kept: Sequence[Path] = (),
    make_folders: bool = True,
) -> None:
    """Proves that files can be written in the files' folders, leaving none there.

    Folders that are not there are created, unless `make_folders` is false; `note` is told of each.
    `kept` are files that must not be written over. Raises InputError naming what stands in the way.
    """
    names = {followed(other): other for other in kept}
    ids = {_file_id(other): other for other in kept}
    ids.pop(None, None)
    for path in paths:
        _refuse_other_than_file(path, option)
        overwritten = names.get(followed(path)) or ids.get(_file_id(path))
        if overwritten is not None:
            raise InputError(f"{option} {path}: would overwrite {overwritten}; give another name")
    for folder in dict.fromkeys(followed(path).parent for path in paths):
        try:
            if not folder.exists():
                if not make_folders:
                    raise InputError(
                        f"{option} {paths[0]}: there is no folder {folder}; create it, or give"
                        " --make-output-path"
                    )
                folder.mkdir(parents=True, exist_ok=True)
                note(f"created {folder}")
            with tempfile.NamedTemporaryFile(dir=folder, prefix=".irt-"):
                pass
        except OSError as error:
            raise InputError(
                f"{option} {paths[0]}: cannot write in {folder}: {error.strerror}"
            ) from error


def _refuse_other_than_file(path: Path, option: str) -> None:
    """Refuses what a renamed file would replace by mistake: a folder, a device, a pipe."""
    try:
        if path.is_dir():
            raise InputError(f"{option} {path}: is a folder; give a file's name")
        if path.exists() and not path.is_file():
            raise InputError(f"{option} {path}: is no regular file; give a file's name")
    except OSError as error:
        raise InputError(f"{option} {path}: {error.strerror}; give another name") from error


def _file_id(path: Path) -> tuple[int, int] | None:
    """What hard links to a file share; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino
