# SPDX-License-Identifier: Apache-2.0
"""MaterialX documents, read through USD's asset resolver, and the standard data libraries."""

import posixpath
from functools import cache

import MaterialX as mx  # noqa: N813
from pxr import Ar

from irt_usd.errors import InputError
from irt_usd.stage import assets_read

_OLDER_NAMES = {"ND_normalmap": "ND_normalmap_float"}
"""Definitions that later versions of the library call otherwise."""


@cache
def standard_library() -> mx.Document:
    """The node definitions that ship with the MaterialX library."""
    library = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    return library


def definition_of(identifier: str) -> mx.NodeDef | None:
    """The standard library's definition of a shader identifier, those of older versions too."""
    name = _OLDER_NAMES.get(identifier, identifier)
    return standard_library().getNodeDef(name)


def read_document(asset: str) -> mx.Document:
    """The document at the resolved path `asset`, which may be inside a package.

    Its xincludes are resolved relative to it, its version is upgraded, file prefixes stand in
    front of file names. Raises InputError naming the file.
    """
    document = mx.createDocument()
    document.setDataLibrary(standard_library())
    _read_into(document, asset)
    mx.flattenFilenames(document)
    return document


def _read_into(document: mx.Document, asset: str, chain: tuple[str, ...] = ()) -> None:
    text = _text(asset)

    def include(
        part: mx.Document, file: mx.FilePath, _search: mx.FileSearchPath, _options: object
    ) -> None:
        included = _anchored(file.asString(), asset)
        if not included:
            raise InputError(f"{asset}: xi:include {file.asString()}: no such file; mend its href")
        if included in (*chain, asset):
            raise InputError(f"{asset}: xi:include {file.asString()}: a cycle; remove one of them")
        _read_into(part, included, (*chain, asset))

    options = mx.XmlReadOptions()
    options.readXIncludeFunction = include
    try:
        mx.readFromXmlString(document, text, mx.FileSearchPath(), options)
    except InputError:
        raise
    except Exception as error:  # the library's own share no base class
        message = f"{asset}: not a MaterialX document: {error}; mend the file"
        raise InputError(message) from None
    document.setSourceUri(asset)


def _text(asset: str) -> str:
    assets_read.note(asset)
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset))
    if opened is None:
        raise InputError(f"{asset}: cannot be opened; give a file that can be read")
    try:
        return bytes(opened.GetBuffer()).decode()
    except UnicodeDecodeError:
        raise InputError(f"{asset}: not a MaterialX document: not UTF-8; mend the file") from None


def _anchored(path: str, anchor: str) -> str:
    """The resolved path of `path` as written in the document `anchor`; empty: no such file."""
    resolver = Ar.GetResolver()
    if Ar.IsPackageRelativePath(anchor):
        package, inner = Ar.SplitPackageRelativePathInner(anchor)
        packaged = posixpath.normpath(posixpath.join(posixpath.dirname(inner), path))
        return str(resolver.Resolve(Ar.JoinPackageRelativePath(package, packaged)))
    return str(resolver.Resolve(resolver.CreateIdentifier(path, Ar.ResolvedPath(anchor))))
