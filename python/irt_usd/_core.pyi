# SPDX-License-Identifier: Apache-2.0
"""The C++ core: scene records, change sets, tracing. It knows nothing of USD."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Vec3 = Sequence[float]
Axis = Literal["X", "Y", "Z"]

Interpolation = Literal["constant", "uniform", "varying", "vertex", "faceVarying"]
Primvars = Mapping[str, tuple[Interpolation, NDArray[np.float32], NDArray[np.int32] | None]]
"""By name (without "primvars:"): interpolation, values (n, w) float32 with w from 1 to 4, and the
value of each element, or None where element i is value i."""

class Quadric:
    """An exact solid of UsdGeom, centred on the origin of object space; lengths in object units."""

    @staticmethod
    def sphere(radius: float) -> Quadric: ...
    @staticmethod
    def cube(size: float) -> Quadric: ...
    @staticmethod
    def cylinder(radius: float, height: float) -> Quadric: ...
    @staticmethod
    def cone(radius: float, height: float) -> Quadric: ...
    @staticmethod
    def capsule(radius: float, height: float) -> Quadric: ...
    @staticmethod
    def frustum(radius_bottom: float, radius_top: float, height: float) -> Quadric:
        """A cylinder with another radius at z = +height/2; one of the radii may be 0."""
    @staticmethod
    def round_cone(radius_bottom: float, radius_top: float, height: float) -> Quadric:
        """The convex hull of balls of these radii at z = -height/2 and +height/2."""
    @staticmethod
    def plane(width: float, length: float) -> Quadric: ...

class Mesh:
    """A polygon mesh in object space.

    points (n, 3) float32; face_vertex_counts (f,) int32; face_vertex_indices (c,) int32;
    normals (k, 3) float32 or None for facets, k as `normals_interpolation` asks; of primvars each
    has as many elements as its interpolation asks. face_materials (f,) int32: -1, the object's
    material, or an index into its face_materials; None: all -1. elements (f,) int32: the authored
    face that each is; None: themselves.
    """

    def __init__(
        self,
        points: NDArray[np.float32],
        face_vertex_counts: NDArray[np.int32],
        face_vertex_indices: NDArray[np.int32],
        normals: NDArray[np.float32] | None = None,
        normals_interpolation: Interpolation = "vertex",
        left_handed: bool = False,
        single_sided: bool = False,
        primvars: Primvars = ...,
        face_materials: NDArray[np.int32] | None = None,
        elements: NDArray[np.int32] | None = None,
    ) -> None: ...
    @property
    def points(self) -> NDArray[np.float32]:
        """A copy, as those below."""
    @property
    def normals(self) -> NDArray[np.float32]: ...
    @property
    def face_vertex_counts(self) -> NDArray[np.int32]: ...
    @property
    def face_vertex_indices(self) -> NDArray[np.int32]: ...
    @staticmethod
    def ribbons(
        points: NDArray[np.float32],
        curve_vertex_counts: NDArray[np.int32],
        widths: NDArray[np.float32],
        normals: NDArray[np.float32],
        *,
        widths_interpolation: Literal["constant", "uniform", "vertex", "faceVarying"],
        normals_interpolation: Literal["constant", "uniform", "vertex", "faceVarying"],
        basis: Literal["linear", "bezier", "bspline", "catmullRom"],
        wrap: Literal["nonperiodic", "periodic", "pinned"],
        segments: int,
        primvars: Primvars,
    ) -> Mesh:
        """Flat strips along curves, which are those that Curves takes, across their normals (k, 3)
        float32, k as `normals_interpolation` asks. Raises ValueError on counts that do not fit."""

class Subdivider:
    """Cuts the faces of control cages `level` times by UsdGeomMesh's rules, through OpenSubdiv.

    Raises ValueError on a level or a name that is out of range.
    """

    def __init__(
        self,
        *,
        scheme: str,
        level: int,
        interpolate_boundary: str = "edgeAndCorner",
        face_varying_linear_interpolation: str = "cornersPlus1",
        triangle_subdivision_rule: str = "catmullClark",
        crease_indices: NDArray[np.int32] = ...,
        crease_lengths: NDArray[np.int32] = ...,
        crease_sharpnesses: NDArray[np.float32] = ...,
        corner_indices: NDArray[np.int32] = ...,
        corner_sharpnesses: NDArray[np.float32] = ...,
        hole_indices: NDArray[np.int32] = ...,
        name_elements: bool = False,
    ) -> None:
        """`name_elements`: the polygons know which of the cage's faces they are pieces of."""
    def refine(self, cage: Mesh) -> Mesh:
        """The polygons that stand for the limit surface, with its normals and refined primvars;
        at level 0 the cage, with smooth normals unless bilinear. The refined topology is kept for
        cages that have the same. Raises ValueError on topology that OpenSubdiv refuses."""

    @property
    def left_out(self) -> list[str]:
        """Creases and corners that the last cage was refined without, and why."""

