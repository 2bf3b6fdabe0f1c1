# SPDX-License-Identifier: Apache-2.0
"""`irt bench`: measurements of speed."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from irt_usd.cli.options import (
    ISAS,
    check_isa,
    is_verbose,
    parse_size,
    shot_options,
    trace_options,
    verbosity_options,
)
from irt_usd.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from irt_usd.shot.settings import ShotOptions, TraceSettings

_SCENES = ("quadrics", "triangles", "pieces", "instances")
_PEER_SCENES = ("triangles", "pieces")
"""Those of nothing but meshes, which are all that Mitsuba has in common with us."""
_PAPER_WIDTH = 140
"""Characters that the paper's tables need where the output is no terminal."""


_repeats_option = click.option(
    "--repeats",
    type=click.IntRange(1, 1000),
    default=7,
    show_default=True,
    help="Rounds; medians are shown.",
)


@click.group()
def bench() -> None:
    """Measure speed on this machine."""


@bench.command()
@click.option("--scene", type=click.Choice(_SCENES), help="One scene; by default all of them.")
@click.option(
    "--scenes",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("build/bench"),
    show_default=True,
    help="Where `make bench` put the stages.",
)
@_repeats_option
@click.option("--size", metavar="WxH", help="Pixels; by default the stages'.")
@click.option("--isa", type=click.Choice(ISAS), default="avx2", show_default=True)
@click.option("--no-peers", is_flag=True, help="Leave Mitsuba 3 out even where it is installed.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the figures.")
@verbosity_options
def trace(
    scene: str | None,
    folder: Path,
    repeats: int,
    size: str | None,
    isa: str,
    no_peers: bool,
    json_path: Path | None,
    quiet: bool,
) -> None:
    """Compare tracing with Embree's bare loop over the same rays, and with Mitsuba 3.

    The figures of one thread count that thread's processor time, so that other work on the machine
    shows little; all others go by the clock and want a machine of their own.
    """
    from rich.console import Console

    from irt_usd.bench import peers as peer
    from irt_usd.bench.report import figure_table, remarks, speed_table, to_json
    from irt_usd.bench.scenes import load_scene
    from irt_usd.bench.trace import measure_scene
    from irt_usd.shot.output import prepare_output

    check_isa(isa)
    pixels = parse_size(size) if size is not None else None
    names = (scene,) if scene is not None else _SCENES
    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)

    say = _sayer(quiet)
    results, compared = [], []
    for name in names:
        loaded = load_scene(name, folder, pixels)
        results.append(measure_scene(loaded, repeats, isa, say))
        if name in _PEER_SCENES and not no_peers:
            if peer.is_installed():
                threads = min(2, len(os.sched_getaffinity(0)))
                compared.append(peer.compare(loaded, repeats, threads, say))
            else:
                say("Mitsuba 3 is not installed; in irt's source folder: pip install .[bench]")
    if json_path is not None:
        _write_json(json_path, to_json(results, compared, repeats, isa))
    if not quiet:
        console = Console()
        console.print(figure_table(results, compared))
        console.print(speed_table(results, compared))
        for line in remarks(results, compared):
            console.print(line, highlight=False, markup=False, soft_wrap=True)


@bench.command()
@click.option("--size", metavar="WxH", default="512x384", show_default=True, help="Pixels.")
@click.option(
    "--scenes",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("shots/paper"),
    show_default=True,
    help="Where the stages of shots/paper/make_paper.py are.",
)
@_repeats_option
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the figures.")
@verbosity_options
def paper(size: str, folder: Path, repeats: int, json_path: Path | None, quiet: bool) -> None:
    """Measure the tables of "Incremental Ray Tracing" (1990) beside the paper's own figures.

    Updates and full traces count from applying the change to the finished film, without files, on
    all threads of the machine. All times go by the clock and want a machine of their own.
    """
    from irt_usd.bench.paper.run import measure
    from irt_usd.bench.paper.tables import remarks, tables
    from irt_usd.bench.report import machine
    from irt_usd.shot.output import prepare_output

    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)
    result = measure(folder, parse_size(size), repeats, _sayer(quiet))
    if json_path is not None:
        _write_json(json_path, result.to_json(machine()))
    if not quiet:
        console = _wide_console()
        for table in tables(result):
            console.print(table)
        for line in remarks(result):
            console.print(line, highlight=False, markup=False, soft_wrap=True)


