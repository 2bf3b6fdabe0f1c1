# SPDX-License-Identifier: Apache-2.0
"""The AOVs by their names, Hydra's where it has one: what each is made of, and its EXR channels.

`depth` is, as compositing expects of Z, the distance along the view in scene units, and not Hydra's
clip-space depth; `cameraDepth` is the same under Hydra's name for it. `objectId` and `primId` are
the hash of the prim's path. No NumPy here, so that `irt --help` is quick.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

_AXES = ("X", "Y", "Z")
_RGB = ("R", "G", "B")


@dataclass(frozen=True)
class Aov:
    """How an AOV is made and stored."""

    source: str
    """The core's AOV that it is made of; empty: it is made of irt.retraced over the frames."""
    letters: tuple[str, ...] = ()
    """Of its channels, after the layer's name; none: it has one channel, of the layer's name."""
    kind: Literal["float", "colour", "id"] = "float"

    def channels(self, layer: str) -> tuple[str, ...]:
        """Names of its channels in a layer of the name."""
        if layer == "depth":
            return ("Z",)
        if self.kind == "id":
            return (f"{layer}.id",)
        return tuple(f"{layer}.{letter}" for letter in self.letters) or (layer,)


AOVS: Mapping[str, Aov] = {
    "depth": Aov("depth"),
    "cameraDepth": Aov("depth"),
    "normal": Aov("normal", _AXES),
    "Neye": Aov("normal", _AXES),
    "position": Aov("position", _AXES),
    "Peye": Aov("position", _AXES),
    "albedo": Aov("albedo", _RGB, "colour"),
    "objectId": Aov("objectId", kind="id"),
    "primId": Aov("objectId", kind="id"),
    "irt.retraced": Aov("irt.retraced"),
    "irt.age": Aov("irt.retraced"),
}

SURFACE_AOVS = tuple(name for name in AOVS if not name.startswith("irt."))
"""Those of what is seen; the others tell of the update, in which ways to a frame differ."""

BEAUTY_SOURCES = frozenset(("color", "C", "Ci", "rgba", "RGBA", "beauty", "alpha", "a", "A"))
"""Sources of render vars that the root layer's R, G, B and A hold."""


def sources(names: Collection[str]) -> tuple[str, ...]:
    """The core's AOVs that those of the names are made of."""
    wanted = [AOVS[name].source for name in names]
    if "Peye" in names:
        wanted.append("normal")  # which is zero where nothing is seen
    return tuple(dict.fromkeys(wanted))
