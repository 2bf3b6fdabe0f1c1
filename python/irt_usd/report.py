# SPDX-License-Identifier: Apache-2.0
"""What was left out of a rendering, or is worth knowing about it: collected, said once."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from irt_usd.errors import InputError

Severity = Literal["skipped", "unsupported", "mentioned"]

_PATHS_SHOWN = 5
"""How many paths a notice's text lists before it counts the rest."""

_LABELS: dict[Severity, str] = {
    "skipped": "skipped",
    "unsupported": "not supported",
    "mentioned": "note",
}


@dataclass
class Notice:
    """One thing to tell the user, and the prims (or files) that it is about, in order found."""

    severity: Severity
    message: str
    paths: list[str] = field(default_factory=list)
    """A skipped prim's ends in the frame at which it was found out."""

    @property
    def text(self) -> str:
        """One line: "not supported: NURBS curves: /A, /B and 3 more"."""
        line = f"{_LABELS[self.severity]}: {self.message}"
        if self.paths:
            line += ": " + ", ".join(self.paths[:_PATHS_SHOWN])
        more = len(self.paths) - _PATHS_SHOWN
        return f"{line} and {more} more" if more > 0 else line


class Report:
    """Collects notices; one message is one notice, however many prims it concerns.

    With `strict`, what is skipped or not supported becomes fatal: `enforce` raises.
    """

    def __init__(self, strict: bool = False) -> None:
        self.strict = strict
        self._notices: dict[tuple[Severity, str], Notice] = {}
        self._known: set[tuple[Severity, str, str]] = set()
        self._taken: dict[tuple[Severity, str], int] = {}
        """How many paths of a notice were there when it was last taken."""
        self._frame: str | None = None

    def skipped(self, message: str, path: str = "") -> None:
        """A prim that cannot be drawn; `message` says what is wrong with which attribute."""
        self._add("skipped", message, path)

    def unsupported(self, kind: str, path: str = "") -> None:
        """A feature that irt does not have; `kind` names it, the same for every prim."""
        self._add("unsupported", kind, path)

    def mentioned(self, message: str, path: str = "") -> None:
        """Something rendered as it is, that the user may not have meant."""
        self._add("mentioned", message, path)

    @property
    def notices(self) -> list[Notice]:
        """All notices so far, in the order of their first occurrence."""
        return list(self._notices.values())

    def take_new(self) -> list[Notice]:
        """What was not yet there at the last call: notices, and of prims skipped every new one."""
        new = []
        for key, notice in self._notices.items():
            taken = self._taken.get(key)
            if taken is None or (notice.severity == "skipped" and len(notice.paths) > taken):
                new.append(Notice(notice.severity, notice.message, notice.paths[taken or 0 :]))
                self._taken[key] = len(notice.paths)
        return new

    @contextmanager
    def at_frame(self, time: float) -> Iterator[None]:
        """What is skipped in the block is said to be so at frame `time`."""
        self._frame = f"{time:.15g}"
        try:
            yield
        finally:
            self._frame = None

    def enforce(self, consequence: str) -> None:
        """Raises InputError if strict and anything was skipped or is not supported.

        It tells `consequence` and lists them all, which are then taken.
        """
        if not self.strict:
            return
        bad = {k: n for k, n in self._notices.items() if n.severity != "mentioned"}
        if bad:
            self._taken.update({key: len(notice.paths) for key, notice in bad.items()})
            lines = [f"--strict: {consequence}", *(notice.text for notice in bad.values())]
            raise InputError("\n  ".join(lines))

    def _add(self, severity: Severity, message: str, path: str) -> None:
        if (severity, message, path) in self._known:
            return
        self._known.add((severity, message, path))
        notice = self._notices.setdefault((severity, message), Notice(severity, message))
        if path and severity == "skipped" and self._frame is not None:
            path += f" at frame {self._frame}"
        if path:
            notice.paths.append(path)
