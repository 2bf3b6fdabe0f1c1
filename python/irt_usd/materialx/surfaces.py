# SPDX-License-Identifier: Apache-2.0
"""MaterialX's surface models in terms of UsdPreviewSurface's inputs, which are what is rendered.

Every model goes by the specular workflow: at normal incidence a dielectric reflects
((ior - 1)/(ior + 1))^2 of its colour, a metal its base colour, and at grazing incidence all.
docs/materialx.md has the same as a table.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from irt_usd.materialx.document import definition_of
from irt_usd.materialx.expressions import Expressions, Value, constant

Inputs = Callable[[str], Value]
Mapped = dict[str, Value]
"""By UsdPreviewSurface's names, but without "useSpecularWorkflow"; opacityMode 1 is presence."""

_ZERO, _ONE = constant(0.0), constant(1.0)
_FLAT = constant(0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Unexpressed:
    """An input that is left out unless it has one of its neutral values.

    `weight`: the input without which it does nothing. `rendered`: what is in its place.
    """

    neutral: tuple[float, ...]
    weight: str = ""
    rendered: str = "ignored"


@dataclass(frozen=True)
class Model:
    """A surface model: how it is mapped, which input is the normal, and what is left out."""

    mapping: Callable[[Expressions, Inputs], Mapped]
    normal: str
    unexpressed: Mapping[str, Unexpressed]


def _weighted(ex: Expressions, *values: Value) -> Value:
    product = values[0]
    for value in values[1:]:
        product = ex.apply("multiply", product, value)
    return product


def _one_minus(ex: Expressions, value: Value) -> Value:
    return ex.apply("subtract", _ONE, value)


def _normal_reflectance(ex: Expressions, ior: Value) -> Value:
    ratio = ex.apply("divide", ex.apply("subtract", ior, _ONE), ex.apply("add", ior, _ONE))
    return ex.apply("multiply", ratio, ratio)


@dataclass(frozen=True)
class _Base:
    """What the models have in common. Colours of metal and dielectric, shares from 0 to 1."""

    diffuse: Value
    metal: Value
    dielectric: Value
    """Reflectance at normal incidence."""
    metalness: Value
    roughness: Value
    ior: Value
    transmission: Value
    transmission_color: Value
    presence: Value
    coat: Value
    coat_color: Value
    coat_roughness: Value
    coat_ior: Value
    emission: Value
    thin: Value


def _mapped(ex: Expressions, base: _Base) -> Mapped:
    tint = ex.apply("mix", _ONE, base.coat_color, base.coat)
    clear = _weighted(ex, base.transmission, _one_minus(ex, base.metalness))
    diffuse = _weighted(ex, base.diffuse, _one_minus(ex, base.metalness), tint)
    specular = ex.apply("mix", base.dielectric, base.metal, base.metalness)
    bent = ex.apply("if_greater", base.thin, constant(0.5), _ONE, base.ior)
    if clear == _ZERO:
        return {
            "diffuseColor": diffuse,
            "emissiveColor": base.emission,
            "specularColor": _weighted(ex, specular, tint),
            "roughness": base.roughness,
            "clearcoat": base.coat,
            "clearcoatRoughness": base.coat_roughness,
            "opacity": base.presence,
            "opacityMode": _ZERO if base.presence == _ONE else _ONE,
            "ior": base.coat_ior,
        }
    # What is not there does not bend light; of what is there, it is the coat's.
    whole = ex.apply("if_greater", _ONE, base.presence, _ONE, base.coat_ior)
    opacity = _weighted(ex, base.presence, _one_minus(ex, clear))
    # Of what passes, the share that is transmitted; the rest goes by.
    through = _one_minus(ex, opacity)
    tinted = (
        _ONE
        if base.presence == _ONE
        else ex.apply("divide", _weighted(ex, base.presence, clear), through)
    )
    return {
        # Where light passes, this is what tints shadows.
        "diffuseColor": ex.apply("mix", diffuse, base.transmission_color, clear),
        "emissiveColor": base.emission,
        "specularColor": _weighted(ex, specular, tint),
        "roughness": base.roughness,
        "clearcoat": base.coat,
        "clearcoatRoughness": base.coat_roughness,
        "opacity": opacity,
        "transmissionColor": ex.apply("mix", _ONE, base.transmission_color, tinted),
        "ior": ex.apply("if_greater", clear, _ZERO, bent, whole),
    }


def _standard_surface(ex: Expressions, get: Inputs) -> Mapped:
    coat = get("coat")
    gamma = ex.apply("add", _weighted(ex, coat, get("coat_affect_color")), _ONE)
    rougher = _weighted(ex, coat, get("coat_affect_roughness"), get("coat_roughness"))
    base_color = ex.apply("power", ex.apply("max", get("base_color"), _ZERO), gamma)
    below = ex.apply("power", ex.apply("max", get("subsurface_color"), _ZERO), gamma)
    if gamma.is_constant(1.0):
        base_color, below = get("base_color"), get("subsurface_color")
    base = _weighted(ex, base_color, get("base"))
    specular = _weighted(ex, get("specular_color"), get("specular"))
    opacity = get("opacity")
    return _mapped(
        ex,
        _Base(
            diffuse=ex.apply("mix", base, below, get("subsurface")),
            metal=_weighted(ex, get("base_color"), get("base")),
            dielectric=_weighted(ex, specular, _normal_reflectance(ex, get("specular_IOR"))),
            metalness=get("metalness"),
            roughness=ex.apply("mix", get("specular_roughness"), _ONE, rougher),
            ior=get("specular_IOR"),
            transmission=get("transmission"),
            transmission_color=get("transmission_color"),
            presence=ex.channel(opacity, 0),
            coat=coat,
            coat_color=get("coat_color"),
            coat_roughness=get("coat_roughness"),
            coat_ior=get("coat_IOR"),
            emission=_weighted(ex, get("emission_color"), get("emission")),
            thin=get("thin_walled"),
        ),
    )


def _open_pbr(ex: Expressions, get: Inputs) -> Mapped:
    base = _weighted(ex, get("base_color"), get("base_weight"))
    specular = _weighted(ex, get("specular_color"), get("specular_weight"))
    metal = _weighted(ex, base, get("specular_weight"))
    return _mapped(
        ex,
        _Base(
            diffuse=ex.apply("mix", base, get("subsurface_color"), get("subsurface_weight")),
            metal=metal,
            dielectric=_weighted(ex, specular, _normal_reflectance(ex, get("specular_ior"))),
            metalness=get("base_metalness"),
            roughness=get("specular_roughness"),
            ior=get("specular_ior"),
            transmission=get("transmission_weight"),
            transmission_color=get("transmission_color"),
            presence=get("geometry_opacity"),
            coat=get("coat_weight"),
            coat_color=get("coat_color"),
            coat_roughness=get("coat_roughness"),
            coat_ior=get("coat_ior"),
            emission=_weighted(ex, get("emission_color"), get("emission_luminance")),
            thin=get("geometry_thin_walled"),
        ),
    )


def _gltf_pbr(ex: Expressions, get: Inputs) -> Mapped:
    tinted = _weighted(ex, get("specular_color"), _normal_reflectance(ex, get("ior")))
    mode = get("alpha_mode")
    blended = ex.apply("if_equal", mode, constant(2.0), get("alpha"), _ONE)
    masked = ex.apply("if_greater", get("alpha_cutoff"), get("alpha"), _ZERO, _ONE)
    mapped = _mapped(
        ex,
        _Base(
            diffuse=get("base_color"),
            metal=get("base_color"),
            dielectric=_weighted(ex, ex.apply("min", tinted, _ONE), get("specular")),
            metalness=get("metallic"),
            roughness=get("roughness"),
            ior=get("ior"),
            transmission=get("transmission"),
            transmission_color=get("base_color"),
            presence=blended,
            coat=get("clearcoat"),
            coat_color=_ONE,
            coat_roughness=get("clearcoat_roughness"),
            coat_ior=constant(1.5),
            emission=_weighted(ex, get("emissive"), get("emissive_strength")),
            thin=ex.apply("if_greater", get("thickness"), _ZERO, _ZERO, _ONE),
        ),
    )
    if mode.is_constant(1.0):
        mapped["opacity"], mapped["opacityThreshold"] = masked, constant(0.5)
    return mapped


def _preview_surface(_ex: Expressions, get: Inputs) -> Mapped:
    """By the metallic workflow where the shader says so: the same inputs, name by name."""
    names = ("diffuseColor", "emissiveColor", "specularColor", "metallic", "roughness")
    more = ("clearcoat", "clearcoatRoughness", "opacity", "opacityThreshold", "opacityMode", "ior")
    return {name: get(name) for name in (*names, *more)}


def _unlit(ex: Expressions, get: Inputs) -> Mapped:
    clear = get("transmission")
    presence = _ONE if clear == _ZERO and get("opacity") != _ONE else _ZERO
    return {
        "diffuseColor": _weighted(ex, get("transmission_color"), clear),
        "emissiveColor": _weighted(ex, get("emission_color"), get("emission")),
        "specularColor": _ZERO,
        "roughness": _ONE,
        "opacity": _weighted(ex, get("opacity"), _one_minus(ex, clear)),
        "opacityMode": presence,
        "ior": _ONE,
    }


_DIFFUSE = "the diffuse of its colour rendered"

_OF_STANDARD = {
    "diffuse_roughness": Unexpressed((0.0,), "", "Lambert rendered"),
    "specular_anisotropy": Unexpressed((0.0,)),
    "transmission_depth": Unexpressed((0.0,), "transmission", "tinted at the surface"),
    "transmission_scatter": Unexpressed((0.0,), "transmission"),
    "transmission_dispersion": Unexpressed((0.0,), "transmission"),
    "transmission_extra_roughness": Unexpressed((0.0,), "transmission"),
    "subsurface": Unexpressed((0.0,), "", _DIFFUSE),
    "sheen": Unexpressed((0.0,)),
    "coat_anisotropy": Unexpressed((0.0,), "coat"),
    "coat_normal": Unexpressed((0.0, 0.0, 1.0), "coat", "the surface's normal rendered"),
    "thin_film_thickness": Unexpressed((0.0,)),
    "opacity": Unexpressed((), "", "its red rendered in all channels"),
}

_OF_OPEN_PBR = {
    "base_diffuse_roughness": Unexpressed((0.0,), "", "Lambert rendered"),
    "specular_roughness_anisotropy": Unexpressed((0.0,)),
    "transmission_depth": Unexpressed((0.0,), "transmission_weight", "tinted at the surface"),
    "transmission_scatter": Unexpressed((0.0,), "transmission_weight"),
    "transmission_dispersion_scale": Unexpressed((0.0,), "transmission_weight"),
    "subsurface_weight": Unexpressed((0.0,), "", _DIFFUSE),
    "fuzz_weight": Unexpressed((0.0,)),
    "coat_roughness_anisotropy": Unexpressed((0.0,), "coat_weight"),
    "coat_darkening": Unexpressed((0.0,), "coat_weight"),
    "geometry_coat_normal": Unexpressed(
        (0.0, 0.0, 1.0), "coat_weight", "the surface's normal rendered"
    ),
    "thin_film_weight": Unexpressed((0.0,)),
}

_OF_GLTF = {
    "attenuation_color": Unexpressed((1.0,), "thickness"),
    "iridescence": Unexpressed((0.0,)),
    "sheen_color": Unexpressed((0.0,)),
    "clearcoat_normal": Unexpressed((0.0, 0.0, 1.0), "clearcoat", "the surface's normal rendered"),
    "anisotropy_strength": Unexpressed((0.0,)),
    "dispersion": Unexpressed((0.0,), "transmission"),
}

MODELS: dict[str, Model] = {
    "standard_surface": Model(_standard_surface, "normal", _OF_STANDARD),
    "open_pbr_surface": Model(_open_pbr, "geometry_normal", _OF_OPEN_PBR),
    "gltf_pbr": Model(_gltf_pbr, "normal", _OF_GLTF),
    "UsdPreviewSurface": Model(_preview_surface, "normal", {"displacement": Unexpressed((0.0,))}),
    "surface_unlit": Model(_unlit, "", {}),
}
"""By MaterialX's node names."""


def is_surface(identifier: str) -> bool:
    """Whether a shader of this identifier is of one of the models."""
    definition = definition_of(identifier)
    return definition is not None and definition.getNodeString() in MODELS
