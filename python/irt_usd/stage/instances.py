# SPDX-License-Identifier: Apache-2.0
"""UsdGeomPointInstancer: prototypes read once, entries as arrays, never one by one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.images.color import Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.color import StageColors
from irt_usd.stage.display_color import INSTANCE_COLOR
from irt_usd.stage.primvars import Primvars, PrimvarValue, primvar_attributes, same_primvars
from irt_usd.stage.snapshot import ObjectState, Shape
from irt_usd.stage.transforms import (
    Node,
    regular_transforms,
    transform_blame,
    transform_fault,
)
from irt_usd.stage.values import Value, matrix_array, same_bits

if TYPE_CHECKING:
    from irt_usd import _core
    from irt_usd.stage.objects import ObjectSource

_ARRAYS = (
    "positions",
    "orientations",
    "orientationsf",
    "scales",
    "protoIndices",
    "ids",
    "invisibleIds",
    "velocities",
    "accelerations",
    "angularVelocities",
)

_SAME_FOR_ALL = ("constant", "uniform")

ENTRY_ATTRIBUTES = ("keys", "protoIndices", "array_from_prototype")
"""The attributes of an InstancesShape that are told entry by entry, not as whole arrays."""


@dataclass(frozen=True, eq=False, slots=True)
class _Prototype:
    """A prototype at one time: its parts' states by path, and the core's record of them."""

    states: Mapping[str, ObjectState]
    record: "_core.Prototype"


class InstancesShape(Shape):
    """Entries that are drawn.

    Attributes: keys (n,) int64, increasing: an entry's id, or its index where there are no ids;
    protoIndices (n,) int32; array_from_prototype (n, 4, 3) float64, row vectors in the instancer's
    space; primvars, constant or one an entry; and all that the prototypes' parts have, by path.
    """

    def __init__(
        self,
        array: "_core.InstanceArray",
        keys: NDArray[np.int64],
        kinds: NDArray[np.int32],
        prototypes: Sequence[tuple[str, _Prototype]],
        primvars: Mapping[str, PrimvarValue],
    ) -> None:
        self._array = array
        self.given = primvars
        self.prototypes = tuple(prototype for _, prototype in prototypes)
        self.attributes: Mapping[str, Value] = {
            "typeName": "PointInstancer",
            "keys": keys,
            "protoIndices": kinds,
            "array_from_prototype": array.array_from_prototype,
            "prototypes": tuple(path for path, _ in prototypes),
            **primvar_attributes({_authored(name): value for name, value in primvars.items()}),
            **{
                f"{path}.{name}": value
                for _, prototype in prototypes
                for path, state in prototype.states.items()
                for name, value in state.attributes.items()
                if name not in ENTRY_ATTRIBUTES
            },
        }

    def geometry(self) -> "_core.InstanceArray":
        """The core's array."""
        return self._array


class _Entries(NamedTuple):
    """Keys, prototypes and matrices of what can be drawn, by key.

    `kept`: where in the instancer's arrays these stand; None: all of them in their order.
    """

    keys: NDArray[np.int64]
    kinds: NDArray[np.int32]
    rows: NDArray[np.float64]
    kept: NDArray[np.intp] | None


class PrototypeSource:
    """Reads one prototype: what is drawn at or under a prim, in the space of the prim's parent."""

    def __init__(self, path: str, parts: Sequence["ObjectSource | InstancerSource"]) -> None:
        self.path = path
        self._parts = parts
        self._prototype: _Prototype | None = None

    @property
    def varies(self) -> bool:
        """Whether it can differ between frames."""
        return any(part.varies for part in self._parts)

    @property
    def primvars(self) -> frozenset[str]:
        """Names of the primvars that the materials of its parts read."""
        return frozenset().union(*(part.primvars for part in self._parts))

    def read(self, time: Usd.TimeCode) -> _Prototype:
        """The prototype at `time`: the same one while nothing changes."""
        from irt_usd import _core

        if self._prototype is not None and not self.varies:
            return self._prototype
        states = {
            part.node.path: state
            for part in self._parts
            if part.node.visible and (state := part.read(time)) is not None
        }
        known = self._prototype
        if known is None or list(known.states.values()) != list(states.values()):
            parts = [state.part(path) for path, state in states.items()]
            self._prototype = known = _Prototype(states, _core.Prototype(parts))
        return known


