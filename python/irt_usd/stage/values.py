# SPDX-License-Identifier: Apache-2.0
"""USD values as plain Python and NumPy values, and their comparison by bits."""

from math import copysign, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf

Value = bool | int | float | str | tuple[Any, ...] | NDArray[Any] | None
"""Scalars; short vectors as tuples; arrays and matrices as read-only NumPy arrays."""

_SMALL = 4096
"""Bytes up to which arrays are compared by way of copies, which is the faster way."""


def plain(value: Any) -> Value:
    """`value` without USD's types; arrays share its memory."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if type(value).__module__ == "pxr.Vt":
        return np.asarray(value)
    if isinstance(value, (Gf.Matrix3d, Gf.Matrix4d)):
        return matrix_array(value)
    if isinstance(value, Sdf.AssetPath):
        return str(value.path)
    try:
        return tuple(value)
    except TypeError:
        return str(value)


def matrix_array(matrix: Gf.Matrix3d | Gf.Matrix4d) -> NDArray[np.float64]:
    """A read-only square copy of `matrix`, row-vector convention."""
    array = np.array(matrix, dtype=np.float64)
    array.flags.writeable = False
    return array


def same_bits(a: Value, b: Value) -> bool:
    """Whether two values are alike in type, shape and every bit: 0.0 differs from -0.0."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and _same_array_bits(a, b)
    if type(a) is not type(b):
        return False
    if isinstance(a, float) and isinstance(b, float):
        return a == b and copysign(1.0, a) == copysign(1.0, b)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same_bits, a, b))
    return bool(a == b)


def coerced(value: Value, like: Value) -> Value:
    """`value` as the type that `like` has: integers become floats; None if it is no such thing."""
    if like is None or isinstance(like, np.ndarray):
        return value
    if isinstance(like, tuple):
        if not isinstance(value, tuple) or len(value) != len(like):
            return None
        parts = tuple(map(coerced, value, like))
        return None if None in parts else parts
    if isinstance(like, str) or isinstance(value, str):
        return value if isinstance(value, str) and isinstance(like, str) else None
    if isinstance(like, float):
        return float(value) if isinstance(value, (int, float)) else None
    return type(like)(value) if isinstance(value, int) else None


def finite(value: Value) -> bool:
    """Whether no number in `value` is NaN or infinite."""
    if isinstance(value, float):
        return isfinite(value)
    if isinstance(value, tuple):
        return all(map(finite, value))
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return bool(np.isfinite(value).all())
    return True


def _same_array_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    if a.nbytes <= _SMALL:
        return a.tobytes() == b.tobytes()
    if a.dtype.kind == "f":
        bits = f"u{a.dtype.itemsize}"
        a, b = np.ascontiguousarray(a).view(bits), np.ascontiguousarray(b).view(bits)
    return bool(np.array_equal(a, b))
