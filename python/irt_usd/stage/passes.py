# SPDX-License-Identifier: Apache-2.0
"""UsdRenderPass: the render settings that a pass renders with, and what it makes of prims.

Of its collections `prune` has prims, and all below them, not be there; objects and lights that
`renderVisibility` leaves out are invisible to every ray; those that `cameraVisibility` leaves out
cast shadows and show in mirrors, but not to the camera; those of `matte` are hold-outs: seen by the
camera they are black with an alpha of 0. Membership is UsdCollectionAPI's, nested collections and
expressions included; what a native instance holds goes by the path of its proxy. Relationships
and uniform attributes do not vary with time, and neither does membership.
"""

from collections.abc import Callable
from dataclasses import dataclass

from pxr import Sdf, Usd, UsdRender

from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.stage.attributes import where

_Predicate = Callable[[str], bool]


@dataclass(frozen=True)
class _Shown:
    """A collection of what is shown."""

    includes: _Predicate
    root: bool
    """Whether it holds all but what it excludes."""

    def leaves_out(self, path: str, is_part: bool) -> bool:
        """Whether it does not hold `path`; of a part: though it holds some prim above it."""
        if self.includes(path):
            return False
        above = Sdf.Path(path).GetPrefixes()[:-1]
        return not is_part or self.root or any(self.includes(str(prim)) for prim in above)


@dataclass(frozen=True)
class RenderPass:
    """What a pass makes of prims, by path; without a pass everything is as it is.

    Instances in an array go by their instancer. Parts of its prototypes, which may lie elsewhere,
    go by it too, unless a collection names or excludes them.
    """

    path: str = ""
    """Empty: no pass."""
    settings: str | None = None
    """The RenderSettings of its renderSource; None: it names none."""
    _prunes: _Predicate | None = None
    _rendered: _Shown | None = None
    _seen: _Shown | None = None
    _holds_out: _Predicate | None = None

    def prunes(self, path: str) -> bool:
        """Whether the prim, with all below it, is not there."""
        return self._prunes is not None and self._prunes(path)

    def hides(self, path: str, is_part: bool = False) -> bool:
        """Whether the object or light, or part of a prototype, is invisible to all rays."""
        return self._rendered is not None and self._rendered.leaves_out(path, is_part)

    def role(self, path: str, is_part: bool = False) -> tuple[bool, bool]:
        """Whether the camera sees the object, light or part, and whether it is matte."""
        unseen = self._seen is not None and self._seen.leaves_out(path, is_part)
        return not unseen, self._holds_out is not None and self._holds_out(path)


NO_PASS = RenderPass()


def list_passes(stage: Usd.Stage) -> list[str]:
    """Paths of the stage's RenderPasses."""
    return [str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA(UsdRender.Pass)]


def read_pass(stage: Usd.Stage, wanted: str | None, source: str, report: Report) -> RenderPass:
    """The pass `wanted`, a path or a bare name; None: no pass.

    Raises InputError where there are none of that name or several, its renderSource names no
    render settings, or a collection of its cannot be evaluated.
    """
    if wanted is None:
        return NO_PASS
    found = list_passes(stage)
    named = [path for path in found if wanted in (path, path.rsplit("/", 1)[1])]
    if len(named) != 1:
        listed = "\n  ".join(["its render passes:", *found]) if found else "it has none"
        what = "no" if not named else "several"
        raise InputError(f"{source}: {what} RenderPass '{wanted}'; {listed}")
    return _Reader(stage, stage.GetPrimAtPath(named[0]), source, report).read()


class _Reader:
    def __init__(self, stage: Usd.Stage, prim: Usd.Prim, source: str, report: Report) -> None:
        self._stage = stage
        self._prim = prim
        self._source = source
        self._report = report

    def read(self) -> RenderPass:
        path = str(self._prim.GetPath())
        if self._prim.GetRelationship("inputPasses").GetForwardedTargets():
            self._report.mentioned("inputPasses of a render pass are not rendered with it", path)
        return RenderPass(
            path,
            self._settings(),
            self._members("prune"),
            self._shown("renderVisibility"),
            self._shown("cameraVisibility"),
            self._members("matte"),
        )

    def _settings(self) -> str | None:
        targets = self._prim.GetRelationship("renderSource").GetForwardedTargets()
        place = where(self._prim, "renderSource", Usd.TimeCode.Default())
        file = self._prim.GetAttribute("fileName").Get()
        if file and file.path:
            self._report.unsupported("a render pass's fileName (prims of this stage)", place)
        if not targets:
            self._report.mentioned(
                "a render pass without renderSource: the stage's settings", place
            )
            return None
        target = self._stage.GetPrimAtPath(targets[0])
        if len(targets) > 1 or not target or not target.IsA(UsdRender.Settings):
            listed = ", ".join(f"<{path}>" for path in targets)
            raise InputError(
                f"{self._source}: the pass's renderSource is {listed}; expected one RenderSettings"
                f" prim; mend it or give --settings: {place}"
            )
        return str(targets[0])

    def _query(self, name: str) -> tuple[Usd.CollectionAPI, _Predicate]:
        collection = Usd.CollectionAPI(self._prim, name)
        valid, reason = collection.Validate()
        place = where(self._prim, f"collection:{name}", Usd.TimeCode.Default())
        if not valid:
            raise InputError(
                f"{self._source}: the pass's collection {name} cannot be evaluated:"
                f" {' '.join(reason.split())}; mend it: {place}"
            )
        expression = collection.GetMembershipExpressionAttr()
        if expression.HasAuthoredValue() and not collection.IsInExpressionMode():
            self._report.mentioned(
                "a membershipExpression beside includes, excludes or includeRoot = true is not"
                " read, as USD has it",
                f"{place}",
            )
        for relationship in (collection.GetIncludesRel(), collection.GetExcludesRel()):
            for target in relationship.GetTargets():
                if not self._exists(target):
                    message = "a member of a render pass's collection that does not exist"
                    holder = where(self._prim, relationship.GetName(), Usd.TimeCode.Default())
                    self._report.skipped(message, f"<{target}> of {holder}")
        query = collection.ComputeMembershipQuery()
        return collection, lambda path: bool(query.IsPathIncluded(Sdf.Path(path)))

    def _exists(self, target: Sdf.Path) -> bool:
        prim = self._stage.GetPrimAtPath(target.GetPrimPath())
        if not prim or not target.IsPropertyPath():
            return bool(prim)
        return Usd.CollectionAPI.IsCollectionAPIPath(target) is not None and prim.HasAPI(
            Usd.CollectionAPI, target.name.removeprefix("collection:")
        )

    def _members(self, name: str) -> _Predicate | None:
        collection, includes = self._query(name)
        return None if collection.HasNoIncludedPaths() else includes

    def _shown(self, name: str) -> _Shown | None:
        """None: everything is."""
        collection, includes = self._query(name)
        root = bool(collection.GetIncludeRootAttr().Get()) and collection.IsInRelationshipsMode()
        excludes = collection.GetExcludesRel().GetTargets()
        if root and not excludes and collection.GetExpansionRuleAttr().Get() != "explicitOnly":
            return None
        return _Shown(includes, root)
