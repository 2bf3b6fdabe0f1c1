# SPDX-License-Identifier: Apache-2.0
"""`irt render`."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from irt_usd.cli.options import (
    check_isa,
    is_verbose,
    shot_options,
    trace_options,
    use_threads,
    verbosity_options,
)

if TYPE_CHECKING:
    from irt_usd.images.exr import PixelType
    from irt_usd.shot.session import Shot
    from irt_usd.shot.settings import ShotOptions, TraceSettings
    from irt_usd.shot.tracer import History


@click.command()
@shot_options
@trace_options
@click.option(
    "-o",
    "--output",
    metavar="PATTERN",
    help="#### (or ###.###, $F4, %04d) is the frame, <product> the render product's name; by"
    " default the products' own names, or out/<stage>.####.exr.",
)
@click.option(
    "--exr-type",
    "pixel_type",
    type=click.Choice(["half", "float"]),
    default="half",
    show_default=True,
    help="Of colours; depth, normals and positions are float in any case.",
)
@click.option(
    "--history",
    type=click.Choice(["full", "none"]),
    default="full",
    show_default=True,
    help="none traces every frame in full.",
)
@click.option(
    "--stats", type=click.Path(path_type=Path), help="Write one JSON object a frame to this file."
)
@click.option("--skip-existing", is_flag=True, help="Leave out frames whose file exists.")
@click.option("--list-cameras", is_flag=True, help="Print the stage's cameras and exit.")
@verbosity_options
def render(
    options: "ShotOptions",
    settings: "TraceSettings",
    output: str | None,
    pixel_type: "PixelType",
    history: "History",
    stats: Path | None,
    strict: bool,
    skip_existing: bool,
    list_cameras: bool,
    quiet: bool,
) -> None:
    """Render a USD shot into a sequence of EXR files.

    What is not given here the stage's render settings say: every product of theirs is rendered,
    with its camera, resolution, vars and name. What is given here wins over them.
    """
    from irt_usd import stage
    from irt_usd.report import Report
    from irt_usd.shot.frames import count_frames, format_frames, parse_frames
    from irt_usd.shot.output import output_paths, parse_pattern, prepare_output
    from irt_usd.shot.products import PRODUCT_TOKEN, shot_paths, view_aovs
    from irt_usd.shot.progress import shot_progress
    from irt_usd.shot.render import TABLE_HEADER, OutputOptions, render_shot
    from irt_usd.shot.session import open_shot, opening
    from irt_usd.shot.settings import check_film_size

    if list_cameras:
        cameras = stage.list_cameras(stage.open_stage(options.stage, opening(options)))
        for path in cameras:
            click.echo(path)
        if not cameras:
            click.echo(f"irt: {options.stage}: no camera", err=True)
        return
    check_isa(settings.isa)
    use_threads(settings.threads)
    if output is not None:
        pattern = parse_pattern(output.replace(PRODUCT_TOKEN, "product"))
        if options.frames is not None:  # refused before the stage is opened
            output_paths(pattern, parse_frames(options.frames))
    shot = open_shot(options, Report(strict))
    for view in shot.views:
        check_film_size(view.framing.size, view_aovs(view, settings))
    paths = shot_paths(shot, output)
    wanted = [
        (frame, files)
        for frame, files in zip(shot.frames, paths, strict=True)
        if not (skip_existing and all(map(_exists, files)))
    ]
    if not quiet:
        click.echo(_headline(shot, format_frames(shot.frames)))
        if len(wanted) < len(shot.frames):
            count = len(shot.frames) - len(wanted)
            exist = "exists already and is" if count == 1 else "exist already and are"
            click.echo(f"{count_frames(count)} {exist} skipped")
    if not wanted:
        return
    note = click.echo if is_verbose() and not quiet else lambda _: None
    kept = shot.layer_files
    files = [file for _, files in wanted for file in files]
    prepare_output(files, "--output", note, kept)
    if stats is not None:
        every = [file for files in paths for file in files]
        prepare_output([stats], "--stats", note, [*kept, *every])
    out = OutputOptions([files for _, files in wanted], pixel_type, history, stats)
    with shot_progress(len(wanted) * len(shot.views), TABLE_HEADER, quiet) as progress:
        render_shot(shot, [frame for frame, _ in wanted], settings, out, progress)
    if not quiet:
        click.echo(f"done: {count_frames(len(wanted))} in {out.paths[0][0].parent}")


def _exists(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that no file can have; writing will say so
        return False


def _headline(shot: "Shot", frames: str) -> str:
    lines = [f"{shot.options.stage}: frames {frames}"]
    for view in shot.views:
        width, height = view.framing.size
        image = f"{width}x{height}, camera {view.camera}"
        if len(shot.views) == 1:
            lines = [f"{lines[0]}, {image}"]
        else:
            lines.append(f"  {view.product.path}: {image}")
    return "\n".join([*lines, motion_line(shot)] if shot.moves else lines)


def motion_line(shot: "Shot") -> str:
    """Where the camera moves, and what comes of it."""
    from irt_usd.shot.frames import format_frames

    return f"irt: the camera moves at frames {format_frames(shot.moves)}: those are traced in full"
