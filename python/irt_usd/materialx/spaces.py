# SPDX-License-Identifier: Apache-2.0
"""MaterialX's geometric nodes, rotations and matrices.

"object" and "model" are the space that a shape is authored in, "world" the stage's.
"""

import math
from collections.abc import Callable

from irt_usd.materialx.expressions import Expressions, Value, constant
from irt_usd.materialx.inputs import WIDTHS, Inputs, Made, Matrix
from irt_usd.stage.graph import Node

_WORLD = "world"
_OBJECT = ("object", "model")

GEOMETRY = ("position", "normal", "view")
"""What there is in either space, by the operations' names."""


def geometry(ex: Expressions, kind: str, space: str) -> Value:
    """One of GEOMETRY; normals and the view are of unit length."""
    value = ex.add(Node(kind))
    if space != _WORLD:
        return value
    if kind == "position":
        return ex.apply("point_to_world", value)
    return ex.apply("normalize", ex.apply(f"{_SORTS[kind]}_to_world", value))


_SORTS = {"normal": "normal", "view": "vector"}


def _geometric(kind: str) -> Callable[[Inputs], Value]:
    return lambda node: geometry(node.expressions, kind, str(node.read("space")))


def _transform(sort: str) -> Callable[[Inputs], Value]:
    """From a space to another; between others than object and world, nothing is done."""

    def transform(node: Inputs) -> Value:
        value = node.value("in")
        before, after = str(node.read("fromspace")), str(node.read("tospace"))
        if before in _OBJECT and after == _WORLD:
            return node.expressions.apply(f"{sort}_to_world", value)
        if before == _WORLD and after in _OBJECT:
            return node.expressions.apply(f"{sort}_to_object", value)
        return value

    return transform


def _rotate3d(node: Inputs) -> Value:
    """Rodrigues' formula for vectors that are rows: clockwise seen from the axis' end."""
    ex, value = node.expressions, node.value("in")
    axis = ex.apply("normalize", node.value("axis"))
    angle = ex.apply("multiply", node.value("amount"), constant(math.pi / 180.0))
    sine, cosine = ex.apply("sin", angle), ex.apply("cos", angle)
    along = ex.apply("multiply", axis, ex.apply("dot", axis, value))
    parts = (
        ex.apply("multiply", value, cosine),
        ex.apply("multiply", ex.apply("cross", value, axis), sine),
        ex.apply("multiply", along, ex.apply("subtract", constant(1.0), cosine)),
    )
    return ex.apply("add", ex.apply("add", parts[0], parts[1]), parts[2])


# ---- matrices


def _sum(ex: Expressions, *values: Value) -> Value:
    total = values[0]
    for value in values[1:]:
        total = ex.apply("add", total, value)
    return total


def _create(node: Inputs) -> Matrix:
    ex = node.expressions
    side = 4 if node.type == "matrix44" else 3
    rows = [node.value(f"in{i + 1}") for i in range(side)]
    if WIDTHS[node.input_type("in1")] < side:
        rows = [ex.swizzle(row, "rgb1" if i == side - 1 else "rgb0") for i, row in enumerate(rows)]
    return Matrix(tuple(rows))


def _transposed(ex: Expressions, matrix: Matrix) -> Matrix:
    side = len(matrix.rows)
    columns = [[ex.channel(row, i) for row in matrix.rows] for i in range(side)]
    return Matrix(tuple(ex.combine(*column) for column in columns))


def _entries(ex: Expressions, matrix: Matrix) -> list[list[Value]]:
    return [[ex.channel(row, i) for i in range(len(matrix.rows))] for row in matrix.rows]


def _determinant(ex: Expressions, entries: list[list[Value]]) -> Value:
    """By the first row's minors."""
    if len(entries) == 1:
        return entries[0][0]
    terms = [
        ex.apply("multiply", entries[0][i], _cofactor(ex, entries, 0, i))
        for i in range(len(entries))
    ]
    return _sum(ex, *terms)


def _cofactor(ex: Expressions, entries: list[list[Value]], row: int, column: int) -> Value:
    rest = [
        [value for j, value in enumerate(line) if j != column]
        for i, line in enumerate(entries)
        if i != row
    ]
    value = _determinant(ex, rest)
    return ex.apply("multiply", value, constant(-1.0)) if (row + column) % 2 else value


def _inverse(node: Inputs) -> Matrix:
    ex, entries = node.expressions, _entries(node.expressions, node.matrix("in"))
    side = range(len(entries))
    determinant = _determinant(ex, entries)
    rows = [ex.combine(*(_cofactor(ex, entries, j, i) for j in side)) for i in side]
    return Matrix(tuple(ex.apply("divide", row, determinant) for row in rows))


def _transformmatrix(node: Inputs) -> Value:
    """A vector that the matrix is too large for is a point: its next component is 1."""
    ex, value, matrix = node.expressions, node.value("in"), node.matrix("mat")
    width = WIDTHS[node.input_type("in")]
    terms = [
        ex.apply("multiply", ex.channel(value, i), row) if i < width else row
        for i, row in enumerate(matrix.rows)
    ]
    return _sum(ex, *terms)


SPACES: dict[str, Callable[[Inputs], Made]] = {
    "position": _geometric("position"),
    "normal": _geometric("normal"),
    "viewdirection": _geometric("view"),
    "transformpoint": _transform("point"),
    "transformvector": _transform("vector"),
    "transformnormal": _transform("normal"),
    "rotate3d": _rotate3d,
    "creatematrix": _create,
    "transpose": lambda node: _transposed(node.expressions, node.matrix("in")),
    "determinant": lambda node: _determinant(
        node.expressions, _entries(node.expressions, node.matrix("in"))
    ),
    "invertmatrix": _inverse,
    "transformmatrix": _transformmatrix,
}
