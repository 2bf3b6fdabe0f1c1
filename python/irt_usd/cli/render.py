# SPDX-License-Identifier: Apache-2.0
"""`irt render`."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from irt_usd.choices import PROGRESS
from irt_usd.cli.farm_options import checkpoint_options
from irt_usd.cli.options import (
    check_isa,
    is_verbose,
    shot_options,
    trace_options,
    use_threads,
    verbosity_options,
)

if TYPE_CHECKING:
    from irt_usd.checkpoint.keeper import CheckpointOptions
    from irt_usd.choices import ProgressFormat
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
    type=click.Choice(["shot", "any", "none"]),
    default="shot",
    show_default=True,
    help="Keep of rays what the shot's own changes can reach, or what any change can; none traces"
    " every frame in full.",
)
@checkpoint_options
@click.option(
    "--from",
    "start",
    type=click.Path(path_type=Path),
    metavar="CHECKPOINT",
    help="Start from the history of another version of the shot: a checkpoint, or the newest of a"
    " folder, kept with --history any (or shot, for changes that shot made itself).",
)
@click.option(
    "--reuse-output",
    "reuse",
    is_flag=True,
    help="With --from: keep the frames of that version whose scene is this one's.",
)
@click.option(
    "--cells",
    metavar="RANGE",
    help="Render these of the 64 cells alone, such as 0-30,40-60:2, into partial frames that irt"
    " merge puts together.",
)
@click.option(
    "--progress",
    "progress_format",
    type=click.Choice(PROGRESS),
    help="Lines for a farm manager; by default a bar on a terminal and plain lines elsewhere.",
)
@click.option(
    "--stats", type=click.Path(path_type=Path), help="Write one JSON object a frame to this file."
)
@click.option(
    "--sidecar",
    is_flag=True,
    help="Write FILE.json beside each frame: times, memory, host. They are in no frame's header, so"
    " that frames compare by their bytes.",
)
@click.option("--skip-existing", is_flag=True, help="Leave out frames whose file exists.")
@click.option(
    "--make-output-path/--no-make-output-path",
    default=True,
    show_default=True,
    help="Create the folders of the output that are not there, or refuse.",
)
@click.option(
    "--preview",
    is_flag=True,
    help="Write a PNG beside each frame, as a display shows it, by $OCIO's config or"
    " OpenColorIO's built-in one.",
)
@click.option("--display", metavar="NAME", help="Of previews; by default the config's first.")
@click.option(
    "--view",
    "display_transform",
    metavar="NAME",
    help="Of previews; by default the display's first.",
)
@click.option(
    "--dry-run",
    is_flag=True,
    help="Say what would change and be traced in each frame, and where it would go; trace and"
    " write nothing.",
)
@click.option(
    "--log-file",
    type=click.Path(path_type=Path),
    help="Add all that is said to the end of this file, each line with its time.",
)
@click.option("--list-cameras", is_flag=True, help="Print the stage's cameras and exit.")
@verbosity_options
def render(
    options: "ShotOptions",
    settings: "TraceSettings",
    output: str | None,
    pixel_type: "PixelType",
    history: "History",
    checkpoint: "CheckpointOptions | None",
    start: Path | None,
    reuse: bool,
    cells: str | None,
    progress_format: "ProgressFormat | None",
    stats: Path | None,
    sidecar: bool,
    strict: bool,
    skip_existing: bool,
    make_output_path: bool,
    preview: bool,
    display: str | None,
    display_transform: str | None,
    dry_run: bool,
    log_file: Path | None,
    list_cameras: bool,
    quiet: bool,
) -> None:
    """Render a USD shot into a sequence of EXR files.

    What is not given here the stage's render settings say: every product of theirs is rendered,
    with its camera, resolution, vars and name. Command-line options win: what is given here holds
    whatever render settings, products and passes say.
    """
    from irt_usd import stage
    from irt_usd.cli.dry_run import dry_run as run_dry
    from irt_usd.cli.log import LoggedProgress, open_log, say, say_notices
    from irt_usd.errors import InputError
    from irt_usd.images.preview import display_view
    from irt_usd.report import Report
    from irt_usd.shot.frames import count_frames, format_frames, parse_frames
    from irt_usd.shot.output import output_paths, parse_pattern, prepare_output
    from irt_usd.shot.products import PRODUCT_TOKEN, shot_paths, view_aovs
    from irt_usd.shot.progress import shot_progress
    from irt_usd.shot.render import TABLE_HEADER, OutputOptions, render_shot
    from irt_usd.shot.session import open_shot, opening
    from irt_usd.shot.settings import check_film_size
    from irt_usd.shot.sidecar import sidecar_path
    from irt_usd.shot.writer import preview_path

    quiet_text = quiet or progress_format in ("json", "none")
    if log_file is not None and not dry_run:
        open_log(log_file)
    if list_cameras:
        cameras = stage.list_cameras(stage.open_stage(options.stage, opening(options)))
        for path in cameras:
            click.echo(path)
        if not cameras:
            click.echo(f"irt: {options.stage}: no camera", err=True)
        return
    if (display is not None or display_transform is not None) and not preview:
        raise InputError("--display and --view are of previews; add --preview")
    if reuse and start is None:
        raise InputError("--reuse-output keeps frames of another version; give --from CHECKPOINT")
    if reuse and (cells is not None or preview):
        raise InputError("--reuse-output is of whole frames alone: no --cells, no --preview")
    if start is not None and history == "none":
        raise InputError("--from starts from a history; leave out --history none")
    if preview and cells is not None:
        raise InputError("--preview is of whole frames; leave it out with --cells")
    check_isa(settings.isa)
    use_threads(settings.threads)
    chosen = None
    if cells is not None:
        from irt_usd.farm.cells import parse_cells, partial_path

        chosen = parse_cells(cells)
        if output is not None and not output.lower().endswith(".exr"):
            output = f"{output}/{Path(options.stage).stem}.{_tokens(options.frames)}.exr"
    if output is not None:
        pattern = parse_pattern(output.replace(PRODUCT_TOKEN, "product"))
        if options.frames is not None:  # refused before the stage is opened
            output_paths(pattern, parse_frames(options.frames))
    shot = open_shot(options, Report(strict))
    for view in shot.views:
        check_film_size(view.framing.size, view_aovs(view, settings))
    paths = shot_paths(shot, output)
    if chosen is not None:
        paths = [tuple(partial_path(file, chosen) for file in files) for files in paths]
    wanted = [
        (frame, files)
        for frame, files in zip(shot.frames, paths, strict=True)
        if not (skip_existing and all(map(_exists, files)))
    ]
    shown = (
        display_view(shot.reader.colors.rendering, display, display_transform) if preview else None
    )
    say(_headline(shot, format_frames(shot.frames)), quiet_text)
    if len(wanted) < len(shot.frames):
        count = len(shot.frames) - len(wanted)
        exist = "exists already and is" if count == 1 else "exist already and are"
        say(f"{count_frames(count)} {exist} skipped", quiet_text)
    if dry_run:
        say_notices(shot.report.take_new())
        run_dry(shot, wanted, history)
        return
    if not wanted:
        return
    note = say if is_verbose() and not quiet_text else lambda _: None
    kept = shot.read_files
    files = [file for _, files in wanted for file in files]
    if shown is not None:
        files += [preview_path(file) for file in files]
    prepare_output(files, "--output", note, kept, make_output_path)
    if sidecar:
        beside_frames = [sidecar_path(file) for _, files in wanted for file in files]
        prepare_output(beside_frames, "--sidecar", note, kept, make_output_path)
    for option, beside in (("--stats", stats), ("--log-file", log_file)):
        if beside is not None:
            every = [file for files in paths for file in files]
            prepare_output([beside], option, note, [*kept, *every], make_output_path)
    out = OutputOptions(
        [files for _, files in wanted],
        pixel_type,
        history,
        stats,
        shown,
        checkpoint,
        start,
        reuse,
        chosen,
        sidecar,
    )
    total = len(wanted) * len(shot.views)
    bar = shot_progress(total, TABLE_HEADER, quiet, progress_format)
    with LoggedProgress(bar, TABLE_HEADER) as progress:
        render_shot(shot, [frame for frame, _ in wanted], settings, out, progress)
    say(f"done: {count_frames(len(wanted))} in {out.paths[0][0].parent}", quiet_text)


def _tokens(frames: str | None) -> str:
    """A frame token with as many decimals as the frames need."""
    from irt_usd.shot.frames import parse_frames

    exponents = [int(f.normalize().as_tuple().exponent) for f in parse_frames(frames or "0")]
    decimals = max(-exponent for exponent in exponents)
    return "####" if decimals <= 0 else f"####.{'#' * decimals}"


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
