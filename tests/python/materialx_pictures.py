# SPDX-License-Identifier: Apache-2.0
"""The pictures of docs/materialx.md: each row of its tables, irt's on the left, Mitsuba 3's beside.

    make materialx-pictures

A ball before a wall under three point lights. irt's material is a surface of MaterialX, Mitsuba's
is built of the closures of its own that are nearest to what that surface means. Mitsuba has the
light that reaches a point straight from the lamps and, through glass, from the wall: what Whitted's
model has too, so that what differs is the material.
"""

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

import mitsuba_judge as judge
from irt_usd.images.contact_sheet import display_srgb
from irt_usd.images.png import write_png
from mitsuba_judge import Look, Scene, Shape, View
from test_materialx_surfaces import source

VIEW = View((0.42, 0.42), (128, 128), 16, 256)
GAP = 4
LAMPS: list[Any] = [((1.6, 2.0, -0.4), 22.0), ((-2.4, 0.4, -1.0), 9.0), ((0.6, -0.2, -4.4), 5.0)]
STEPS = 48
MIDDLE, RADIUS = (0.0, 0.0, -3.0), 0.9

RED, GOLD, TEAL = (0.7, 0.15, 0.1), (0.9, 0.6, 0.3), (0.1, 0.5, 0.55)
GREY, WHITE, BLACK = (0.5,) * 3, (1.0,) * 3, (0.0,) * 3

Picture = NDArray[np.float32]
Bsdf = dict[str, Any]


def rgb(color: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": list(color)}


def principled(color: Any, **values: Any) -> Bsdf:
    return {"type": "principled", "base_color": rgb(color), **values}


def coat(roughness: float) -> Bsdf:
    """A lobe of a dielectric of index 1.5 alone: a metal of its reflectance."""
    return principled((0.04,) * 3, metallic=1.0, roughness=roughness)


def masked(bsdf: Bsdf, opacity: float) -> Bsdf:
    return {"type": "mask", "opacity": opacity, "bsdf": {"type": "twosided", "bsdf": bsdf}}


def glass(ior: float = 1.5, alpha: float = 0.0, **values: Any) -> Bsdf:
    kind = {"type": "roughdielectric", "alpha": alpha} if alpha else {"type": "dielectric"}
    return {**kind, "int_ior": ior, "ext_ior": 1.0, **values}


def fog(albedo: Any, free_path: Any) -> dict[str, Any]:
    density = np.broadcast_to(1.0 / np.array(free_path), 3)
    return {
        "type": "homogeneous",
        "albedo": rgb(albedo),
        "sigma_t": rgb((density / density.max()).tolist()),
        "scale": float(density.max()),
    }


def inner_albedo(color: Any) -> list[float]:
    """Of one scattering, where that of many is `color` (Kulla and Conty 2017)."""
    return [1 - math.exp(-5.09406 * a + 2.61188 * a**2 - 4.31805 * a**3) for a in color]


def waves(size: int = 256, count: int = 10) -> Picture:
    """The heights of a relief, (h, w, 3) from 0 to 1."""
    x = np.sin(np.linspace(0, 2 * np.pi * count, size, endpoint=False)) * 0.5 + 0.5
    heights = np.multiply.outer(x, x)[..., np.newaxis]
    return np.repeat(heights, 3, axis=2).astype("f4")


def normals(size: int = 256, count: int = 10, depth: float = 0.3) -> Picture:
    """Of such a relief, as a normal map."""
    turn = np.linspace(0, 2 * np.pi * count, size, endpoint=False)
    across, along = np.meshgrid(np.cos(turn) * depth, np.cos(turn) * depth)
    unit = np.stack([-across, -along, np.ones_like(across)], axis=-1)
    unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
    return (0.5 * unit + 0.5).astype("f4")


def bitmap(values: Picture) -> dict[str, Any]:
    import mitsuba as mi

    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(values[::-1])), "raw": True}


