# SPDX-License-Identifier: Apache-2.0
"""`irt bench`: measurements of speed."""

import json
import os
from pathlib import Path

import click

from irt_usd.cli.options import ISAS, check_isa, is_verbose, parse_size, verbosity_options

_SCENES = ("quadrics", "triangles", "pieces", "instances")
_PEER_SCENES = ("triangles", "pieces")
"""Those of nothing but meshes, which are all that Mitsuba has in common with us."""


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
@click.option(
    "--repeats",
    type=click.IntRange(1, 1000),
    default=7,
    show_default=True,
    help="Rounds; medians are shown.",
)
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
    from irt_usd.images.atomic import atomic_file
    from irt_usd.shot.output import prepare_output

    check_isa(isa)
    pixels = parse_size(size) if size is not None else None
    names = (scene,) if scene is not None else _SCENES
    if json_path is not None:
        prepare_output([json_path], "--json", click.echo if is_verbose() else lambda _: None)

    def say(text: str) -> None:
        if not quiet:
            click.echo(text, err=True)

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
        with atomic_file(json_path) as temporary:
            text = json.dumps(to_json(results, compared, repeats, isa), indent=2, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
    if not quiet:
        console = Console()
        console.print(figure_table(results, compared))
        console.print(speed_table(results, compared))
        for line in remarks(results, compared):
            console.print(line, highlight=False, markup=False, soft_wrap=True)
