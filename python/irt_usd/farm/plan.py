# SPDX-License-Identifier: Apache-2.0
"""The plan of a job: which commands, in which order. Writers turn it into schedulers' forms."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from irt_usd.farm.cells import CELLS, format_cells


@dataclass(frozen=True)
class JobPlan:
    """A shot split by cells, merged, and verified.

    `options` go to irt render as they are, stage, frames and output left out; `inputs` are the
    files that the shot was found to be made of.
    """

    name: str
    stage: Path
    frames: str
    options: tuple[str, ...]
    output: Path
    """The pattern of whole frames."""
    work: Path
    """A folder for partial frames and checkpoints, which all hosts see."""
    groups: tuple[tuple[int, ...], ...]
    verified: str
    """Frames that are rendered again from nothing and compared by bytes; empty: none."""
    inputs: tuple[Path, ...]
    grace: int
    timeout: int
    every: str
    irt: str = "irt"

    @property
    def cells(self) -> list[str]:
        """Each task's, as --cells has them."""
        return [format_cells(group) for group in self.groups]

    def render(self, stage: str, cells: str, work: str, progress: Sequence[str]) -> list[str]:
        """The command of a task, which resumes what an earlier try of it left."""
        return [
            *(self.irt, "render", stage, "--frames", self.frames, *self.options),
            *("--cells", cells, "--output", f"{work}/parts"),
            *("--checkpoint", f"{work}/checkpoints/cells{cells}"),
            *("--checkpoint-every", self.every, "--grace", str(self.grace), *progress),
        ]

    def merge(self, work: str, output: str, progress: Sequence[str]) -> list[str]:
        """Makes whole frames."""
        return [self.irt, "merge", f"{work}/parts", "--output", output, *progress]

    def verify(self, stage: str, folder: str, progress: Sequence[str]) -> list[str]:
        """Renders some frames again from nothing, into `folder`."""
        return [
            *(self.irt, "render", stage, "--frames", self.verified, *self.options),
            *("--history", "none", "--output", f"{folder}/{self.output.name}", *progress),
        ]

    def verify_script(self, stage: str, folder: str, output_folder: str, irt: str) -> str:
        """Bash: those frames again, and their bytes compared with what was merged."""
        command = shell_line([irt, *self.verify(stage, folder, ())[1:]])
        return (
            f"rm -rf {quoted(folder)}\n"
            f"{command}\n"
            f"for file in {quoted(folder)}/*.exr; do\n"
            f'    cmp "$file" {quoted(output_folder)}/"${{file##*/}}"\n'
            f"done\n"
            f"rm -rf {quoted(folder)}\n"
        )


def quoted(text: str) -> str:
    """One word for a shell; of OpenJD's and shell's variables, {{A.B}} and ${A}, the value's."""
    if "{{" in text or "${" in text:
        return '"' + text.replace('"', '\\"') + '"'
    return shlex.quote(text)


def shell_line(words: Sequence[str]) -> str:
    """A command for a shell."""
    return " ".join(map(quoted, words))


def split_cells(tasks: int) -> tuple[tuple[int, ...], ...]:
    """All cells in so many groups, as equal as can be."""
    edges = [task * CELLS // tasks for task in range(tasks + 1)]
    return tuple(tuple(range(a, b)) for a, b in pairwise(edges))
