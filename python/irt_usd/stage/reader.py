# SPDX-License-Identifier: Apache-2.0
"""A shot, read frame by frame: what can vary is found once, and nothing else is read again."""

from collections.abc import Container, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeVar

from pxr import Usd, UsdGeom, UsdShade

from irt_usd.aovs import primvar_of
from irt_usd.choices import MissingAsset
from irt_usd.errors import InputError
from irt_usd.images.textures import TextureLibrary
from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.camera import CameraSource, same_camera
from irt_usd.stage.color import StageColors
from irt_usd.stage.curves import CurvesSource
from irt_usd.stage.diagnostics import attempt, usd_diagnostics, usd_errors
from irt_usd.stage.display_color import DISPLAY_PRIMVARS, given_by_instancers
from irt_usd.stage.graph import TextureSource
from irt_usd.stage.ies import check_profiles
from irt_usd.stage.instances import InstancerSource, PrototypeSource
from irt_usd.stage.lights import CAMERA_LIGHT, DOME_SAMPLES, LightSource, camera_light
from irt_usd.stage.lights import KINDS as LIGHT_KINDS
from irt_usd.stage.material_set import MaterialSet
from irt_usd.stage.materials import bound_materials
from irt_usd.stage.mesh import MeshSource
from irt_usd.stage.mesh_lights import MeshLightSource
from irt_usd.stage.objects import ObjectSource, ShapeSource
from irt_usd.stage.passes import read_pass
from irt_usd.stage.points import PointsSource
from irt_usd.stage.quadrics import QuadricSource
from irt_usd.stage.settings import BINDING_PURPOSES, Settings, read_settings
from irt_usd.stage.skel import Skin, Skins
from irt_usd.stage.snapshot import (
    CameraState,
    LightState,
    MaterialState,
    ObjectState,
    Snapshot,
    Vector,
)
from irt_usd.stage.subsets import material_subsets
from irt_usd.stage.survey import Survey, stage_prims, survey, survey_prototype
from irt_usd.stage.transforms import Node
from irt_usd.stage.views import View, ViewOptions, plan_views

_Worn = tuple[str, frozenset[str], ShapeSource | None]
"""A material's name, the primvars that it and those of faces read, and the reader of the shape that
wears it; None: it cannot be read."""

_S = TypeVar("_S", ObjectState, MaterialState, LightState)
_State = TypeVar("_State", covariant=True)


@dataclass(frozen=True)
class ReadOptions:
    """What of the stage is read, and how it is seen.

    `settings`: the render settings, a path or a bare name; None: the stage's own. What overrides
    them: `camera` (a path or a bare name), `size` (width and height of the full frame in pixels),
    `data_window` (as Framing has it) and `lock_camera` (the time at which cameras are read).
    `views`: what a reader of the same shot made of all that. `purposes`: which of UsdGeom's are
    rendered; None: the render settings', or default and render. `camera_light`: whether a stage
    without a light that irt renders gets one at the first view's camera. `dome_samples`: directions
    that a dome lights from. `aovs`: those asked for beside the products' vars. `missing_asset`:
    what becomes of a shot whose files are not all there. `render_pass`: the RenderPass (a path or a
    bare name) whose settings and collections hold. `level`: how often faces of subdivision meshes
    are cut. `texture_memory`: bytes that textures may take. `textures`: another source than the
    files that the stage names.
    """

    camera: str | None = None
    purposes: tuple[str, ...] | None = None
    camera_light: bool = True
    level: int = 0
    size: tuple[int, int] | None = None
    missing_asset: MissingAsset = "fail"
    texture_memory: int | None = None
    textures: TextureSource | None = None
    settings: str | None = None
    data_window: tuple[float, float, float, float] | None = None
    lock_camera: float | None = None
    dome_samples: int = DOME_SAMPLES
    aovs: tuple[str, ...] = ()
    views: tuple[View, ...] | None = None
    render_pass: str | None = None


class _Placed(Protocol[_State]):
    @property
    def node(self) -> Node: ...

    @property
    def varies(self) -> bool: ...

    def read(self, time: Usd.TimeCode) -> _State | None: ...