def bumped(bsdf: Bsdf) -> Bsdf:
    mapped = {"type": "normalmap", "normalmap": bitmap(normals()), "bsdf": bsdf}
    return {**mapped, "use_shadowing_function": False}


def ball(look: Look, relief: float = 0.0) -> Shape:
    """With s around and t upwards; with `relief`, its points raised by as much at waves."""
    made = judge.ball(MIDDLE, RADIUS, look, STEPS, smooth=not relief)
    unit = (made.points - MIDDLE) / RADIUS
    around = (np.arctan2(unit[:, 2], unit[:, 0]) / (2 * np.pi)) % 1.0
    st = np.stack([around, np.arccos(np.clip(-unit[:, 1], -1, 1)) / np.pi], axis=1)
    # Triangles over the seam have points of their own, with s beyond 1.
    corners = st[made.triangles]
    over = corners[..., 0].max(axis=1) - corners[..., 0].min(axis=1) > 0.5
    corners[..., 0] += (corners[..., 0] < 0.5) & over[:, np.newaxis]
    points = made.points[made.triangles].reshape(-1, 3)
    if relief:
        waved = np.sin(20 * np.pi * corners[..., 0]) * np.sin(20 * np.pi * corners[..., 1])
        points += relief * waved.reshape(-1, 1) * (points - MIDDLE) / RADIUS
    triangles = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    smooth = None if relief else unit[made.triangles].reshape(-1, 3)
    return Shape(points, triangles, look, smooth, corners.reshape(-1, 2))


def scene(look: Look, glowing: bool = False, relief: float = 0.0) -> Scene:
    """The ball before a chequered wall, which glows where the ball is of glass."""
    squares = np.kron([[0.1, 0.6], [0.6, 0.1]], np.ones((8, 8)))
    wall = np.repeat(squares[..., np.newaxis], 3, axis=2).astype("f4")
    paper = Look(WHITE, wall, glows=glowing)
    back = judge.quad((-4, -4, -4.6), (8, 0, 0), (0, 8, 0), paper, 8.0)
    return Scene([back, ball(look, relief)], LAMPS)


@dataclass
class Row:
    """One picture: a surface of MaterialX, and what Mitsuba has of its like."""

    model: str
    inputs: dict[str, Any]
    theirs: Callable[[], Picture]
    glowing: bool = False

    def ours(self) -> Picture:
        _stage, made, report = source(self.model, self.inputs)
        core = made.read(Usd.TimeCode(1)).core()
        for notice in report.notices:
            print(f"    {notice.text}")
        return judge.render_irt(scene(Look(given=(core, {})), self.glowing), VIEW)


def lit(bsdf: Bsdf | Callable[[], Bsdf], relief: float = 0.0) -> Picture:
    """By the lamps alone."""
    made = bsdf() if callable(bsdf) else bsdf
    return judge.render_mitsuba(scene(Look(given=(None, made)), relief=relief), VIEW)


def through(bsdf: Bsdf, medium: dict[str, Any] | None = None, glowing: bool = True) -> Picture:
    """With what comes through the ball; in a medium, wherever light is led."""
    deep = 256 if medium else (9 if glowing else 2)
    integrator = {"type": "volpath", "max_depth": deep, "rr_depth": 1000}
    look = Look(given=(None, bsdf), medium=medium)
    return judge.render_mitsuba(scene(look, glowing), VIEW, integrator)


def by_channel(make: Callable[[float], Picture], values: Any) -> Picture:
    """A picture whose channels differ in a number that Mitsuba has one of."""
    return np.stack([make(value)[..., c] for c, value in enumerate(values)], axis=-1)


def together(*lobes: Callable[[], Bsdf]) -> Picture:
    """Lobes added up: pictures by lamps alone are linear in what is reflected."""
    empty = lit(masked({"type": "diffuse", "reflectance": rgb(BLACK)}, 1.0))
    pictures = [lit(lobe) - empty for lobe in lobes]
    summed: Picture = np.sum(pictures, axis=0) + empty
    return summed


