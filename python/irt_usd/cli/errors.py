# SPDX-License-Identifier: Apache-2.0
"""How a command ends: contract C4's exit statuses, one message for whatever stopped it."""

import errno
import os
import signal
import sys
import traceback
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from irt_usd.errors import IrtError, MachineError
from irt_usd.interrupt import Interrupted, signals_noted

VERBOSE = "irt.verbose"
"""Key of the root context's `meta`: whether a traceback is wanted."""

_NO_USD = (
    "this Python has no OpenUSD (no module pxr): install irt-usd[usd], or run irt with a Python"
    " that has one, such as Houdini's hython or Maya's mayapy"
)

STATUS_DIFFERENT = 4
"""A verification found a difference."""

STATUS_RESUMABLE = 75
"""Interrupted with a checkpoint to resume from."""


class IrtGroup(click.Group):
    """A group whose commands end as C4 says."""

    def main(self, *args: Any, **extra: Any) -> Any:
        """Runs the program; exits with status 1 where the system refuses, a full disk for one.

        What irt opens itself is told by its name, so that nameless refusals are of the output.
        """
        try:
            return super().main(*args, **extra)
        except OSError as error:
            _discard_output()
            failure = MachineError(
                f"{error.filename or 'standard output'}: {error.strerror or error}"
            )
            with suppress(OSError):
                _say(f"error: {failure}")
            sys.exit(failure.status)

    def invoke(self, ctx: click.Context) -> Any:
        """Runs the command; exits with its error's status, and 128 + n, or 75, after signal n."""
        try:
            with signals_noted():
                return super().invoke(ctx)
        except IrtError as error:
            _say(f"error: {error}")
            ctx.exit(error.status)
        except Interrupted as error:
            name = signal.Signals(error.signum).name
            if error.checkpoint:
                _say(f"stopped by {name}; to be resumed from {error.checkpoint}")
                ctx.exit(STATUS_RESUMABLE)
            _say(f"stopped by {name}; every file written is whole")
            ctx.exit(128 + error.signum)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except OSError as error:
            if error.errno != errno.EPIPE and ctx.find_root().meta.get(VERBOSE):
                traceback.print_exc()
            raise
        except Exception as error:
            from irt_usd.cli.log import log

            if isinstance(error, ModuleNotFoundError) and error.name == "pxr":
                _say(f"error: {_NO_USD}")
                ctx.exit(1)
            if ctx.find_root().meta.get(VERBOSE):
                traceback.print_exc()
            log(traceback.format_exc())
            _say(
                f"error: internal: {type(error).__name__}: {error}; this is a defect of irt"
                " (-v shows where)"
            )
            ctx.exit(1)


def _discard_output() -> None:
    """Has standard output end in nothing, lest Python fail again to write it when it exits."""
    with suppress(OSError, ValueError), Path(os.devnull).open("wb") as nothing:
        os.dup2(nothing.fileno(), sys.stdout.fileno())


def _say(text: str) -> None:
    from irt_usd.cli.log import log

    click.echo(f"irt: {text}", err=True)
    log(f"irt: {text}")