class Spheres:
    """Balls in object space: points (n, 3) float32, widths (1,) or (n,) float32, diameters;
    primvars as Mesh takes them, constant, uniform (one value) or vertex (n values)."""

    def __init__(
        self,
        points: NDArray[np.float32],
        widths: NDArray[np.float32],
        primvars: Primvars = ...,
    ) -> None: ...

class Curves:
    """Curves as chains of round cones, in object space.

    points (n, 3) float32; curve_vertex_counts (c,) int32; widths (k,) float32, diameters, k as
    `widths_interpolation` asks of UsdGeom's curves; primvars as Mesh takes them. "faceVarying"
    stands for varying, a value at each end of a span. Each span of a cubic basis becomes `segments`
    straight ones. Raises ValueError on counts that do not fit.
    """

    def __init__(
        self,
        points: NDArray[np.float32],
        curve_vertex_counts: NDArray[np.int32],
        widths: NDArray[np.float32],
        widths_interpolation: Literal["constant", "uniform", "vertex", "faceVarying"] = "constant",
        basis: Literal["linear", "bezier", "bspline", "catmullRom"] = "linear",
        wrap: Literal["nonperiodic", "periodic", "pinned"] = "nonperiodic",
        segments: int = 8,
        primvars: Primvars = ...,
    ) -> None: ...

class PassRole:
    """What a render pass makes of an object: hidden from the camera alone, or a hold-out."""

    camera_visible: bool
    matte: bool
    def __init__(self, camera_visible: bool = True, matte: bool = False) -> None: ...

_Part = tuple[
    str,
    Quadric | Mesh | Spheres | Curves | InstanceArray,
    NDArray[np.float64],
    str,
    Primvars,
    Sequence[str],
]

class Prototype:
    """Geometry shared by instances.

    Each part: (name, geometry, prototype_from_part (4, 4) float64, material, constant primvars,
    materials of faces), and perhaps its role, beside that of the object.
    A part that is an array names no material, for the parts of its prototypes do.
    """

    def __init__(
        self,
        parts: Sequence[_Part | tuple[*_Part, PassRole]],
    ) -> None: ...

class InstanceArray:
    """Many instances in little memory: as an object of its own, or as a part of a prototype.

    `array_from_prototype`: (n, 4, 3) float64, row vectors, without the last column.
    `prototype_of`: (n,) int32, into `prototypes`; None: all are of the first. `keys`: (n,) int64,
    increasing: what names an entry from change to change; None: 0, 1, 2, ... `primvars`: constant,
    or "vertex" by entry, for parts that have none of the name; an inner array's come first.
    """

    def __init__(
        self,
        prototypes: Sequence[Prototype],
        array_from_prototype: NDArray[np.float64],
        prototype_of: NDArray[np.int32] | None = None,
        keys: NDArray[np.int64] | None = None,
        primvars: Primvars = ...,
    ) -> None: ...
    def __len__(self) -> int: ...
    @property
    def array_from_prototype(self) -> NDArray[np.float64]:
        """The core's own memory, read-only."""

