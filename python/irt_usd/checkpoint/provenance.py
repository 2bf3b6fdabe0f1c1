# SPDX-License-Identifier: Apache-2.0
"""What a shot's pixels depend on, item by item, so that two runs can be told to be the same job."""

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import irt_usd
from irt_usd import _core
from irt_usd.shot.frames import format_frame, format_frames
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage import Snapshot, assets_read
from irt_usd.stage.snapshot import LightState, MaterialState, State
from irt_usd.stage.values import Value

Items = dict[str, Any]
"""Named things that must agree, as JSON holds them."""

_NO_SETTINGS = {"threads"}
"""Fields of TraceSettings that reach no pixel."""

_NO_OPTIONS = {"stage", "frames", "asset_path", "session_layer", "require_locked"}
"""Fields of ShotOptions that reach pixels by the files they lead to, or not at all."""


@cache
def build_hash() -> str:
    """Of the program's own files: histories are laid out as one build does it."""
    package = Path(irt_usd.__file__).parent
    files = sorted({*package.rglob("*.py"), Path(_core.__file__)})
    return _core.bytes_hash("".join(_core.file_hash(str(file)) for file in files).encode())


def program_items(isa: str, same_build: bool) -> Items:
    """The program and the machine; `same_build`: down to how memory is laid out."""
    versions = _core.versions()
    items: Items = {
        "program version": versions["irt"],
        "instruction set": isa,
        "numeric fingerprint": _core.numeric_fingerprint(isa),
    }
    if same_build:
        items["program build"] = build_hash()
    return items


def setting_items(shot: Shot, settings: TraceSettings, extra: Mapping[str, Any]) -> Items:
    """What was asked for; `extra` are the caller's own."""
    chosen = {k: v for k, v in asdict(settings).items() if k not in _NO_SETTINGS}
    options = {k: v for k, v in asdict(shot.options).items() if k not in _NO_OPTIONS}
    layer = shot.options.session_layer
    items: Items = {
        **{f"setting {name}": value for name, value in chosen.items()},
        **{f"option {name}": value for name, value in options.items()},
        "option session_layer": Path(layer).name if layer else None,
        "stage name": Path(shot.options.stage).name,
        "frames": format_frames(shot.frames),
        "render origin": list(shot.render_origin),
        "views": [[view.camera, view.product.path, asdict(view.framing)] for view in shot.views],
        **dict(extra),
    }
    plain: Items = json.loads(json.dumps(items, default=str))
    return plain


class FileHashes:
    """Hashes of the files a shot is made of, each taken once, when the shot is first seen with it.

    Files below the stage's folder are named from there, so that a job may be moved as a whole.
    """

    def __init__(self, shot: Shot) -> None:
        self._shot = shot
        self._folder = Path(os.path.realpath(shot.options.stage)).parent
        self._hashes: dict[Path, str] = {}

    def take(self) -> dict[str, str]:
        """All so far, by name."""
        config = os.environ.get("OCIO", "")
        for file in (*self._shot.read_files, *assets_read.files(), Path(config)):
            outer = Path(str(file).split("[", 1)[0]) if not file.exists() else file
            if outer not in self._hashes and outer.is_file():
                self._hashes[outer] = _core.file_hash(str(outer))
        return {self._name(file): found for file, found in self._hashes.items()}

    def path(self, name: str) -> Path:
        """The file of that name now."""
        return self._folder / name

    def _name(self, file: Path) -> str:
        real = Path(os.path.realpath(file))
        return str(real.relative_to(self._folder) if real.is_relative_to(self._folder) else real)


class SceneDigest:
    """Hashes of whole scenes. States that stay are hashed once."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[State, str]] = {}
        self._files: dict[Path, str] = {}

    def cameras(self, snapshot: Snapshot) -> list[str]:
        """By view."""
        return [self._state(camera) for camera in snapshot.cameras]

    def scene(self, snapshot: Snapshot) -> str:
        """Of objects, materials and lights."""
        parts: list[str] = []
        known: dict[int, tuple[State, str]] = {}
        kinds: tuple[Mapping[str, State], ...] = (
            snapshot.objects,
            snapshot.materials,
            snapshot.lights,
        )
        for states in kinds:
            for path, state in sorted(states.items()):
                kept = self._known.get(id(state))
                digest = kept[1] if kept is not None else self._state(state)
                known[id(state)] = (state, digest)
                parts.append(f"{path}\0{digest}\0")
            parts.append("\n")
        self._known = known
        return _core.bytes_hash("".join(parts).encode())

    def _state(self, state: State) -> str:
        text = "".join(
            f"{name}\0{_text(value)}\0" for name, value in sorted(state.attributes.items())
        )
        if isinstance(state, MaterialState):
            for reference in sorted(state.surface.textures, key=lambda r: (r.file, r.color_space)):
                text += f"{reference.color_space}\0{self._contents(reference.file)}\0"
        if isinstance(state, LightState):
            shaped = sorted(state.modifiers.items())
            text += repr((state.energy, shaped, state.up, state.sky and state.sky.axes))
            if picture := state.attributes.get("inputs:texture:file"):
                text += self._contents(str(picture))
            webs = (file for file in assets_read.files() if file.suffix.lower() == ".ies")
            text += " ".join(sorted(self._contents(str(file)) for file in webs))
        return _core.bytes_hash(f"{type(state).__name__}\0{state.path}\0{text}".encode())

    def _contents(self, file: str) -> str:
        """Of a texture's files; names of tiles have a number in the place of <UDIM>."""
        outer = Path(file.split("[", 1)[0])
        files = sorted(outer.parent.glob(outer.name.replace("<UDIM>", "[0-9]" * 4)))
        for path in (outer, *files):
            if path not in self._files and path.is_file():
                self._files[path] = _core.file_hash(str(path))
        return " ".join(self._files.get(path, "") for path in (outer, *files))


def _text(value: Value) -> str:
    """Equal where `same_bits` holds, and else different."""
    if isinstance(value, np.ndarray):
        bits = _core.bytes_hash(np.ascontiguousarray(value).tobytes())
        return f"{value.dtype.str}{value.shape}{bits}"
    if isinstance(value, tuple):
        return f"({','.join(map(_text, value))})"
    return f"{type(value).__name__} {value!r}"


def differences(then: Items, now: Items) -> Iterator[str]:
    """One text for each item that differs."""
    for name in sorted(then.keys() | now.keys()):
        if then.get(name) != now.get(name):
            yield f"{name}: {_shown(then.get(name))} then, {_shown(now.get(name))} now"


def file_differences(then: Mapping[str, str], hashes: FileHashes) -> Iterator[str]:
    """One text for each file that is not as it was; and those that are new."""
    now = hashes.take()
    for name, before in sorted(then.items()):
        path = hashes.path(name)
        if not path.is_file():
            yield f"file {name}: is gone"
        elif now.get(name, "") != before and _core.file_hash(str(path)) != before:
            yield f"file {name}: has changed"
    for name in sorted(now.keys() - then.keys()):
        yield f"file {name}: was not there"


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return value
    return json.dumps(value)


def frame_key(frame: Any) -> str:
    """A frame as JSON's key."""
    return format_frame(frame)