class ShotReader:
    """Reads snapshots of a stage that is not edited meanwhile.

    Whether something can vary, and so all that is decided here, is a matter of the stage alone,
    not of `frames`: a reader made for one frame, with the same size, gives the same snapshot of
    it, bit for bit. (Without a given size, the camera's aspect at the first frame decides.)
    """

    def __init__(
        self, stage: Usd.Stage, options: ReadOptions, report: Report, frames: Sequence[float]
    ) -> None:
        """Analyses the stage.

        Raises InputError: no frames, no camera, one that shows nothing at one of the frames, or an
        image without pixels.
        """
        layer = stage.GetRootLayer()
        self._stage = stage
        self._file = str(layer.realPath or layer.identifier)
        self._report = report
        self._missing_asset = options.missing_asset
        if not frames:
            raise InputError(f"{self._file}: no frames to read; give a range that holds some")
        with self._diagnostics():
            self._analyse(options, frames)

    def _analyse(self, options: ReadOptions, frames: Sequence[float]) -> None:
        self.render_pass = read_pass(self._stage, options.render_pass, self._file, self._report)
        """What the shot's render pass makes of prims."""
        wanted = options.settings or self.render_pass.settings
        given = options.camera is not None or options.views is not None
        settings = read_settings(self._stage, wanted, self._file, self._report, given)
        self.views = options.views or tuple(self._plan_views(settings, options, frames[0]))
        """The shot's images, one at least."""
        self._cameras = [
            CameraSource(
                self._stage.GetPrimAtPath(view.camera),
                self._file,
                self._report,
                options.lock_camera,
            )
            for view in self.views
        ]
        self.purposes = options.purposes or settings.purposes
        """Those of UsdGeom's that are rendered."""
        self._binding_purpose = (settings.binding_purposes or BINDING_PURPOSES)[0]
        prunes = self.render_pass.prunes if self.render_pass.path else None
        found = survey(self._stage, self.purposes, self._report, prunes)
        self._hierarchy = found.hierarchy
        self._colors = colors = StageColors(self._stage, self._report, settings.path)
        self.colors = colors.spaces
        """What leads to the rendering space."""
        self._library = TextureLibrary(colors.spaces, self._report, options.texture_memory)
        self._profiles: dict[str, str] = {}
        self.textures = options.textures or self._library
        """The texels of all materials and lights."""
        self._lights = self._read_lights(found, colors, options)
        self._mesh_lights = {
            light.node.path: light for light in self._lights if isinstance(light, MeshLightSource)
        }
        self._is_lit = bool(found.lights or found.mesh_lights)
        self.camera_light = options.camera_light and not (self._is_lit or self._pruned_lights())
        """Whether a light at the camera stands in: the stage has no light of a kind rendered."""
        if self.camera_light:
            self._report.mentioned("no lights that irt renders: a light at the camera instead")
        elif not self._is_lit:
            self._report.mentioned("no lights that irt renders, and none at the camera")
        self._materials = MaterialSet(self._stage, colors, self.textures, self._report)
        self._level = options.level
        self._skins = Skins(self._hierarchy, self._report)
        variables = (v.aov for view in self.views for v in view.product.variables)
        aovs = {*options.aovs, *variables}
        self._primvars = frozenset(filter(None, map(primvar_of, aovs)))
        self._name_elements = "elementId" in aovs
        self._shared: dict[tuple[str, ...], _Worn] = {}
        self._prototypes: dict[str, PrototypeSource | None] = {}
        self._given: frozenset[str] | None = None
        """Display primvars that point instancers have; None: there are none, or not yet read."""
        self._objects: list[ObjectSource | InstancerSource] = [
            *self._bind(found.objects, found.subsets),
            *self._instancers(found.instancers),
        ]
        if options.textures is None:
            self._find_files()
        self._lights = [
            light
            for light in self._lights
            if not isinstance(light, MeshLightSource) or light.mesh is not None
        ]
        for light in self._lights:
            light.link(source.node.path for source in self._objects)
        self._snapshot: Snapshot | None = None
        self.camera_moves = [self._find_camera_moves(v, frames) for v in range(len(self.views))]
        """By view the frames, of those given, whose camera differs from that of the frame
        before."""

    def _pruned_lights(self) -> bool:
        """Whether the stage has lights, though the render pass may have pruned them all."""
        return bool(self.render_pass.path) and any(
            str(prim.GetTypeName()) in LIGHT_KINDS for prim in stage_prims(self._stage)
        )

    @property
    def files(self) -> list[str]:
        """What textures and IES profiles are read from."""
        return [*self._library.files, *self._profiles]

    def _read_lights(
        self, found: Survey, colors: StageColors, options: ReadOptions
    ) -> list[LightSource]:
        lights: list[LightSource] = []
        report, textures, samples = self._report, self.textures, options.dome_samples
        for node in (*found.lights, *found.mesh_lights):
            if self.render_pass.hides(node.path):
                continue
            light: LightSource | None
            if node.prim.GetTypeName() == "Mesh":
                light = attempt(
                    partial(MeshLightSource, node, report, colors, textures), node.prim, report
                )
            else:
                light = attempt(
                    partial(LightSource, node.prim, node, report, colors, textures, samples),
                    node.prim,
                    report,
                )
            if light is not None:
                light.camera_visible, _ = self.render_pass.role(node.path)
                lights.append(light)
        return lights

    def _plan_views(self, settings: Settings, options: ReadOptions, first: float) -> Sequence[View]:
        overriding = ViewOptions(
            options.camera, options.size, options.data_window, options.lock_camera
        )
        time = Usd.TimeCode(first)
        return plan_views(self._stage, settings, overriding, time, self._file, self._report)

    def read(self, time: float) -> Snapshot:
        """The shot at `time` (in time codes), in any order of times.

        What is wrong with single prims goes to the report. Raises InputError on a camera that
        shows nothing, and on files that USD can no longer read.
        """
        with self._report.at_frame(time), self._diagnostics():
            code = Usd.TimeCode(time)
            self._hierarchy.update(code)
            self._snapshot = self._next(code, self._snapshot)
            return self._snapshot

    def camera_position(self, time: Usd.TimeCode) -> Vector:
        """Where the first view's camera is at `time`, in world space, finite or not."""
        with self._diagnostics():
            return self._cameras[0].position(time)

    def _diagnostics(self) -> AbstractContextManager[None]:
        return usd_diagnostics(self._report, self._stage, self._file, self._missing_asset)

    def _next(self, time: Usd.TimeCode, old: Snapshot | None) -> Snapshot:
        cameras = tuple(self._read_camera(view, time) for view in range(len(self.views)))
        camera = cameras[0]
        hidden = set(old.hidden) if old else set()
        objects = _seen(self._objects, time, hidden, self._report)
        changed_lights = _seen(self._lights, time, hidden, self._report)
        materials = self._materials.read(time)
        if old is None:
            self._objects = [s for s in self._objects if s.varies]
            self._lights = [s for s in self._lights if s.varies]
        if self.camera_light and (old is None or old.camera is not camera):
            changed_lights[CAMERA_LIGHT] = camera_light(camera)
        lights = _updated(old.lights if old else {}, changed_lights)
        if materials or changed_lights:
            skies = {light.sky.reference for light in lights.values() if light.sky is not None}
            self.textures.keep(self._materials.shown | skies)
        if self._is_lit and not any(any(light.energy) for light in lights.values()):
            self._report.mentioned(
                "no light gives light: none is visible, or all have an energy of zero",
                f"frame {time.GetValue():g}",
            )
        return Snapshot(
            float(time.GetValue()),
            _updated(old.objects if old else {}, objects),
            _updated(old.materials if old else {}, materials),
            lights,
            cameras,
            old.hidden if old and hidden == old.hidden else frozenset(hidden),
        )

    def _bind(
        self,
        nodes: Sequence[Node],
        divided: Container[str],
        given: frozenset[str] | None = None,
    ) -> list[ObjectSource]:
        """Sources of the objects, and (in passing) of every material they wear.

        `given`: of parts of a prototype, the display primvars that their instances may have; None:
        they are no parts.
        """
        sources = []
        is_part = given is not None
        nodes = [node for node in nodes if not self.render_pass.hides(node.path, is_part)]
        bindings = bound_materials(
            [node.prim for node in nodes], self._report, self._binding_purpose
        )
        for node, (_, material) in zip(nodes, bindings, strict=True):
            skin = attempt(partial(self._skins.skin, node), node.prim, self._report)
            if material and self.render_pass.prunes(str(material.GetPath())):
                material = None
            name, read, shape = self._shape(node, material, skin, divided, given or frozenset())
            light = self._mesh_lights.get(node.path)
            glow = light.wear(self._materials.bound(material)) if light is not None else None
            if glow is not None:
                name = self._materials.add(glow)
            if shape is not None:
                role = self.render_pass.role(node.path, is_part)
                source = ObjectSource(node, shape, name, self._report, skin, role, read)
                sources.append(source)
                if light is not None:
                    light.mesh = source
        return sources

    def _shape(
        self,
        node: Node,
        material: UsdShade.Material | None,
        skin: Skin | None,
        divided: Container[str],
        given: frozenset[str],
    ) -> _Worn:
        """The material that `node` wears, and the reader of its shape.

        One for all native instances of a prim that inherit and wear the same.
        """
        subsets: list[tuple[Usd.Prim, str]] = []
        read: frozenset[str] = frozenset()
        if node.path in divided and node.prim.GetTypeName() == "Mesh":
            subsets, read = self._subsets(node)
        key: tuple[str, ...] = ()
        if node.prim.IsInstanceProxy():
            inherited = UsdGeom.PrimvarsAPI(node.prim).FindInheritablePrimvars()
            attributes = [primvar.GetAttr() for primvar in inherited]
            key = (
                str(node.prim.GetPrimInPrototype().GetPath()),
                str(material.GetPath()) if material else "",
                str(id(skin.deformation)) if skin else "",
                *(name for _, name in subsets),
                *(str(a.GetPath()) for a in attributes if not a.GetPrim().IsInstanceProxy()),
                *sorted(given),
            )
            if key in self._shared:
                return self._shared[key]
        name, wanted = self._materials.worn(node, material, given)
        wanted |= read | self._primvars
        make = partial(self._shape_source, node, wanted, skin, subsets)
        worn = name, wanted, attempt(make, node.prim, self._report)
        if key:
            self._shared[key] = worn
        return worn

    def _subsets(self, node: Node) -> tuple[list[tuple[Usd.Prim, str]], frozenset[str]]:
        """The subsets that bind materials, the names of these, and the primvars they read."""
        prims = attempt(partial(material_subsets, node.prim), node.prim, self._report) or []
        worn = []
        read: frozenset[str] = frozenset()
        for prim, (_, material) in zip(
            prims, bound_materials(prims, self._report, self._binding_purpose), strict=True
        ):
            source = self._materials.bound(material)
            if source is not None:
                worn.append((prim, source.path))
                read |= source.primvars
        return worn, read

    def _shape_source(
        self,
        node: Node,
        wanted: frozenset[str],
        skin: Skin | None,
        subsets: list[tuple[Usd.Prim, str]],
    ) -> ShapeSource:
        kind = str(node.prim.GetTypeName())
        deformed = skin.deformation if skin is not None else None
        if kind == "Mesh":
            return MeshSource(
                node, self._report, wanted, deformed, self._level, subsets, self._name_elements
            )
        if kind == "Points":
            return PointsSource(node, self._report, wanted, deformed)
        if kind == "BasisCurves":
            return CurvesSource(node, self._report, wanted, deformed, self._level)
        return QuadricSource(node, self._report, wanted)

    def _instancers(self, nodes: Sequence[Node], is_part: bool = False) -> list[InstancerSource]:
        sources = []
        if nodes and self._given is None:
            self._given = given_by_instancers(self._stage)
        for node in nodes:
            if self.render_pass.hides(node.path, is_part):
                continue
            prototypes = attempt(partial(self._prototypes_of, node), node.prim, self._report)
            if prototypes:
                role = self.render_pass.role(node.path, is_part)
                source = InstancerSource(node, prototypes, self._report, self._colors, role)
                sources.append(source)
        return sources

    def _prototypes_of(self, node: Node) -> list[PrototypeSource] | None:
        """Those that an instancer names; None, reported, if one is not there."""
        relationship = UsdGeom.PointInstancer(node.prim).GetPrototypesRel()
        place = where(node.prim, "prototypes", Usd.TimeCode.Default())
        found = []
        for target in relationship.GetForwardedTargets():
            root = self._stage.GetPrimAtPath(target)
            source = self._prototype(root) if root else None
            if source is None:
                fault = "holds the instancer itself" if root else "does not exist"
                message = f"a prototype {fault}, the instancer is left out"
                self._report.skipped(message, f"<{target}> of {place}")
                return None
            found.append(source)
        if not found:
            self._report.skipped("a point instancer without prototypes", place)
        return found

    def _prototype(self, root: Usd.Prim) -> PrototypeSource | None:
        """The source of a prototype, one for all who name it; None while it is being read."""
        path = str(root.GetPath())
        if path in self._prototypes:
            return self._prototypes[path]
        self._prototypes[path] = None
        prunes = self.render_pass.prunes if self.render_pass.path else None
        found = survey_prototype(root, self._hierarchy, self.purposes, self._report, prunes)
        inherited = UsdGeom.PrimvarsAPI(root).FindInheritablePrimvars()
        if any(primvar.GetPrimvarName() in DISPLAY_PRIMVARS for primvar in inherited):
            for node in found.objects:
                node.display_primvars = True
        source = PrototypeSource(
            path,
            [
                *self._bind(found.objects, found.subsets, self._given or frozenset()),
                *self._instancers(found.instancers, is_part=True),
            ],
        )
        self._prototypes[path] = source
        return source

    def _find_files(self) -> None:
        """Looks at all textures and profiles. Raises InputError where they are required."""
        references = self._materials.references()
        for light in self._lights:
            references = {**light.textures(), **references}
            self._profiles |= light.profiles()
        policy, report, file = self._missing_asset, self._report, self._file
        self._library.survey(references, self._stage, policy, file)
        check_profiles(self._profiles, self._stage, policy, report, file)

    def _read_camera(self, view: int, time: Usd.TimeCode) -> CameraState:
        with usd_errors(f"{self._file}: the camera {self.views[view].camera}"):
            return self._cameras[view].read(time, self.views[view].framing)

    def _find_camera_moves(self, view: int, frames: Sequence[float]) -> list[float]:
        if not self._cameras[view].varies:
            self._read_camera(view, Usd.TimeCode(frames[0]))
            return []
        moves = []
        previous: CameraState | None = None
        for frame in frames:
            camera = self._read_camera(view, Usd.TimeCode(frame))
            if previous is not None and not same_camera(previous, camera):
                moves.append(frame)
            previous = camera
        return moves


def _seen(
    sources: Iterable[_Placed[_S]], time: Usd.TimeCode, hidden: set[str], report: Report
) -> dict[str, _S | None]:
    """States by path, None for what is not there; keeps `hidden` the paths of the invisible."""
    states: dict[str, _S | None] = {}
    for source in sources:
        path = source.node.path
        if source.node.visible:
            hidden.discard(path)
            states[path] = attempt(partial(source.read, time), source.node.prim, report)
        else:
            hidden.add(path)
            states[path] = None
    return states


def _updated(old: Mapping[str, _S], changes: Mapping[str, _S | None]) -> Mapping[str, _S]:
    """`old` with `changes` (None: not there): `old` itself if it already has them."""
    differing = {path: s for path, s in changes.items() if old.get(path) is not s}
    if not differing:
        return old
    updated = {**old, **{path: s for path, s in differing.items() if s is not None}}
    for path, state in differing.items():
        if state is None:
            updated.pop(path, None)
    return updated
