# SPDX-License-Identifier: Apache-2.0
"""A MaterialX document as a USD layer, laid out as USD's own UsdMtlx lays it out.

Materials are at /MaterialX/Materials/<name>, their inputs the surface shader's, which is their
child by the name of its node definition; node graphs at /MaterialX/NodeGraphs/<name> are
referenced below the materials that use them; nodes outside graphs are in /MaterialX/NodeGraphs
itself (pxr/usd/usdMtlx/reader.cpp).
"""

import MaterialX as mx  # noqa: N813
from pxr import Sdf, Usd, UsdShade

from irt_usd.errors import InputError
from irt_usd.materialx.looks import add_looks
from irt_usd.materialx.nodegraphs import NodeGraphs, definition
from irt_usd.materialx.values import make_input, set_value, usd_name

_ROOT = Sdf.Path("/MaterialX")

_SHADER_TYPES = {
    mx.SURFACE_SHADER_TYPE_STRING: "surface",
    mx.DISPLACEMENT_SHADER_TYPE_STRING: "displacement",
    mx.VOLUME_SHADER_TYPE_STRING: "volume",
}


def layer_text(document: mx.Document) -> str:
    """The layer of `document`, as text. Raises InputError on what has no meaning."""
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim(_ROOT)
    try:
        graphs = NodeGraphs(stage, _ROOT.AppendChild("NodeGraphs"), document)
        materials = {
            node.getName(): _add_material(stage, node, graphs)
            for node in document.getMaterialNodes()
        }
        _add_inheritance(document, materials)
        add_looks(stage, _ROOT, document, materials)
    except (ValueError, mx.ExceptionFoundCycle) as error:
        raise InputError(f"{document.getSourceUri()}: {error}; mend the file") from None
    return str(stage.GetRootLayer().ExportToString())


def _add_material(stage: Usd.Stage, node: mx.Node, graphs: NodeGraphs) -> UsdShade.Material:
    path = _ROOT.AppendChild("Materials").AppendChild(usd_name(node.getName()))
    material = UsdShade.Material.Define(stage, path)
    for kind, terminal in _SHADER_TYPES.items():
        for shader in mx.getShaderNodes(node, kind):
            source = _add_shader(stage, material, shader, terminal, graphs)
            output = material.CreateOutput(f"mtlx:{terminal}", Sdf.ValueTypeNames.Token)
            output.ConnectToSource(source.ConnectableAPI(), terminal)
    return material


def _add_shader(
    stage: Usd.Stage,
    material: UsdShade.Material,
    node: mx.Node,
    terminal: str,
    graphs: NodeGraphs,
) -> UsdShade.Shader:
    """The shader `node` under `material`: a reference to its kind's, so that variants override."""
    defined = definition(node)
    identifier = defined.getName() if defined else node.getCategory()
    prototype = _ROOT.AppendChild("Shaders").AppendChild(usd_name(identifier))
    if not stage.GetPrimAtPath(prototype):
        shared = UsdShade.Shader.Define(stage, prototype)
        shared.CreateIdAttr(identifier)
        shared.CreateOutput(terminal, Sdf.ValueTypeNames.Token)
    path = material.GetPath().AppendChild(usd_name(identifier))
    shader = UsdShade.Shader.Define(stage, path)
    shader.GetPrim().GetReferences().AddInternalReference(prototype)
    for declared in (defined or node).getActiveInputs():
        of_material = make_input(material.ConnectableAPI(), declared)
        make_input(shader.ConnectableAPI(), declared).ConnectToSource(of_material)
    for given in node.getInputs():
        set_value(make_input(material.ConnectableAPI(), given).GetAttr(), given)
        source = graphs.source_under(material.GetPath(), given)
        if source is not None:
            make_input(shader.ConnectableAPI(), given).GetAttr().SetConnections([source])
    return shader


def _add_inheritance(document: mx.Document, materials: dict[str, UsdShade.Material]) -> None:
    for node in document.getMaterialNodes():
        inherited = node.getAttribute("inherit")
        if not inherited:
            continue
        if inherited not in materials:
            raise ValueError(f"{node.getName()}: inherits {inherited}, which is no material of it")
        derived = materials[node.getName()].GetPrim()
        derived.GetSpecializes().AddSpecialize(materials[inherited].GetPath())
