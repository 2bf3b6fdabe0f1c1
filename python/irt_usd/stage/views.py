# SPDX-License-Identifier: Apache-2.0
"""The images of a shot: through which camera each is seen, and of which pixels."""

from dataclasses import dataclass, replace

from pxr import Usd

from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.camera import CameraSource, choose_camera
from irt_usd.stage.diagnostics import usd_errors
from irt_usd.stage.framing import Framing
from irt_usd.stage.settings import Product, Settings

_DEFAULT_WIDTH = 960

_MAX_SIDE = 65536
"""Widest and highest image, in pixels: beyond it a request is taken for a slip."""


@dataclass(frozen=True)
class ViewOptions:
    """What overrides the render settings; None does not.

    `camera`: a path or a bare name. `size`: of the full frame, in pixels. `data_window`: as
    Framing has it. `lock_camera`: the time at which the camera is read, whatever the frame.
    """

    camera: str | None = None
    size: tuple[int, int] | None = None
    data_window: tuple[float, float, float, float] | None = None
    lock_camera: float | None = None


@dataclass(frozen=True)
class View:
    """One image of a shot."""

    camera: str
    framing: Framing
    product: Product


def plan_views(
    stage: Usd.Stage,
    settings: Settings,
    options: ViewOptions,
    time: Usd.TimeCode,
    source: str,
    report: Report,
) -> list[View]:
    """One view a product. Raises InputError on cameras and sizes that show nothing.

    `time`: where neither options nor settings give a size, the camera's aspect then decides.
    """
    views = []
    for product in settings.products:
        camera = choose_camera(stage, options.camera or product.camera, source)
        with usd_errors(f"{source}: the camera {camera}"):
            reader = CameraSource(stage.GetPrimAtPath(camera), source, report, options.lock_camera)
            reader.report_unsupported(report, time, product)
            size, origin = _size(options, product, reader, time)
        framing = Framing(
            _checked(size, origin, source),
            options.data_window or product.data_window,
            product.pixel_aspect,
            product.policy,
        )
        width, height = framing.size
        if width < 1 or height < 1:
            window = ", ".join(f"{edge:g}" for edge in framing.data_window)
            place = "--region" if options.data_window else product.path or settings.path
            raise InputError(
                f"{source}: the data window ({window}) holds no pixel's centre of"
                f" {size[0]}x{size[1]}; widen it: {place}"
            )
        _checked(framing.size, "the data window", source)
        views.append(View(camera, framing, product))
    return views


def settled(view: View) -> View:
    """The view as another reader may have it: nothing of it is bound to a stage."""
    return replace(view, product=replace(view.product, name=None))


def _size(
    options: ViewOptions, product: Product, camera: CameraSource, time: Usd.TimeCode
) -> tuple[tuple[int, int], str]:
    """Of the full frame, and where it comes from."""
    if options.size is not None:
        return options.size, "the size asked for"
    if product.resolution is not None:
        return product.resolution, "the render settings' resolution"
    aspect = camera.aspect(time) / product.pixel_aspect
    height = max(1, int(_DEFAULT_WIDTH / aspect))
    return (_DEFAULT_WIDTH, height), f"the apertures of {camera.path}"


def _checked(size: tuple[int, int], origin: str, source: str) -> tuple[int, int]:
    width, height = size
    if not (1 <= width <= _MAX_SIDE and 1 <= height <= _MAX_SIDE):
        raise InputError(
            f"{source}: {origin}: an image of {width:.9g}x{height:.9g} pixels;"
            f" expected 1 to {_MAX_SIDE} a side; mend it or give --size"
        )
    return width, height
