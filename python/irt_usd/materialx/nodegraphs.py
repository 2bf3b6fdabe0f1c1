# SPDX-License-Identifier: Apache-2.0
"""MaterialX node graphs as UsdShade ones, each made once and referenced where it is used."""

import MaterialX as mx  # noqa: N813
from pxr import Sdf, Usd, UsdShade

from irt_usd.materialx.document import standard_library
from irt_usd.materialx.values import TYPES, make_input, set_value, usd_name

_SHADER_TYPES = ("material", "surfaceshader", "displacementshader", "volumeshader", "lightshader")


def definition(node: mx.Node) -> mx.NodeDef | None:
    """The definition of `node`, also where its inputs do not quite match; None: there is none."""
    exact = node.getNodeDef()
    if exact is not None:
        return exact
    matching = node.getDocument().getMatchingNodeDefs(node.getCategory())
    return next((d for d in matching if d.getType() == node.getType()), None)


class NodeGraphs:
    """The node graphs of one document, below `root`."""

    def __init__(self, stage: Usd.Stage, root: Sdf.Path, document: mx.Document) -> None:
        self._stage = stage
        self._root = root
        self._document = document
        self._has_loose_nodes = False
        for graph in document.getChildren():
            defined = graph.getNodeDef() if isinstance(graph, mx.NodeGraph) else None
            if defined is not None:
                self._build(graph, root.AppendChild(usd_name(defined.getName())), defined)

    def source_under(self, parent: Sdf.Path, port: mx.Input) -> Sdf.Path | None:
        """The output that `port` is connected to, its graph referenced below the prim `parent`.

        None: not connected. Raises ValueError: to something that is not there.
        """
        graph_name, node_name = port.getNodeGraphString(), port.getNodeName()
        if graph_name:
            graph = self._document.getNodeGraph(graph_name)
            if graph is None:
                raise ValueError(f"{port.getNamePath()}: no node graph {graph_name}")
            reference = self._reference(parent, self._graph(graph))
            return reference.AppendProperty(f"outputs:{_output_name(port, graph.getOutputs())}")
        if node_name:
            self._build_loose_nodes()
            container = self._reference(parent, self._root)
            return self._node_output(container, port, self._document)
        if port.getOutputString():
            output = self._document.getOutput(port.getOutputString())
            if output is None:
                raise ValueError(f"{port.getNamePath()}: no output {port.getOutputString()}")
            self._build_loose_nodes()
            return self._node_output(self._reference(parent, self._root), output, self._document)
        return None

    def _graph(self, graph: mx.NodeGraph) -> Sdf.Path:
        path = self._root.AppendChild(usd_name(graph.getName()))
        if not self._stage.GetPrimAtPath(path):
            self._build(graph, path, None)
        return path

    def _reference(self, parent: Sdf.Path, target: Sdf.Path) -> Sdf.Path:
        path = parent.AppendChild(target.name)
        if not self._stage.GetPrimAtPath(path):
            self._stage.DefinePrim(path).GetReferences().AddInternalReference(target)
        return path

    def _build_loose_nodes(self) -> None:
        if self._has_loose_nodes:
            return
        self._has_loose_nodes = True
        self._stage.DefinePrim(self._root)
        self._add_nodes(self._document, self._root)

    def _build(self, graph: mx.NodeGraph, path: Sdf.Path, defined: mx.NodeDef | None) -> None:
        made = UsdShade.NodeGraph.Define(self._stage, path).ConnectableAPI()
        for port in [*(defined.getActiveInputs() if defined else []), *graph.getInputs()]:
            item = make_input(made, port)
            set_value(item.GetAttr(), port)
            if port.getNodeGraphString():
                item.GetAttr().SetConnections([self.source_under(path, port)])
        self._add_nodes(graph, path)
        for output in graph.getOutputs():
            kind = TYPES.get(output.getType(), Sdf.ValueTypeNames.Token)
            attribute = made.CreateOutput(usd_name(output.getName()), kind).GetAttr()
            source = self._inner_source(path, output, graph)
            if source is not None:
                attribute.SetConnections([source])

    def _add_nodes(self, container: mx.GraphElement, path: Sdf.Path) -> None:
        for node in container.getNodes():
            if node.getType() not in _SHADER_TYPES:
                self._add_node(node, path.AppendChild(usd_name(node.getName())), container)

    def _add_node(self, node: mx.Node, path: Sdf.Path, container: mx.GraphElement) -> None:
        defined = definition(node)
        if defined is not None and self._is_local(defined):
            target = self._root.AppendChild(usd_name(defined.getName()))
            prim = self._stage.DefinePrim(path)
            prim.GetReferences().AddInternalReference(target)
        else:
            shader = UsdShade.Shader.Define(self._stage, path)
            shader.CreateIdAttr(defined.getName() if defined else node.getCategory())
            prim = shader.GetPrim()
        made = UsdShade.ConnectableAPI(prim)
        for port in node.getInputs():
            item = make_input(made, port)
            set_value(item.GetAttr(), port)
            source = self._inner_source(path.GetParentPath(), port, container)
            if source is not None:
                item.GetAttr().SetConnections([source])
        for output in defined.getActiveOutputs() if defined else [node]:
            name = usd_name(output.getName()) if defined else "out"
            kind = TYPES.get(output.getType(), Sdf.ValueTypeNames.Token)
            made.CreateOutput(name, kind)

    def _inner_source(
        self, parent: Sdf.Path, port: mx.PortElement, container: mx.GraphElement
    ) -> Sdf.Path | None:
        if port.getNodeName():
            return self._node_output(parent, port, container)
        if port.hasInterfaceName():
            name = port.getInterfaceName()
            return parent.AppendProperty(f"inputs:{usd_name(name)}")
        if port.getNodeGraphString() and parent == self._root:
            graph = self._document.getNodeGraph(port.getNodeGraphString())
            if graph is None:
                raise ValueError(f"{port.getNamePath()}: no node graph {port.getNodeGraphString()}")
            output = _output_name(port, graph.getOutputs())
            return self._graph(graph).AppendProperty(f"outputs:{output}")
        return None

    def _node_output(
        self, parent: Sdf.Path, port: mx.PortElement, container: mx.GraphElement
    ) -> Sdf.Path:
        name = port.getNodeName()
        node = container.getNode(name)
        if node is None:
            raise ValueError(f"{port.getNamePath()}: no node {name}")
        defined = definition(node)
        output = _output_name(port, defined.getActiveOutputs() if defined else [])
        return parent.AppendChild(usd_name(name)).AppendProperty(f"outputs:{output}")

    def _is_local(self, defined: mx.NodeDef) -> bool:
        """Whether the document itself defines it, by a node graph."""
        if standard_library().getNodeDef(defined.getName()) is not None:
            return False
        return isinstance(defined.getImplementation(), mx.NodeGraph)


def _output_name(port: mx.PortElement, outputs: list[mx.Output]) -> str:
    """The output that `port` names, else the only one."""
    named = port.getOutputString()
    if named and not isinstance(port, mx.Output):
        return usd_name(named)
    if named and any(output.getName() == named for output in outputs):
        return usd_name(named)
    return usd_name(outputs[0].getName()) if outputs else "out"
