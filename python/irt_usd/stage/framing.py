# SPDX-License-Identifier: Apache-2.0
"""From a camera's film back and an image's resolution to the image's window, as UsdRender says.

Resolution and aperture need not agree in aspect: `aspectRatioConformPolicy` says which gives way
(UsdRenderSettingsBase; the arithmetic is that of UsdRenderComputeSpec).
"""

from dataclasses import dataclass
from math import ceil

POLICIES = (
    "expandAperture",
    "cropAperture",
    "adjustApertureWidth",
    "adjustApertureHeight",
    "adjustPixelAspectRatio",
)

WHOLE = (0.0, 0.0, 1.0, 1.0)
"""The data window that is the whole frame."""


@dataclass(frozen=True)
class Framing:
    """The pixels of an image.

    `data_window` is left, bottom, right, top in the unit square of the frame, y up; a pixel is in
    it if its centre is, and it may reach beyond the frame.
    """

    frame: tuple[int, int]
    """Width and height of the full frame, in pixels: EXR's display window."""
    data_window: tuple[float, float, float, float] = WHOLE
    pixel_aspect: float = 1.0
    """Width over height of a pixel."""
    policy: str = "adjustApertureHeight"

    @property
    def start(self) -> tuple[int, int]:
        """The data window's upper left pixel, counted on the full frame from its upper left."""
        (left, _), (_, top) = self._spans
        return left, self.frame[1] - top

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the data window in pixels; not positive where it selects none."""
        (left, right), (bottom, top) = self._spans
        return right - left, top - bottom

    @property
    def _spans(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """First pixel and the one after the last: in x, and in y, upwards."""
        left, bottom, right, top = self.data_window
        width, height = self.frame
        return (_first(left, width), _first(right, width)), (
            _first(bottom, height),
            _first(top, height),
        )

    def conform(self, aperture: tuple[float, float]) -> tuple[tuple[float, float], float]:
        """The aperture that the full frame shows, and the pixels' aspect."""
        width, height = aperture
        frame_aspect = self.frame[0] / self.frame[1]
        image_aspect = self.pixel_aspect * frame_aspect
        wide = width / height > image_aspect
        if self.policy == "adjustPixelAspectRatio":
            return aperture, width / height / frame_aspect
        narrows = {
            "adjustApertureWidth": True,
            "adjustApertureHeight": False,
            "expandAperture": not wide,
            "cropAperture": wide,
        }[self.policy]
        conformed = (height * image_aspect, height) if narrows else (width, width / image_aspect)
        return conformed, self.pixel_aspect


def _first(edge: float, pixels: int) -> int:
    """The first pixel whose centre is not before `edge`."""
    return ceil(edge * pixels - 0.5)
