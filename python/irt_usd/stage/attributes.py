# SPDX-License-Identifier: Apache-2.0
"""The attributes of one prim, of which only those that can vary are read again."""

from collections.abc import Iterable, Sequence
from functools import cache

from pxr import Sdf, Usd

from irt_usd.report import Report
from irt_usd.stage.values import Value, coerced, plain, same_bits


@cache
def _fallback(type_name: str, attribute: str) -> Value:
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(type_name)
    return plain(definition.GetAttributeFallbackValue(attribute)) if definition else None


def authored_properties(prim: Usd.Prim, in_clips: bool) -> frozenset[str]:
    """Names of the properties that something is said of, in value clips alone if `in_clips`."""
    names = prim.GetAuthoredPropertyNames()
    if in_clips:
        names += [a.GetName() for a in prim.GetAttributes() if a.HasAuthoredValue()]
    return frozenset(names)


class Attributes:
    """Values by attribute name; unauthored ones have their schema's fallback, else None.

    A value of another type than its schema's is reported, and the fallback takes its place.
    `in_clips`: whether value clips may give values to what is declared nowhere else. `schema`: the
    prim type whose fallbacks hold; None: the prim's own.
    """

    def __init__(
        self,
        prim: Usd.Prim,
        names: Iterable[str],
        report: Report,
        in_clips: bool = False,
        schema: str | None = None,
    ) -> None:
        self.prim = prim
        self._report = report
        self.values: dict[str, Value] = {}
        self._varying: dict[str, Usd.AttributeQuery] = {}
        self._interrupted = False
        """Whether the last update failed midway: what it had read by then counts as changed."""
        authored = authored_properties(prim, in_clips)
        self._schema = schema or str(prim.GetTypeName())
        for name in names:
            if name not in authored:
                self.values[name] = _fallback(self._schema, name)
                continue
            query = Usd.AttributeQuery(prim, name)
            if query.ValueMightBeTimeVarying():
                self._varying[name] = query
                self.values[name] = None
            else:
                self.values[name] = self._get(name, query, Usd.TimeCode.EarliestTime())

    @property
    def vary(self) -> bool:
        """Whether any value can differ between frames."""
        return bool(self._varying)

    def update(self, time: Usd.TimeCode) -> bool:
        """Reads what can vary at `time`; returns whether any bit differs from before."""
        changed = self._interrupted
        self._interrupted = True
        for name, query in self._varying.items():
            value = self._get(name, query, time)
            if not same_bits(value, self.values[name]):
                self.values[name] = value
                changed = True
        self._interrupted = False
        return changed

    def _get(self, name: str, query: Usd.AttributeQuery, time: Usd.TimeCode) -> Value:
        authored = plain(query.Get(time))
        fallback = _fallback(self._schema, name)
        if authored is None:
            # USD gives nothing for a blocked time sample; elsewhere a block means the fallback.
            return fallback
        value = coerced(authored, fallback)
        if value is None:
            message = f"the value is of another type than {name} has; its fallback is rendered"
            self._report.skipped(message, where(self.prim, name, time))
            return fallback
        return value


def where(prim: Usd.Prim, attribute: str, time: Usd.TimeCode) -> str:
    """The text '/Prim.attribute in /file.usda', of the file whose opinion holds at `time`.

    Without an opinion on the attribute (or relationship), of the file that has the prim.
    """
    opinions = prim.GetProperty(attribute).GetPropertyStack(time)
    return f"{prim.GetPath()}.{attribute}{_in_file(opinions or prim.GetPrimStack())}"


def prim_location(prim: Usd.Prim) -> str:
    """The text '/Prim in /file.usda', of the file with the strongest opinion on the prim."""
    return f"{prim.GetPath()}{_in_file(prim.GetPrimStack())}"


def _in_file(opinions: Sequence[Sdf.Spec]) -> str:
    if not opinions:
        return ""
    layer = opinions[0].layer
    return f" in {layer.realPath or layer.identifier}"
