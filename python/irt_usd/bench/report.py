# SPDX-License-Identifier: Apache-2.0
"""`irt bench trace` as tables and as JSON."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from irt_usd import _core
from irt_usd.bench.peers import PeerResult
from irt_usd.bench.timing import Figure
from irt_usd.bench.trace import TraceResult


def machine() -> dict[str, Any]:
    """What the figures depend on: processor, how many, and how busy they are with other work."""
    model = ""
    for line in Path("/proc/cpuinfo").read_text(encoding="ascii").splitlines():
        if line.startswith("model name"):
            model = line.split(":", 1)[1].strip()
            break
    return {
        "processor": model,
        "processors": len(os.sched_getaffinity(0)),
        "load_average": os.getloadavg()[0],
        "versions": _core.versions(),
    }


def figure_table(results: Sequence[TraceResult], peers: Sequence[PeerResult]) -> Table:
    """Every ratio beside its floor and aim."""
    table = Table(title="Ratios: medians and ranges (higher is better)")
    for column in ("scene", "figure"):
        table.add_column(column)
    for column in ("median", "range", "floor", "aim"):
        table.add_column(column, justify="right")
    table.add_column("")
    for result in results:
        _add_figures(table, result.scene, result.figures)
    for peer in peers:
        _add_figures(table, peer.scene, peer.figures)
    return table


def speed_table(results: Sequence[TraceResult], peers: Sequence[PeerResult]) -> Table:
    """Rays, or paths, a second."""
    table = Table(title="Millions a second")
    table.add_column("scene")
    table.add_column("what")
    table.add_column("rays", justify="right")
    table.add_column("paths", justify="right")
    for result in results:
        _add_speeds(table, result.scene, result.rays_per_second, peers=False)
    for peer in peers:
        image = f"direct light, {peer.threads} threads: "
        speeds = {image + name: speed for name, speed in peer.paths_per_second.items()}
        _add_speeds(table, peer.scene, speeds, peers=True)
    return table


def remarks(results: Iterable[TraceResult], peers: Sequence[PeerResult]) -> list[str]:
    """What the tables rest on, line by line."""
    lines = []
    for result in results:
        width, height = result.size
        rays = ", ".join(f"{count:,} {kind}" for kind, count in result.rays.items() if count)
        lines.append(f"{result.scene}: {result.contents}; {width}x{height}; rays: {rays}")
    for peer in peers:
        for variant, difference in peer.differences.items():
            lines.append(
                f"{peer.scene}, Mitsuba {peer.version} {variant}: its image differs from ours by"
                f" {difference:.2%} (means of 8x8 pixels, {peer.samples} samples a pixel)"
            )
        for variant, why in peer.absent.items():
            lines.append(f"{peer.scene}: Mitsuba's {variant} is left out: {why}")
    return lines


def to_json(
    results: Sequence[TraceResult], peers: Sequence[PeerResult], repeats: int, isa: str
) -> dict[str, Any]:
    """All of it; `peers` is empty where Mitsuba did not run."""
    return {
        "machine": machine(),
        "isa": isa,
        "repeats": repeats,
        "scenes": [result.to_json() for result in results],
        "peers": [peer.to_json() for peer in peers],
    }


def _add_figures(table: Table, scene: str, figures: Sequence[Figure]) -> None:
    for figure in figures:
        ratio = figure.ratio
        style = "red" if figure.verdict == "floor missed" else None
        table.add_row(
            scene,
            figure.name,
            f"{ratio.median:.2f}",
            f"{ratio.low:.2f}-{ratio.high:.2f}",
            *("" if target is None else f"{target:g}" for target in (figure.floor, figure.aim)),
            figure.verdict,
            style=style,
        )
    table.add_section()


def _add_speeds(table: Table, scene: str, speeds: dict[str, float], peers: bool) -> None:
    for name, speed in speeds.items():
        cells = (f"{speed / 1e6:.2f}", "")
        table.add_row(scene, name, *(reversed(cells) if peers else cells))
    table.add_section()
