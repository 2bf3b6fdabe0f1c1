# SPDX-License-Identifier: Apache-2.0
"""Rows of docs/numerics.md: each measures errors, keeps the worst and what caused it, and must stay
within its bound."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass
class Row:
    """One row. `bound` and `worst` are in `unit`; `cause` is the input with the worst error."""

    extreme: str
    unit: str
    bound: float
    worst: float = -1.0
    cause: str = "nothing was measured"

    def see(self, error: float, cause: str) -> None:
        """An error, in the row's unit, and the input that had it. NaN is the worst of all."""
        if not error <= self.worst:
            self.worst, self.cause = float(error), cause

    @property
    def where(self) -> str:
        return self.cause if self.worst > 0 else ""

    @property
    def passed(self) -> bool:
        return 0 <= self.worst <= self.bound


NewRow = Callable[[str, str, float], Row]
