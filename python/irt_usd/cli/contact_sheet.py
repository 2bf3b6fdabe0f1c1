# SPDX-License-Identifier: Apache-2.0
"""`irt contact-sheet`."""

from pathlib import Path

import click


@click.command("contact-sheet")
@click.argument("out", metavar="OUT.png", type=click.Path(path_type=Path))
@click.argument(
    "frames", metavar="FRAMES...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option("--columns", type=click.IntRange(1, 1000), help="By default about a square.")
@click.option(
    "--width",
    type=click.IntRange(16, 4096),
    default=240,
    show_default=True,
    help="Of one frame, in pixels.",
)
@click.option(
    "--retraced",
    is_flag=True,
    help="Show where rays were retraced, over a dim image; needs frames with --aov irt.retraced.",
)
def contact_sheet(
    out: Path, frames: tuple[Path, ...], columns: int | None, width: int, retraced: bool
) -> None:
    """Show a sequence of EXR files at a glance, as one PNG in sRGB."""
    from irt_usd.images.contact_sheet import write_contact_sheet
    from irt_usd.shot.frames import count_frames
    from irt_usd.shot.output import prepare_output

    prepare_output([out], "contact sheet", lambda _: None)
    write_contact_sheet(out, frames, columns, width, retraced)
    click.echo(f"{out}: {count_frames(len(frames))}")
