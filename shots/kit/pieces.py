# SPDX-License-Identifier: Apache-2.0
"""Chess pieces for squares of 5 cm, one function a piece: solids and some meshes at a path.

A knight looks along +x.
"""

import numpy as np
from pxr import Usd

from shots.kit.mesh import PolygonMesh, define_mesh, lathe, loft, smooth
from shots.kit.solids import Turner

SQUARE = 5.0


def pawn(stage: Usd.Stage, path: str) -> None:
    """The paper's seven primitives."""
    turner = Turner(stage, path)
    turner.cylinder("foot", 1.6, 0.0, 0.45)
    turner.bulge("rim", 1.5, 1.1, 0.5)
    turner.cone("skirt", 1.2, 0.7, 3.4)
    turner.capsule("stem", 0.52, 1.5, 2.4)
    turner.bulge("ring", 0.85, 0.4, 3.15)
    turner.cylinder("collar", 0.95, 3.25, 0.2)
    turner.sphere("head", 0.95, (0, 4.15, 0))


def rook(stage: Usd.Stage, path: str) -> None:
    """A tower of cylinders, its battlements cubes."""
    turner = Turner(stage, path)
    turner.cylinder("foot", 1.8, 0.0, 0.5)
    turner.bulge("rim", 1.7, 1.3, 0.6)
    turner.cone("skirt", 1.45, 0.8, 3.9)
    turner.cylinder("tower", 0.95, 1.4, 3.3)
    turner.bulge("ring", 1.25, 0.5, 4.1)
    turner.cylinder("parapet", 1.35, 4.5, 0.7)
    for i in range(6):
        turner.box(f"merlon_{i}", (0.4, 0.55, 0.75), (1.13, 5.45, 0), 60.0 * i)


def bishop(stage: Usd.Stage, path: str, segments: int = 40, per_span: int = 4) -> None:
    """One closed mesh, turned on the lathe; it is the piece to make of glass."""
    define_mesh(stage, f"{path}/body", bishop_mesh(segments, per_span))


def bishop_mesh(segments: int, per_span: int) -> PolygonMesh:
    """The bishop's body; points grow with `segments` times `per_span`."""
    straight = np.array([(1.75, 0.0), (1.75, 0.42)])
    base = smooth([(1.75, 0.42), (1.62, 0.8), (1.25, 1.05), (1.15, 1.1)], per_span)
    waist = smooth([(1.15, 1.1), (0.8, 2.0), (0.58, 3.2), (0.55, 4.0), (0.62, 4.4)], per_span)
    collar = smooth([(0.62, 4.4), (1.0, 4.5), (1.05, 4.65), (0.98, 4.8), (0.6, 4.9)], per_span)
    mitre = smooth(
        [(0.6, 4.9), (0.9, 5.35), (0.95, 5.8), (0.72, 6.4), (0.36, 6.85), (0.2, 6.95)], per_span
    )
    knob = smooth([(0.2, 6.95), (0.32, 7.15), (0.32, 7.3), (0.2, 7.48), (0.0, 7.55)], per_span)
    return lathe([straight, base, waist, collar, mitre, knob], segments)


def knight(stage: Usd.Stage, path: str, segments: int = 24, per_span: int = 4) -> None:
    """A lofted head and neck on turned solids, with cones for ears."""
    turner = Turner(stage, path)
    turner.cylinder("foot", 1.75, 0.0, 0.45)
    turner.bulge("rim", 1.65, 1.2, 0.55)
    turner.cylinder("plinth", 1.25, 0.8, 0.5)
    define_mesh(stage, f"{path}/head", knight_mesh(segments, per_span))
    for name, z in (("left", -0.34), ("right", 0.34)):
        ear = turner.cone(f"ear_{name}", 0.2, 5.2, 0.85)
        ear.AddRotateZOp().Set(20.0)
        ear.GetPrim().GetAttribute("xformOp:translate").Set((0.0, 5.85, z))
        turner.sphere(f"eye_{name}", 0.15, (0.9, 5.0, 1.75 * z))


def knight_mesh(segments: int, per_span: int) -> PolygonMesh:
    """Ellipses along the spine: (x, y, half depth across the spine, half width)."""
    spine = smooth(
        [
            (0.0, 1.25, 1.2, 1.15),
            (-0.2, 2.0, 1.22, 0.95),
            (-0.35, 2.9, 1.25, 0.82),
            (-0.25, 3.9, 1.22, 0.76),
            (0.1, 4.65, 1.05, 0.72),
            (0.75, 4.8, 0.85, 0.64),
            (1.3, 4.5, 0.68, 0.55),
            (1.8, 4.05, 0.56, 0.48),
            (2.15, 3.7, 0.48, 0.42),
            (2.3, 3.55, 0.26, 0.24),
        ],
        per_span,
    )
    along = np.gradient(spine[:, :2], axis=0)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    # From outside, with the spine up, columns run right: front (the throat), then -z, then back.
    across, aside = np.cos(angle) * spine[:, 2, None], -np.sin(angle) * spine[:, 3, None]
    x = spine[:, 0, None] + across * along[:, 1, None]
    y = spine[:, 1, None] - across * along[:, 0, None]
    return loft(np.stack([x, y, aside], axis=-1))


def queen(stage: Usd.Stage, path: str) -> None:
    """Solids, with a coronet of pearls."""
    turner = Turner(stage, path)
    _royal_body(turner, 6.9)
    turner.cup("crown", 1.25, 6.0, 2.4)
    turner.bulge("cap", 0.85, 0.9, 8.35)
    for i in range(8):
        angle = 2 * np.pi * i / 8
        center = (1.08 * float(np.sin(angle)), 8.5, 1.08 * float(np.cos(angle)))
        turner.sphere(f"pearl_{i}", 0.24, center)
    turner.sphere("knob", 0.36, (0, 9.0, 0))


def king(stage: Usd.Stage, path: str) -> None:
    """Solids, with a cross of two cubes."""
    turner = Turner(stage, path)
    _royal_body(turner, 7.3)
    turner.cup("crown", 1.3, 6.4, 2.4)
    turner.bulge("cap", 1.3, 0.9, 8.8)
    turner.box("cross_upright", (0.34, 1.5, 0.34), (0, 9.85, 0))
    turner.box("cross_bar", (1.05, 0.34, 0.34), (0, 10.0, 0))


def _royal_body(turner: Turner, shoulder: float) -> None:
    turner.cylinder("foot", 1.95, 0.0, 0.5)
    turner.bulge("rim", 1.85, 1.4, 0.65)
    turner.cone("skirt", 1.5, 0.9, shoulder - 0.5)
    turner.capsule("stem", 0.62, 1.5, shoulder - 1.6)
    turner.bulge("ring", 1.05, 0.5, shoulder - 1.05)
    turner.cylinder("collar", 1.2, shoulder - 0.85, 0.22)
