# SPDX-License-Identifier: Apache-2.0
"""Frames of another version that are this one's, too: kept, not rendered."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from irt_usd import _core
from irt_usd.aovs import MOTION
from irt_usd.checkpoint.container import RefusedError, read
from irt_usd.checkpoint.provenance import SceneDigest, differences, program_items, setting_items
from irt_usd.checkpoint.store import KIND, newest
from irt_usd.images.exr import rewrite_metadata
from irt_usd.shot.frames import Frame, format_frame
from irt_usd.shot.metadata import frame_metadata, shot_metadata
from irt_usd.shot.products import view_aovs
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage import Snapshot

_FREE = ("frames", "history", "rendered frames", "stage name", "option ")
"""Items that two versions whose scenes agree may differ in; the stage's name is written anew."""


class OldFrames:
    """The frames that the run of the checkpoint `path` wrote, with the scenes they show.

    Raises RefusedError where the checkpoint is damaged or its frames were made otherwise.
    """

    def __init__(
        self, path: Path, shot: Shot, settings: TraceSettings, extra: dict[str, Any]
    ) -> None:
        self._shot = shot
        container = read(newest(path), KIND)
        container.verify()
        self._header = container.header
        self._digest = SceneDigest()
        self._common = [shot_metadata(shot, settings, view) for view in range(len(shot.views))]
        now = {
            **program_items(settings.isa, same_build=True),
            **setting_items(shot, settings, extra),
        }
        found = [
            text for text in differences(self._header["job"], now) if not text.startswith(_FREE)
        ]
        if any(".irt." in name or name.startswith("irt.") for name in _layers(now)):
            found.append("layers irt.*, which tell of the run, are asked for")
        if any(name in MOTION for view in shot.views for name in view_aovs(view, settings)):
            found.append("layers of motion, which tell of other frames, are asked for")
        if found:
            raise RefusedError(f"{path}: its frames cannot be kept: " + "; ".join(found))

    def keep(self, frame: Frame, snapshot: Snapshot, paths: Sequence[Path]) -> bool:
        """Writes the files of `frame`, if the old scene is `snapshot` and the files are whole."""
        name = format_frame(frame)
        hashes, files = self._header["done"].get(name), self._header["outputs"].get(name)
        digest = [self._digest.scene(snapshot), *self._digest.cameras(snapshot)]
        if hashes is None or files is None or self._header["digests"].get(name) != digest:
            return False
        olds = [Path(file) for file in files]
        if not all(
            old.is_file() and _core.file_hash(str(old)) == hashed
            for old, hashed in zip(olds, hashes, strict=True)
        ):
            return False
        for view, (old, path) in enumerate(zip(olds, paths, strict=True)):
            metadata = self._common[view] | frame_metadata(
                self._shot, frame, snapshot.cameras[view]
            )
            rewrite_metadata(old, path, metadata)
        return True


def _layers(items: dict[str, Any]) -> Sequence[str]:
    return items.get("setting aovs") or ()
