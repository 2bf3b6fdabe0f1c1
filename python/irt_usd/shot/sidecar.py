# SPDX-License-Identifier: Apache-2.0
"""A JSON file beside a frame, of what its pixels do not depend on: times, memory, the machine.

These never go into the frame's own header, so that frames compare by their bytes.
"""

import json
import os
import platform
import resource
from datetime import UTC, datetime
from pathlib import Path

from irt_usd import _core
from irt_usd.images.atomic import atomic_file
from irt_usd.shot.stats import FrameStats


def sidecar_path(frame: Path) -> Path:
    """Of the frame's file: its name and .json."""
    return frame.with_name(f"{frame.name}.json")


def write_sidecar(frame: Path, stats: FrameStats, threads: int) -> None:
    """Writes the sidecar of a frame that is on disk. Raises MachineError.

    `threads`: as TraceSettings has it.
    """
    processors = len(os.sched_getaffinity(0))
    facts = {
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": platform.node(),
        "system": platform.platform(),
        "processors": processors,
        "threads": threads or processors,
        "peak_memory_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "versions": _core.versions(),
        "frame": stats.to_json(),
    }
    with atomic_file(sidecar_path(frame)) as temporary:
        text = json.dumps(facts, indent=2, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")
