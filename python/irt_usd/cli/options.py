# SPDX-License-Identifier: Apache-2.0
"""Options that several commands share."""

import functools
import re
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from math import isfinite
from typing import Any

import click

from irt_usd.aovs import ALIASES, is_aov
from irt_usd.choices import COMPLEXITY, MISSING_ASSET, PURPOSES, MissingAsset
from irt_usd.cli.errors import VERBOSE
from irt_usd.errors import InputError
from irt_usd.shot.frames import parse_frames
from irt_usd.shot.settings import AOV_NAMES, ShotOptions, TraceSettings, check_film_size

Command = Callable[..., Any]
"""A function on its way to becoming a click command."""

ISAS = ("sse2", "sse4.2", "avx", "avx2", "avx512")
"""From narrow to wide."""

_DEFAULTS = TraceSettings()


def verbosity_options(command: Command) -> Command:
    """-v, for `is_verbose`, and -q, which the command gets as `quiet`."""

    def remember(ctx: click.Context, _param: click.Parameter, value: bool) -> None:
        ctx.find_root().meta[VERBOSE] = value

    return _with(
        command,
        click.option(
            "-v",
            "--verbose",
            is_flag=True,
            expose_value=False,
            callback=remember,
            help="Say more; show tracebacks.",
        ),
        click.option(
            "-q",
            "--quiet",
            is_flag=True,
            help="No table; notices and errors still go to standard error.",
        ),
    )


def is_verbose() -> bool:
    """Whether -v was given to the running command."""
    return bool(click.get_current_context().find_root().meta.get(VERBOSE))


def shot_options(command: Command) -> Command:
    """The stage and what of it is wanted; the command gets them as `options`, a ShotOptions."""

    @functools.wraps(command)
    def with_options(
        *args: Any,
        stage: str,
        camera: str | None,
        frames: str | None,
        size: str | None,
        no_camera_light: bool,
        require_locked: bool,
        purposes: str | None,
        session_layer: str | None,
        mask: str | None,
        asset_path: tuple[str, ...],
        missing_asset: MissingAsset,
        complexity: str,
        texture_memory: str | None,
        settings_path: str | None,
        region: str | None,
        lock_camera: str | None,
        dome_samples: int,
        pass_path: str | None,
        **rest: Any,
    ) -> Any:
        options = ShotOptions(
            stage,
            camera,
            frames,
            parse_size(size) if size is not None else None,
            not no_camera_light,
            require_locked,
            _parse_purposes(purposes) if purposes is not None else None,
            session_layer,
            _parse_mask(mask) if mask is not None else (),
            asset_path,
            missing_asset,
            parse_bytes("--texture-memory", texture_memory) if texture_memory else None,
            complexity,
            settings_path,
            _parse_region(region) if region is not None else None,
            _parse_frame(lock_camera) if lock_camera is not None else None,
            dome_samples,
            pass_path,
        )
        return command(*args, options=options, **rest)

    return _with(
        with_options,
        click.argument("stage", metavar="STAGE"),
        click.option(
            "-c",
            "--camera",
            metavar="PATH",
            help="The camera; by default the render settings', or the stage's only one.",
        ),
        click.option(
            "-s",
            "--settings",
            "settings_path",
            metavar="PATH",
            help="The RenderSettings prim; by default the stage's renderSettingsPrimPath.",
        ),
        click.option(
            "--pass",
            "pass_path",
            metavar="PATH",
            help="The RenderPass whose settings and collections hold; by default none.",
        ),
        click.option(
            "-f",
            "--frames",
            metavar="RANGE",
            help="7, 1001:1100, 1:48x2, 1-48:2, 1:2x0.25 or a list; by default the stage's range.",
        ),
        click.option("--size", metavar="WxH", help="Pixels; by default the render settings'."),
        click.option(
            "--region",
            metavar="L,B,R,T",
            help="Render this window of the frame alone, 0,0,1,1 being all of it, y up; beyond it"
            " is overscan. By default the render settings' dataWindowNDC.",
        ),
        click.option(
            "--dome-samples",
            type=click.IntRange(1, 4096),
            default=32,
            show_default=True,
            help="Directions from which a dome lights surfaces.",
        ),
        click.option(
            "--lock-camera",
            metavar="FRAME",
            help="See every frame as the camera stands at this one.",
        ),
        click.option(
            "--no-camera-light", is_flag=True, help="No light at the camera of a shot without any."
        ),
        click.option(
            "--require-locked", is_flag=True, help="Refuse a camera that moves in the range."
        ),
        click.option(
            "--session-layer",
            metavar="FILE",
            help="A layer whose opinions are stronger than the stage's own.",
        ),
        click.option(
            "--mask",
            metavar="PRIMPATH[,PRIMPATH...]",
            help="Only these prims, with their descendants, ancestors and what they are bound to.",
        ),
        click.option(
            "--purposes",
            metavar="PURPOSE[,PURPOSE...]",
            help="What is rendered beside the purpose default: render, proxy, guide; by default"
            " what the stage's render settings say, or render.",
        ),
        click.option(
            "--asset-path",
            metavar="DIR",
            multiple=True,
            help="A folder searched for assets, before those of PXR_AR_DEFAULT_SEARCH_PATH; may be"
            " repeated.",
        ),
        click.option(
            "--missing-asset",
            type=click.Choice(MISSING_ASSET),
            default="fail",
            show_default=True,
            help="Of a layer or texture that is not there: refuse the shot, render without it and"
            " say so once, or say so each time.",
        ),
        click.option(
            "--texture-memory",
            metavar="SIZE",
            help="Most that textures may take, such as 512M or 4G: over it their finest levels are"
            " dropped, the largest first.",
        ),
        click.option(
            "--complexity",
            type=click.Choice(list(COMPLEXITY)),
            default="low",
            show_default=True,
            help="How often the faces of subdivision meshes are cut: 0, 1, 2 or 3 times; cubic"
            " curves are cut alike.",
        ),
        click.option("--strict", is_flag=True, help="Refuse what would be left out and reported."),
    )


