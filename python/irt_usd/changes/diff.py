# SPDX-License-Identifier: Apache-2.0
"""Two snapshots to a change list. Only states that are not the same objects are looked into."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from operator import is_not
from typing import TYPE_CHECKING, Generic, TypeVar

from irt_usd.changes.invalidation import Invalidates, invalidates
from irt_usd.stage.camera import same_camera
from irt_usd.stage.instances import ENTRY_ATTRIBUTES, EntryChange, InstancesShape, entry_changes
from irt_usd.stage.snapshot import (
    CameraState,
    LightState,
    MaterialState,
    ObjectState,
    Snapshot,
    State,
)
from irt_usd.stage.values import Value, same_bits

if TYPE_CHECKING:
    from irt_usd import _core
    from irt_usd.stage.graph import TextureReference, TextureSource

_S = TypeVar("_S", ObjectState, MaterialState, LightState)


@dataclass(frozen=True, slots=True)
class Change:
    """One attribute's values before and after (None: not there), and what that makes stale.

    Prims that come or go have one change: of "visibility" where that is why, else of "(added)" or
    "(removed)".
    """

    path: str
    attribute: str
    old: Value
    new: Value
    invalidates: Invalidates


_MOST_ENTRIES = 16
"""Of an instancer so many entries are told one by one; more are counted."""

_Difference = tuple[str, Value, Value]
"""Attribute, value before, value after."""


@dataclass(frozen=True, slots=True)
class _Pair(Generic[_S]):
    """A state before and after (None: not there), and where the two differ."""

    old: _S | None
    new: _S | None
    differences: list[_Difference]


def whole_changes(old: Snapshot, new: Snapshot) -> "_core.ChangeSet":
    """All of `new`, and removals of what `old` alone has, for the core to compare by value.

    Of two readings of different stages: what one text names may lie in different files.
    """
    found = ChangeList(None, new)
    changes = found.core
    kinds: tuple[tuple[Mapping[str, State], Mapping[str, State], Callable[[str], None]], ...] = (
        (old.materials, new.materials, changes.remove_material),
        (old.objects, new.objects, changes.remove_object),
        (old.lights, new.lights, changes.remove_light),
    )
    for before, after, remove in kinds:
        left = {name for state in after.values() for name in _names(state)}
        for state in before.values():
            for name in _names(state):
                if name not in left:
                    remove(name)
    return changes


def _names(state: State) -> list[str]:
    """Of the core's records."""
    return state.names() if isinstance(state, LightState) else [state.path]


class ChangeList:
    """What leads from one snapshot (None: from nothing) to another, in order of kind and path."""

    def __init__(self, old: Snapshot | None, new: Snapshot) -> None:
        self._new = new
        self.initial = old is None
        """Whether there was no snapshot before: everything is new."""
        self._objects = _differing(old.objects if old else {}, new.objects)
        self._materials = _differing(old.materials if old else {}, new.materials)
        self._lights = _differing(old.lights if old else {}, new.lights)
        pairs_of_cameras = list(zip(old.cameras, new.cameras, strict=True)) if old else []
        self.cameras = [not same_camera(a, b) for a, b in pairs_of_cameras] or [False] * len(
            new.cameras
        )
        """By view: whether its camera maps the world to the image otherwise than before."""
        self.exposures = [a.exposure != b.exposure for a, b in pairs_of_cameras]
        """By view: whether what is written is multiplied otherwise than before."""
        self._by_owner: dict[str, list[Change]] = {}
        for path, (a, b) in {b.path: (a, b) for a, b in pairs_of_cameras}.items():
            self._by_owner[path] = list(_camera_changes(path, a, b))
        hidden_before = old.hidden if old else frozenset()
        for pairs in (self._objects, self._materials, self._lights):
            for path, pair in pairs.items():
                if pair.old is None or pair.new is None:
                    found = [_whole_change(path, pair.old, pair.new, hidden_before, new.hidden)]
                else:
                    found = list(_attribute_changes(path, pair.old, pair.new, pair.differences))
                self._by_owner.setdefault(path, []).extend(found)
        self.changes = [change for owned in self._by_owner.values() for change in owned]
        """By value, bit for bit: time samples that repeat a value are no change."""

    @property
    def camera(self) -> bool:
        """Whether a camera maps the world to the image otherwise than before."""
        return any(self.cameras)

    @cached_property
    def core(self) -> "_core.ChangeSet":
        """The same for the core: whole records of what changed, removals of what went."""
        from irt_usd import _core

        changes = _core.ChangeSet()
        self._load_textures()
        for pairs, remove in (
            (self._materials, changes.remove_material),
            (self._objects, changes.remove_object),
            (self._lights, changes.remove_light),
        ):
            for path, pair in pairs.items():
                if pair.new is None:
                    for name in pair.old.names() if isinstance(pair.old, LightState) else (path,):
                        remove(name)
                else:
                    pair.new.add_to(changes)
        return changes

    @cached_property
    def moved(self) -> "_core.ChangeSet":
        """Of `core` the objects, and the materials that are new: all that geometry needs."""
        from irt_usd import _core

        changes = _core.ChangeSet()
        for path, pair in self._materials.items():
            if pair.old is None and pair.new is not None:
                changes.set_material(path, _core.Material())
        for path, of_object in self._objects.items():
            if of_object.new is None:
                changes.remove_object(path)
            else:
                of_object.new.add_to(changes)
        return changes

    def cause(self, path: str) -> str:
        """The changes of what is called `path`, or of its parts, as prim.attribute."""
        owner = path if path in self._by_owner else path.partition("[")[0].partition("#")[0]
        changes = self._by_owner.get(owner, [])
        found = [c for c in changes if c.path == path] or changes
        return ", ".join(f"{c.path}.{c.attribute}" for c in found) or path

    def _load_textures(self) -> None:
        """Decodes together, rather than one by one, what the changed materials show."""
        wanted: dict[TextureSource, set[TextureReference]] = {}
        for pair in self._materials.values():
            if pair.new is not None and pair.new.textures is not None:
                wanted.setdefault(pair.new.textures, set()).update(pair.new.surface.textures)
        for textures, references in wanted.items():
            textures.load(references)

    def summary(self) -> str:
        """Short text such as "3 moved, 1 material, 1 light energy"."""
        if self.initial:
            return ", ".join(
                _counted(count, noun)
                for count, noun in (
                    (len(self._new.objects), "object"),
                    (len(self._new.materials), "material"),
                    (len(self._new.lights), "light"),
                )
            )
        counts: dict[str, int] = {}
        if self.camera:
            counts["camera"] = 1
        if any(self.exposures):
            counts["exposure"] = 1
        for pair in self._objects.values():
            verb = _object_verb(pair)
            counts[verb] = counts.get(verb, 0) + 1
        parts = ["camera" if name == "camera" else f"{n} {name}" for name, n in counts.items()]
        if self._materials:
            parts.append(_counted(len(self._materials), "material"))
        dimmed = sum(_only_energy(pair.old, pair.new) for pair in self._lights.values())
        if dimmed:
            parts.append(f"{dimmed} light energy")
        if len(self._lights) > dimmed:
            parts.append(_counted(len(self._lights) - dimmed, "light"))
        return ", ".join(parts) or "nothing"