def plastic(color: Any, **values: Any) -> Bsdf:
    return {"type": "roughplastic", "diffuse_reflectance": rgb(color), "alpha": 0.09, **values}


MATT = {"type": "diffuse", "reflectance": rgb(RED)}
STANDARD: dict[str, Any] = {"base": 1.0, "base_color": RED, "specular": 0.0}
CLEAR: dict[str, Any] = {"transmission": 1.0, "specular_roughness": 0.0, "base": 0.0}
METAL: dict[str, Any] = {"base": 1.0, "base_color": GOLD, "metalness": 1.0}
IORS = (1.43, 1.5, 1.57)
TINT = (0.9, 0.6, 0.3)

MAPPED: dict[str, Row] = {
    "diffuse": Row("standard_surface", STANDARD, partial(lit, MATT)),
    "metal": Row(
        "standard_surface",
        {**METAL, "specular_roughness": 0.4},
        partial(lit, principled(GOLD, metallic=1.0, roughness=0.4)),
    ),
    "dielectric": Row(
        "standard_surface",
        {"base": 1.0, "base_color": RED, "specular_roughness": 0.3},
        partial(lit, plastic(RED)),
    ),
    "transmission": Row(
        "standard_surface",
        {**CLEAR, "transmission_color": TINT},
        partial(through, glass(specular_transmittance=rgb(TINT))),
        glowing=True,
    ),
    "thin_walled": Row(
        "standard_surface",
        {**CLEAR, "thin_walled": True},
        partial(through, {"type": "thindielectric", "int_ior": 1.5, "ext_ior": 1.0}),
        glowing=True,
    ),
    "presence": Row(
        "standard_surface",
        {**METAL, "specular_roughness": 0.4, "opacity": GREY},
        partial(through, masked(principled(GOLD, metallic=1.0, roughness=0.4), 0.5), glowing=False),
    ),
    "coat": Row(
        "standard_surface",
        {**STANDARD, "coat": 1.0, "coat_roughness": 0.3, "coat_color": GOLD},
        partial(
            together,
            lambda: {"type": "diffuse", "reflectance": rgb(np.multiply(RED, GOLD))},
            partial(coat, 0.3),
        ),
    ),
    "emission": Row(
        "standard_surface",
        {"base": 0.0, "specular": 0.0, "emission": 0.5, "emission_color": TEAL},
        lambda: judge.render_mitsuba(scene(Look(tuple(np.multiply(TEAL, 0.5)), glows=True)), VIEW),
    ),
    "normal_map": Row("", {}, partial(lit, lambda: bumped(MATT))),
}

