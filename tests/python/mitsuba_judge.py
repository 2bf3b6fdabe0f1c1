# SPDX-License-Identifier: Apache-2.0
"""Scenes built twice from the same numbers, for irt's core and for Mitsuba 3, and their comparison.

Both see along -z from the origin, at 90 degrees across. What both must agree on is chosen so that
their models coincide: matt surfaces have an index of refraction of 1 and lights near the camera,
where Schlick's Fresnel vanishes.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irt_usd import _core

SIZE = (128, 96)
SAMPLES = 16
MITSUBA_SAMPLES = 256
REGIONS = (4, 3)
"""Into how many regions, across and down, a picture is divided."""

Array = NDArray[np.float64]
Wrap = Literal["repeat", "mirror", "clamp"]


@dataclass
class Look:
    """A material: matt, a mirror-smooth glass, or one that only glows.

    Textures are (h, w, 3) float32, row 0 at the top; `normal_map` holds (n + 1) / 2. `given`: any
    other material of irt's core, and the BSDF of Mitsuba's that it is to be like; `medium` is then
    what Mitsuba fills the shape with.
    """

    color: tuple[float, float, float] = (0.5, 0.5, 0.5)
    texture: NDArray[np.float32] | None = None
    wrap: Wrap = "repeat"
    normal_map: NDArray[np.float32] | None = None
    glows: bool = False
    glass_ior: float | None = None
    given: tuple[Any, dict[str, Any]] | None = None
    medium: dict[str, Any] | None = None


@dataclass
class Shape:
    """Triangles, counter-clockwise seen from the front. `normals` and `st` are by vertex."""

    points: Array
    triangles: NDArray[np.int32]
    look: Look
    normals: Array | None = None
    st: Array | None = None


@dataclass(frozen=True)
class View:
    """What is seen: half the window's sides at distance 1, and in how many pixels and samples."""

    half: tuple[float, float] = (1.0, 0.75)
    size: tuple[int, int] = SIZE
    samples: int = SAMPLES
    mitsuba_samples: int = MITSUBA_SAMPLES


@dataclass
class Scene:
    """Shapes under point lights (position, radiant intensity)."""

    shapes: list[Shape] = field(default_factory=list)
    lights: list[tuple[tuple[float, float, float], float]] = field(default_factory=list)


def quad(corner: Any, along_s: Any, along_t: Any, look: Look, st_size: float = 1.0) -> Shape:
    """A parallelogram with st from 0 to `st_size` along its sides."""
    c, s, t = (np.array(v, dtype=float) for v in (corner, along_s, along_t))
    st = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * st_size
    points = np.array([c, c + s, c + s + t, c + t])
    return Shape(points, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32), look, None, st)


def ball(center: Any, radius: float, look: Look, steps: int, smooth: bool) -> Shape:
    """A sphere of `steps` bands and twice as many segments."""
    polar = np.linspace(0, np.pi, steps + 1)
    around = np.linspace(0, 2 * np.pi, 2 * steps + 1)[:-1]
    p, a = np.meshgrid(polar, around, indexing="ij")
    unit = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], axis=-1)
    count = len(around)
    faces = []
    for i in range(steps):
        for j in range(count):
            k = (j + 1) % count
            upper, lower = (
                (i * count + j, i * count + k),
                ((i + 1) * count + k, (i + 1) * count + j),
            )
            if i > 0:
                faces.append((upper[0], upper[1], lower[0]))
            if i < steps - 1:
                faces.append((upper[0], lower[0], lower[1]))
    flat = unit.reshape(-1, 3)
    triangles = np.array(faces, dtype=np.int32)
    return Shape(np.array(center) + radius * flat, triangles, look, flat if smooth else None)


def render_irt(scene: Scene, seen: View = View()) -> NDArray[np.float32]:
    """(h, w, 3)."""
    changes = _core.ChangeSet()
    for i, shape in enumerate(scene.shapes):
        changes.set_material(f"/look{i}", _core_material(shape.look))
        mesh = _core.Mesh(
            shape.points.astype("f4"),
            np.full(len(shape.triangles), 3, np.int32),
            shape.triangles.ravel(),
            None if shape.normals is None else shape.normals.astype("f4"),
            primvars=({} if shape.st is None else {"st": ("vertex", shape.st.astype("f4"), None)}),
        )
        changes.set_object(f"/shape{i}", mesh, np.eye(4), f"/look{i}")
    for i, (position, intensity) in enumerate(scene.lights):
        changes.set_light(f"/light{i}", _core.Light.point(position, (intensity,) * 3))
    view = _core.ViewSettings(*seen.size, samples=seen.samples, max_depth=8)
    across, up = seen.half
    renderer = _core.Renderer(_core.Camera(np.eye(4), (-across, across, -up, up)), view)
    renderer.update(changes)
    return renderer.beauty()[..., :3].copy()


