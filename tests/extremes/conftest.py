# SPDX-License-Identifier: Apache-2.0
"""Begins, judges and reports the rows."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from extremes.rows import NewRow, Row

_rows = pytest.StashKey[list[Row]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("numerics")
    group.addoption("--full", action="store_true", help="as many inputs as docs/numerics.md tells")
    group.addoption(
        "--report", type=Path, metavar="FILE", help="write the rows as a table in Markdown"
    )


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_rows] = []


@pytest.fixture
def full(request: pytest.FixtureRequest) -> bool:
    """Whether to measure as much as the report asks, or a part of it."""
    return bool(request.config.getoption("--full"))


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Iterator[NewRow]:
    """Begins a row (what, the unit of its errors, their bound), which is judged at the end."""
    rows: list[Row] = []

    def begin(extreme: str, unit: str, bound: float) -> Row:
        rows.append(Row(extreme, unit, bound))
        return rows[-1]

    yield begin
    request.config.stash[_rows].extend(rows)
    failed = [r for r in rows if not r.passed]
    assert not failed, "\n".join(
        f"{r.extreme}: {r.worst:g} {r.unit}, at most {r.bound:g} allowed: {r.cause}" for r in failed
    )


def pytest_sessionfinish(session: pytest.Session) -> None:
    path: Path | None = session.config.getoption("--report")
    if path is None:
        return
    lines = ["| extreme | error | bound | worst | where |", "| --- | --- | --- | --- | --- |"]
    lines += [
        f"| {r.extreme} | {r.unit} | {r.bound:.2g} | {r.worst:.2g} | {r.where} |"
        for r in session.config.stash[_rows]
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
