# SPDX-License-Identifier: Apache-2.0
"""USD stages to snapshots of plain records."""

from irt_usd.stage.camera import list_cameras
from irt_usd.stage.open import OpenOptions, open_stage
from irt_usd.stage.reader import ReadOptions, ShotReader
from irt_usd.stage.snapshot import (
    CameraState,
    LightState,
    MaterialState,
    ObjectState,
    Snapshot,
    State,
)

__all__ = [
    "CameraState",
    "LightState",
    "MaterialState",
    "ObjectState",
    "OpenOptions",
    "ReadOptions",
    "ShotReader",
    "Snapshot",
    "State",
    "list_cameras",
    "open_stage",
]