class Texture:
    """An image, or the tiles of a UDIM, with its mip pyramid.

    Each tile: (u, v, texels), texels (h, w) or (h, w, c), c 1 to 4, uint8, uint16 (both standing
    for [0, 1]), float16 or float32, the first row the top one; st (0, 0) is the bottom left corner.
    One channel gives (r, r, r, 1), two (r, r, r, g), three (r, g, b, 1). Arrays in C order are
    shared, not copied: they must not be written to any more. Tiles that are no UDIM's are one, at
    (0, 0).

    `transfer` is that of the colour channels; `matrix` takes linear RGB, as a column, to the
    rendering space, after filtering.
    """

    def __init__(
        self,
        tiles: Sequence[tuple[int, int, NDArray[Any]]],
        *,
        transfer: Literal["linear", "srgb"] = "linear",
        matrix: NDArray[np.float64] | None = None,
        udim: bool = False,
    ) -> None: ...
    def without_finest(self, count: int) -> Texture:
        """Without its `count` finest levels, or with its coarsest alone. Levels are shared."""
    @property
    def level_bytes(self) -> list[int]:
        """Bytes of each level, all tiles together, the finest first."""

WrapMode = Literal["black", "clamp", "repeat", "mirror"]
SHADE_OPS: list[str]
"""The operations of ShadeNode; docs/shading.md says what they compute."""

class ShadeNode:
    """A node of a material's graph. Values have four components.

    `inputs` are earlier nodes' indices, -1 where a slot is not connected: it is then what
    `constants` has there, a number for all components or up to four numbers, the missing ones 0
    and the fourth 1; slots that are neither are 0. `swizzle` (of op "swizzle") is four of r, g, b,
    a, 0, 1.
    """

    def __init__(
        self,
        op: str,
        inputs: Sequence[int] = (),
        constants: Sequence[float | Sequence[float]] = (),
        *,
        primvar: str = "",
        texture: Texture | None = None,
        wrap: tuple[WrapMode, WrapMode] = ("repeat", "repeat"),
        swizzle: str = "rgba",
    ) -> None: ...

class Material:
    """UsdPreviewSurface's inputs, with its defaults; colours are scene-linear RGB.

    `connected` gives the inputs of those names (all but the two switches) a node of `nodes` and its
    channel: "rgb", or one of "r", "g", "b", "a". `normal` is in tangent space.
    `opacity_is_presence` is opacityMode "presence". `transmission_color`, none of
    UsdPreviewSurface's, tints a refracted ray at each surface.
    """

    def __init__(
        self,
        *,
        diffuse_color: Vec3 = ...,
        emissive_color: Vec3 = ...,
        specular_color: Vec3 = ...,
        use_specular_workflow: bool = False,
        opacity_is_presence: bool = False,
        metallic: float = 0.0,
        roughness: float = 0.5,
        clearcoat: float = 0.0,
        clearcoat_roughness: float = 0.01,
        opacity: float = 1.0,
        opacity_threshold: float = 0.0,
        ior: float = 1.5,
        normal: Vec3 = ...,
        transmission_color: Vec3 = ...,
        nodes: Sequence[ShadeNode] = (),
        connected: Mapping[str, tuple[int, str]] = ...,
    ) -> None: ...

class Light:
    """A delta light; directions and positions in world space, energy scene-linear RGB."""

    @staticmethod
    def distant(
        direction: Vec3,
        irradiance: Vec3,
        casts_shadows: bool = True,
        *,
        modifiers: dict[str, Any] = ...,
    ) -> Light:
        """`direction` is the way the light travels; `irradiance` at normal incidence.

        `modifiers`, of a point light too: profile (uniform, facing, round, facets), facets (by
        row, area along its normal and offset from the position; (n, 6), world orientation), axis
        (a point's main direction) and side (across it; unit, world space), diffuse, specular,
        cone_angle (degrees), cone_softness, focus, focus_tint, ies (vertical angles, horizontal
        angles, values by horizontal and vertical angle), shadow_color, shadow_distance,
        shadow_falloff, shadow_falloff_gamma, unlit and shadowless (paths of objects it does not
        light, and that cast none of its shadows)."""
    @staticmethod
    def point(
        position: Vec3,
        intensity: Vec3,
        casts_shadows: bool = True,
        *,
        modifiers: dict[str, Any] = ...,
    ) -> Light:
        """`intensity` is the greatest radiant intensity: irradiance is intensity / distance²."""
    @staticmethod
    def environment(
        radiance: Vec3,
        camera_visible: bool = True,
        texture: Texture | None = None,
        axes: tuple[Vec3, Vec3, Vec3] = ...,
    ) -> Light:
        """What rays see that meet nothing; it lights no surface.

        `camera_visible`: whether those that come straight from the camera see it. `texture` is a
        lat-long picture as OpenEXR has them, with its x, y (pole) and z axes in the world,
        orthonormal."""

