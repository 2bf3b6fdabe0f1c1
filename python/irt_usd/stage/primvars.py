# SPDX-License-Identifier: Apache-2.0
"""Primvars of one prim: those that are wanted, its own or inherited, as 32-bit floats."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.values import Value, plain, same_bits

if TYPE_CHECKING:
    from irt_usd import _core

Interpolation = Literal["constant", "uniform", "vertex", "faceVarying"]


@dataclass(frozen=True, eq=False, slots=True)
class PrimvarValue:
    """A primvar's value at one time."""

    interpolation: Interpolation
    """USD's "varying" is "vertex" here."""
    values: NDArray[np.float32]
    """(n, width), width from 1 to 4."""
    indices: NDArray[np.int32] | None
    """The value of each element; None: element i is value i."""
    linear: bool = False
    """Of a vertex primvar: whether subdivision, too, interpolates it linearly (USD's "varying")."""

    @property
    def core(self) -> tuple["_core.Interpolation", NDArray[np.float32], NDArray[np.int32] | None]:
        """As _core.Mesh takes it."""
        return "varying" if self.linear else self.interpolation, self.values, self.indices

    @property
    def single(self) -> "PrimvarValue":
        """Of one element: the same as a constant."""
        values = self.values if self.indices is None else self.values[self.indices]
        return PrimvarValue("constant", values, None)

    def elements(self) -> int:
        """How many elements there are."""
        return len(self.values if self.indices is None else self.indices)

    def selected(self, kept: NDArray[np.bool_]) -> "PrimvarValue":
        """Only the elements that `kept` says."""
        if self.indices is None:
            return PrimvarValue(self.interpolation, self.values[kept], None)
        return PrimvarValue(self.interpolation, self.values, self.indices[kept])

    def picked(self, elements: NDArray[np.intp] | None) -> "PrimvarValue":
        """Those elements, in their order; None: all."""
        if elements is None:
            return self
        if self.indices is None or len(elements) == 0:
            return PrimvarValue(self.interpolation, self.values[elements], None)
        return PrimvarValue(self.interpolation, self.values, self.indices[elements])


Check = Callable[[PrimvarValue], str | None]
"""What is wrong with the size of a primvar, if anything."""


class Primvars:
    """The primvars called `wanted` (without "primvars:") that `prim` has or inherits.

    Inherited ones are constant, by UsdGeom's rule. Of those that cannot be used (of no numeric
    type, NaN, indices out of range, a size that the shape does not take) each is reported, and
    left out.
    """

    def __init__(self, prim: Usd.Prim, wanted: Iterable[str], report: Report) -> None:
        self._report = report
        api = UsdGeom.PrimvarsAPI(prim)
        found = ((name, api.FindPrimvarWithInheritance(name)) for name in sorted(wanted))
        self._found = {
            name: primvar for name, primvar in found if primvar and primvar.HasAuthoredValue()
        }
        self._varying = {n for n, p in self._found.items() if p.ValueMightBeTimeVarying()}
        self._sources: dict[str, tuple[Value, Value]] = {}
        self._values: dict[str, PrimvarValue | None] = {}

    @property
    def vary(self) -> bool:
        """Whether any value can differ between frames."""
        return bool(self._varying)

    def update(self, time: Usd.TimeCode) -> bool:
        """Reads what can vary (at first: all) at `time`; returns whether any bit differs."""
        changed = False
        for name, primvar in self._found.items():
            if name in self._sources and name not in self._varying:
                continue
            indices = primvar.GetIndices(time) if primvar.IsIndexed() else None
            source = plain(primvar.Get(time)), plain(indices)
            known = self._sources.get(name)
            if known is not None and all(map(same_bits, source, known)):
                continue
            try:
                self._values[name] = _read(primvar, *source)
            except ValueError as fault:
                self._values[name] = None
                self._skip(primvar, str(fault), time)
            self._sources[name] = source
            changed = True
        return changed

    def checked(self, check: Check, time: Usd.TimeCode) -> dict[str, PrimvarValue]:
        """The values by name, but for those that `check` finds fault with, which are reported."""
        usable = {}
        for name, value in self._values.items():
            if value is None:
                continue
            fault = check(value)
            if fault is None:
                usable[name] = value
            else:
                self._skip(self._found[name], fault, time)
        return usable

    def _skip(self, primvar: UsdGeom.Primvar, fault: str, time: Usd.TimeCode) -> None:
        attribute = primvar.GetAttr()
        name = str(attribute.GetName())
        message = f"{name} is not used: {fault}"
        self._report.skipped(message, where(attribute.GetPrim(), name, time))


def _read(primvar: UsdGeom.Primvar, value: Value, indices: Value) -> PrimvarValue | None:
    """None where the value is blocked; raises ValueError on what cannot be used."""
    if value is None:
        return None
    array = np.asarray(value)
    kind = primvar.GetAttr().GetTypeName()
    if not kind.isArray:
        array = array[np.newaxis]
    if array.dtype.kind not in "fiub" or array.ndim > 2 or max(array.shape[1:], default=1) > 4:
        raise ValueError(f"its type is {kind}; expected 1 to 4 numbers")
    if primvar.GetElementSize() != 1:
        raise ValueError(f"its elementSize is {primvar.GetElementSize()}; expected 1")
    with np.errstate(over="ignore"):
        narrowed = np.array(array if array.ndim == 2 else array[:, np.newaxis], np.float32)
    if not np.isfinite(narrowed).all():
        message = "it holds a NaN, or a number beyond single precision"
        raise ValueError(f"{message}; expected finite ones")
    authored = str(primvar.GetInterpolation())
    interpolation = cast("Interpolation", "vertex" if authored == "varying" else authored)
    if indices is None:
        return PrimvarValue(interpolation, narrowed, None, authored == "varying")
    into = np.array(indices, np.int32)
    if len(into) and (into.min() < 0 or into.max() >= len(narrowed)):
        worst = into.min() if into.min() < 0 else into.max()
        raise ValueError(f"index {worst} names none of its {len(narrowed)} values")
    return PrimvarValue(interpolation, narrowed, into, authored == "varying")


def constant_only(value: PrimvarValue) -> str | None:
    """For shapes without vertices: one element is all they take, whatever its interpolation."""
    if value.elements() == 1:
        return None
    return (
        f"it has {value.elements()} elements of interpolation {value.interpolation}; "
        "expected one, the shape having no vertices"
    )


def same_primvars(a: Mapping[str, PrimvarValue], b: Mapping[str, PrimvarValue]) -> bool:
    """Whether the two agree in every bit."""
    before, after = primvar_attributes(a), primvar_attributes(b)
    return before.keys() == after.keys() and all(map(same_bits, before.values(), after.values()))


def primvar_attributes(primvars: Mapping[str, PrimvarValue]) -> dict[str, Value]:
    """What a change is looked for in, by USD attribute name."""
    attributes: dict[str, Value] = {}
    for name, primvar in primvars.items():
        attributes[f"primvars:{name}"] = primvar.values
        attributes[f"primvars:{name}:indices"] = primvar.indices
        attributes[f"primvars:{name}:interpolation"] = primvar.interpolation
    return attributes
