# SPDX-License-Identifier: Apache-2.0
"""The files and AOVs of a shot's images: what options and render products say of them."""

from collections.abc import Sequence
from pathlib import Path

from irt_usd.aovs import BEAUTY_SOURCES, SURFACE_AOVS
from irt_usd.errors import InputError
from irt_usd.report import Report
from irt_usd.shot.frames import format_frame
from irt_usd.shot.output import default_pattern, output_paths, parse_pattern
from irt_usd.shot.session import Shot
from irt_usd.shot.settings import TraceSettings
from irt_usd.stage.views import View

PRODUCT_TOKEN = "<product>"
"""In --output: the render product's prim name."""


def product_label(view: View) -> str:
    """What tells a view's files from those of other views."""
    return view.product.path.rsplit("/", 1)[-1]


def shot_paths(shot: Shot, output: str | None) -> list[tuple[Path, ...]]:
    """For each frame the files of its views, no two alike. Raises InputError.

    `output` wins over the products' own names; without either they are named after the stage.
    """
    columns = [_view_paths(shot, view, output) for view in shot.views]
    taken: dict[Path, str] = {}
    for view, column in zip(shot.views, columns, strict=True):
        for frame, path in zip(shot.frames, column, strict=True):
            whose = f"frame {format_frame(frame)} of {view.product.path or 'the shot'}"
            other = taken.setdefault(path, whose)
            if other != whose:
                raise InputError(
                    f"{path}: would be the file both of {other} and of {whose}; give each product"
                    " a productName of its own, time-sampled or with a frame token (####)"
                )
    return list(zip(*columns, strict=True))


def _view_paths(shot: Shot, view: View, output: str | None) -> Sequence[Path]:
    product, label = view.product, product_label(view)
    if output is not None:
        if len(shot.views) > 1 and PRODUCT_TOKEN not in output:
            raise InputError(
                f"--output {output}: the render settings have {len(shot.views)} products; put"
                f" {PRODUCT_TOKEN} in the name, which becomes each product's prim name"
            )
        return output_paths(parse_pattern(output.replace(PRODUCT_TOKEN, label)), shot.frames)
    names = [product.name_at(float(frame)) for frame in shot.frames]
    if not all(names):
        several = label if len(shot.views) > 1 else ""
        return output_paths(default_pattern(shot.options.stage, shot.frames, several), shot.frames)
    origin = f"the productName at {product.place}:"
    if len(set(names)) == 1:
        return output_paths(parse_pattern(names[0], origin), shot.frames)
    return [
        parse_pattern(name, origin).path(frame)
        for name, frame in zip(names, shot.frames, strict=True)
    ]


def view_aovs(view: View, settings: TraceSettings) -> tuple[str, ...]:
    """The AOVs of a view beside its beauty: those asked for, else those of its product's vars."""
    if settings.aovs is not None:
        return settings.aovs
    return tuple(_layers(view))


def every_aov(views: Sequence[View]) -> tuple[str, ...]:
    """All that show what is seen: those of fixed names, and what the views' products ask for."""
    asked = (name for view in views for name in _layers(view) if not name.startswith("irt."))
    return tuple(dict.fromkeys((*SURFACE_AOVS, *asked)))


def view_layers(view: View, settings: TraceSettings) -> dict[str, str]:
    """EXR layers of AOVs, where they are not called as the AOVs are."""
    return dict(settings.layers) if settings.aovs is not None else _layers(view)


def _layers(view: View) -> dict[str, str]:
    found: dict[str, str] = {}
    for variable in view.product.variables:
        if variable.aov:
            found.setdefault(variable.aov, variable.layer)
    return found


def report_variables(views: Sequence[View], report: Report) -> None:
    """Reports render vars that nothing is written of."""
    for view in views:
        layers: dict[str, str] = {}
        for variable in view.product.variables:
            beauty = variable.source in BEAUTY_SOURCES and variable.source_type == "raw"
            if not variable.aov and not beauty:
                kind = f"render vars of {variable.source_type} source '{variable.source}'"
                report.unsupported(kind, variable.path)
            elif variable.aov and layers.setdefault(variable.aov, variable.layer) != variable.layer:
                message = f"a render var that asks for what is in layer {layers[variable.aov]}"
                report.skipped(message, variable.path)
