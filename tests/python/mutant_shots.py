# SPDX-License-Identifier: Apache-2.0
"""Shots in which faults of cpp/irt/mutant.h show that random ones seldom find."""

import scenes
from edits import Shot

GLASS = {"roughness": 0.0, "ior": 1.5}
PANES = [
    ("material", "/pale", {**GLASS, "opacity": 0.05, "diffuse_color": (0.9, 0.31, 0.83)}),
    ("material", "/dusky", {**GLASS, "opacity": 0.2, "diffuse_color": (0.41, 0.77, 0.53)}),
    ("object", "/p", ("plane", 3.0, 3.0), scenes.floor(0.5), "/pale"),
    ("object", "/q", ("plane", 3.0, 3.0), scenes.floor(0.75), "/dusky"),
    ("object", "/r", ("plane", 3.0, 3.0), scenes.floor(1.25), "/glass"),
]

SHOTS = {
    "panes that move in turn": Shot(
        "hall",
        [PANES, *[[("shift", pane, (0.01, 0.125, 0.0))] for pane in ("/q", "/p", "/r")]],
        size=(33, 17),
        samples=4,
    ),
    "a cut-out begins to tint": Shot(
        "hall", [[("look", "/leaf", {"opacity_threshold": 0.0})]], samples=4
    ),
    "what a cut-out passed on whole is passed on in part": Shot(
        "hall", [[("look", "/leaf", {"opacity": 0.9, "opacity_threshold": 0.0, "ior": 1.0})]]
    ),
}
