# SPDX-License-Identifier: Apache-2.0
"""The entry point and its commands."""

import os
import sys
from pathlib import Path

import click

from irt_usd.cli.bench import bench
from irt_usd.cli.changes import changes
from irt_usd.cli.checkpoint import checkpoint
from irt_usd.cli.contact_sheet import contact_sheet
from irt_usd.cli.errors import IrtGroup
from irt_usd.cli.fingerprint import fingerprint
from irt_usd.cli.merge import merge
from irt_usd.cli.render import render
from irt_usd.cli.speedup import speedup
from irt_usd.cli.submit import submit
from irt_usd.cli.verify import verify
from irt_usd.cli.versions import print_versions


@click.group(cls=IrtGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=print_versions,
    help="Show every library's version and exit.",
)
def cli() -> None:
    """Exact incremental ray tracing of USD shots.

    Exit status: 0 done, 1 a failure of irt or the machine, 2 bad usage or input, 4 a verification
    found a difference, 5 a checkpoint was refused, 75 interrupted with a checkpoint to resume from,
    128 + n stopped by signal n without one.
    """


for command in (
    render,
    verify,
    changes,
    merge,
    submit,
    checkpoint,
    speedup,
    contact_sheet,
    fingerprint,
    bench,
):
    cli.add_command(command)


def main() -> None:
    """Runs `irt` and exits."""
    _open_closed_streams()
    cli(prog_name="irt")


def _open_closed_streams() -> None:
    """Gives standard streams that the caller closed to nothing, lest a file take their number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode))  # noqa: SIM115 (for good)
