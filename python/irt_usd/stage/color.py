# SPDX-License-Identifier: Apache-2.0
"""In which colour space the stage's colours are, and in which it is rendered."""

from typing import Any

from pxr import Usd, UsdRender

from irt_usd.images.color import LINEAR_REC709, ColorSpaces, Conversion
from irt_usd.report import Report
from irt_usd.stage.attributes import where


def color_space_of(attribute: Usd.Attribute, cache: Any = None) -> str:
    """The colour space of an attribute, its prim or an ancestor; empty where none says.

    Before OpenUSD 25.02 it is the attribute's own.
    """
    if hasattr(Usd, "ColorSpaceAPI"):
        return str(Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, cache) or "")
    return str(attribute.GetColorSpace())


class StageColors:
    """What leads the stage's colours to its rendering space."""

    def __init__(self, stage: Usd.Stage, report: Report, settings_path: str = "") -> None:
        """`settings_path`: the render settings, where they are other than the stage's own.

        Raises InputError where the rendering space is not known, or is not linear.
        """
        self._report = report
        self._cache = Usd.ColorSpaceHashCache() if hasattr(Usd, "ColorSpaceAPI") else None
        settings = (
            UsdRender.Settings.Get(stage, settings_path)
            if settings_path
            else UsdRender.Settings.GetStageRenderSettings(stage)
        )
        attribute = settings.GetRenderingColorSpaceAttr() if settings else None
        name = str(attribute.Get() or "") if attribute else ""
        if attribute and name:
            prim = settings.GetPrim()
            place = where(prim, attribute.GetName(), Usd.TimeCode.Default())
            self.spaces = ColorSpaces(name, place)
        else:
            self.spaces = ColorSpaces()

    @property
    def default(self) -> Conversion | None:
        """Of colours that say nothing: linear Rec.709's; None where that is rendered in."""
        return _unless_identity(self.spaces.conversion(LINEAR_REC709))

    def space_of(self, attribute: Usd.Attribute) -> str:
        """The space that `attribute`, its prim or an ancestor names; empty if none does."""
        return color_space_of(attribute, self._cache)

    def to_rendering(self, attribute: Usd.Attribute | None) -> Conversion | None:
        """For the colour that `attribute` holds; None: it is there already.

        By the attribute's colour space, or that of its prim or an ancestor (ColorSpaceAPI).
        """
        if attribute is None:
            return None
        name = self.space_of(attribute)
        if not name:
            return self.default
        found = self.spaces.conversion(name)
        if found is None:
            message = f"the colour space {name} is not known; {LINEAR_REC709} is taken instead"
            place = where(attribute.GetPrim(), attribute.GetName(), Usd.TimeCode.Default())
            self._report.skipped(message, place)
            return self.default
        return _unless_identity(found)


def _unless_identity(conversion: Conversion | None) -> Conversion | None:
    if conversion is None or (conversion.transfer == "linear" and conversion.matrix is None):
        return None
    return conversion
