# SPDX-License-Identifier: Apache-2.0
"""`irt verify`."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from irt_usd.cli.errors import STATUS_DIFFERENT
from irt_usd.cli.options import (
    check_isa,
    is_verbose,
    shot_options,
    trace_options,
    use_threads,
    verbosity_options,
)
from irt_usd.cli.render import motion_line

if TYPE_CHECKING:
    from irt_usd.shot.settings import ShotOptions, TraceSettings


@click.command()
@shot_options
@trace_options
@click.option(
    "--brute-force-pixels",
    type=click.IntRange(0, 65536),
    default=16,
    show_default=True,
    help="Pixels of each frame that are traced without any acceleration, too.",
)
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the verdict.")
@verbosity_options
@click.pass_context
def verify(
    ctx: click.Context,
    options: "ShotOptions",
    settings: "TraceSettings",
    brute_force_pixels: int,
    json_path: Path | None,
    strict: bool,
    quiet: bool,
) -> None:
    """Prove that the shot's frames equal full traces of them, bit for bit.

    Renders the range as a shot, and every frame again from nothing, and compares every channel of
    every pixel: beauty and the AOVs asked for, all of them where none is. Exit status 4 if any
    bit differs.
    """
    from irt_usd.aovs import SURFACE_AOVS
    from irt_usd.images.atomic import atomic_file
    from irt_usd.report import Report
    from irt_usd.shot.output import prepare_output
    from irt_usd.shot.products import every_aov
    from irt_usd.shot.progress import shot_progress
    from irt_usd.shot.session import open_shot
    from irt_usd.shot.settings import check_film_size
    from irt_usd.shot.verify import TABLE_HEADER, verify_shot

    check_isa(settings.isa)
    use_threads(settings.threads)
    asked = tuple(name for name in settings.aovs or () if not name.startswith("irt."))
    shot = open_shot(replace(options, aovs=asked or SURFACE_AOVS), Report(strict))
    settings = replace(settings, aovs=asked or every_aov(shot.views))
    for view in shot.views:
        check_film_size(view.framing.size, settings.aovs or ())
    if json_path is not None:
        note = click.echo if is_verbose() else lambda _: None
        prepare_output([json_path], "--json", note, shot.read_files)
    if shot.moves and not quiet:
        click.echo(motion_line(shot))
    with shot_progress(len(shot.frames) * len(shot.views), TABLE_HEADER, quiet) as progress:
        verdict = verify_shot(shot, settings, brute_force_pixels, progress)
    if not (quiet and verdict.exact):
        click.echo(verdict.sentence())
    if json_path is not None:
        with atomic_file(json_path) as temporary:
            text = json.dumps(verdict.to_json(), indent=2, allow_nan=False)
            temporary.write_text(text + "\n", encoding="utf-8")
    if not verdict.exact:
        ctx.exit(STATUS_DIFFERENT)