LEFT_OUT: dict[str, Row] = {
    "subsurface": Row(
        "standard_surface",
        {"base": 0.0, "specular": 0.0, "subsurface": 1.0, "subsurface_color": RED},
        partial(through, {"type": "null"}, fog(inner_albedo(RED), (0.1, 0.05, 0.05)), False),
    ),
    "transmission_depth": Row(
        "standard_surface",
        {**CLEAR, "transmission_color": TINT, "transmission_depth": 1.0},
        partial(through, glass(), fog(BLACK, -1.0 / np.log(TINT))),
        glowing=True,
    ),
    "transmission_scatter": Row(
        "standard_surface",
        {**CLEAR, "transmission_depth": 1.0, "transmission_scatter": GREY},
        partial(through, glass(), fog((0.95,) * 3, 1.0)),
        glowing=True,
    ),
    "dispersion": Row(
        "standard_surface",
        {**CLEAR, "transmission_dispersion": 9.0},
        partial(by_channel, lambda ior: through(glass(ior)), IORS),
        glowing=True,
    ),
    "extra_roughness": Row(
        "standard_surface",
        {**CLEAR, "transmission_extra_roughness": 0.4},
        partial(through, glass(alpha=0.16)),
        glowing=True,
    ),
    "attenuation": Row(
        "gltf_pbr",
        {"metallic": 0.0, "roughness": 0.0, "transmission": 1.0, "thickness": 1.0,
         "attenuation_color": TINT, "attenuation_distance": 1.0},
        partial(through, glass(), fog(BLACK, -1.0 / np.log(TINT))),
        glowing=True,
    ),
    "sheen": Row(
        "standard_surface",
        {**STANDARD, "base_color": (0.1, 0.02, 0.02), "sheen": 1.0, "sheen_color": WHITE},
        partial(lit, principled((0.1, 0.02, 0.02), sheen=1.0, specular=0.0, roughness=1.0)),
    ),
    "thin_film": Row(
        "standard_surface",
        {**METAL, "specular_roughness": 0.4, "thin_film_thickness": 500.0},
        partial(lit, principled(GOLD, metallic=1.0, roughness=0.4)),
    ),
    "anisotropy": Row(
        "standard_surface",
        {**METAL, "specular_roughness": 0.5, "specular_anisotropy": 0.9},
        partial(lit, principled(GOLD, metallic=1.0, roughness=0.5, anisotropic=0.9)),
    ),
    "diffuse_roughness": Row(
        "standard_surface",
        {**STANDARD, "diffuse_roughness": 1.0},
        partial(lit, principled(RED, specular=0.0, roughness=1.0)),
    ),
    "coat_normal": Row(
        "standard_surface",
        {**STANDARD, "coat": 1.0, "coat_roughness": 0.3, "coat_normal": (0.3, 0.0, 0.9)},
        partial(together, lambda: MATT, lambda: bumped(coat(0.3))),
    ),
    "coat_darkening": Row(
        "open_pbr_surface",
        {"base_color": RED, "specular_weight": 0.0, "coat_weight": 1.0, "coat_roughness": 0.3,
         "coat_ior": 1.5, "coat_darkening": 1.0},
        partial(lit, plastic(RED, nonlinear=True)),
    ),
    "opacity_by_channel": Row(
        "standard_surface",
        {**STANDARD, "base_color": GREY, "opacity": (0.9, 0.5, 0.2)},
        partial(
            by_channel,
            lambda p: through(
                masked({"type": "diffuse", "reflectance": rgb(GREY)}, p), glowing=False
            ),
            (0.9, 0.5, 0.2),
        ),
    ),
    "displacement": Row(
        "UsdPreviewSurface",
        {"diffuseColor": RED, "ior": 1.0, "roughness": 1.0, "displacement": 0.05},
        partial(lit, MATT, 0.05),
    ),
    "bump": Row(
        "standard_surface",
        STANDARD,
        partial(lit, lambda: {"type": "bumpmap", "scale": 0.2, "arbitrary": bitmap(waves()),
                              "bsdf": MATT}),
    ),
}  # fmt: skip


def pair(row: Row) -> Picture:
    """(h, w, 3) display values, irt's to the left."""
    if row.model:
        ours = row.ours()
    else:
        look = Look(RED, normal_map=normals())
        ours = judge.render_irt(scene(look), VIEW)
    theirs = row.theirs()
    ratio = np.clip(ours, 0, 1).mean() / np.clip(theirs, 0, 1).mean()
    print(f"    mean over Mitsuba's: {ratio:.3f}")
    height = ours.shape[0]
    gap = np.full((height, GAP, 3), 0.5, np.float32)
    return np.concatenate([display_srgb(ours), gap, display_srgb(theirs)], axis=1)


def main(folder: Path, wanted: list[str]) -> None:
    """Writes the pictures of `wanted` rows, by default all, into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, row in (MAPPED | LEFT_OUT).items():
        if not wanted or name in wanted:
            print(name)
            write_png(folder / f"{name}.png", pair(row))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
