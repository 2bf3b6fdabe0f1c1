# SPDX-License-Identifier: Apache-2.0
"""What the stage's own render settings (UsdRenderSettings) say of the shot."""

from typing import cast

from pxr import Usd, UsdRender, Vt

from irt_usd.report import Report
from irt_usd.stage.attributes import Attributes

PURPOSES = ("default", "render")
"""UsdGeom's purposes that are rendered, as UsdRenderSettings has it by default."""

_NAMES = ("resolution", "pixelAspectRatio", "dataWindowNDC")


def settings_camera(stage: Usd.Stage) -> str | None:
    """The camera that the stage's render settings name, if any."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    targets = settings.GetCameraRel().GetForwardedTargets() if settings else []
    return str(targets[0]) if targets else None


def settings_purposes(stage: Usd.Stage) -> tuple[str, ...]:
    """The purposes that the stage's render settings include; default and render without any."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    included = settings.GetIncludedPurposesAttr().Get() if settings else None
    return tuple(included) if isinstance(included, Vt.TokenArray) else PURPOSES


def settings_size(stage: Usd.Stage, report: Report) -> tuple[int, int] | None:
    """Width and height that the stage's render settings author, if any.

    What else they author and would change the picture is reported.
    """
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    if not settings:
        path = stage.GetMetadata("renderSettingsPrimPath")
        if path:
            message = "the stage's renderSettingsPrimPath names no RenderSettings prim"
            report.skipped(message, str(path))
        return None
    path = str(settings.GetPath())
    attributes = Attributes(settings.GetPrim(), _NAMES, report)
    attributes.update(Usd.TimeCode.EarliestTime())
    values = attributes.values
    if values["pixelAspectRatio"] != 1:
        report.unsupported("pixels that are not square", path)
    if values["dataWindowNDC"] != (0, 0, 1, 1):
        report.unsupported("render settings' dataWindowNDC (the whole frame rendered)", path)
    if not settings.GetResolutionAttr().HasAuthoredValue():
        return None
    return cast("tuple[int, int]", values["resolution"])
