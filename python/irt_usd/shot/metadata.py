# SPDX-License-Identifier: Apache-2.0
"""What a frame's header says: only what its pixels depend on, so that files compare by bytes.

Times, hosts, threads and the cost of a frame belong in the statistics file.
"""

from fractions import Fraction
from math import isfinite
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from irt_usd import _core
from irt_usd.images.exr import Matrix, MetadataValue, TimeCode, source_date
from irt_usd.shot.frames import Frame, format_frame
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage.snapshot import CameraState

_INTEGERS = 2**31
"""OpenEXR's integers and rationals end here; larger frame numbers and rates are left out."""

_SINGLE = 3e38
"""Floats of a header end here."""

_FLIP_Z = np.diag([1.0, 1.0, -1.0, 1.0])


def shot_metadata(shot: Shot, settings: TraceSettings, view: int = 0) -> dict[str, MetadataValue]:
    """The entries that are the same in every frame of a view.

    Raises InputError: a bad SOURCE_DATE_EPOCH.
    """
    camera = shot.views[view].camera
    product = shot.views[view].product.path
    versions = _core.versions()
    entries: dict[str, MetadataValue] = {
        "Software": f"irt {versions['irt']}",
        "DateTime": source_date(),
        "cameraLabel": camera,
        "irt:stage": Path(shot.options.stage).name,
        "irt:camera": camera,
        "irt:cameraLight": int(shot.reader.camera_light),
        "irt:purposes": " ".join(shot.reader.purposes),
        "irt:complexity": shot.options.complexity,
        "irt:missingAsset": shot.options.missing_asset,
        "irt:renderingColorSpace": shot.reader.colors.rendering,
        "irt:domeSamples": shot.options.dome_samples,
        "irt:samples": settings.samples,
        "irt:maxDepth": settings.max_depth,
        "irt:throughputCutoff": settings.throughput_cutoff,
        "irt:mirrorRoughness": settings.mirror_roughness,
        "irt:renderOrigin": " ".join(repr(float(value)) for value in shot.render_origin),
        "irt:isa": settings.isa,
        "irt:numericFingerprint": _core.numeric_fingerprint(settings.isa),
        "irt:versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
    }
    chromaticities = shot.reader.colors.chromaticities()
    if chromaticities is not None:
        entries["chromaticities"] = chromaticities
    if shot.options.texture_memory is not None:
        entries["irt:textureMemory"] = str(shot.options.texture_memory)
    if shot.options.session_layer is not None:
        entries["irt:sessionLayer"] = Path(shot.options.session_layer).name
    if shot.options.mask:
        entries["irt:mask"] = " ".join(shot.options.mask)
    if shot.reader.render_pass.path:
        entries["irt:renderPass"] = shot.reader.render_pass.path
    if product:
        entries["irt:renderProduct"] = product
    if shot.options.lock_camera is not None:
        entries["irt:lockCamera"] = format_frame(shot.options.lock_camera)
    layer = shot.stage.GetRootLayer()
    for entry, text in (("Copyright", layer.owner), ("ImageDescription", layer.comment)):
        if text:
            entries[entry] = str(text)
    rate = shot.stage.GetFramesPerSecond()
    if rate < _INTEGERS:
        entries["framesPerSecond"] = frames_per_second(rate)
    return entries


