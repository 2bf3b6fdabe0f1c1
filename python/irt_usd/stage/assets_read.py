# SPDX-License-Identifier: Apache-2.0
"""Which files beside layers a shot was made of: noted where they are opened."""

from pathlib import Path

from pxr import Ar

_read: dict[str, None] = {}


def note(path: str) -> None:
    """`path`, which may lie in a package, is about to be read."""
    _read[path] = None


def forget() -> None:
    """Another shot begins."""
    _read.clear()


def files() -> list[Path]:
    """Those noted, packages in place of what lies in them."""
    outer = {
        Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path
        for path in _read
    }
    return sorted(Path(path) for path in outer)