def trace_options(command: Command) -> Command:
    """How frames are traced; the command gets them as `settings`, a TraceSettings."""

    @functools.wraps(command)
    def with_settings(*args: Any, **given: Any) -> Any:
        layers = dict(map(_parse_aov, given.pop("aov")))
        aovs = tuple(layers) or None
        named = tuple((aov, layer) for aov, layer in layers.items() if layer)
        names = ("samples", "max_depth", "throughput_cutoff", "mirror_roughness", "isa", "threads")
        settings = TraceSettings(aovs=aovs, layers=named, **{n: given.pop(n) for n in names})
        if isinstance(options := given.get("options"), ShotOptions):
            given["options"] = replace(options, aovs=aovs or ())
        return command(*args, settings=settings, **given)

    return _with(
        with_settings,
        _number("--samples", click.IntRange(1, 4096), _DEFAULTS.samples, "Samples a pixel."),
        _number(
            "--max-depth",
            click.IntRange(0, 10_000),
            _DEFAULTS.max_depth,
            "Reflections and refractions after the primary ray.",
        ),
        _number(
            "--throughput-cutoff",
            click.FloatRange(0, 1, min_open=True),
            _DEFAULTS.throughput_cutoff,
            "Rays that carry less than about this are not traced.",
        ),
        _number(
            "--mirror-roughness",
            click.FloatRange(0, 1),
            _DEFAULTS.mirror_roughness,
            "Surfaces up to this roughness reflect sharply.",
        ),
        click.option(
            "--aov",
            metavar="[LAYER=]NAME",
            multiple=True,
            help="A further layer; may be repeated. By default the render products' vars."
            f" {', '.join(AOV_NAMES)}, primvars:NAME.",
        ),
        _number("--threads", click.IntRange(0, 1024), _DEFAULTS.threads, "0 is all."),
        click.option(
            "--isa",
            type=click.Choice(ISAS),
            default=_DEFAULTS.isa,
            show_default=True,
            help="Instruction set that trees are walked with; shows in no pixel.",
        ),
    )


