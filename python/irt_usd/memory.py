# SPDX-License-Identifier: Apache-2.0
"""How much memory there is."""

from pathlib import Path


def free_memory() -> int:
    """Bytes that can be had without swapping."""
    fields = dict(
        line.split(":", 1)
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    )
    return int(fields["MemAvailable"].split()[0]) * 1024
