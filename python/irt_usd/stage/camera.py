# SPDX-License-Identifier: Apache-2.0
"""UsdGeomCamera: the view it gives, and which camera a shot is seen through.

Lens and film back are in tenths of a scene unit; for perspective only their ratios matter, so that
the unit cancels. How an image's aspect and the apertures' are reconciled is framing.py's to say.
An authored clippingRange clips what is seen, in mirrors and shadows nothing; the schema's own
(1 to 1000000) is no statement about a scene, and does not. Exposure multiplies what is written.
"""

from math import inf, isfinite
from typing import cast

from pxr import Gf, Usd, UsdGeom

from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes, where
from irt_usd.stage.framing import Framing
from irt_usd.stage.settings import Product
from irt_usd.stage.snapshot import CameraState, Vector
from irt_usd.stage.survey import stage_prims
from irt_usd.stage.transforms import ancestry, transform_blame, transform_fault
from irt_usd.stage.values import Value, matrix_array, same_bits

_NAMES = (
    "projection",
    "horizontalAperture",
    "verticalAperture",
    "horizontalApertureOffset",
    "verticalApertureOffset",
    "focalLength",
    "clippingRange",
)

_EXPOSURE = (
    "exposure",
    "exposure:iso",
    "exposure:time",
    "exposure:fStop",
    "exposure:responsivity",
)


def list_cameras(stage: Usd.Stage) -> list[str]:
    """Paths of the stage's cameras, in its order, those inside instances included."""
    return [str(prim.GetPath()) for prim in stage_prims(stage) if prim.IsA(UsdGeom.Camera)]


def choose_camera(stage: Usd.Stage, wanted: str | None, source: str) -> str:
    """The path of the camera `wanted`, a path or a bare name.

    Without one: the only one. Raises InputError, listing what there is, if that names none or
    several.
    """
    cameras = list_cameras(stage)
    listed = "\n  ".join(["its cameras:", *cameras])
    if not cameras:
        raise InputError(f"{source}: the stage has no camera; add a prim of type Camera")
    if wanted is None and len(cameras) > 1:
        raise InputError(f"{source}: several cameras; choose one with --camera; {listed}")
    if wanted is None:
        return cameras[0]
    named = [path for path in cameras if path == wanted or path.rsplit("/", 1)[1] == wanted]
    if wanted in named:
        return wanted
    if len(named) > 1:
        raise InputError(f"{source}: several cameras are named '{wanted}'; give a path; {listed}")
    if not named:
        raise InputError(f"{source}: no camera '{wanted}'; {listed}")
    return named[0]


