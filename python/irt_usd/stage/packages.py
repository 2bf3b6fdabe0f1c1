# SPDX-License-Identifier: Apache-2.0
"""USDZ packages: what makes one unfit to be read, found before anything is made of its contents.

Packages are zip archives whose files stand in them as they are, the root layer first ("USDZ File
Format Specification", OpenUSD); whatever unpacks to more than is there is thus none.
"""

import os
import struct
from pathlib import Path
from typing import BinaryIO
from zipfile import ZIP_STORED, BadZipFile, ZipFile, ZipInfo

_ENCRYPTED = 1
"""The bit of a zip entry's flags."""

_LOCAL_HEADER = struct.Struct("<4s5H3I2H")

_LAYERS = (".usd", ".usda", ".usdc")


def package_fault(path: str) -> str | None:
    """What is wrong with the package `path`, if anything. Unpacks nothing."""
    try:
        with ZipFile(path) as package, Path(path).open("rb") as file:
            entries = package.infolist()
            for entry in entries:
                fault = _entry_fault(entry, file)
                if fault is not None:
                    return f"its file {entry.filename} {fault}"
    except (BadZipFile, struct.error, NotImplementedError, ValueError) as error:
        return f"it is no zip archive, or was cut short: {error}"
    if not entries or not entries[0].filename.lower().endswith(_LAYERS):
        return "its first file is no USD layer"
    return None


def _entry_fault(entry: ZipInfo, file: BinaryIO) -> str | None:
    if entry.flag_bits & _ENCRYPTED:
        return "is encrypted, which packages cannot be"
    if entry.compress_type != ZIP_STORED:
        return "is compressed, which packages cannot be"
    size = os.fstat(file.fileno()).st_size
    file.seek(entry.header_offset)
    header = _LOCAL_HEADER.unpack(file.read(_LOCAL_HEADER.size))
    packed, unpacked, name, extra = header[-4:]
    end = entry.header_offset + _LOCAL_HEADER.size + name + extra + entry.file_size
    if end > size or entry.compress_size != entry.file_size:
        return f"claims {entry.file_size} bytes, more than there are"
    if not packed == unpacked == entry.file_size:
        return f"claims {unpacked} bytes in one place, {entry.file_size} in another"
    return None
