# SPDX-License-Identifier: Apache-2.0
"""`irt checkpoint`."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from irt_usd.checkpoint.container import Container


@click.group()
def checkpoint() -> None:
    """Look into checkpoints."""


@checkpoint.command()
@click.argument("path", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="As one JSON object.")
def info(path: Path, as_json: bool) -> None:
    """What is in a checkpoint, or the newest of a folder, and what it is of."""
    container = _opened(path)
    header = container.header
    sizes: dict[str, int] = {}
    for name, entry in container.entries.items():
        kind = name.rsplit(".cell", 1)[-1].split(".", 1)[-1] if ".cell" in name else name
        sizes[kind] = sizes.get(kind, 0) + entry.item_size * entry.count
    found: dict[str, Any] = {
        "path": str(container.path),
        "bytes": container.path.stat().st_size,
        "schema": header["schema"],
        "frame": header["frame"],
        "frames written": len(header["done"]),
        **header["job"],
        "files": header["files"],
        "arrays": dict(sorted(sizes.items(), key=lambda item: -item[1])),
    }
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    for name, value in found.items():
        if isinstance(value, dict):
            click.echo(f"{name}:")
            for key, inner in value.items():
                click.echo(f"  {key}: {inner:,}" if isinstance(inner, int) else f"  {key}: {inner}")
        elif value is not None:
            click.echo(f"{name}: {value}")


@checkpoint.command()
@click.argument("path", type=click.Path(path_type=Path))
def verify(path: Path) -> None:
    """Prove every byte of a checkpoint, or of the newest of a folder (status 5: damaged)."""
    container = _opened(path)
    container.verify()
    size = container.path.stat().st_size
    click.echo(f"{container.path}: whole: {size:,} bytes, every one as its hash has it")


def _opened(path: Path) -> "Container":
    from irt_usd.checkpoint.container import read
    from irt_usd.checkpoint.store import KIND, newest

    return read(newest(path), KIND)