def frame_metadata(shot: Shot, frame: Frame, camera: CameraState) -> dict[str, MetadataValue]:
    """The entries of one frame.

    Focal length and film back are in millimetres, as is usual for USD's tenths of a scene unit.
    """
    world_to_camera, world_to_ndc = camera_matrices(
        camera.world_from_camera, camera.window, camera.orthographic
    )
    entries: dict[str, MetadataValue] = {
        "irt:frame": format_frame(frame),
        "irt:timeCode": float(frame),
        "worldToCamera": world_to_camera,
        "worldToNDC": world_to_ndc,
        "nominalFocalLength": _number(camera, "focalLength"),
        "irt:horizontalAperture": _number(camera, "horizontalAperture"),
        "irt:verticalAperture": _number(camera, "verticalAperture"),
        "irt:exposureScale": camera.exposure,
        "PixelAspectRatio": camera.pixel_aspect,
    }
    if not camera.orthographic:
        left, right, bottom, top = camera.window
        entries["screenWindowCenter"] = ((left + right) / 2, (bottom + top) / 2)
        entries["screenWindowWidth"] = right - left
    rate = shot.stage.GetFramesPerSecond()
    if frame == frame.to_integral_value() and abs(frame) < _INTEGERS:
        entries["imageCounter"] = int(frame)
        code = time_code(int(frame), rate)
        if code is not None:
            entries["smpte:TimeCode"] = code
    locked = shot.options.lock_camera
    time = Usd.TimeCode(float(frame if locked is None else locked))
    return entries | _lens(shot.stage.GetPrimAtPath(camera.path), time, rate)


def _lens(camera: Usd.Prim, time: Usd.TimeCode, rate: float) -> dict[str, MetadataValue]:
    """What a camera says of itself that shows in no pixel here, where it is authored."""

    def number(name: str) -> float:
        attribute = camera.GetAttribute(name)
        value = attribute.Get(time) if attribute and attribute.HasAuthoredValue() else None
        return float(value) if isinstance(value, (int, float)) and isfinite(value) else 0.0

    found = {
        "FNumber": number("fStop"),
        "focus": number("focusDistance"),
        "ExposureTime": (number("shutter:close") - number("shutter:open")) / max(rate, 1e-9),
    }
    return {entry: value for entry, value in found.items() if 0 < value < _SINGLE}


def time_code(frame: int, rate: float) -> TimeCode | None:
    """SMPTE's time code of a frame counted from 0; None where it has none."""
    whole = round(rate) if isfinite(rate) else 0
    if frame < 0 or not 1 <= whole <= 99 or abs(rate - whole) > 0.1:
        return None
    seconds, frames = divmod(frame, whole)
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    if hours > 23:
        return None
    return TimeCode(int(f"{hours:02d}{minutes:02d}{seconds:02d}{frames:02d}", 16))


def _number(camera: CameraState, attribute: str) -> float:
    return cast("float", camera.attributes[attribute])


def frames_per_second(rate: float) -> Fraction:
    """The rate as a fraction: 24 is 24/1, and 23.976 is NTSC's 24000/1001."""
    ntsc = Fraction(round(rate) * 1000, 1001)
    if rate != round(rate) and abs(float(ntsc) - rate) < 1e-3:
        return ntsc
    return Fraction(rate).limit_denominator(1001)


def camera_matrices(
    world_from_camera: NDArray[np.float64],
    window: tuple[float, float, float, float],
    orthographic: bool,
) -> tuple[Matrix, Matrix]:
    """OpenEXR's worldToCamera and worldToNDC, for row vectors.

    `world_from_camera` (4, 4) looks along -z; OpenEXR's camera space is left-handed and looks
    along +z. NDC is (0, 0) at the upper left of the display window and (1, 1) at the lower
    right; its z, without meaning there, is 1 - 1/distance so that the matrix has an inverse.
    """
    left, right, bottom, top = window
    world_to_camera = np.linalg.inv(world_from_camera) @ _FLIP_Z
    scale_x, scale_y = 1 / (right - left), 1 / (top - bottom)
    shift = np.array([-left * scale_x, top * scale_y])
    ndc = np.zeros((4, 4))
    ndc[0, 0], ndc[1, 1], ndc[2, 2] = scale_x, -scale_y, 1.0
    if orthographic:
        ndc[3, :2], ndc[3, 3] = shift, 1.0
    else:
        ndc[2, :2], ndc[2, 3], ndc[3, 2] = shift, 1.0, -1.0
    return _row_major(world_to_camera), _row_major(world_to_camera @ ndc)


def _row_major(matrix: NDArray[np.floating[Any]]) -> Matrix:
    return tuple(float(value) for value in matrix.ravel())
