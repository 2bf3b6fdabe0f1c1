# SPDX-License-Identifier: Apache-2.0
"""UsdGeomPointInstancer: prototypes read once, entries as arrays, never one by one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import where
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
    space; and all that the prototypes' parts have, by path.
    """

    def __init__(
        self,
        array: "_core.InstanceArray",
        keys: NDArray[np.int64],
        kinds: NDArray[np.int32],
        prototypes: Sequence[tuple[str, _Prototype]],
    ) -> None:
        self._array = array
        self.prototypes = tuple(prototype for _, prototype in prototypes)
        self.attributes: Mapping[str, Value] = {
            "typeName": "PointInstancer",
            "keys": keys,
            "protoIndices": kinds,
            "array_from_prototype": array.array_from_prototype,
            "prototypes": tuple(path for path, _ in prototypes),
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
        self._report_primvars()

    @property
    def varies(self) -> bool:
        """Whether entries, prototypes, place or visibility can differ between frames."""
        return (
            self._animated
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
        if (
            shape is None
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
        keys, kinds, rows = entries
        old = self._shape
        if (
            old is not None
            and all(a is b for a, (_, b) in zip(old.prototypes, prototypes, strict=True))
            and same_bits(old.attributes["keys"], keys)
            and same_bits(old.attributes["protoIndices"], kinds)
            and same_bits(old.attributes["array_from_prototype"], rows)
        ):
            return old
        records = [prototype.record for _, prototype in prototypes]
        counted = len(keys) == 0 or (keys[0] == 0 and keys[-1] == len(keys) - 1)
        array = _core.InstanceArray(records, rows, kinds, None if counted else keys)
        return InstancesShape(array, keys, kinds, prototypes)

    def _entries(
        self, world: NDArray[np.float64], time: Usd.TimeCode
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]] | None:
        """Keys, prototypes and matrices of what can be drawn, by key."""
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
            return keys, kinds, rows
        kept = np.flatnonzero(drawn) if order is None else order[drawn[order]]
        return keys[kept], kinds[kept], np.ascontiguousarray(rows[kept])

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

    def _report_primvars(self) -> None:
        for primvar in UsdGeom.PrimvarsAPI(self.node.prim).GetAuthoredPrimvars():
            if primvar.GetInterpolation() != UsdGeom.Tokens.constant:
                self._report.unsupported("primvars by instance", str(primvar.GetAttr().GetPath()))


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