class InstancerSource:
    """Reads one instancer."""

    def __init__(
        self,
        node: Node,
        prototypes: Sequence[PrototypeSource],
        report: Report,
        colors: StageColors,
        role: tuple[bool, bool] = (True, False),
    ) -> None:
        """`role`: as ObjectState has it."""
        self.node = node
        self._role = role
        self._prototypes = prototypes
        self._report = report
        self._instancer = UsdGeom.PointInstancer(node.prim)
        prim = node.prim
        self._animated = any(prim.GetAttribute(n).ValueMightBeTimeVarying() for n in _ARRAYS)
        self._shape: InstancesShape | None = None
        self._state: ObjectState | None = None
        self._checked = b""
        """The world transform under which the entries were found to have inverses."""
        self.primvars = frozenset().union(*(prototype.primvars for prototype in prototypes))
        """Names of the primvars that the materials of its prototypes read."""
        self._primvars = Primvars(prim, {_authored(name) for name in self.primvars}, report)
        color = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
        self._from_color = colors.to_rendering(color.GetAttr()) if color else None

    @property
    def varies(self) -> bool:
        """Whether entries, prototypes, place or visibility can differ between frames."""
        return (
            self._animated
            or self._primvars.vary
            or self.node.moves
            or self.node.visibility_varies
            or any(prototype.varies for prototype in self._prototypes)
        )

    def read(self, time: Usd.TimeCode) -> ObjectState | None:
        """The instances at `time` as one object: the same one while nothing changes.

        None, and reported, if nothing of it can be drawn.
        """
        world = matrix_array(self.node.world)
        fault = transform_fault(self.node.world)
        if fault:
            self._report.skipped(*transform_blame(self.node, fault, time))
            self._shape = self._state = None
            return None
        prototypes = [(p.path, p.read(time)) for p in self._prototypes]
        shape = self._shape
        repainted = self._primvars.update(time)
        if (
            shape is None
            or repainted
            or self._animated
            or world.tobytes() != self._checked
            or any(a is not b for a, (_, b) in zip(shape.prototypes, prototypes, strict=True))
        ):
            shape = self._build(world, prototypes, time)
            self._checked = world.tobytes()
        if shape is None:
            self._state = None
        elif (
            self._state is None
            or self._state.shape is not shape
            or not same_bits(self._state.world_from_object, world)
        ):
            self._state = ObjectState(self.node.path, shape, world, "", False, self._role)
        self._shape = shape
        return self._state

    def _build(
        self,
        world: NDArray[np.float64],
        prototypes: Sequence[tuple[str, _Prototype]],
        time: Usd.TimeCode,
    ) -> InstancesShape | None:
        from irt_usd import _core

        entries = self._entries(world, time)
        if entries is None:
            return None
        keys, kinds, rows, kept = entries
        primvars = self._read_primvars(kept, time)
        old = self._shape
        if (
            old is not None
            and all(a is b for a, (_, b) in zip(old.prototypes, prototypes, strict=True))
            and same_bits(old.attributes["keys"], keys)
            and same_bits(old.attributes["protoIndices"], kinds)
            and same_bits(old.attributes["array_from_prototype"], rows)
            and same_primvars(old.given, primvars)
        ):
            return old
        records = [prototype.record for _, prototype in prototypes]
        counted = len(keys) == 0 or (keys[0] == 0 and keys[-1] == len(keys) - 1)
        given = {name: primvar.core for name, primvar in primvars.items()}
        array = _core.InstanceArray(records, rows, kinds, None if counted else keys, given)
        return InstancesShape(array, keys, kinds, prototypes, primvars)

    def _read_primvars(
        self, kept: NDArray[np.intp] | None, time: Usd.TimeCode
    ) -> dict[str, PrimvarValue]:
        """Primvars by UsdGeomPointInstancer's rule, by the names that parts read.

        Varying, vertex and faceVarying ones are by instance, others the same for all. `kept`: which
        are drawn, in their order; None: all.
        """
        total = len(_get(self.node.prim, "positions", time, np.float32))

        def fault(value: PrimvarValue) -> str | None:
            wanted = 1 if value.interpolation in _SAME_FOR_ALL else total
            if value.elements() == wanted:
                return None
            return f"it has {value.elements()} elements, expected {wanted}"

        found = {}
        read = self._primvars.checked(fault, time)
        for name in sorted(self.primvars):
            value = read.get(_authored(name))
            if value is None:
                continue
            if name == INSTANCE_COLOR:
                value = _converted(value, self._from_color)
            if value.interpolation in _SAME_FOR_ALL:
                found[name] = value.single
            else:
                found[name] = PrimvarValue("vertex", value.values, value.indices).picked(kept)
        return found

    def _entries(self, world: NDArray[np.float64], time: Usd.TimeCode) -> _Entries | None:
        prim = self.node.prim
        kinds = np.asarray(_get(prim, "protoIndices", time, np.int32), np.int32)
        positions = _get(prim, "positions", time, np.float32)
        total = len(positions)
        if total == 0 or len(kinds) == 0:
            self._report.mentioned("empty point instancer", str(prim.GetPath()))
            return None
        for name in ("protoIndices", "orientations", "orientationsf", "scales"):
            length = len(_get(prim, name, time, np.float32))
            if length not in (total, 0):
                message = f"there are {length} {name}; expected {total}, one for each position"
                self._report.skipped(message, where(prim, name, time))
                return None
        transforms = self._instancer.ComputeInstanceTransformsAtTime(
            time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
        )
        matrices = np.asarray(transforms)
        if len(matrices) != total:
            message = "its instances' transforms cannot be computed from its arrays"
            self._report.skipped(message, where(prim, "positions", time))
            return None
        rows = np.ascontiguousarray(matrices[:, :, :3])
        del transforms, matrices
        drawn = self._drawn(kinds, rows, world, time)
        keys = self._keys(total, time)
        order = None if (keys[1:] > keys[:-1]).all() else np.argsort(keys, kind="stable")
        if order is None and drawn.all():
            return _Entries(keys, kinds, rows, None)
        kept = np.flatnonzero(drawn) if order is None else order[drawn[order]]
        return _Entries(keys[kept], kinds[kept], np.ascontiguousarray(rows[kept]), kept)

    def _keys(self, total: int, time: Usd.TimeCode) -> NDArray[np.int64]:
        prim = self.node.prim
        ids = np.asarray(_get(prim, "ids", time, np.int64), np.int64)
        if len(ids) == 0:
            return np.arange(total, dtype=np.int64)
        fault = ""
        if len(ids) != total:
            fault = f"there are {len(ids)} ids; expected {total}, one for each position"
        elif len(np.unique(ids)) != total:
            fault = "some ids name two instances; expected each once"
        elif np.abs(ids).max() > 2**62:
            fault = "some ids are beyond 2^62"
        if fault:
            self._report.skipped(f"{fault}; indices name them instead", where(prim, "ids", time))
            return np.arange(total, dtype=np.int64)
        return ids

    def _drawn(
        self,
        kinds: NDArray[np.int32],
        rows: NDArray[np.float64],
        world: NDArray[np.float64],
        time: Usd.TimeCode,
    ) -> NDArray[np.bool_]:
        """Which entries are shown and can be drawn; the others that should be are reported."""
        prim, total = self.node.prim, len(kinds)
        mask = self._instancer.ComputeMaskAtTime(time)
        shown = np.array(mask, np.bool_) if len(mask) == total else np.ones(total, np.bool_)
        count = len(self._prototypes)
        named = (kinds >= 0) & (kinds < count)
        regular = regular_transforms(rows, world)
        for good, name, message in (
            (named, "protoIndices", f"no prototype of that index; expected 0 to {count - 1}"),
            (regular, "scales", "a transform that is singular or not finite"),
        ):
            bad = int((shown & ~good).sum())
            if bad:
                text = f"{bad} of {total} instances are left out: {message}"
                self._report.skipped(text, where(prim, name, time))
            shown &= good
        return shown


