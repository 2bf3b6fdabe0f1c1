# SPDX-License-Identifier: Apache-2.0
"""`irt --version`."""

import platform

import click


def print_versions(ctx: click.Context, _param: click.Parameter, wanted: bool) -> None:
    """Prints a line a library, irt's own first."""
    if not wanted or ctx.resilient_parsing:
        return
    for name, version in library_versions().items():
        click.echo(f"{name} {version}")
    ctx.exit()


def library_versions() -> dict[str, str]:
    """Every library that can reach a pixel or a file, by name."""
    import numpy as np
    import OpenImageIO as oiio  # noqa: N813
    from pxr import Usd

    from irt_usd import _core

    core = _core.versions()
    _, minor, patch = Usd.GetVersion()
    return {
        "irt": core.pop("irt"),
        **core,
        "OpenUSD": f"{minor}.{patch:02d}",
        "OpenImageIO": oiio.VERSION_STRING,
        "OpenColorIO": oiio.get_string_attribute("opencolorio_version"),
        "NumPy": np.__version__,
        "Python": platform.python_version(),
    }
