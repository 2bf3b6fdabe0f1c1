# SPDX-License-Identifier: Apache-2.0
"""Many frames, and frames with odd numbers."""

from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom

import scenes
from extremes.rows import NewRow
from irt_usd.report import Report
from irt_usd.stage import ReadOptions, ShotReader, open_stage

EDITS: list[scenes.Edit] = [
    ("shift", "/b", (0.25, 0.0, 0.0)),
    ("look", "/glass", {"opacity": 0.5}),
    ("light", "/fill", ("point", (0.25, 2.0, -3.0), (8.0, 4.0, 4.0), True)),
    ("shine", "/key", (0.5, 0.5, 0.4)),
    ("remove", "/d"),
    ("bind", "/c", "/glass"),
    ("deform", "/b", 3, (0.0, 0.25, 0.0)),
    ("resize", "/a", (0.75,)),
    ("hide", "/e"),
    ("object", "/new", ("cone", 0.25, 0.75), scenes.floor(1.25), "/mirror"),
]


def test_edits_and_their_undoing(row: NewRow, full: bool) -> None:
    """Each edit and its undoing, over and over: the film returns to its first bits, and after the
    first round the history holds no byte more."""
    frames = 10_000 if full else 400
    bits = row("10,000 frames of edits and their undoing", "frames that differ when undone", 0)
    growth = row("the same, bytes of history after the first round", "bytes more", 0)
    state = scenes.hall()
    made = scenes.renderer(24, 20)
    made.update(state.fresh())
    first = scenes.film_bits(made)
    sizes = []
    for frame in range(0, frames, 2):
        edit = EDITS[frame // 2 % len(EDITS)]
        made.update(state.apply([edit]))
        done = made.update(state.apply([("undo", 1)]))
        state.past.clear()
        bits.see(0 if scenes.film_bits(made) == first else 1, f"frame {frame}, {edit[:2]}")
        if frame // 2 % len(EDITS) == len(EDITS) - 1:
            sizes.append(done["history"]["all_bytes"])
    made.validate()
    growth.see(max(0, max(sizes[1:]) - sizes[1]), f"round {int(np.argmax(sizes))}")


STAGE = """#usda 1.0
(
    startTimeCode = {start}
    endTimeCode = {end}
)
def Sphere "ball"
{{
    double radius = 1
    double3 xformOp:translate.timeSamples = {{ {start}: (0, 0, 0), {end}: ({step}, 0, 0) }}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def Camera "cam"
{{
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


def test_odd_times(row: NewRow, tmp_path: Path) -> None:
    """Keys a millionth of a frame apart, near any frame: the positions are USD's own, which sees
    no such step as a line everywhere (near 1000 it holds the first key)."""
    seen = row("sub-frame steps of 10^-6 near frame 0, -1000, ±10^9", "error of a position", 0)
    step = 1e-6
    for start in (0.0, -1000.0, 1e9, -1e9):
        end = start + step
        path = tmp_path / f"odd{start:g}.usda"
        path.write_text(STAGE.format(start=repr(start), end=repr(end), step=repr(end - start)))
        times = [start + (end - start) * part / 4 for part in range(5)]
        stage: Usd.Stage = open_stage(str(path))
        reader = ShotReader(stage, ReadOptions(), Report(), times)
        ball = UsdGeom.Xformable(stage.GetPrimAtPath("/ball"))
        for time in times:
            found = reader.read(time).objects["/ball"].world_from_object[3][0]
            own = ball.ComputeLocalToWorldTransform(Usd.TimeCode(time))[3][0]
            seen.see(abs(found - own), f"time {time!r}")