def _authored(name: str) -> str:
    """The primvar that a part's material reads by `name`."""
    return "displayColor" if name == INSTANCE_COLOR else name


def _converted(color: PrimvarValue, conversion: Conversion | None) -> PrimvarValue:
    if conversion is None or color.values.shape[1] != 3:
        return color
    values = np.array([conversion.color(row) for row in color.values], np.float32)
    return PrimvarValue(color.interpolation, values.reshape(-1, 3), color.indices)


def _get(prim: Usd.Prim, name: str, time: Usd.TimeCode, dtype: Any) -> NDArray[Any]:
    value = prim.GetAttribute(name).Get(time)
    return np.empty(0, dtype) if value is None else np.asarray(value)


@dataclass(frozen=True, slots=True)
class EntryChange:
    """What became of one entry, or (key None) of many."""

    key: int | None
    attribute: str
    old: Value
    new: Value


def entry_changes(old: InstancesShape, new: InstancesShape, most: int) -> list[EntryChange]:
    """How the entries of two shapes differ, by key; more than `most` are told as one."""
    names = ENTRY_ATTRIBUTES
    arrays: list[dict[str, Any]] = [{n: s.attributes[n] for n in names} for s in (old, new)]
    (before, after) = arrays
    if same_bits(before["keys"], after["keys"]):
        i = j = np.arange(len(before["keys"]))
        gone = come = np.empty(0, np.int64)
    else:
        _, i, j = np.intersect1d(
            before["keys"], after["keys"], assume_unique=True, return_indices=True
        )
        gone = np.setdiff1d(before["keys"], after["keys"], assume_unique=True)
        come = np.setdiff1d(after["keys"], before["keys"], assume_unique=True)
    bits = [a["array_from_prototype"].view(np.uint64) for a in arrays]
    moved = np.flatnonzero((bits[0][i] != bits[1][j]).any(axis=(1, 2)))
    turned = np.flatnonzero(before["protoIndices"][i] != after["protoIndices"][j])
    total = len(moved) + len(turned) + len(gone) + len(come)
    if total > most:
        parts = ((moved, "moved"), (turned, "prototype"), (come, "added"), (gone, "removed"))
        text = ", ".join(f"{len(which)} {verb}" for which, verb in parts if len(which))
        return [EntryChange(None, "instances", None, text)]
    changes = [EntryChange(int(key), "(removed)", None, None) for key in gone]
    changes += [EntryChange(int(key), "(added)", None, None) for key in come]
    for name, which in (("array_from_prototype", moved), ("protoIndices", turned)):
        changes += [
            EntryChange(
                int(after["keys"][j[k]]),
                name,
                _plain(before[name][i[k]]),
                _plain(after[name][j[k]]),
            )
            for k in which
        ]
    return sorted(changes, key=lambda change: (change.key or 0, change.attribute))


def _plain(value: Any) -> Value:
    return value if getattr(value, "ndim", 0) else int(value)
