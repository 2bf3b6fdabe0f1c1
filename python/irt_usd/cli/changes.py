# SPDX-License-Identifier: Apache-2.0
"""`irt changes`."""

import json
from typing import TYPE_CHECKING, Any

import click

from irt_usd.cli.options import shot_options, verbosity_options

if TYPE_CHECKING:
    from irt_usd.changes import Change, ChangeList
    from irt_usd.shot.settings import ShotOptions

_LONGEST_VALUE = 16
"""Numbers: larger arrays are told by their type and size."""


@click.command()
@shot_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON: one object a frame, in a list.")
@verbosity_options
def changes(
    options: "ShotOptions",
    as_json: bool,
    strict: bool,
    quiet: bool,  # noqa: ARG001 (all that is printed was asked for)
) -> None:
    """Show what changes in every frame of a shot: prim, attribute, values, what it invalidates.

    The first frame is where the shot starts; it has no changes.
    """
    from irt_usd import interrupt
    from irt_usd.changes import diff
    from irt_usd.report import Report
    from irt_usd.shot.frames import format_frame
    from irt_usd.shot.session import open_shot
    from irt_usd.shot.stats import json_frame

    shot = open_shot(options, Report(strict))
    previous = None
    objects = []

    def tell_notices() -> None:
        for notice in shot.report.take_new():
            click.echo(f"irt: {notice.text}", err=True)

    for frame in shot.frames:
        interrupt.check()
        snapshot = shot.reader.read(float(frame))
        shot.report.enforce(f"frame {format_frame(frame)} cannot be rendered whole")
        tell_notices()
        found: ChangeList | None = diff(previous, snapshot) if previous is not None else None
        previous = snapshot
        listed: list[Change] = found.changes if found is not None else []
        if as_json:
            objects.append(
                {
                    "frame": json_frame(frame),
                    "summary": found.summary() if found is not None else "first frame",
                    "camera": found.camera if found is not None else False,
                    "changes": [_to_json(change) for change in listed],
                }
            )
            continue
        summary = found.summary() if found is not None else "first frame"
        click.echo(f"{format_frame(frame)}: {summary}")
        for change in listed:
            click.echo(
                f"  {change.path}.{change.attribute}: {_text(change.old)} -> {_text(change.new)}"
                f"  [{change.invalidates}]"
            )
    if as_json:
        click.echo(json.dumps(objects, indent=2, allow_nan=False))


def _to_json(change: "Change") -> dict[str, Any]:
    return {
        "prim": change.path,
        "attribute": change.attribute,
        "old": _plain(change.old),
        "new": _plain(change.new),
        "invalidates": change.invalidates,
    }


def _text(value: Any) -> str:
    plain = _plain(value)
    return plain if isinstance(plain, str) else json.dumps(plain)


def _plain(value: Any) -> Any:
    """As JSON can hold it; large arrays as text such as "float32 1024x3"."""
    import numpy as np

    if isinstance(value, np.ndarray):
        if value.size > _LONGEST_VALUE:
            return f"{value.dtype} {'x'.join(str(side) for side in value.shape)}"
        return _plain(value.tolist())
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    return value
