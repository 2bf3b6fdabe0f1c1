# SPDX-License-Identifier: Apache-2.0
"""Where the value of a shader's input comes from, through interfaces and nested node graphs."""

from dataclasses import dataclass

from pxr import Sdf, Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import where


@dataclass(frozen=True, slots=True)
class Source:
    """What feeds an input: a shader's output, or else an attribute's value, or nothing."""

    shader: UsdShade.Shader | None = None
    output: str = ""
    attribute: Usd.Attribute | None = None

    @property
    def text(self) -> str:
        """The connection as USD writes it; of a shader alone."""
        assert self.shader is not None
        return f"<{self.shader.GetPath()}.outputs:{self.output}>"


def source_of(shader_input: UsdShade.Input, report: Report) -> Source:
    """Follows connections upstream from `shader_input` to a shader's output, or to a value.

    As UsdShade has it: where upstream there is no value, the one nearest to it counts. Connections
    that lead nowhere or round in a circle are reported, and end the search.
    """
    port: UsdShade.Input | UsdShade.Output = shader_input
    valued: Usd.Attribute | None = None
    seen: set[Sdf.Path] = set()
    while True:
        attribute = port.GetAttr()
        if attribute.GetPath() in seen:
            report.skipped("a connection that leads back to itself", _location(shader_input))
            return Source(attribute=valued)
        seen.add(attribute.GetPath())
        if attribute.HasAuthoredValue():
            valued = attribute
        sources, dangling = port.GetConnectedSources()
        for path in dangling:
            message = f"connected to <{path}>, which does not exist"
            report.skipped(message, where(attribute.GetPrim(), attribute.GetName(), _NO_TIME))
        if not sources:
            return Source(attribute=valued)
        if len(sources) > 1:
            report.mentioned("several connections, the first followed", _location(shader_input))
        found = sources[0]
        name = found.sourceName
        if found.sourceType == UsdShade.AttributeType.Input:
            port = found.source.GetInput(name)
        elif found.source.GetPrim().IsA(UsdShade.Shader):
            return Source(UsdShade.Shader(found.source.GetPrim()), name)
        else:
            port = found.source.GetOutput(name)
        if not port:
            path = found.source.GetPath().AppendProperty(
                UsdShade.Utils.GetFullName(name, found.sourceType)
            )
            message = f"connected to <{path}>, which does not exist"
            report.skipped(message, where(attribute.GetPrim(), attribute.GetName(), _NO_TIME))
            return Source(attribute=valued)


_NO_TIME = Usd.TimeCode.Default()


def _location(shader_input: UsdShade.Input) -> str:
    attribute = shader_input.GetAttr()
    return where(attribute.GetPrim(), attribute.GetName(), _NO_TIME)
