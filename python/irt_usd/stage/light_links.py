# SPDX-License-Identifier: Apache-2.0
"""UsdLux's linking: which objects a light does not light, and which cast none of its shadows."""

from collections.abc import Iterable

from pxr import Usd, UsdLux


def unlinked(prim: Usd.Prim, objects: Iterable[str]) -> tuple[set[str], set[str]]:
    """Of `objects` (paths), those that a light does not light, and those without its shadows.

    Collections name prims, and an instance of an array is its instancer's. Sets of prims that
    collections include, nested ones too, count with all that is under them.
    """
    light = UsdLux.LightAPI(prim)
    known = list(objects)
    return (
        _left_out(light.GetLightLinkCollectionAPI(), known),
        _left_out(light.GetShadowLinkCollectionAPI(), known),
    )


def _left_out(collection: Usd.CollectionAPI, objects: Iterable[str]) -> set[str]:
    excludes = collection.GetExcludesRel().HasAuthoredTargets()
    if not excludes and collection.GetIncludeRootAttr().Get() is not False:
        return set()
    query = collection.ComputeMembershipQuery()
    return {path for path in objects if not query.IsPathIncluded(path.split("[", 1)[0])}
