# SPDX-License-Identifier: Apache-2.0
"""Previews: frames as a screen shows them, through a display and view of OpenColorIO's.

The config is $OCIO's, or OpenColorIO's built-in one where that is not set.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irt_usd.errors import InputError
from irt_usd.images.color import display_config, display_processor

_BRIGHTEST = 65504.0
"""What stands for infinity: the greatest half."""


@dataclass(frozen=True)
class DisplayView:
    """Leads the rendering space to a display."""

    display: str
    view: str
    processor: Any

    def shown(self, beauty: NDArray[np.float32]) -> NDArray[np.float32]:
        """Display values of `beauty` (height, width, 4), premultiplied: over black."""
        import PyOpenColorIO as ocio  # noqa: N813

        finite = np.nan_to_num(beauty[..., :3], nan=0.0, posinf=_BRIGHTEST, neginf=0.0)
        pixels = np.ascontiguousarray(finite, np.float32)
        height, width, _ = pixels.shape
        self.processor.apply(ocio.PackedImageDesc(pixels, width, height, 3))
        return pixels


def display_view(rendering: str, display: str | None, view: str | None) -> DisplayView:
    """The display and view asked for; None: the config's default.

    `rendering` is the rendering space's name. Raises InputError, listing what there is, where the
    config has no display or view of the name.
    """
    config, origin = display_config()
    displays = list(config.getDisplays())
    chosen = display or config.getDefaultDisplay()
    if chosen not in displays:
        listed = "\n  ".join([f"{origin} has:", *displays])
        raise InputError(f"--display {chosen}: no such display; {listed}")
    views = list(config.getViews(chosen))
    shown = view or config.getDefaultView(chosen)
    if shown not in views:
        listed = "\n  ".join([f"{chosen} has:", *views])
        raise InputError(f"--view {shown}: no such view; {listed}")
    return DisplayView(chosen, shown, display_processor(rendering, chosen, shown))