def _core_material(look: Look) -> "_core.Material":
    if look.given is not None:
        material: _core.Material = look.given[0]
        return material
    if look.glass_ior is not None:
        return _core.Material(
            diffuse_color=(1, 1, 1), roughness=0.0, opacity=0.0, ior=look.glass_ior
        )
    nodes: list[_core.ShadeNode] = []
    connected: dict[str, tuple[int, str]] = {}

    def texture(image: NDArray[np.float32]) -> int:
        source = _core.Texture([(0, 0, np.ascontiguousarray(image))])
        nodes.append(_core.ShadeNode("primvar", primvar="st"))
        nodes.append(
            _core.ShadeNode(
                "texture", [len(nodes) - 1], texture=source, wrap=(look.wrap, look.wrap)
            )
        )
        return len(nodes) - 1

    target = "emissive_color" if look.glows else "diffuse_color"
    if look.texture is not None:
        connected[target] = (texture(look.texture), "rgb")
    if look.normal_map is not None:
        doubled = _core.ShadeNode("multiply", [texture(look.normal_map)], [0, 2])
        nodes.append(doubled)
        nodes.append(_core.ShadeNode("subtract", [len(nodes) - 1], [0, 1]))
        connected["normal"] = (len(nodes) - 1, "rgb")
    black = (0.0, 0.0, 0.0)
    return _core.Material(
        diffuse_color=black if look.glows else look.color,
        emissive_color=look.color if look.glows else black,
        ior=1.0,
        roughness=1.0,
        nodes=nodes,
        connected=connected,
    )


def render_mitsuba(
    scene: Scene, seen: View = View(), integrator: dict[str, Any] | None = None
) -> NDArray[np.float32]:
    """(h, w, 3)."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    # Bounces between matt surfaces are none of Whitted's.
    deep = any(shape.look.glass_ior is not None for shape in scene.shapes)
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": integrator
        or {"type": "path", "max_depth": 9 if deep else 2, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": 2 * np.degrees(np.arctan(seen.half[0])),
            "fov_axis": "x",
            "near_clip": 0.01,
            "far_clip": 1e4,
            "to_world": mi.ScalarTransform4f(np.diag([-1.0, 1, -1, 1]).tolist()),
            "film": {
                "type": "hdrfilm",
                "width": seen.size[0],
                "height": seen.size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "stratified", "sample_count": seen.mitsuba_samples},
        },
    }
    for i, (position, intensity) in enumerate(scene.lights):
        value = {"type": "rgb", "value": [intensity] * 3}
        parts[f"light{i}"] = {"type": "point", "position": list(position), "intensity": value}
    for i, shape in enumerate(scene.shapes):
        parts[f"shape{i}"] = _mitsuba_mesh(mi, f"shape{i}", shape)
    image = mi.render(mi.load_dict(parts), spp=seen.mitsuba_samples)
    return np.asarray(image, dtype=np.float32)[..., :3]


def _mitsuba_mesh(mi: Any, name: str, shape: Shape) -> Any:
    look = shape.look

    def image(values: NDArray[np.float32]) -> dict[str, Any]:
        return {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(values[::-1])),
            "raw": True,
            "filter_type": "bilinear",
            "wrap_mode": look.wrap,
        }

    def color(black: bool) -> dict[str, Any]:
        if look.texture is not None and not black:
            return image(look.texture)
        return {"type": "rgb", "value": [0.0] * 3 if black else list(look.color)}

    bsdf: dict[str, Any] = {"type": "diffuse", "reflectance": color(look.glows)}
    if look.glass_ior is not None:
        bsdf = {"type": "dielectric", "int_ior": look.glass_ior, "ext_ior": 1.0}
    elif look.normal_map is not None:
        bsdf = {"type": "normalmap", "normalmap": image(look.normal_map), "bsdf": bsdf}
        # A shadowing of bumps by themselves that UsdPreviewSurface knows nothing of.
        bsdf["use_shadowing_function"] = False
    if look.given is not None:
        bsdf = look.given[1]
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    if look.glows:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": color(False)})
    if look.medium is not None:
        properties["interior"] = mi.load_dict(look.medium)
    properties["face_normals"] = shape.normals is None
    mesh = mi.Mesh(
        name,
        len(shape.points),
        len(shape.triangles),
        props=properties,
        has_vertex_normals=shape.normals is not None,
        has_vertex_texcoords=shape.st is not None,
    )
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = shape.points.astype("f4").ravel()
    parameters["faces"] = shape.triangles.astype("u4").ravel()
    if shape.normals is not None:
        parameters["vertex_normals"] = shape.normals.astype("f4").ravel()
    if shape.st is not None:
        parameters["vertex_texcoords"] = shape.st.astype("f4").ravel()
    parameters.update()
    return mesh


@dataclass(frozen=True)
class Verdict:
    """`worst_region`: largest relative difference of a region's mean. `flip`: mean HDR-FLIP."""

    worst_region: float
    flip: float


def compare(ours: NDArray[np.float32], reference: NDArray[np.float32]) -> Verdict:
    """Compare two (h, w, 3) pictures; regions darker than a thousandth of the mean are left out."""
    import flip_evaluator

    worst = 0.0
    across, down = REGIONS
    for rows in zip(*(np.array_split(p, down, axis=0) for p in (ours, reference)), strict=True):
        for a, b in zip(*(np.array_split(p, across, axis=1) for p in rows), strict=True):
            if b.mean() > 1e-3 * reference.mean():
                worst = max(worst, abs(float(a.mean() / b.mean()) - 1))
    _, mean, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(reference), np.ascontiguousarray(ours), "HDR"
    )
    return Verdict(worst, float(mean))
