# SPDX-License-Identifier: Apache-2.0
"""`irt merge`."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from irt_usd.choices import PROGRESS
from irt_usd.cli.options import verbosity_options

if TYPE_CHECKING:
    from irt_usd.choices import ProgressFormat
    from irt_usd.farm.merge import Whole


@click.command()
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="DIR")
@click.option(
    "-o",
    "--output",
    metavar="PATTERN",
    required=True,
    help="#### (or ###.###, $F4, %04d) is the frame, <product> the render product's name.",
)
@click.option("--progress", "progress_format", type=click.Choice(PROGRESS), help="As irt render's.")
@verbosity_options
def merge(
    folders: tuple[Path, ...],
    output: str,
    progress_format: "ProgressFormat | None",
    quiet: bool,
) -> None:
    """Put the partial frames of `irt render --cells` together.

    Refuses parts of different jobs, and frames of which a cell is missing or there twice.
    """
    from irt_usd import interrupt
    from irt_usd.farm.merge import complete_frames, merge_frames, merged_paths
    from irt_usd.shot.frames import format_frame
    from irt_usd.shot.output import prepare_output
    from irt_usd.shot.progress import shot_progress

    frames = complete_frames(folders)
    paths = merged_paths(frames, output)
    prepare_output(paths, "--output", lambda _: None)
    with shot_progress(len(frames), f"{'frame':>8}  file", quiet, progress_format) as progress:

        def done(whole: "Whole", path: Path) -> None:
            progress.finished(f"{format_frame(whole.frame):>8}  {path}")
            interrupt.check()

        merge_frames(frames, paths, done)