class CameraSource:
    """Reads the camera."""

    def __init__(
        self, prim: Usd.Prim, source: str, report: Report, locked: float | None = None
    ) -> None:
        """`locked`: the time at which place and lens are read, whatever is asked for."""
        self._chain = ancestry(prim)
        self._node = self._chain[-1]
        self._prim = prim
        self._file = source
        self._report = report
        self._locked = Usd.TimeCode(locked) if locked is not None else None
        self._attributes = Attributes(prim, _NAMES, report, self._node.in_clips)
        self._exposure = Attributes(prim, _EXPOSURE, report, self._node.in_clips)
        self._clips = prim.GetAttribute("clippingRange").HasAuthoredValue()
        self._state: CameraState | None = None
        self._world = b""

    @property
    def path(self) -> str:
        """The camera's prim."""
        return self._node.path

    @property
    def varies(self) -> bool:
        """Whether the view can differ between frames."""
        return self._locked is None and (self._attributes.vary or self._node.moves)

    def aspect(self, time: Usd.TimeCode) -> float:
        """Horizontal over vertical aperture. Raises InputError where they give none."""
        self._attributes.update(self._time(time))
        for name in ("horizontalAperture", "verticalAperture"):
            self._positive(name, time)
        return self._number("horizontalAperture") / self._number("verticalAperture")

    def read(self, time: Usd.TimeCode, framing: Framing) -> CameraState:
        """The camera at `time`, for images of `framing`: the same object while nothing changes.

        Raises InputError on a transform, aperture, focal length or clipping range that shows
        nothing.
        """
        seen = self._time(time)
        changed = self._attributes.update(seen)
        exposed = self._exposure.update(time)
        self._move(seen)
        world = bytes(self._node.world)
        if self._state is None or changed or exposed or world != self._world:
            self._world = world
            self._state = self._build(seen, time, framing)
        return self._state

    def _time(self, time: Usd.TimeCode) -> Usd.TimeCode:
        return time if self._locked is None else self._locked

    def position(self, time: Usd.TimeCode) -> Vector:
        """Where the camera is in world space, finite or not. Raises nothing."""
        self._move(self._time(time))
        x, y, z = self._node.world.ExtractTranslation()
        return (x, y, z)

    def _move(self, time: Usd.TimeCode) -> None:
        for node in self._chain:
            node.update_transform(time)

    def report_unsupported(self, report: Report, time: Usd.TimeCode, product: Product) -> None:
        """Reports what the camera asks for and does not get, unless `product` does without it."""
        camera, path = UsdGeom.Camera(self._prim), self._node.path
        if camera.GetClippingPlanesAttr().Get(time):
            report.unsupported("camera clippingPlanes", path)
        if product.depth_of_field and camera.GetFStopAttr().Get(time):
            report.unsupported("depth of field (everything in focus)", path)
        shutter = camera.GetShutterOpenAttr().Get(time), camera.GetShutterCloseAttr().Get(time)
        if product.motion_blur and shutter[0] != shutter[1]:
            report.mentioned("no motion blur: the shutter is open at the frame's time alone", path)

    def _build(self, time: Usd.TimeCode, exposed_at: Usd.TimeCode, framing: Framing) -> CameraState:
        fault = transform_fault(self._node.world)
        if fault:
            message, place = transform_blame(self._node, fault, time)
            raise InputError(
                f"{self._file}: at {time.GetValue():g}, of the camera, {message}: {place}"
            )
        values: dict[str, Value] = dict(self._attributes.values)
        projection = values["projection"]
        if projection not in ("perspective", "orthographic"):
            self._refuse("projection", "perspective or orthographic", time)
        orthographic = projection == "orthographic"
        self._positive("horizontalAperture", time)
        if orthographic:
            scale = Gf.Camera.APERTURE_UNIT
        else:
            self._positive("focalLength", time)
            scale = 1 / self._number("focalLength")
        for name in ("horizontalApertureOffset", "verticalApertureOffset"):
            if not isfinite(self._number(name)):
                self._refuse(name, "a finite number", time)
        width, height = self._number("horizontalAperture"), self._number("verticalAperture")
        if framing.policy != "adjustApertureHeight":
            self._positive("verticalAperture", time)
        (width, height), pixel_aspect = framing.conform((width, height))
        x = self._number("horizontalApertureOffset")
        y = self._number("verticalApertureOffset")
        world = matrix_array(self._node.world)
        window = (
            (x - width / 2) * scale,
            (x + width / 2) * scale,
            (y - height / 2) * scale,
            (y + height / 2) * scale,
        )
        attributes = {
            **values,
            **self._exposure.values,
            "typeName": "Camera",
            "world_from_object": world,
        }
        return CameraState(
            self._node.path,
            attributes,
            world,
            window,
            orthographic,
            self._clipping(time),
            pixel_aspect,
            self._exposure_scale(exposed_at),
        )

    def _clipping(self, time: Usd.TimeCode) -> tuple[float, float]:
        """Near and far, as depths."""
        if not self._clips:
            return (0.0, inf)
        near, far = cast("tuple[float, float]", self._attributes.values["clippingRange"])
        if not (isfinite(near) and near >= 0 and far > near):
            self._refuse("clippingRange", "near below far, and near 0 or more", time)
        return (near, far)

    def _exposure_scale(self, time: Usd.TimeCode) -> float:
        camera = UsdGeom.Camera(self._prim)
        if hasattr(camera, "ComputeLinearExposureScale"):
            scale = camera.ComputeLinearExposureScale(time)
        else:  # before OpenUSD 25.02 exposure was all
            scale = 2.0 ** self._exposure_value()
        if isfinite(scale) and scale >= 0:
            return float(scale)
        message = f"the camera's exposure multiplies by {scale}; expected a finite number from 0"
        self._report.skipped(f"{message}; none is rendered", where(self._prim, "exposure", time))
        return 1.0

    def _exposure_value(self) -> float:
        value = self._exposure.values["exposure"]
        return value if isinstance(value, float) else 0.0

    def _number(self, name: str) -> float:
        value = self._attributes.values[name]
        return value if isinstance(value, float) else float("nan")

    def _positive(self, name: str, time: Usd.TimeCode) -> None:
        value = self._number(name)
        if not (isfinite(value) and value > 0):
            self._refuse(name, "a positive finite number", time)

    def _refuse(self, name: str, wanted: str, time: Usd.TimeCode) -> None:
        value = self._attributes.values[name]
        place = where(self._prim, name, time)
        raise InputError(
            f"{self._file}: at {time.GetValue():g} the camera's {name} is {value};"
            f" expected {wanted}: {place}"
        )


def same_camera(a: CameraState, b: CameraState) -> bool:
    """Whether both map the world to the image alike, to the bit."""
    return a is b or (
        a.orthographic == b.orthographic
        and same_bits(a.window, b.window)
        and a.clipping == b.clipping
        and same_bits(a.world_from_camera, b.world_from_camera)
    )