def diff(old: Snapshot | None, new: Snapshot) -> ChangeList:
    """What changed from `old` (None: nothing yet) to `new`."""
    return ChangeList(old, new)


def _differing(old: Mapping[str, _S], new: Mapping[str, _S]) -> dict[str, _Pair[_S]]:
    """The states that differ in some bit, by path."""
    pairs: dict[str, _Pair[_S]] = {}
    if list(old) == list(new):
        # The common case, at the speed of C: mostly the same objects in the same order.
        candidates: Iterable[str] = compress(new, map(is_not, old.values(), new.values()))
    else:
        candidates = (path for path, state in new.items() if old.get(path) is not state)
        pairs = {path: _Pair(state, None, []) for path, state in old.items() if path not in new}
    for path in candidates:
        before, after = old.get(path), new[path]
        differences = _differences(before, after) if before is not None else []
        if before is None or differences:
            pairs[path] = _Pair(before, after, differences)
    return dict(sorted(pairs.items()))


def _differences(old: State, new: State) -> list[_Difference]:
    before, after = old.attributes, new.attributes
    names = before if before.keys() == after.keys() else {**before, **after}
    return [
        (name, before.get(name), after.get(name))
        for name in names
        if not same_bits(before.get(name), after.get(name))
    ]


def _attribute_changes(
    path: str, old: State, new: State, differences: Iterable[_Difference]
) -> Iterator[Change]:
    same_aim = _only_energy(old, new)
    entries = False
    for name, before, after in differences:
        if name in ENTRY_ATTRIBUTES:
            entries = True
            continue
        # What a material's other shaders, or prototypes' parts, say is named by whole paths.
        prim, attribute = name.rsplit(".", 1) if name.startswith("/") else (path, name)
        yield Change(prim, attribute, before, after, invalidates(old, new, name, same_aim))
    if not entries:
        return
    for entry in _entry_changes(old, new, _MOST_ENTRIES):
        named = path if entry.key is None else f"{path}[{entry.key}]"
        stale = invalidates(old, new, entry.attribute)
        yield Change(named, entry.attribute, entry.old, entry.new, stale)


def _entry_changes(old: State | None, new: State | None, most: int) -> list[EntryChange]:
    if isinstance(old, ObjectState) and isinstance(new, ObjectState):
        before, after = old.shape, new.shape
        if isinstance(before, InstancesShape) and isinstance(after, InstancesShape):
            return entry_changes(before, after, most)
    return []


def _camera_changes(path: str, old: CameraState, new: CameraState) -> Iterator[Change]:
    moved = not same_camera(old, new)
    for name, before, after in _differences(old, new):
        exposes = name.startswith("exposure")
        if moved or exposes:
            kind: Invalidates = invalidates(old, new, name)
            yield Change(path, name, before, after, kind)


def _whole_change(
    path: str,
    old: State | None,
    new: State | None,
    hidden_before: frozenset[str],
    hidden_now: frozenset[str],
) -> Change:
    """The one change of what comes or goes."""
    before: Value = None
    after: Value = None
    if path in hidden_now:
        attribute, before, after = "visibility", "inherited", "invisible"
    elif path in hidden_before:
        attribute, before, after = "visibility", "invisible", "inherited"
    else:
        attribute = "(added)" if old is None else "(removed)"
    return Change(path, attribute, before, after, invalidates(old, new, attribute))


def _only_energy(old: State | None, new: State | None) -> bool:
    """Whether a light's record differs in nothing but its energy, which it had and has."""
    if not isinstance(old, LightState) or not isinstance(new, LightState):
        return False
    return (
        old.kind == new.kind
        and same_bits(old.aim, new.aim)
        and old.casts_shadows == new.casts_shadows
        and old.modifiers == new.modifiers
        and old.sky == new.sky
        and any(old.energy)
    )


def _object_verb(pair: _Pair[ObjectState]) -> str:
    if pair.old is None:
        return "appeared"
    if pair.new is None:
        return "gone"
    changed = {name for name, _, _ in pair.differences}
    if changed <= set(ENTRY_ATTRIBUTES):
        return "rearranged"
    if changed - {"world_from_object", "material:binding"}:
        return "deformed"
    return "moved" if "world_from_object" in changed else "rebound"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