def parse_size(text: str) -> tuple[int, int]:
    """`960x540` as (width, height). Raises InputError where it is not that, or no film's size."""
    match = re.fullmatch(r"([+-]?[0-9]{1,18})[xX]([+-]?[0-9]{1,18})", text)
    if match is None:
        raise InputError(f"--size {text}: expected width x height, such as 960x540")
    size = (int(match[1]), int(match[2]))
    check_film_size(size, ())
    return size


def _parse_aov(text: str) -> tuple[str, str]:
    """An AOV, and the name of its layer; empty: the AOV's."""
    layer, given, name = text.partition("=") if not text.startswith("lpe:") else ("", "", text)
    if not given:
        layer, name = "", text
    name = ALIASES.get(name, name)
    if not is_aov(name):
        raise InputError(
            f"--aov {text}: there is no AOV '{name}'; expected one of {', '.join(AOV_NAMES)},"
            " or primvars:NAME"
        )
    if given and not re.fullmatch(r"[A-Za-z0-9_.:-]+", layer):
        raise InputError(f"--aov {text}: '{layer}' is no name for an EXR layer")
    return name, layer


def _parse_purposes(text: str) -> tuple[str, ...]:
    """`default` is always among them, as in usdrecord."""
    names = text.replace(",", " ").split()
    for name in names:
        if name not in PURPOSES:
            raise InputError(
                f"--purposes {text}: there is no purpose '{name}'; expected some of"
                f" {', '.join(PURPOSES)}"
            )
    return tuple(dict.fromkeys(["default", *names]))


def _parse_region(text: str) -> tuple[float, float, float, float]:
    try:
        edges = tuple(map(float, text.replace(",", " ").split()))
    except ValueError:
        edges = ()
    if len(edges) != 4 or not all(map(isfinite, edges)):
        raise InputError(f"--region {text}: expected left,bottom,right,top, such as 0,0,0.5,1")
    left, bottom, right, top = edges
    if not (left < right and bottom < top):
        raise InputError(f"--region {text}: left must be below right, and bottom below top")
    return (left, bottom, right, top)


def _parse_frame(text: str) -> Decimal:
    try:
        (frame,) = parse_frames(text)
    except (InputError, ValueError) as error:
        raise InputError(f"--lock-camera {text}: expected one frame, such as 1001") from error
    return frame


def _parse_mask(text: str) -> tuple[str, ...]:
    paths = tuple(text.replace(",", " ").split())
    if not paths:
        raise InputError("--mask: no prim is named; write /World/Chair")
    return paths


def parse_bytes(option: str, text: str) -> int:
    """`4G` as a number of bytes; K, M, G and T count in powers of 1024. Raises InputError."""
    match = re.fullmatch(r"([0-9]{1,12}(?:\.[0-9]{1,6})?)([kKmMgGtT]?)(?:i?[bB])?", text.strip())
    size = float(match[1]) * 1024 ** " KMGT".index(match[2].upper() or " ") if match else 0
    if size < 1:
        raise InputError(f"{option} {text}: expected a size above 0, such as 512M or 4G")
    return int(size)


def check_isa(isa: str) -> None:
    """Raises InputError where this processor lacks the instruction set."""
    from irt_usd import _core

    best = _core.best_isa()
    if ISAS.index(isa) > ISAS.index(best):
        raise InputError(f"--isa {isa}: this processor has no wider one than {best}; use that")


def use_threads(threads: int) -> None:
    """Bounds the libraries' own thread pools, too; 0 leaves them be."""
    if threads > 0:
        import OpenImageIO as oiio  # noqa: N813
        from pxr import Work

        Work.SetConcurrencyLimit(threads)
        oiio.attribute("threads", threads)
        oiio.attribute("exr_threads", threads)


def _number(name: str, kind: Any, default: float, text: str) -> Callable[[Any], Command]:
    return click.option(
        name, type=kind, default=default, show_default=True, callback=_not_nan, help=text
    )


def _not_nan(_ctx: click.Context, param: click.Parameter, value: float) -> float:
    if value != value:  # click's ranges let it pass
        raise InputError(f"{param.opts[0]} nan: expected a number")
    return value


def _with(command: Command, *decorators: Callable[[Any], Command]) -> Command:
    for decorator in reversed(decorators):
        command = decorator(command)
    return command
