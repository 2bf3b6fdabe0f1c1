# SPDX-License-Identifier: Apache-2.0
"""One walk over the stage: what is there to render, and what is there that is not rendered."""

from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial

from pxr import Usd, UsdGeom, UsdLux, UsdVol

from irt_usd.report import Report
from irt_usd.stage import lights, quadrics
from irt_usd.stage.diagnostics import attempt
from irt_usd.stage.transforms import Hierarchy, Node

_NOT_RENDERED = {
    "NurbsCurves": "NURBS curves",
    "HermiteCurves": "Hermite curves",
    "NurbsPatch": "NURBS patches",
    "TetMesh": "tetrahedral meshes",
    "Volume": "volumes",
}

POINT_BASED = ("Mesh", "Points", "BasisCurves")

_LEAVES = frozenset(("PointInstancer", "Volume", "Material", "NodeGraph", "Shader"))
"""Types whose descendants are theirs to interpret: prototypes, fields, shader nodes."""


@dataclass
class Survey:
    """What the stage holds, in stage order."""

    hierarchy: Hierarchy
    objects: list[Node] = field(default_factory=list)
    lights: list[Node] = field(default_factory=list)
    subsets: set[str] = field(default_factory=set)
    """Paths of prims that have GeomSubsets."""
    instancers: list[Node] = field(default_factory=list)
    mesh_lights: list[Node] = field(default_factory=list)
    """Of `objects` the meshes that are lights."""


_Predicate = Callable[[str], bool]


def stage_prims(stage: Usd.Stage, prunes: _Predicate | None = None) -> Iterator[Usd.Prim]:
    """The prims that can have a part in a picture, parents first, instances' own included.

    `prunes`: which, by path, are left out with all below them.
    """
    return _pruned(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()), prunes)


def survey(
    stage: Usd.Stage,
    purposes: Container[str],
    report: Report,
    prunes: _Predicate | None = None,
) -> Survey:
    """Walks active, defined, loaded prims; of what is rendered, lists the given purposes.

    What is inside native instances is listed too, each an object of its own, under its own path.
    `prunes` is as in stage_prims.
    """
    found = Survey(Hierarchy(report))
    _walk(stage_prims(stage, prunes), found, purposes, report)
    return found


def survey_prototype(
    root: Usd.Prim,
    hierarchy: Hierarchy,
    purposes: Container[str],
    report: Report,
    prunes: _Predicate | None = None,
) -> Survey:
    """What is drawn at and under the prototype `root` of a point instancer.

    Its nodes join `hierarchy`; their world is the space of the root's parent. Prototypes may be
    `over`s and classes. Lights among them are not lights of the shot.
    """
    found = Survey(hierarchy)
    predicate = Usd.PrimIsActive & Usd.PrimIsLoaded
    _walk(
        _pruned(Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate)), prunes),
        found,
        purposes,
        report,
        root.GetPath().pathElementCount - 1,
    )
    for light in (*found.lights, *found.mesh_lights):
        report.unsupported("lights in prototypes", light.path)
    return found


def _pruned(prims: Usd.PrimRange, prunes: _Predicate | None) -> Iterator[Usd.Prim]:
    walk = iter(prims)
    for prim in walk:
        if prunes is not None and prunes(str(prim.GetPath())):
            walk.PruneChildren()
            continue
        if str(prim.GetTypeName()) in _LEAVES:
            walk.PruneChildren()
        yield prim


def _walk(
    prims: Iterable[Usd.Prim],
    found: Survey,
    purposes: Container[str],
    report: Report,
    depth: int = 0,
) -> None:
    """Sorts `prims`, parents first, the first of them `depth` levels below the stage's root."""
    ancestors: list[Node | None] = []
    for prim in prims:
        path = prim.GetPath()
        del ancestors[path.pathElementCount - depth - 1 :]
        parent = ancestors[-1] if ancestors else None
        kind = str(prim.GetTypeName())
        unread = bool(ancestors) and parent is None
        node = None if unread else attempt(partial(Node, prim, str(path), parent), prim, report)
        ancestors.append(node)
        if node is None:
            continue
        found.hierarchy.nodes.append(node)
        if (node.purpose or "default") in purposes:
            _sort(node, kind, found, report)


def _sort(node: Node, kind: str, found: Survey, report: Report) -> None:
    prim = node.prim
    if kind in quadrics.LENGTHS or kind in POINT_BASED:
        found.objects.append(node)
        found.hierarchy.require(node)
        if kind == "Mesh" and prim.HasAPI(UsdLux.LightAPI):
            found.mesh_lights.append(node)
        elif prim.HasAPI(UsdLux.LightAPI):
            report.unsupported(f"lights made of {kind} (rendered as geometry)", node.path)
    elif kind in lights.KINDS:
        found.lights.append(node)
        found.hierarchy.require(node)
    elif kind == "PointInstancer":
        found.instancers.append(node)
        found.hierarchy.require(node)
    elif kind == "GeomSubset":
        if node.parent is not None:
            found.subsets.add(node.parent.path)
    elif kind in _NOT_RENDERED:
        report.unsupported(_NOT_RENDERED[kind], node.path)
    elif not kind or kind in ("Xform", "Scope"):
        return
    elif prim.HasAPI(UsdLux.LightAPI):
        report.unsupported(f"{kind} lights", node.path)
    elif prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdVol.Volume):
        report.unsupported(f"{kind} prims", node.path)
