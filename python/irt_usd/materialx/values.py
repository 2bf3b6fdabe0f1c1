# SPDX-License-Identifier: Apache-2.0
"""MaterialX's types and values as USD's, as in UsdMtlx (pxr/usd/usdMtlx/utils.cpp)."""

from typing import Any

import MaterialX as mx  # noqa: N813
from pxr import Gf, Sdf, Usd, UsdShade

_T = Sdf.ValueTypeNames

TYPES: dict[str, Sdf.ValueTypeName] = {
    "boolean": _T.Bool,
    "color2": _T.Float2,
    "color2array": _T.Float2Array,
    "color3": _T.Color3f,
    "color3array": _T.Color3fArray,
    "color4": _T.Color4f,
    "color4array": _T.Color4fArray,
    "filename": _T.Asset,
    "float": _T.Float,
    "floatarray": _T.FloatArray,
    "geomname": _T.String,
    "geomnamearray": _T.StringArray,
    "integer": _T.Int,
    "integerarray": _T.IntArray,
    "matrix33": _T.Matrix3d,
    "matrix44": _T.Matrix4d,
    "string": _T.String,
    "stringarray": _T.StringArray,
    "surfaceshader": _T.Token,
    "vector2": _T.Float2,
    "vector2array": _T.Float2Array,
    "vector3": _T.Float3,
    "vector3array": _T.Float3Array,
    "vector4": _T.Float4,
    "vector4array": _T.Float4Array,
}
"""Of a type that is not here, an attribute is a token, its type the render type."""

_VECTORS: dict[str, Any] = {
    "color2": Gf.Vec2f,
    "color3": Gf.Vec3f,
    "color4": Gf.Vec4f,
    "vector2": Gf.Vec2f,
    "vector3": Gf.Vec3f,
    "vector4": Gf.Vec4f,
}
_MATRICES: dict[str, tuple[type, int]] = {
    "matrix33": (Gf.Matrix3d, 3),
    "matrix44": (Gf.Matrix4d, 4),
}


def usd_value(text: str, kind: str) -> Any:
    """The value that `text` spells in MaterialX's type `kind`; None: none, or no such type.

    Raises ValueError where the text is no such value.
    """
    if kind.endswith("array"):
        return _array(text, kind.removesuffix("array"))
    if kind in ("string", "geomname"):
        return text
    if not text:
        return None
    if kind == "filename":
        return Sdf.AssetPath(text)
    if kind == "boolean":
        if text not in ("true", "false"):
            raise ValueError("expected true or false")
        return text == "true"
    if kind == "integer":
        return int(text)
    if kind == "float":
        return float(text)
    if kind in _VECTORS:
        return _VECTORS[kind](*_numbers(text, _VECTORS[kind].dimension))
    if kind in _MATRICES:
        matrix, side = _MATRICES[kind]
        return matrix(*_numbers(text, side * side))
    return None


def set_value(target: Usd.Attribute, element: mx.ValueElement) -> None:
    """Gives `target` the value of `element`, its value curve, and the colour space it is in.

    Raises ValueError.
    """
    kind = element.getType()
    try:
        value = usd_value(element.getValueString(), kind)
        if value is not None and element.hasValueString():
            target.Set(value)
        for frame, text in _curve(element):
            target.Set(usd_value(text, kind), Usd.TimeCode(frame))
    except ValueError as error:
        path, written = element.getNamePath(), element.getValueString()
        raise ValueError(f'{path}: value "{written}" is no {kind}: {error}') from None
    space = element.getActiveColorSpace()
    if space and _has_colour(element):
        target.SetColorSpace(space)


def make_input(connectable: UsdShade.ConnectableAPI, element: mx.TypedElement) -> UsdShade.Input:
    """The input of `connectable` that has the name and type of `element`."""
    kind = element.getType()
    made = connectable.CreateInput(usd_name(element.getName()), TYPES.get(kind, _T.Token))
    if kind not in TYPES:
        made.SetRenderType(kind)
    return made


def usd_name(name: str) -> str:
    """A MaterialX name as a prim's: its namespace's colon is two underscores."""
    return name.replace(":", "__")


def _has_colour(element: mx.ValueElement) -> bool:
    kind = str(element.getType())
    if kind in ("color3", "color4"):
        return True
    node = element.getParent()
    if kind != "filename" or not isinstance(node, mx.Node):
        return kind == "filename"
    return str(node.getType()) in ("color3", "color4", "multioutput")


def _curve(element: mx.ValueElement) -> list[tuple[int, str]]:
    curve, extent = element.getAttribute("valuecurve"), element.getAttribute("valuerange")
    if not curve or not extent:
        return []
    first, last = (int(text) for text in extent.split(","))
    parts = [text.strip() for text in curve.split(",")]
    width = len(parts) // max(1, last - first + 1)
    if width * (last - first + 1) != len(parts) or width == 0:
        raise ValueError(f"its valuecurve does not have a value for each of the frames {extent}")
    values = [", ".join(parts[i : i + width]) for i in range(0, len(parts), width)]
    return list(zip(range(first, last + 1), values, strict=True))


def _array(text: str, kind: str) -> list[Any] | None:
    scalars: dict[str, type[int | float]] = {"integer": int, "float": float}
    parts = [part.strip() for part in text.split(",")] if text else []
    if kind in ("string", "geomname"):
        return parts
    if kind in scalars:
        return [scalars[kind](part) for part in parts]
    if kind in _VECTORS:
        width = _VECTORS[kind].dimension
        numbers = _numbers(text, len(parts) // width * width)
        return [_VECTORS[kind](*numbers[i : i + width]) for i in range(0, len(numbers), width)]
    return None


def _numbers(text: str, count: int) -> list[float]:
    numbers = [float(part) for part in text.split(",")] if text else []
    if len(numbers) != count:
        raise ValueError(f"expected {count} numbers")
    return numbers