def sky_directions(count: int, up: Vec3) -> list[tuple[float, float, float]]:
    """Unit directions in which light travels, spread evenly over the sphere (Fibonacci's).

    Raises ValueError where `count` is below 1."""

class SkyCells:
    """A lat-long picture, summed up in cells small enough to be taken for directions."""

    def __init__(self, texture: Texture) -> None: ...
    def irradiances(
        self, axes: tuple[Vec3, Vec3, Vec3], directions: Sequence[Vec3]
    ) -> list[tuple[float, float, float]]:
        """Irradiance at normal incidence of the distant light in each direction: each stands for
        the part of the sky that is nearest to it."""

def texture_mean(texture: Texture) -> tuple[float, float, float]:
    """The mean colour of the finest texels: linear light, rendering space."""

def mesh_light(
    mesh: Mesh, world_from_object: NDArray[np.float64], path: str
) -> tuple[tuple[float, float, float], float, NDArray[np.float32]]:
    """Centre of a mesh's surface, its area, and its facets (n, 6), as Light.distant takes them.

    Raises ValueError, naming `path`, on broken topology or values."""

class Camera:
    """`window` is (left, right, bottom, top) of the image on camera space's plane z = -1
    (perspective), or in camera units (orthographic). Camera looks along -z, y up. Primary rays see
    what lies between the depths `clipping` (near, at least 0; far), along -z in camera units."""

    def __init__(
        self,
        world_from_camera: NDArray[np.float64],
        window: tuple[float, float, float, float],
        orthographic: bool = False,
        clipping: tuple[float, float] = ...,
    ) -> None: ...

class ChangeSet:
    """Edits by name; a record replaces the one of that name, None removes it.

    Matrices are in USD's row-vector convention (`p_world = p_object @ m`), float64 (4, 4).
    """

    def __init__(self) -> None: ...
    def set_object(
        self,
        path: str,
        geometry: Quadric | Mesh | Spheres | Curves | Prototype | InstanceArray,
        world_from_object: NDArray[np.float64],
        material: str = "",
        primvars: Primvars = ...,
        face_materials: Sequence[str] = (),
        role: PassRole = ...,
    ) -> None:
        """`primvars`: constant ones, read where the geometry has none of the name."""
    def remove_object(self, path: str) -> None: ...
    def set_material(self, name: str, material: Material) -> None: ...
    def remove_material(self, name: str) -> None: ...
    def set_light(self, path: str, light: Light) -> None: ...
    def remove_light(self, path: str) -> None: ...
    @property
    def empty(self) -> bool: ...

class ViewSettings:
    """What a view renders. `samples` a pixel; `max_depth` counts bounces after the primary ray;
    a branch is cut when its throughput's largest channel falls below about `throughput_cutoff`;
    surfaces of at most `mirror_roughness` spawn a mirror ray. `aovs` from AOVS. The film is a
    window on the full frame, of `frame` pixels ((0, 0): the film's own): its upper left pixel is
    the full frame's pixel `start`, inside or not. A pixel is the same in every window."""

    def __init__(
        self,
        width: int,
        height: int,
        samples: int = 1,
        max_depth: int = 8,
        throughput_cutoff: float = 0.0009765625,
        mirror_roughness: float = 0.1,
        aovs: Sequence[str] = (),
        start: tuple[int, int] = (0, 0),
        frame: tuple[int, int] = (0, 0),
        parts: Sequence[
            tuple[str, Literal["any", "none", "once", "more", "some"], bool, Sequence[str] | None]
        ] = (),
    ) -> None:
        """`parts` of the beauty, each: name, how often light was scattered, whether emission
        counts, labels of the lights that do (None: all)."""

AOVS: tuple[str, ...]
"""depth, normal, position, albedo, objectId, instanceId, elementId, CryptoObject, CryptoMaterial,
irt.seen, irt.retraced, irt.cause. There is also primvars:NAME for every NAME."""

