# SPDX-License-Identifier: Apache-2.0
"""Colour spaces: from those of textures and constants to the rendering space, by OpenColorIO.

Names are looked up in $OCIO's config, where there is one, and then in OpenColorIO's built-in config
below, which knows those of USD and of the Color Interop Forum.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irt_usd.errors import InputError

BUILTIN_CONFIG = "ocio://cg-config-v5.0.0_aces-v2.1_ocio-v2.6"
"""By its whole name: what "latest" means moves."""

LINEAR_REC709 = "lin_rec709_scene"
"""The rendering space unless something else is asked for, and that of colours on a stage."""

SRGB = "srgb_rec709_scene"
RAW = "raw"

_REC709_NAMES = frozenset((LINEAR_REC709, "lin_rec709", "Linear Rec.709 (sRGB)"))
_SRGB_NAMES = frozenset((SRGB, "sRGB", "srgb_texture", "sRGB Encoded Rec.709 (sRGB)"))
_RAW_NAMES = frozenset((RAW, "data", "identity", "unknown", ""))

_LINEAR_TOLERANCE = 1e-4
"""How far, relatively, a space may be from linear in OpenColorIO's single precision."""


@dataclass(frozen=True, eq=False)
class Conversion:
    """Leads a colour space to the rendering space.

    First the curve `transfer`, then `matrix` (3, 3), for columns, None for the identity. "baked" is
    the curve of no formula that the core has: `apply` does all of it.
    """

    transfer: Literal["linear", "srgb", "baked"]
    matrix: NDArray[np.float64] | None = None
    processor: Any = None

    def apply(self, pixels: NDArray[np.float32]) -> None:
        """Converts `pixels` (h, w, 3 or 4), C-contiguous, in place, alpha left as it is."""
        import PyOpenColorIO as ocio  # noqa: N813

        height, width, channels = pixels.shape
        self.processor.apply(ocio.PackedImageDesc(pixels, width, height, channels))

    def color(self, rgb: Sequence[float]) -> tuple[float, float, float]:
        """One colour, converted."""
        if self.transfer == "baked":
            converted = np.asarray(self.processor.applyRGB([float(v) for v in rgb]))
        else:
            vector = np.asarray(rgb, np.float64)
            if self.transfer == "srgb":
                vector = np.array([_linear_of_srgb(v) for v in vector])
            converted = vector if self.matrix is None else self.matrix @ vector
        red, green, blue = (float(v) for v in converted)
        return red, green, blue


def _linear_of_srgb(value: float) -> float:
    """IEC 61966-2-1's decoding."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


class ColorSpaces:
    """What leads to one rendering space."""

    def __init__(self, rendering: str | None = None, origin: str = "the rendering space") -> None:
        """`rendering` None: $OCIO's scene_linear, linear Rec.709 without.

        Raises InputError, of `origin`, for spaces that are not known or not linear, and for an
        $OCIO that cannot be read.
        """
        if rendering is None:
            config = _user_config()
            if config is None:
                rendering = LINEAR_REC709
            elif config.hasRole("scene_linear"):
                rendering = str(config.getColorSpace("scene_linear").getName())
                origin = f"$OCIO's scene_linear ({os.environ['OCIO']})"
            else:
                raise InputError(
                    f"OCIO={os.environ['OCIO']}: the config has no scene_linear role; add one, or"
                    " author the render settings' renderingColorSpace"
                )
        self.rendering = rendering
        """Its name, as it was asked for."""
        self._conversions: dict[str, Conversion | None] = {}
        self._raw = rendering in _RAW_NAMES
        if not self._raw and rendering not in _REC709_NAMES:
            found = self.conversion(LINEAR_REC709)
            if found is None or found.transfer != "linear":
                reason = "is not linear" if found else "is in no OpenColorIO config at hand"
                raise InputError(
                    f"{origin}: the colour space {rendering} {reason}; name a linear one, such as"
                    f" {LINEAR_REC709} or lin_ap1_scene"
                )

    def conversion(self, name: str) -> Conversion | None:
        """From the space `name`; None if it is not known."""
        if name not in self._conversions:
            self._conversions[name] = self._find(name)
        return self._conversions[name]

    def chromaticities(self) -> tuple[float, ...] | None:
        """Of the rendering space: x, y of red, green, blue and white, as OpenEXR has them.

        None for Rec.709, and where nothing is known of it. White is D65 as in Rec.709: other whites
        are adapted to it.
        """
        conversion = self.conversion(LINEAR_REC709)
        if conversion is None or conversion.matrix is None:
            return None
        to_xyz = np.array(_XYZ_FROM_REC709) @ np.linalg.inv(conversion.matrix)
        corners = [*to_xyz.T, to_xyz.sum(axis=1)]
        return tuple(float(v) for xyz in corners for v in xyz[:2] / xyz.sum())

    def _find(self, name: str) -> Conversion | None:
        if self._raw or name in _RAW_NAMES:
            return Conversion("srgb") if name in _SRGB_NAMES else Conversion("linear")
        if self.rendering in _REC709_NAMES:
            if name in _REC709_NAMES:
                return Conversion("linear")
            if name in _SRGB_NAMES:
                return Conversion("srgb")
        if name in _SRGB_NAMES:
            linear = self.conversion(LINEAR_REC709)
            return Conversion("srgb", linear.matrix) if linear is not None else None
        source, target = _lookup(name), _lookup(self.rendering)
        if source is None or target is None:
            return None
        if source[0].getColorSpace(source[1]).isData():
            return Conversion("linear")
        processor = _processor(source, target)
        matrix = _matrix_of(processor)
        if matrix is None:
            return Conversion("baked", None, processor)
        identity = np.allclose(matrix, np.eye(3), rtol=0, atol=_LINEAR_TOLERANCE)
        return Conversion("linear", None if identity else matrix)


_XYZ_FROM_REC709 = (
    (0.4123907992659595, 0.3575843393838780, 0.1804807884018343),
    (0.2126390058715104, 0.7151686787677559, 0.0721923153607337),
    (0.0193308187155918, 0.1191947797946259, 0.9505321522496608),
)
"""ITU-R BT.709's primaries with D65."""


