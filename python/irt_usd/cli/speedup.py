# SPDX-License-Identifier: Apache-2.0
"""`irt speedup`."""

from pathlib import Path

import click


@click.command()
@click.argument("stats", type=click.Path(path_type=Path))
@click.argument("full_stats", type=click.Path(path_type=Path))
def speedup(stats: Path, full_stats: Path) -> None:
    """Show how much faster than full traces the updates of a shot were.

    STATS and FULL_STATS are what `irt render --stats` wrote, the second with `--history none`.
    The column `tracing` compares the time from change set to film, `frame` all of a frame's time,
    its file included.
    """
    from irt_usd.shot.speedup import TABLE_HEADER, compare_stats, read_stats, table_rows

    speedups = compare_stats(read_stats(stats), read_stats(full_stats))
    click.echo(TABLE_HEADER)
    for row in table_rows(speedups):
        click.echo(row)