class Foreseen:
    """What a shot says can ever change, and where."""

    def __init__(self, initial: ChangeSet) -> None:
        """`initial`: the change set that makes the shot's first frame from nothing."""
    def add(self, changes: ChangeSet) -> None:
        """A later frame's changes; to be called in the order of the frames."""

class Renderer:
    """A scene and a view of it, or several. Throws ValueError on records that cannot be
    rendered, naming the path; nothing is then applied."""

    def __init__(
        self,
        camera: Camera,
        settings: ViewSettings,
        *,
        render_origin: Vec3 | None = None,
        isa: str = "avx2",
        threads: int = 0,
        history: bool = True,
        cost_model: bool = True,
        cell_order: Sequence[int] | None = None,
        foreseen: Foreseen | None = None,
    ) -> None:
        """`render_origin` (world) defaults to the camera's position. `threads` 0: all.
        `history` False: nothing is kept of rays, and every update that changes anything is a full
        trace. `cost_model` False: updates are never given up for full traces that would cost less.
        `foreseen`: what can ever change, None: anything; of rays that nothing of it can reach no
        history is kept, and an update that changes something else starts again.
        `cell_order`: the cells that are rendered, in the order in which they are handed out, which
        shows in no result; by default all of 0 to 63. Pixels of others stay black."""
    def update(
        self,
        changes: ChangeSet,
        camera: Camera | None = None,
        on_progress: Callable[[float], None] | None = None,
        *,
        keep_history: bool = True,
        more_views: Sequence[tuple[Camera | None, bool]] = (),
    ) -> dict[str, Any]:
        """Applies `changes` (and a changed camera), renders what they require, and returns the
        update's statistics: `restart` (why the update was a full trace; None if it was none, or the
        first), `rays` traced {primary, reflected, refracted, shadow}, `all_rays` the film is made
        of, `flagged_rays`, `tested_rays`, `retraced_rays`, `changed_rays`, `new_rays` (of the ray
        trees: shadow rays are not counted), `uncovered_rays` (whose visible object changed),
        `whole_scene_rays` (of those: for which the whole scene was searched), `nodes_traversed`,
        `intersections`, `shadings`, `history` {nodes, points, all_bytes, bytes: by kind},
        `seconds` by the clock {apply, bvh, detect, trace, shade, combine, film, total} (phases that
        run on all threads share the time as they share the processors; of a full trace all is
        trace), `cells` {rays: [64], seconds of their threads: [64]}.

        `more_views`: camera and keep_history of every added view; theirs are the statistics in the
        list `more_views`. Time spent on the scene is told of the first view alone.

        `keep_history` False: a full trace records nothing, for the next update could not use it.
        Polls signals. `on_progress` gets the share done, at most 20 times a second; what it raises
        stops a full trace, and the last whole film stays. An incremental update runs to its end.
        Raises RuntimeError when called while an update runs."""
    def add_view(self, camera: Camera, settings: ViewSettings) -> None:
        """Another view of the scene, with a history of its own; views are numbered from 0."""
    def beauty(self, view: int = 0) -> NDArray[np.float32]:
        """(height, width, 4) RGBA, scene-linear, row 0 on top; a read-only view of the film,
        valid until the next update."""
    def aov(self, name: str, view: int = 0) -> NDArray[np.float32] | NDArray[np.uint32]:
        """(height, width) depth, irt.retraced, ids and irt.cause (uint32); (height, width, 4)
        primvars; (height, width, ranks, 2) Cryptomatte's ids and the bits of their float coverage
        (uint32); (height, width, 3) the others, parts of the beauty by their names among them."""
    def motion(
        self, changes: ChangeSet, camera: Camera | None = None, view: int = 0
    ) -> NDArray[np.float32]:
        """(height, width, 2): by how many pixels, to the right and upwards, each pixel's visible
        point is elsewhere in the state of the scene that `changes` lead to, seen through `camera`
        (None: the view's). Nothing is applied. 0 where nothing is seen, or nothing corresponds.
        Raises ValueError unless irt.seen was asked for."""
    def cause_name(self, cause: int) -> str:
        """The path of the object, material or light that a value of irt.cause stands for; empty
        where it stands for none."""
    def names(self, aov: str, ids: set[int]) -> dict[int, str]:
        """Names of objects (CryptoObject) or materials (CryptoMaterial) by their ids, of those ids
        that the scene has."""
    def brute_force_pixel(
        self, x: int, y: int, view: int = 0
    ) -> dict[str, NDArray[np.float32] | NDArray[np.uint32]]:
        """The pixel by the brute-force twin: {"beauty": (4,), aov: ...}."""
    def validate(self) -> None:
        """For tests: checks the history that the last update left, entry by entry, and the film
        against it. Raises RuntimeError naming the first invariant that is broken, and where."""

    def save(self, arrays: ArrayWriter) -> None:
        """Adds what a checkpoint holds: films, histories and what they refer to. It is to be
        written before the next update."""
    def restore(
        self, scene: ChangeSet, file: MappedFile, arrays: Mapping[str, tuple[int, int, int]]
    ) -> None:
        """Makes this renderer, which has rendered nothing, the one that was saved. `scene` makes
        that one's scene from nothing; options and views are to be its own. `arrays`: item size,
        count and offset in the file by name. Raises RuntimeError, naming the array that is missing
        or of another scene; the renderer is then of no further use."""

