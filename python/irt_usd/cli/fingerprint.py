# SPDX-License-Identifier: Apache-2.0
"""`irt fingerprint`."""

import click

from irt_usd.cli.options import ISAS, check_isa


@click.command()
@click.option("--isa", type=click.Choice(ISAS), default="avx2", show_default=True)
def fingerprint(isa: str) -> None:
    """Print the numeric fingerprint: hosts of equal fingerprint render equal bits."""
    from irt_usd import _core

    check_isa(isa)
    click.echo(_core.numeric_fingerprint(isa))
