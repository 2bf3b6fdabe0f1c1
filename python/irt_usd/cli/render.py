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
    from irt_usd.shot.output import OutputPattern
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
    help="#### (or ###.###, $F4, %04d) is the frame; by default out/<stage>.####.exr.",
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
    """Render a USD shot into a sequence of EXR files."""
    from irt_usd import stage
    from irt_usd.report import Report
    from irt_usd.shot.frames import count_frames, format_frames, parse_frames
    from irt_usd.shot.output import default_pattern, output_paths, parse_pattern, prepare_output
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
    pattern: OutputPattern | None = parse_pattern(output) if output is not None else None
    if pattern is not None and options.frames is not None:
        output_paths(pattern, parse_frames(options.frames))  # refused before the stage is opened
    shot = open_shot(options, Report(strict))
    check_film_size(shot.size, settings.aovs)
    paths = output_paths(pattern or default_pattern(options.stage, shot.frames), shot.frames)
    wanted = [
        (frame, path)
        for frame, path in zip(shot.frames, paths, strict=True)
        if not (skip_existing and _exists(path))
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
    prepare_output([path for _, path in wanted], "--output", note, kept)
    if stats is not None:
        prepare_output([stats], "--stats", note, [*kept, *paths])
    out = OutputOptions([path for _, path in wanted], pixel_type, history, stats)
    with shot_progress(len(wanted), TABLE_HEADER, quiet) as progress:
        render_shot(shot, [frame for frame, _ in wanted], settings, out, progress)
    if not quiet:
        click.echo(f"done: {count_frames(len(wanted))} in {out.paths[0].parent}")


def _exists(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that no file can have; writing will say so
        return False


def _headline(shot: "Shot", frames: str) -> str:
    width, height = shot.size
    line = f"{shot.options.stage}: frames {frames}, {width}x{height}, camera {shot.camera_path}"
    return f"{line}\n{motion_line(shot)}" if shot.camera_moves else line


def motion_line(shot: "Shot") -> str:
    """Where the camera moves, and what comes of it."""
    from irt_usd.shot.frames import format_frames

    return (
        f"irt: the camera moves at frames {format_frames(shot.camera_moves)}:"
        " those are traced in full"
    )
