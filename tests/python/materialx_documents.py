# SPDX-License-Identifier: Apache-2.0
"""MaterialX documents for tests."""

SURFACE = """
  <standard_surface name="S" type="surfaceshader">{inputs}</standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
"""


def mtlx(body: str, attributes: str = 'version="1.39"') -> str:
    """The text of a document."""
    xi = 'xmlns:xi="http://www.w3.org/2001/XInclude"'
    return f'<?xml version="1.0"?>\n<materialx {attributes} {xi}>{body}</materialx>\n'


def material(inputs: str = "", nodes: str = "") -> str:
    """A document of one material, M, of a standard surface with the given inputs."""
    return mtlx(nodes + SURFACE.format(inputs=inputs))
