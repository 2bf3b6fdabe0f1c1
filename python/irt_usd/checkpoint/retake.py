# SPDX-License-Identifier: Apache-2.0
"""Retakes: the history of another version of a shot as the start of this one's."""

from dataclasses import fields
from decimal import Decimal
from pathlib import Path
from typing import Any

from irt_usd import interrupt
from irt_usd.changes import diff
from irt_usd.checkpoint.container import Container, RefusedError, read
from irt_usd.checkpoint.provenance import (
    FileHashes,
    Items,
    SceneDigest,
    differences,
    file_differences,
    program_items,
    setting_items,
)
from irt_usd.checkpoint.store import KIND, newest
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.foresight import foresee
from irt_usd.shot.frames import Frame
from irt_usd.shot.session import Shot, open_shot
from irt_usd.shot.settings import ShotOptions, TraceSettings
from irt_usd.shot.tracer import ShotTracer
from irt_usd.stage import Snapshot

_SHOWN = 5
"""Prims that a message names."""


def start_retake(
    path: Path, shot: Shot, settings: TraceSettings, cells: Any, tracer: ShotTracer, first: Frame
) -> str:
    """Brings `tracer` to the scene and the history of the checkpoint `path`, of another version.

    `first` is the frame that will be traced next. Returns a line that tells of it. Raises
    RefusedError where the checkpoint is damaged, its version of the shot is not there any more, or
    its history cannot serve what differs.
    """
    container = read(newest(path), KIND)
    container.verify()
    header = container.header
    _refuse(container, list(differences(_comparable(header["job"]), _now(shot, settings, cells))))
    if header["job"]["history"] == "none":
        raise RefusedError(f"{container.path}: keeps no history (--history none)")
    old = _old_shot(container)
    snapshot = _old_scene(container, old)
    if header["job"]["history"] == "shot":
        _refuse_unserved(container, old, diff(snapshot, shot.reader.read(float(first))).changes)
        foreseen = foresee(old, old.frames)
    else:
        foreseen = None
    try:
        tracer.retake(snapshot, container, foreseen)
    except RuntimeError as error:
        raise RefusedError(f"{container.path}: {error}") from error
    return f"starts from frame {header['frame']} of {old.options.stage} ({container.path})"


def described(shot: Shot) -> dict[str, Any]:
    """For a header: how the shot was opened, so that it can be again."""
    from dataclasses import asdict

    options = asdict(shot.options)
    for name in ("stage", "session_layer"):
        if options[name] is not None:
            options[name] = str(Path(options[name]).absolute())
    options["asset_path"] = [str(Path(folder).absolute()) for folder in options["asset_path"]]
    if options["lock_camera"] is not None:
        options["lock_camera"] = str(options["lock_camera"])
    return options


def _now(shot: Shot, settings: TraceSettings, cells: Any) -> Items:
    items = {
        **program_items(settings.isa, same_build=True),
        **setting_items(shot, settings, {"cells": cells}),
    }
    return _comparable(items)


def _comparable(items: Items) -> Items:
    """What two versions must agree in: how films and histories are laid out and rounded."""
    exact = {"instruction set", "numeric fingerprint", "render origin", "views", "cells"}
    return {
        name: value
        for name, value in items.items()
        if name in exact or name.startswith(("program ", "setting "))
    }


def _old_shot(container: Container) -> Shot:
    given = container.header["shot"]
    known = {field.name for field in fields(ShotOptions)}
    options: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in given.items()
        if name in known
    }
    if options["lock_camera"] is not None:
        options["lock_camera"] = Decimal(options["lock_camera"])
    options["frames"] = container.header["job"]["frames"]
    try:
        return open_shot(ShotOptions(**options), Report())
    except InputError as error:
        raise RefusedError(
            f"{container.path}: the version that it is of cannot be opened: {error}"
        ) from error


def _old_scene(container: Container, old: Shot) -> Snapshot:
    header = container.header
    files, digest = FileHashes(old), SceneDigest()
    _refuse(container, list(file_differences(header["files"], files)))
    snapshot = old.reader.read(float(Decimal(header["frame"])))
    found = list(file_differences(header["files"], files))
    if header["cameras"] != digest.cameras(snapshot) or header["scene"] != digest.scene(snapshot):
        found.append("scene: the stage is read otherwise now")
    _refuse(container, found)
    return snapshot


def _refuse_unserved(container: Container, old: Shot, changes: Any) -> None:
    """A history for a shot's own changes serves no other prims' changes."""
    served: set[str] = set()
    reader, previous = old.reread(), None
    for frame in old.frames:
        interrupt.check()
        snapshot = reader.read(float(frame))
        if previous is not None:
            served |= {change.path for change in diff(previous, snapshot).changes}
        previous = snapshot
    others = sorted({change.path for change in changes} - served)
    if others:
        named = ", ".join(others[:_SHOWN])
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        raise RefusedError(
            f"{container.path}: its history was kept for the shot's own changes (--history shot)"
            f" and cannot serve those of {named}{more}; render that version with --history any"
        )


def _refuse(container: Container, found: list[str]) -> None:
    if found:
        raise RefusedError(f"{container.path}: cannot be started from: " + "; ".join(found))
