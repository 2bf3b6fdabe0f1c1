# SPDX-License-Identifier: Apache-2.0
"""Makes of PyPI's bpy 4.3.0 an OpenUSD 24.05 to build the delegate's tests against.

The wheel carries OpenUSD's library with Hydra and no headers. These are taken from a checkout of
OpenUSD's repository at v24.05; TBB's, which must be those of 2020, from PyPI's tbb-devel. Nothing
of it is for users.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

_WHEELS = ("bpy==4.3.0", "tbb-devel==2020.0.133")
_CONFIGURED = {
    "PXR_MAJOR_VERSION": "0",
    "PXR_MINOR_VERSION": "24",
    "PXR_PATCH_VERSION": "5",
    "PXR_VERSION": "2405",
    "PXR_USE_NAMESPACES": "1",
    "PXR_EXTERNAL_NAMESPACE": "pxr",
    "PXR_INTERNAL_NAMESPACE": "pxrInternal_v0_24",
    "PXR_PYTHON_SUPPORT_ENABLED": "1",
    "PXR_PREFER_SAFETY_OVER_SPEED": "1",
}


def main() -> None:
    """Fills a folder with `include/`, `tbb/` and `lib/`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("source", type=Path, help="a checkout of OpenUSD at v24.05")
    parser.add_argument("folder", type=Path, help="where to put it")
    options = parser.parse_args()
    template = options.source / "pxr" / "pxr.h.in"
    if not template.exists():
        parser.error(f"{template} is not there: expected a checkout of OpenUSD")
    for header in (options.source / "pxr").rglob("*.h*"):
        if header.suffix not in (".h", ".hpp"):
            continue
        target = options.folder / "include" / header.relative_to(options.source)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(header, target)
    text = re.sub("@([A-Z_]+)@", lambda m: _CONFIGURED[m[1]], template.read_text())
    (options.folder / "include/pxr/pxr.h").write_text(text)
    with tempfile.TemporaryDirectory() as wheels:
        download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        subprocess.run([*download, "--dest", wheels, *_WHEELS], check=True)
        for wheel in Path(wheels).iterdir():
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(options.folder / "wheels")
    for name, found in (("lib", "bpy/lib"), ("tbb", "tbb_devel-2020.0.133.data/data/include")):
        link = options.folder / name
        if not link.exists():
            link.symlink_to(Path("wheels") / found, target_is_directory=True)


if __name__ == "__main__":
    main()