@bench.command("open")
@shot_options
@_repeats_option
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the figures.")
@verbosity_options
def open_command(
    options: "ShotOptions",
    repeats: int,
    json_path: Path | None,
    strict: bool,  # noqa: ARG001 (what is left out takes no time)
    quiet: bool,
) -> None:
    """Measure the time from a stage's name to its first ray: USD's, irt's own, the core's trees."""
    from irt_usd.bench.reading import measure_opening
    from irt_usd.bench.report import machine
    from irt_usd.shot.output import prepare_output

    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)
    found = measure_opening(options, repeats, _sayer(quiet))
    if json_path is not None:
        _write_json(json_path, {"machine": machine(), **found.to_json()})
    for name, spread in found.rows():
        click.echo(f"{name:<28} {spread.median:8.3f} s  ({spread.low:.3f} to {spread.high:.3f})")


@bench.command("changes")
@click.option("--prims", type=click.IntRange(1, 10**6), default=10_000, show_default=True)
@click.option(
    "--moving",
    type=click.IntRange(1, 10**6),
    default=10,
    show_default=True,
    help="Prims that move in every frame.",
)
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the figures.")
@verbosity_options
def changes_command(
    prims: int,
    moving: int,
    json_path: Path | None,
    quiet: bool,  # noqa: ARG001 (all that is printed was asked for)
) -> None:
    """Measure how long it takes to find what changes in a frame of a stage of many prims."""
    from irt_usd.bench.reading import measure_changes
    from irt_usd.bench.report import machine
    from irt_usd.shot.output import prepare_output

    if moving > prims:
        raise InputError(f"--moving {moving}: there are {prims} prims; give at most that")
    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)
    found = measure_changes(prims, moving)
    if json_path is not None:
        _write_json(json_path, {"machine": machine(), **found.to_json()})
    spread = found.milliseconds
    click.echo(
        f"{found.prims} prims, {found.moving} of them moving: the change set of a frame in"
        f" {spread.median:.2f} ms ({spread.low:.2f} to {spread.high:.2f}, {found.frames} frames)"
    )


@bench.command("aovs")
@shot_options
@trace_options
@_repeats_option
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the figures.")
@verbosity_options
def aovs_command(
    options: "ShotOptions",
    settings: "TraceSettings",
    repeats: int,
    json_path: Path | None,
    strict: bool,  # noqa: ARG001 (what is left out takes no time)
    quiet: bool,
) -> None:
    """Measure what all AOVs together cost, what of writing tracing hides, what cameras share.

    All times go by the clock and want a machine of their own.
    """
    from irt_usd.bench.aovs import measure_aovs
    from irt_usd.bench.report import machine
    from irt_usd.shot.output import prepare_output

    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)
    found = measure_aovs(options, settings, repeats, _sayer(quiet))
    if json_path is not None:
        _write_json(json_path, {"machine": machine(), **found.to_json()})
    for row in found.rows():
        click.echo(row)


def _sayer(quiet: bool) -> Callable[[str], None]:
    """Says what is under way on standard error, or nothing."""
    return (lambda _: None) if quiet else (lambda text: click.echo(text, err=True))


def _write_json(path: Path, content: dict[str, Any]) -> None:
    from irt_usd.images.atomic import atomic_file

    with atomic_file(path) as temporary:
        text = json.dumps(content, indent=2, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def _wide_console() -> "Console":
    """One whose tables are whole where the output is a file or a pipe."""
    from rich.console import Console

    console = Console()
    return console if console.is_terminal else Console(width=_PAPER_WIDTH)
