# SPDX-License-Identifier: Apache-2.0
"""`irt bench paper` as tables: ours, the paper's, and what is asked for."""

from collections.abc import Iterator

from rich.table import Table

from irt_usd.bench.paper import published
from irt_usd.bench.paper.result import EditResult, PaperResult, SceneResult, light_figure
from irt_usd.bench.timing import Figure

_LABELS = {
    "full": "full trace",
    "move_1": "move 1",
    "move_2": "move 2",
    "resize": "resize",
    "light": "light moved",
    "color": "colour",
}
_MISSED = "red"
_TARGETS = ("paper", "floor", "aim")


def tables(result: PaperResult) -> Iterator[Table]:
    """The five tables in order, the last with the initial step."""
    yield _table_1(result)
    yield _table_2(result.scenes["chess_shadows"])
    yield _table_3(result)
    yield _table_4(result)
    yield _table_5(result)


def remarks(result: PaperResult) -> Iterator[str]:
    """What the tables rest on, line by line."""
    width, height = result.size
    yield f"{width}x{height}, 1 sample, medians of {result.repeats} rounds; films equal bit for bit"
    for name, scene in result.scenes.items():
        speeds = ", ".join(f"{k} {v / 1e6:.2f}" for k, v in scene.rays_per_second().items())
        yield (
            f"{name}: mean tree level {scene.level:.2f}; million rays/s: {speeds};"
            f" an empty update takes {scene.empty_share:.5f} of a full trace"
        )


def _table(title: str, left: tuple[str, ...], right: tuple[str, ...]) -> Table:
    table = Table(title=title)
    for column in left:
        table.add_column(column)
    for column in right:
        table.add_column(column, justify="right")
    return table


def _table_1(result: PaperResult) -> Table:
    columns = ("ms", "ratio", "range", "by CPU", "with files", "ceiling", *_TARGETS)
    table = _table("Table 1: full trace over update", ("scene", "edit"), columns)
    table.add_column("")
    for name, scene in result.scenes.items():
        table.add_row(name, _LABELS["full"], f"{1e3 * scene.times.full_seconds:.2f}")
        for edit, entry in scene.edits.items():
            paper = published.ratio(name, edit)
            _add_ratio(table, (name, _LABELS[edit]), entry, paper, scene.figure(edit))
        table.add_section()
    return table


def _table_2(scene: SceneResult) -> Table:
    kinds = {"nodes_traversed": "nodes", "intersections": "tests", "shadings": "shadings"}
    columns = [column for kind in kinds.values() for column in (kind, "paper")]
    table = _table(
        f"Table 2: shares of the full trace, {scene.name} (tests: of rays against primitives)",
        ("edit",),
        (*columns, "new rays", "waste", "tested/changed", "from history"),
    )
    full = scene.work.full
    whole = [c for kind in kinds for c in (f"{getattr(full, kind):,}", "")]
    table.add_row(_LABELS["full"], *whole, f"{scene.work.tree_rays:,}")
    for edit, counts in scene.work.edits.items():
        row, missed = [], counts.waste > published.MOST_WASTE
        for kind in kinds:
            ours, paper = scene.work.share(edit, kind), published.share(edit, kind)
            most = published.MOST_INTERSECTIONS if kind == "intersections" else 1.0
            missed = missed or ours > most * paper
            row += [f"{ours:.4f}", f"{paper:.4f}"]
        row += [f"{counts.new_rays:,}", f"{counts.waste:.2f}"]
        row += [_number(counts.tested_over_changed), _number(counts.from_history)]
        table.add_row(_LABELS[edit], *row, style=_MISSED if missed else None)
    return table


def _table_3(result: PaperResult) -> Table:
    columns = ("ms", "ratio", "range", "by CPU", "with files", "ceiling", *_TARGETS)
    table = _table("Table 3: lights moved of three, chess with shadows", ("lights",), columns)
    table.add_column("")
    for moved, entry in result.lights.items():
        paper = published.lights_ratio(int(moved))
        _add_ratio(table, (moved,), entry, paper, light_figure(entry, paper))
    return table


def _table_4(result: PaperResult) -> Table:
    table = _table(
        "Table 4: spread over the cells, (max - min) / max",
        ("scene", "what"),
        ("rays", "history (paper)", "seconds", "time (paper)"),
    )
    for name, scene in result.scenes.items():
        paper = published.SPREADS.get(name)
        table.add_row(
            name,
            "initial step",
            f"{scene.rays_spread:.4f}",
            _number(paper.history if paper else None, 3),
            f"{scene.time_spread:.3f}",
            _number(paper.time if paper else None, 3),
            style=_MISSED if scene.rays_spread > published.MOST_SPREAD else None,
        )
        for edit in scene.edits:
            rays, seconds = scene.update_rays_spread(edit), scene.update_time_spread(edit)
            table.add_row(name, _LABELS[edit], f"{rays:.3f}", "", f"{seconds:.3f}", "")
        table.add_section()
    return table


def _table_5(result: PaperResult) -> Table:
    table = _table(
        "Table 5: the history, and what the initial step takes over tracing without one",
        ("scene", "kind"),
        (
            "count",
            "MB",
            "bytes a pixel",
            "a node",
            "a point",
            "a node (paper)",
            "overhead",
            "by CPU",
        ),
    )
    for name, scene in result.scenes.items():
        for kind, size in scene.kinds().items():
            count = "" if size["count"] is None else f"{size['count']:,}"
            table.add_row(name, kind, count, f"{(size['bytes'] or 0) / 1e6:.2f}")
        paper = published.HISTORY.get(name)
        large = paper is not None and scene.bytes_per_point > paper.bytes_per_node
        table.add_row(
            name,
            "all",
            "",
            f"{scene.history_bytes / 1e6:.2f}",
            f"{scene.history_bytes / scene.pixels:.0f}",
            f"{scene.bytes_per_node:.0f}",
            f"{scene.bytes_per_point:.0f}",
            _number(paper.bytes_per_node if paper else None, 0),
            f"{scene.overhead:.2f}",
            f"{scene.processor_overhead:.2f}",
            style=_MISSED if large or scene.overhead > published.MOST_OVERHEAD else None,
        )
        table.add_section()
    return table


def _add_ratio(
    table: Table, head: tuple[str, ...], entry: EditResult, paper: float | None, figure: Figure
) -> None:
    ratio = figure.ratio
    table.add_row(
        *head,
        f"{1e3 * entry.times.seconds:.2f}",
        f"{ratio.median:.2f}",
        f"{ratio.low:.2f}-{ratio.high:.2f}",
        f"{entry.times.processor_ratio.median:.2f}",
        f"{entry.times.whole_frame_ratio.median:.2f}",
        *(_number(value) for value in (entry.ceiling, paper, figure.floor, figure.aim)),
        figure.verdict,
        style=_MISSED if figure.verdict == "floor missed" else None,
    )


def _number(value: float | None, digits: int = 2) -> str:
    return "" if value is None else f"{value:.{digits}f}"
