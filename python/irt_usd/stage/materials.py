# SPDX-License-Identifier: Apache-2.0
"""Which materials the stage's prims are bound to, and which of their surfaces irt renders."""

from functools import partial

from pxr import Sdf, Tf, Usd, UsdShade

from irt_usd.report import Report
from irt_usd.stage.attributes import where
from irt_usd.stage.diagnostics import attempt

_RENDER_CONTEXTS = ("mtlx", "")
"""Of the surfaces that are rendered, the first there is, as Storm has it."""


def rendered_surface(material: UsdShade.Material, report: Report) -> UsdShade.Shader | None:
    """The surface of `material`, MaterialX's or UsdPreviewSurface; None, and reported, if none."""
    path = str(material.GetPath())
    unknown: dict[str, None] = {}
    for context in _RENDER_CONTEXTS:
        shader = material.ComputeSurfaceSource(context)[0]
        identifier = str(shader.GetIdAttr().Get() or "") if shader else ""
        if identifier == "UsdPreviewSurface" or is_materialx(identifier):
            for other in unknown:
                report.unsupported(f"surface shader {other} ({identifier} rendered instead)", path)
            return shader
        if shader:
            unknown[identifier or "without an info:id"] = None
    for identifier in unknown:
        report.unsupported(f"surface shader {identifier} (displayColor rendered instead)", path)
    if unknown:
        return None
    others = [o.GetBaseName() for o in material.GetSurfaceOutputs() if o.HasConnectedSource()]
    if others:
        kind = f"materials for other renderers alone ({', '.join(sorted(others))})"
        report.unsupported(f"{kind} (displayColor rendered instead)", path)
    else:
        report.mentioned("material without a surface, displayColor rendered instead", path)
    return None


def is_materialx(identifier: str) -> bool:
    """Whether a shader of this identifier is a surface of MaterialX that is rendered."""
    if not identifier.startswith("ND_"):
        return False
    from irt_usd.materialx.surfaces import is_surface

    return is_surface(identifier)


def bound_materials(
    prims: list[Usd.Prim], report: Report, purpose: str = "full"
) -> list[tuple[Sdf.Path, UsdShade.Material | None]]:
    """For each prim the material that its binding resolves to, and its path.

    By UsdShade's rules for the purpose, inherited and collection bindings included.
    Missing ones are reported.
    """
    found = []
    try:
        materials, relationships = _compute_bound(prims, purpose)
    except Tf.ErrorException:
        one_by_one = [attempt(partial(_compute_bound, [p], purpose), p, report) for p in prims]
        materials = [found[0][0] if found else None for found in one_by_one]
        relationships = [found[1][0] if found else None for found in one_by_one]
    for material, relationship in zip(materials, relationships, strict=True):
        if material:
            found.append((material.GetPath(), material))
            continue
        found.append((Sdf.Path.emptyPath, None))
        if relationship:
            targets = ", ".join(f"<{t}>" for t in relationship.GetTargets())
            message = "the bound material does not exist, displayColor rendered instead"
            place = where(relationship.GetPrim(), relationship.GetName(), Usd.TimeCode.Default())
            report.skipped(message, f"{targets} of {place}")
    return found


def _compute_bound(
    prims: list[Usd.Prim], purpose: str
) -> tuple[list[UsdShade.Material], list[Usd.Relationship]]:
    materials, relationships = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(prims, purpose)
    return materials, relationships
