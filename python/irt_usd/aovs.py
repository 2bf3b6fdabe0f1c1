# SPDX-License-Identifier: Apache-2.0
"""The AOVs by their names, Hydra's where it has one: what each is made of, and its EXR channels.

`depth` is, as compositing expects of Z, the distance along the view in scene units, and not Hydra's
clip-space depth; `cameraDepth` is the same under Hydra's name for it. `objectId` and `primId` are
the hash of the prim's path. `primvars:NAME` may say of which type it is wanted, as render vars do:
`primvars:st as float2`. docs/aovs.md has them all. No NumPy here, so that `irt --help` is quick.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from irt_usd import light_paths

_AXES = ("X", "Y", "Z")
_RGB = ("R", "G", "B")


@dataclass(frozen=True)
class Aov:
    """How an AOV is made and stored."""

    source: str
    """The core's AOV that it is made of; empty: it is made of irt.retraced over the frames."""
    letters: tuple[str, ...] = ()
    """Of its channels, after the layer's name; none: it has one channel, of the layer's name."""
    kind: Literal["float", "colour", "id", "cryptomatte"] = "float"
    """colour: as beauty is stored. cryptomatte: pairs of id and coverage, two to a layer."""

    def channels(self, layer: str, count: int = 0) -> tuple[str, ...]:
        """Names of its channels in a layer of the name; of a cryptomatte there are `count`."""
        if layer == "depth":
            return ("Z",)
        if self.kind == "id":
            return (f"{layer}.id",)
        if self.kind == "cryptomatte":
            return tuple(f"{layer}{i // 4:02d}.{'RGBA'[i % 4]}" for i in range(count))
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
    "instanceId": Aov("instanceId", kind="id"),
    "elementId": Aov("elementId", kind="id"),
    "CryptoObject": Aov("CryptoObject", kind="cryptomatte"),
    "CryptoMaterial": Aov("CryptoMaterial", kind="cryptomatte"),
    "motionBack": Aov("irt.seen", _AXES[:2]),
    "motionFore": Aov("irt.seen", _AXES[:2]),
    "irt.retraced": Aov("irt.retraced"),
    "irt.cause": Aov("irt.cause"),
    "irt.age": Aov("irt.retraced"),
}
"""Those of fixed names."""

SURFACE_AOVS = tuple(name for name in AOVS if not name.startswith("irt."))
"""Those of what is seen; the others tell of the update, in which ways to a frame differ."""

BEAUTY_SOURCES = frozenset(("color", "C", "Ci", "rgba", "RGBA", "beauty", "alpha", "a", "A"))
"""Sources of render vars that the root layer's R, G, B and A hold."""

ALIASES: Mapping[str, str] = {
    **dict.fromkeys(("Z", "z", "Pz"), "depth"),
    **dict.fromkeys(("N", "Nn"), "normal"),
    **dict.fromkeys(("P",), "position"),
    **dict.fromkeys(("ID", "id", "primid"), "primId"),
    **dict.fromkeys(("motionvector", "motionVector"), "motionFore"),
    **dict.fromkeys(("cryptoObject", "crypto_object"), "CryptoObject"),
    **dict.fromkeys(("cryptoMaterial", "crypto_material"), "CryptoMaterial"),
}
"""Names that other renderers have for the same; render vars may use them."""

PRIMVARS = "primvars:"
LPE = "lpe:"
MOTION: Mapping[str, int] = {"motionBack": -1, "motionFore": 1}
"""AOVs of motion, and to which frame they lead."""

_TYPES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("float", "half", "double", "int", "bool"), ()),
    **dict.fromkeys(("float2", "half2", "double2", "int2"), ("X", "Y")),
    **dict.fromkeys(("texCoord2f", "texCoord2h", "texCoord2d"), ("X", "Y")),
    **{f"{kind}3{p}": _RGB for kind in ("color",) for p in "fhd"},
    **{f"{kind}3{p}": _AXES for kind in ("point", "normal", "vector", "texCoord") for p in "fhd"},
    **dict.fromkeys(("float3", "half3", "double3", "int3"), _AXES),
    **{f"color4{p}": (*_RGB, "A") for p in "fhd"},
    **dict.fromkeys(("float4", "half4", "double4", "int4"), (*_AXES, "W")),
}
"""Channels of a primvar's AOV, by the type that it is wanted as."""

DEFAULT_TYPE = "color3f"
"""Of render vars, by UsdRenderVar's schema, and of primvars asked for without one."""


def is_aov(name: str) -> bool:
    """Whether there is such an AOV."""
    try:
        aov(name)
    except KeyError:
        return False
    return True


@lru_cache(maxsize=256)
def aov(name: str) -> Aov:
    """The AOV of a name. Raises KeyError."""
    if name in AOVS:
        return AOVS[name]
    if name.startswith(LPE):
        try:
            light_paths.parse(name)
        except ValueError as error:
            raise KeyError(name) from error
        return Aov(name, _RGB, "colour")
    primvar = primvar_of(name)
    if not primvar:
        raise KeyError(name)
    kind = name.rpartition(" as ")[2] if " as " in name else DEFAULT_TYPE
    return Aov(f"{PRIMVARS}{primvar}", _TYPES[kind])


def primvar_of(name: str) -> str:
    """The NAME of primvars:NAME; empty of other AOVs."""
    return name.removeprefix(PRIMVARS).partition(" as ")[0] if name.startswith(PRIMVARS) else ""


def default_layer(name: str) -> str:
    """The EXR layer of an AOV that is given no other name: without what layers cannot hold."""
    if name.startswith(LPE):
        return "lpe_" + re.sub(r"[^A-Za-z0-9]+", "_", name.removeprefix(LPE)).strip("_")
    return f"{PRIMVARS}{primvar}" if (primvar := primvar_of(name)) else name


def primvar_aov(primvar: str, kind: str = DEFAULT_TYPE) -> str:
    """The AOV of a primvar, wanted as `kind`, one of USD's types; color3f where that has no use."""
    suffix = f" as {kind}" if kind in _TYPES and kind != DEFAULT_TYPE else ""
    return f"{PRIMVARS}{primvar}{suffix}"


Part = tuple[str, light_paths.Events, bool, tuple[str, ...] | None]
"""A part of the beauty as the core takes it: name, events, whether emission counts, lights."""


def beauty_parts(names: Collection[str]) -> list[Part]:
    """The parts of the beauty among AOVs."""
    found: list[Part] = []
    for name in names:
        if name.startswith(LPE):
            said = light_paths.parse(name)
            found.append((name, said.events, said.emission, said.labels))
    return found


def sources(names: Collection[str]) -> tuple[str, ...]:
    """The core's AOVs that those of the names are made of."""
    wanted = [aov(name).source for name in names if not name.startswith(LPE)]
    if "Peye" in names:
        wanted.append("normal")  # which is zero where nothing is seen
    return tuple(dict.fromkeys(wanted))