class ArrayWriter:
    """Arrays on their way to a file."""

    def __init__(self) -> None: ...
    def add(self, name: str, array: NDArray[Any]) -> None:
        """A contiguous array, which is copied."""
    def directory(self) -> list[tuple[str, str, int, int, int]]:
        """Name, numpy's type, item size, count and offset of each."""
    def size(self) -> int:
        """Bytes in all."""
    def write(self, path: str, header: str) -> None:
        """Writes the file: beside, synced, renamed. Raises OSError; then `path` is as it was."""
    def write_in_background(self, path: str, header: str) -> BackgroundWrite:
        """The same by a child process, with everything as it is now."""

class BackgroundWrite:
    """A file on its way to the disk; letting go of it ends it."""

    def done(self) -> bool: ...
    def cancel(self) -> None: ...
    def result(self) -> int:
        """Once done: 0, or the system's error number, or -1 where it was ended by force."""

class MappedFile:
    """A file of arrays in memory. Raises OSError where it cannot be read, RuntimeError where its
    preamble, header or size do not hold."""

    def __init__(self, path: str) -> None: ...
    def header(self) -> bytes: ...
    def data(self) -> NDArray[np.uint8]:
        """The mapped data; read-only, not copied."""
    def damaged(self, threads: int = 0) -> list[int]:
        """Numbers of the blocks that differ from their hashes."""

CHECKPOINT_BLOCK: int

def file_hash(path: str) -> str:
    """xxh3, 128 bit, of a file's bytes, as 32 hex digits. Raises OSError."""

def bytes_hash(data: bytes) -> str:
    """The same of bytes."""

def numeric_fingerprint(isa: str = "avx2") -> str:
    """Hash over fixed rays and libm calls (DESIGN 3, rule 11), as 16 hex digits."""

def name_hash(name: str) -> int:
    """MurmurHash3 (x86, 32 bit), which ids are made of."""

def versions() -> dict[str, str]:
    """Versions of irt, Embree, TBB, Imath and the compiler."""

def best_isa() -> str:
    """The widest instruction set of this processor."""

class TraceBench:
    """What `irt bench trace` times: a render, and that render's queries alone. Raises ValueError as
    Renderer does."""

    def __init__(
        self,
        scene: ChangeSet,
        camera: Camera,
        settings: ViewSettings,
        *,
        render_origin: Vec3,
        isa: str = "avx2",
    ) -> None:
        """Builds the trees; one set of them serves every call."""
    def render(self, threads: int) -> float:
        """Seconds of a full trace into the film: rays, shading and film, no trees."""
    def time(
        self, loop: Literal["bare", "ours"], query: Literal["nearest", "occlusion"]
    ) -> tuple[float, int]:
        """Seconds of one pass on one thread over the rays of that kind that `render` traces, in its
        order, and how many met something (occlusion: something opaque)."""
    @property
    def rays(self) -> dict[str, int]:
        """The rays recorded: primary, reflected, refracted, shadow."""
    def beauty(self) -> NDArray[np.float32]:
        """(height, width, 4): a copy of the film as the last `render` left it."""
