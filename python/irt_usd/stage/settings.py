# SPDX-License-Identifier: Apache-2.0
"""What the stage's own render settings (UsdRenderSettings) say of the shot."""

from pxr import Usd, UsdRender

from irt_usd.report import Report


def settings_camera(stage: Usd.Stage) -> str | None:
    """The camera that the stage's render settings name, if any."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    targets = settings.GetCameraRel().GetForwardedTargets() if settings else []
    return str(targets[0]) if targets else None


def settings_size(stage: Usd.Stage, report: Report) -> tuple[int, int] | None:
    """Width and height that the stage's render settings author, if any.

    What else they author and would change the picture is reported.
    """
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    if not settings:
        return None
    path = str(settings.GetPath())
    if settings.GetPixelAspectRatioAttr().Get() != 1:
        report.unsupported("pixels that are not square", path)
    if tuple(settings.GetDataWindowNDCAttr().Get()) != (0, 0, 1, 1):
        report.unsupported("render settings' dataWindowNDC (the whole frame rendered)", path)
    resolution = settings.GetResolutionAttr()
    if not resolution.HasAuthoredValue():
        return None
    width, height = resolution.Get()
    return int(width), int(height)
