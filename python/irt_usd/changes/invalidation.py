# SPDX-License-Identifier: Apache-2.0
"""What each kind of change makes stale, in one table.

The names say the most that a change can touch, for people to read; the core decides for itself,
from the records.
"""

from typing import Literal

from irt_usd.stage.lights import ENERGY_ATTRIBUTES
from irt_usd.stage.snapshot import CameraState, LightState, MaterialState, ObjectState, State

Invalidates = Literal[
    "visibility and shading",
    "shading",
    "spawned rays",
    "shadow rays",
    "light energy only (no rays)",
    "everything (restart)",
    "what is written (no rays)",
]
"""visibility and shading: rays through the object's old and new surfaces. spawned rays: reflected,
refracted and shadow rays of the points it shows at, and shadows it casts. shadow rays: those to
this light. shading: colours alone. light energy only: sums alone.
what is written: a factor of finished pixels."""

_OBJECT: dict[str, Invalidates] = {
    "normals": "spawned rays",
    "normals:interpolation": "spawned rays",
    "material:binding": "spawned rays",
}

_MATERIAL: dict[str, Invalidates] = {
    "diffuseColor": "shading",
    "emissiveColor": "shading",
}


def invalidates(
    old: State | None, new: State | None, attribute: str, same_aim: bool = False
) -> Invalidates:
    """What the change of `attribute` from `old` to `new` (None: not there) makes stale.

    `same_aim`: a light's record is the same but for its energy.
    """
    state = new or old
    if isinstance(state, CameraState):
        if attribute.startswith("exposure"):
            return "what is written (no rays)"
        return "everything (restart)"
    if isinstance(state, ObjectState):
        if old is None or new is None:
            return "visibility and shading"
        # Those of points and curves come with their shape.
        shaded = state.attributes["typeName"] in ("Mesh", "PointInstancer")
        if shaded and attribute.startswith("primvars:"):
            return "spawned rays"
        return _OBJECT.get(attribute, "visibility and shading")
    if isinstance(state, MaterialState):
        if attribute == "diffuseColor" and not (_only_diffuse(old) and _only_diffuse(new)):
            return "spawned rays"
        return _MATERIAL.get(attribute, "spawned rays")
    return _of_light(old, new, attribute, same_aim)


def _only_diffuse(state: State | None) -> bool:
    """Whether the colour tints no shadow and weighs no mirror ray."""
    if not isinstance(state, MaterialState):
        return True
    opacity, metallic = state.surface.constant("opacity"), state.surface.constant("metallic")
    return opacity is not None and opacity >= 1.0 and metallic == 0.0


def _of_light(old: State | None, new: State | None, attribute: str, same_aim: bool) -> Invalidates:
    if new is None:
        return "light energy only (no rays)"
    if not _shines(old) and _shines(new):
        return "shadow rays"
    turned = _is_dome(old) and _is_dome(new) and attribute == "world_from_object"
    if same_aim or turned or attribute in ENERGY_ATTRIBUTES:
        return "light energy only (no rays)"
    return "shadow rays"


def _is_dome(light: State | None) -> bool:
    return isinstance(light, LightState) and light.kind == "dome"


def _shines(light: State | None) -> bool:
    return isinstance(light, LightState) and any(light.energy)
