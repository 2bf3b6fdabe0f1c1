# SPDX-License-Identifier: Apache-2.0
"""What operations know of a node."""

from dataclasses import dataclass
from typing import Any, Protocol

from irt_usd.materialx.expressions import Expressions, Value

WIDTHS = {"color4": 4, "vector4": 4, "color3": 3, "vector3": 3, "vector2": 2}
"""Components of the types that have several."""


@dataclass(frozen=True)
class Matrix:
    """A matrix by its rows; vectors are rows, too, and stand to its left."""

    rows: tuple[Value, ...]


Made = Value | Matrix | dict[str, Value]
"""What a node comes to: its output, or each of several by name."""


class Inputs(Protocol):
    """A node's inputs at a time."""

    expressions: Expressions
    type: str
    """The MaterialX type of the node's output."""

    def value(self, name: str) -> Value:
        """An input's value as it goes into the graph."""

    def matrix(self, name: str) -> Matrix:
        """An input's value, a matrix."""

    def read(self, name: str) -> Any:
        """An input's value where it must be a constant, else its default."""

    def input_type(self, name: str) -> str:
        """An input's MaterialX type."""

    def image(self) -> Value:
        """The texture that an image node reads."""

    def frame(self) -> float:
        """The frame that is rendered."""
