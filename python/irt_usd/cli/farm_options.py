# SPDX-License-Identifier: Apache-2.0
"""Options of jobs on farms."""

import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from irt_usd.errors import InputError

if TYPE_CHECKING:
    from irt_usd.checkpoint.keeper import Every

Command = Callable[..., Any]

_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0}


def checkpoint_options(command: Command) -> Command:
    """Where and when checkpoints are made; the command gets them as `checkpoint`."""

    @functools.wraps(command)
    def with_checkpoint(
        *args: Any,
        checkpoint: Path | None,
        checkpoint_every: str,
        resume: Any,
        keep: int,
        grace: float,
        **rest: Any,
    ) -> Any:
        every = parse_every(checkpoint_every)
        chosen = None
        if checkpoint is not None:
            from irt_usd.checkpoint.keeper import CheckpointOptions

            chosen = CheckpointOptions(checkpoint, every, resume, keep, grace)
        elif resume == "require":
            raise InputError("--resume require: give the folder by --checkpoint DIR")
        return command(*args, checkpoint=chosen, **rest)

    for option in (
        click.option(
            "--grace",
            type=click.FloatRange(0, 86400),
            default=30.0,
            show_default=True,
            help="Seconds from a signal to the end, in which a checkpoint is made; what OpenJD's"
            " cancel_info.json says wins.",
        ),
        click.option(
            "--keep",
            type=click.IntRange(1, 1000),
            default=2,
            show_default=True,
            help="Checkpoints that stay.",
        ),
        click.option(
            "--resume",
            type=click.Choice(["auto", "require", "never"]),
            default="auto",
            show_default=True,
            help="Go on from the newest checkpoint of this very job where there is one; or refuse"
            " to start without (status 5); or start again.",
        ),
        click.option(
            "--checkpoint-every",
            metavar="N|SECONDS",
            default="60s",
            show_default=True,
            help="Every so many frames (10), or so much time (60s, 5m, 1h).",
        ),
        click.option(
            "--checkpoint",
            type=click.Path(path_type=Path),
            metavar="DIR",
            help="Keep checkpoints in this folder: when it is time, after SIGUSR1, before the end"
            " that SIGTERM, SIGINT or SIGHUP ask for (status 75), and when the shot is done.",
        ),
    ):
        with_checkpoint = option(with_checkpoint)
    return with_checkpoint


def parse_every(text: str) -> "Every":
    """`10` frames, or `60s`, `5m`, `1h`. Raises InputError."""
    from irt_usd.checkpoint.keeper import Every

    match = re.fullmatch(r"([0-9]{1,9}(?:\.[0-9]{1,6})?)([smh]?)", text.strip())
    if match and match[2] and float(match[1]) > 0:
        return Every(seconds=float(match[1]) * _UNITS[match[2]])
    if match and not match[2] and "." not in match[1] and int(match[1]) > 0:
        return Every(frames=int(match[1]))
    raise InputError(
        f"--checkpoint-every {text}: expected a number of frames, such as 10, or a time, such as"
        " 60s or 5m"
    )
