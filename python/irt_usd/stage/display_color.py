# SPDX-License-Identifier: Apache-2.0
"""The material of what has none: displayColor and displayOpacity, as constants."""

import numpy as np
from pxr import Usd, UsdGeom

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.graph import DEFAULTS, Surface
from irt_usd.stage.snapshot import MaterialState
from irt_usd.stage.values import Value, finite, same_bits

DEFAULT_MATERIAL = "irt:default"
"""Name of UsdPreviewSurface's defaults: no binding, no displayColor. Not a prim path."""


def default_material() -> MaterialState:
    """UsdPreviewSurface with nothing authored: grey, 0.18."""
    return MaterialState(DEFAULT_MATERIAL, DEFAULTS, Surface())


class DisplayColorSource:
    """Reads the display primvars of one prim, its own or inherited, into a material of its own."""

    def __init__(self, prim: Usd.Prim, report: Report) -> None:
        self.path = f"{prim.GetPath()}.primvars:displayColor"
        self._report = report
        primvars = UsdGeom.PrimvarsAPI(prim)
        self._color = primvars.FindPrimvarWithInheritance("displayColor")
        self._opacity = primvars.FindPrimvarWithInheritance("displayOpacity")
        self._state: MaterialState | None = None
        self.varies = any(
            primvar.HasAuthoredValue() and primvar.ValueMightBeTimeVarying()
            for primvar in (self._color, self._opacity)
            if primvar
        )

    def read(self, time: Usd.TimeCode) -> MaterialState:
        """The material at `time`: the same object while no bit of it changes."""
        if self._state is not None and not self.varies:
            return self._state
        values: dict[str, Value] = {}
        values["diffuseColor"] = self._first(self._color, DEFAULTS["diffuseColor"], time)
        values["opacity"] = self._first(self._opacity, DEFAULTS["opacity"], time)
        if self._state is None or not all(
            same_bits(values[name], self._state.attributes[name]) for name in values
        ):
            self._state = MaterialState(self.path, {**DEFAULTS, **values}, Surface(values))
        return self._state

    def _first(self, primvar: UsdGeom.Primvar, default: Value, time: Usd.TimeCode) -> Value:
        authored = primvar.ComputeFlattened(time) if primvar else None
        if authored is None:
            return default
        array = np.asarray(authored)
        shape = (3,) if isinstance(default, tuple) else ()
        prim, name = primvar.GetAttr().GetPrim(), str(primvar.GetAttr().GetName())
        if array.ndim == 0 or array.dtype.kind != "f" or array.shape[1:] != shape:
            self._report.skipped(f"{name} is of the wrong type", where(prim, name, time))
            return default
        if len(array) == 0:
            return default
        if primvar.GetInterpolation() != UsdGeom.Tokens.constant and (array != array[0]).any():
            kind = f"{primvar.GetPrimvarName()} varying over a surface (first value rendered)"
            self._report.unsupported(kind, str(prim.GetPath()))
        value: Value = tuple(array[0].tolist()) if shape else float(array[0])
        opaque = float("inf") if shape else 1.0
        if not finite(value) or np.min(array[0]) < 0 or np.max(array[0]) > opaque:
            message = f"{name} is {value}; expected finite numbers from 0"
            self._report.skipped(f"{message}; its default is rendered", where(prim, name, time))
            return default
        return value
