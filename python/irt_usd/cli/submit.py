# SPDX-License-Identifier: Apache-2.0
"""`irt submit`."""

import os
from pathlib import Path
from typing import Any

import click

from irt_usd.cli.farm_options import parse_every
from irt_usd.errors import InputError

_OWN = {
    "stage", "frames", "output", "cells", "stats", "quiet", "verbose", "list_cameras",
    "skip_existing", "progress_format", "checkpoint", "checkpoint_every", "resume", "keep", "grace",
}  # fmt: skip
"""Options of irt render that the plan gives, or that a job has no use for."""

_REFUSED = {"preview", "dry_run", "log_file", "start", "reuse"}
"""Options of irt render that a job does not have."""

_FILES = {"session_layer", "asset_path"}
"""Options that are files or folders."""


@click.command(
    context_settings={"ignore_unknown_options": True, "allow_interspersed_args": True},
    options_metavar="[OPTIONS AND THOSE OF IRT RENDER]",
)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED, metavar="STAGE")
@click.option(
    "--bundle", type=click.Path(path_type=Path), metavar="DIR", help="An OpenJD job bundle."
)
@click.option("--opencue", type=click.Path(path_type=Path), metavar="FILE", help="An outline.")
@click.option("--script", type=click.Path(path_type=Path), metavar="FILE", help="A shell script.")
@click.option("--tasks", type=click.IntRange(1, 64), default=8, show_default=True)
@click.option(
    "-o", "--output", metavar="PATTERN", help="Of whole frames; by default out/<stage>.####.exr."
)
@click.option(
    "--work",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="For partial frames and checkpoints; by default beside the output.",
)
@click.option(
    "--verify-frames",
    type=click.IntRange(min=0),
    default=2,
    show_default=True,
    help="How many frames are rendered again from nothing and compared by bytes.",
)
@click.option("--name", help="The job's name; by default the stage's.")
@click.option("--irt", "program", default="irt", show_default=True, help="As workers find it.")
@click.option(
    "--timeout", type=click.IntRange(1), default=86400, show_default=True, help="Seconds."
)
@click.option(
    "--grace",
    type=click.IntRange(1, 600),
    default=120,
    show_default=True,
    help="Seconds between notice and end.",
)
@click.option("--checkpoint-every", "every", default="60s", show_default=True)
def submit(
    arguments: tuple[str, ...],
    bundle: Path | None,
    opencue: Path | None,
    script: Path | None,
    tasks: int,
    output: str | None,
    work: Path | None,
    verify_frames: int,
    name: str | None,
    program: str,
    timeout: int,
    grace: int,
    every: str,
) -> None:
    """Write a shot as a job: its cells in tasks, merged, sampled frames verified.

    Options of irt render may be given too, and go with the tasks.
    """
    from irt_usd.farm.openjd import write_bundle
    from irt_usd.farm.plan import JobPlan, split_cells
    from irt_usd.farm.scripts import write_outline, write_script
    from irt_usd.report import Report
    from irt_usd.shot.frames import format_frames
    from irt_usd.shot.output import default_pattern, output_paths, parse_pattern
    from irt_usd.shot.products import PRODUCT_TOKEN
    from irt_usd.shot.session import open_shot
    from irt_usd.stage import assets_read

    if not (bundle or opencue or script):
        raise InputError("say what to write: --bundle DIR, --opencue FILE or --script FILE")
    parse_every(every)
    options, passed = _render_options(list(arguments))
    shot = open_shot(options, Report())
    whole = output or default_pattern(options.stage, shot.frames).text
    output_paths(parse_pattern(whole.replace(PRODUCT_TOKEN, "product")), shot.frames)
    if len(shot.views) > 1 and PRODUCT_TOKEN not in whole:
        raise InputError(
            f"--output {whole}: the render settings have {len(shot.views)} products; put"
            f" {PRODUCT_TOKEN} in the name"
        )
    pattern = Path(os.path.abspath(whole))  # noqa: PTH100 (keeps links)
    count = min(verify_frames, len(shot.frames))
    picked = [shot.frames[(2 * i + 1) * len(shot.frames) // (2 * count)] for i in range(count)]
    plan = JobPlan(
        name=name or Path(options.stage).stem,
        stage=Path(os.path.abspath(options.stage)),  # noqa: PTH100
        frames=format_frames(shot.frames),
        options=tuple(passed),
        output=pattern,
        work=Path(os.path.abspath(work or pattern.parent / "irt_work")),  # noqa: PTH100
        groups=split_cells(tasks),
        verified=format_frames(picked),
        inputs=tuple(sorted({*map(Path.absolute, [*shot.read_files, *assets_read.files()])})),
        grace=grace,
        timeout=timeout,
        every=every,
        irt=program,
    )
    if bundle is not None:
        write_bundle(plan, bundle)
        click.echo(
            f"{bundle}: openjd run {bundle}/template.yaml, or deadline bundle submit {bundle}"
        )
    if opencue is not None:
        write_outline(plan, opencue)
        click.echo(f"{opencue}: pycuerun {opencue}")
    if script is not None:
        write_script(plan, script)
        click.echo(f"{script}: run it; TRIES=3 tries failed tasks again")


def _render_options(arguments: list[str]) -> tuple[Any, list[str]]:
    """The shot's options, as irt render would take the arguments, and those to pass on."""
    from irt_usd.cli.render import render

    found: list[Any] = []
    with render.make_context("submit", list(arguments)) as context:
        raw, _, _ = render.make_parser(context).parse_args(list(arguments))
        passed: list[str] = []
        for option in render.params:
            value = raw.get(option.name or "")
            if value is not None and option.name in _REFUSED:
                raise InputError(f"{option.opts[-1]}: is not of jobs; leave it out")
            if not isinstance(option, click.Option) or value is None or option.name in _OWN:
                continue
            for one in value if option.multiple else [value]:
                if option.name in _FILES:  # tasks run elsewhere
                    one = os.path.abspath(one)  # noqa: PTH100
                if option.is_flag:
                    passed.append((option.opts if one else option.secondary_opts)[-1])
                else:
                    passed += [option.opts[-1], str(one)]

        from irt_usd.cli.options import shot_options

        def take(**given: Any) -> None:
            found.append(given["options"])

        takes = shot_options(take)
        names = {parameter.name for parameter in getattr(takes, "__click_params__", [])}
        takes(**{name: value for name, value in context.params.items() if name in names})
    return found[0], passed
