# SPDX-License-Identifier: Apache-2.0
"""Looks, collections and variants of a MaterialX document.

As UsdMtlx has them: each look a prim below <root>/Looks with bindings to the collections, and a
variant of the set LookVariant of /ModelRoot; variants of values on the materials themselves.
"""

from collections.abc import Mapping

import MaterialX as mx  # noqa: N813
from pxr import Sdf, Usd, UsdShade

from irt_usd.materialx.values import make_input, set_value, usd_name

_MODEL = Sdf.Path("/ModelRoot")

_Selections = dict[str, str]
"""Variant names by variant set."""


def add_looks(
    stage: Usd.Stage,
    root: Sdf.Path,
    document: mx.Document,
    materials: Mapping[str, UsdShade.Material],
) -> None:
    """Adds what `document` says of looks to `stage`. Raises ValueError."""
    looks = document.getLooks()
    if not looks:
        return
    collections = _Collections(stage, root.AppendChild("Collections"), document)
    for look in looks:
        for assign in look.getMaterialAssigns():
            if assign.getMaterial() in materials:
                _add_variants(document, materials[assign.getMaterial()], _selections(look, assign))
    model = stage.DefinePrim(_MODEL)
    variants = model.GetVariantSets().AddVariantSet("LookVariant")
    for look in looks:
        path = root.AppendChild("Looks").AppendChild(usd_name(look.getName()))
        _add_look(stage, path, look, materials, collections)
        variants.AddVariant(usd_name(look.getName()))
        variants.SetVariantSelection(usd_name(look.getName()))
        with variants.GetVariantEditContext():
            model.GetReferences().AddInternalReference(path)
    variants.ClearVariantSelection()


class _Collections:
    """Collections of one prim, which the looks reference."""

    def __init__(self, stage: Usd.Stage, path: Sdf.Path, document: mx.Document) -> None:
        self.path = path
        self._prim = stage.DefinePrim(path)
        for collection in document.getCollections():
            self._add(collection)

    def name_for(self, assign: mx.MaterialAssign) -> str | None:
        """The collection that `assign` is for; None: the whole look's."""
        if assign.getCollectionString():
            return usd_name(assign.getCollectionString())
        geometry = assign.getActiveGeom()
        if not geometry or geometry == mx.UNIVERSAL_GEOM_NAME:
            return None
        name = f"geom_{assign.getParent().getName()}_{assign.getName()}"
        self._include(Usd.CollectionAPI.Apply(self._prim, usd_name(name)), geometry)
        return usd_name(name)

    def _add(self, collection: mx.Collection) -> None:
        made = Usd.CollectionAPI.Apply(self._prim, usd_name(collection.getName()))
        for included in collection.getIncludeCollections():
            path = Usd.CollectionAPI.GetNamedCollectionPath(
                self._prim, usd_name(included.getName())
            )
            made.CreateIncludesRel().AddTarget(path)
        self._include(made, collection.getIncludeGeom())
        for path in _geometry_paths(collection.getExcludeGeom()):
            made.CreateExcludesRel().AddTarget(path.ReplacePrefix("/", self.path))

    def _include(self, made: Usd.CollectionAPI, geometry: str) -> None:
        for path in _geometry_paths(geometry):
            made.CreateIncludesRel().AddTarget(path.ReplacePrefix("/", self.path))


def _geometry_paths(text: str) -> list[Sdf.Path]:
    """The paths in `text`, which cannot be patterns."""
    names = [part.strip() for part in text.split(",") if part.strip()]
    for name in names:
        if not name.startswith("/") or not Sdf.Path.IsValidPathString(name):
            raise ValueError(f"geometry {name}: expected an absolute path without wildcards")
    return [Sdf.Path(name) for name in names]


def _add_look(
    stage: Usd.Stage,
    path: Sdf.Path,
    look: mx.Look,
    materials: Mapping[str, UsdShade.Material],
    collections: _Collections,
) -> None:
    prim = stage.DefinePrim(path)
    if look.getInheritString():
        parent = path.GetParentPath().AppendChild(usd_name(look.getInheritString()))
        prim.GetReferences().AddInternalReference(parent)
    scope = stage.DefinePrim(path.AppendChild("Materials")).GetPath()
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    order = []
    for assign in look.getMaterialAssigns():
        material = materials.get(assign.getMaterial())
        if material is None:
            place = assign.getNamePath()
            raise ValueError(f"{place}: assigns {assign.getMaterial()}, which is no material of it")
        name = usd_name(assign.getName())
        worn = stage.DefinePrim(scope.AppendChild(name))
        worn.GetReferences().AddInternalReference(material.GetPath())
        for variant_set, variant in _selections(look, assign).items():
            worn.GetVariantSet(variant_set).SetVariantSelection(variant)
        collection = collections.name_for(assign)
        if collection is None:
            binding.Bind(UsdShade.Material(worn))
            order.append(binding.GetDirectBindingRel().GetName())
        else:
            named = Usd.CollectionAPI(prim, collection)
            binding.Bind(named, UsdShade.Material(worn), name)
            order.append(binding.GetCollectionBindingRel(name).GetName())
    prim.GetReferences().AddInternalReference(collections.path)
    if order:
        prim.SetPropertyOrder(order)


def _selections(look: mx.Look, assign: mx.MaterialAssign) -> _Selections:
    """Of the look it inherits, of the look, and of the assignment, later ones stronger."""
    found: _Selections = {}
    for element in [*reversed(_lineage(look)), assign]:
        for chosen in element.getChildren():
            if isinstance(chosen, mx.VariantAssign):
                found[chosen.getVariantSetString()] = chosen.getVariantString()
    return found


def _lineage(look: mx.Look) -> list[mx.Look]:
    found: list[mx.Look] = []
    current = look
    while current is not None:
        if any(current.getName() == known.getName() for known in found):
            raise ValueError(f"{look.getName()}: looks that inherit each other")
        found.append(current)
        current = current.getDocument().getLook(current.getInheritString())
    return found


def _add_variants(
    document: mx.Document, material: UsdShade.Material, selections: _Selections
) -> None:
    for set_name in selections:
        variant_set = document.getVariantSet(set_name)
        if variant_set is None:
            raise ValueError(f"no variant set {set_name}")
        made = material.GetPrim().GetVariantSets().AddVariantSet(usd_name(set_name))
        for variant in variant_set.getVariants():
            made.AddVariant(usd_name(variant.getName()))
            made.SetVariantSelection(usd_name(variant.getName()))
            with made.GetVariantEditContext():
                for given in variant.getInputs():
                    port = make_input(material.ConnectableAPI(), given)
                    set_value(port.GetAttr(), given)
        made.ClearVariantSelection()
