# SPDX-License-Identifier: Apache-2.0
"""`.mtlx` files that a stage's layers refer to, composed without USD's plugin for them.

Composition fails on such a file, because no file format has its extension, unless a layer of its
identifier is there already. So whatever failed is read, put there as a layer in memory, and the
stage opened once more: nothing is edited, and paths, payloads, variants and packages resolve as
with the plugin.
"""

import re
from collections.abc import Callable

from pxr import Ar, Pcp, Sdf, Usd

from irt_usd.errors import InputError

_ASSET = re.compile(r"Could not (?:open asset|load sublayer) @([^@]+\.mtlx\]*)@")

_TARGET = ":SDF_FORMAT_ARGS:target=usd"
"""What composition adds to the identifier of a file whose format it does not know."""


def open_with_materialx(open_stage: Callable[[], Usd.Stage]) -> Usd.Stage:
    """What `open_stage` opens, with the MaterialX files that it composes.

    Raises InputError naming the file, and the prim that refers to it.
    """
    layers: dict[str, Sdf.Layer] = {}
    while True:
        stage = open_stage()
        new: dict[str, Sdf.Path] = {}
        for error in stage.GetCompositionErrors():
            file = _file_of(error, stage)
            if file and file not in layers:
                new.setdefault(file, error.rootSite.path)
        if not new:
            return stage
        for file, prim in new.items():
            layers[file] = _layer(file, prim)


def _file_of(error: Pcp.ErrorBase, stage: Usd.Stage) -> str:
    """The MaterialX file, there but of a format unknown to USD, that `error` is about; or empty."""
    named = _ASSET.search(str(error))
    if not named or "Cannot determine file format" not in str(error):
        return ""
    with Ar.ResolverContextBinder(stage.GetPathResolverContext()):
        return str(Ar.GetResolver().Resolve(named[1]))


def _layer(file: str, prim: Sdf.Path) -> Sdf.Layer:
    from irt_usd.materialx.document import read_document
    from irt_usd.materialx.layer import layer_text

    try:
        text = layer_text(read_document(file))
    except InputError as failure:
        raise InputError(f"{failure}, or what refers to it at prim <{prim}>") from None
    # USD refuses to make a layer by such an identifier, but not to give it to one without a file.
    layer = Sdf.Layer.CreateAnonymous(_TARGET, Sdf.FileFormat.FindById("usda"))
    layer.identifier = f"{file}{_TARGET}"
    layer.ImportFromString(text)
    layer.SetPermissionToSave(False)
    return layer
