# SPDX-License-Identifier: Apache-2.0
"""UsdGeomMesh's subdivision attributes, and the core's Subdivider made of them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irt_usd.stage.topology import TopologyError, integers
from irt_usd.stage.values import Value, same_bits

if TYPE_CHECKING:
    from irt_usd import _core

SCHEMES = ("catmullClark", "loop", "bilinear")

_INTEGERS = ("creaseIndices", "creaseLengths", "cornerIndices")
_FLOATS = ("creaseSharpnesses", "cornerSharpnesses")
_TOKENS = ("interpolateBoundary", "faceVaryingLinearInterpolation", "triangleSubdivisionRule")
NAMES = ("subdivisionScheme", *_TOKENS, *_INTEGERS, *_FLOATS)
"""Of the attributes; holeIndices belong to every mesh."""


class Subdivision:
    """Cuts one mesh's faces `level` times. What topology alone decides is done once."""

    def __init__(self, level: int, name_elements: bool = False) -> None:
        self._level = level
        self._rules: dict[str, Value] = {}
        self._name_elements = name_elements
        self._subdivider: _core.Subdivider | None = None

    def refine(
        self, cage: "_core.Mesh", values: Mapping[str, Value]
    ) -> tuple["_core.Mesh", Sequence[str], str | None]:
        """The refined cage, and what of its creases and corners was left out, and None.

        Or the control cage, nothing, and why.
        `values` are the mesh's attributes, "holeIndices" among them, which name its faces.
        """
        from irt_usd import _core

        rules = {name: values[name] for name in (*NAMES, "holeIndices")}
        try:
            if self._subdivider is None or not all(
                same_bits(value, self._rules[name]) for name, value in rules.items()
            ):
                self._subdivider = _subdivider(rules, self._level, self._name_elements)
                self._rules = rules
            refined = self._subdivider.refine(cage)
            return refined, self._subdivider.left_out, None
        except (ValueError, TopologyError) as fault:
            self._subdivider = None
            plain = _core.Subdivider(
                scheme=str(values["subdivisionScheme"]),
                level=0,
                hole_indices=_integers("holeIndices", rules),
                name_elements=self._name_elements,
            )
            return plain.refine(cage), (), str(fault)

    def forget(self) -> None:
        """Frees the refined topology."""
        self._subdivider = None


def _subdivider(rules: Mapping[str, Value], level: int, name_elements: bool) -> "_core.Subdivider":
    from irt_usd import _core

    return _core.Subdivider(
        scheme=str(rules["subdivisionScheme"]),
        level=level,
        interpolate_boundary=str(rules["interpolateBoundary"]),
        face_varying_linear_interpolation=str(rules["faceVaryingLinearInterpolation"]),
        triangle_subdivision_rule=str(rules["triangleSubdivisionRule"]),
        crease_indices=_integers("creaseIndices", rules),
        crease_lengths=_integers("creaseLengths", rules),
        crease_sharpnesses=_floats("creaseSharpnesses", rules),
        corner_indices=_integers("cornerIndices", rules),
        corner_sharpnesses=_floats("cornerSharpnesses", rules),
        hole_indices=_integers("holeIndices", rules),
        name_elements=name_elements,
    )


def _integers(name: str, rules: Mapping[str, Value]) -> Any:
    value = rules[name]
    return np.zeros(0, np.int32) if value is None else integers(name, value)


def _floats(name: str, rules: Mapping[str, Value]) -> Any:
    value = np.asarray([] if rules[name] is None else rules[name])
    if value.ndim != 1 or value.dtype.kind not in "fiu" or not np.isfinite(value).all():
        raise ValueError(f"the {name} are no array of finite numbers")
    return value.astype(np.float32)