@cache
def _builtin_config() -> Any:
    import PyOpenColorIO as ocio  # noqa: N813

    return ocio.Config.CreateFromFile(BUILTIN_CONFIG)


def _user_config() -> Any | None:
    path = os.environ.get("OCIO")
    return _config_file(path) if path else None


@cache
def _config_file(path: str) -> Any:
    import PyOpenColorIO as ocio  # noqa: N813

    try:
        return ocio.Config.CreateFromFile(path)
    except (ocio.Exception, ocio.ExceptionMissingFile) as error:
        raise InputError(
            f"OCIO={path}: no OpenColorIO config can be read there: {error}; mend the file, or"
            " unset OCIO"
        ) from None


def _lookup(name: str) -> tuple[Any, str] | None:
    """The config that knows the space, and the space's own name there."""
    for config in (_user_config(), _builtin_config()):
        space = config.getColorSpace(name) if config is not None else None
        if space is not None:
            return config, str(space.getName())
    return None


def _processor(source: tuple[Any, str], target: tuple[Any, str]) -> Any:
    import PyOpenColorIO as ocio  # noqa: N813

    try:
        if source[0] is target[0]:
            found = source[0].getProcessor(source[1], target[1])
        else:
            found = ocio.Config.GetProcessorFromConfigs(*source, *target)
    except (ocio.Exception, ocio.ExceptionMissingFile) as error:
        raise InputError(
            f"OpenColorIO cannot lead {source[1]} to {target[1]}: {error}; mend the config"
        ) from None
    depth = ocio.BIT_DEPTH_F32
    return found.getOptimizedCPUProcessor(depth, depth, ocio.OPTIMIZATION_LOSSLESS)


def display_config() -> tuple[Any, str]:
    """The config whose displays are offered, and what to call it. Raises InputError on $OCIO."""
    config = _user_config()
    if config is not None:
        return config, f"OCIO={os.environ['OCIO']}"
    return _builtin_config(), BUILTIN_CONFIG


def display_processor(rendering: str, display: str, view: str) -> Any:
    """From the space `rendering` to a display that display_config has; single precision.

    Raises InputError where OpenColorIO finds no way.
    """
    import PyOpenColorIO as ocio  # noqa: N813

    config, _ = display_config()
    source = _lookup(rendering)
    try:
        if source is None or source[0] is config:
            name = source[1] if source is not None else rendering
            transform = ocio.DisplayViewTransform(src=name, display=display, view=view)
            found = config.getProcessor(transform)
        else:
            found = ocio.Config.GetProcessorFromConfigs(
                *source, config, display, view, ocio.TRANSFORM_DIR_FORWARD
            )
        return found.getDefaultCPUProcessor()
    except (ocio.Exception, ocio.ExceptionMissingFile) as error:
        raise InputError(
            f"OpenColorIO cannot lead {rendering} to {display}, {view}: {error}; choose others with"
            " --display and --view, or mend the config"
        ) from None


def _matrix_of(processor: Any) -> NDArray[np.float64] | None:
    """The processor as a matrix for columns; None if it is none."""
    matrix = np.array([processor.applyRGB(row) for row in np.eye(3).tolist()], np.float64).T
    for probe in ((0.0, 0.0, 0.0), (0.25, 0.5, 0.125), (2.0, 4.0, 8.0), (0.01, 0.02, 0.05)):
        found = np.array(processor.applyRGB(list(probe)))
        expected = matrix @ np.array(probe)
        scale = max(probe) * _LINEAR_TOLERANCE
        if not np.allclose(found, expected, rtol=0, atol=scale):
            return None
    return matrix
