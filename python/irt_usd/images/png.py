# SPDX-License-Identifier: Apache-2.0
"""PNG files of display values."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from numpy.typing import NDArray

from irt_usd.errors import MachineError
from irt_usd.images.atomic import atomic_file


def write_png(
    path: Path, pixels: NDArray[np.float32], metadata: Mapping[str, str] | None = None
) -> None:
    """Writes `pixels` (height, width, 3), display values from 0 to 1, as 8 bits, atomically.

    Values beyond are clipped, NaN is black. Raises MachineError where the file cannot be written.
    """
    clipped = np.clip(np.nan_to_num(pixels, nan=0.0), 0.0, 1.0)
    image: NDArray[Any] = np.rint(clipped * 255.0).astype(np.uint8)
    spec = oiio.ImageSpec(image.shape[1], image.shape[0], 3, oiio.UINT8)
    for name, value in (metadata or {}).items():
        spec[name] = value
    with atomic_file(path) as temporary:
        output = oiio.ImageOutput.create("png")
        if output is None:
            raise MachineError(f"{path}: OpenImageIO cannot write PNG: {oiio.geterror().strip()}")
        written = output.open(str(temporary), spec) and output.write_image(image)
        if not (output.close() and written):
            raise MachineError(f"{path}: cannot be written: {output.geterror().strip()}")
