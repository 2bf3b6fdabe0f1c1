# SPDX-License-Identifier: Apache-2.0
"""A plan as a shell script, and as an outline for OpenCue."""

import json
from pathlib import Path

from irt_usd.farm.plan import JobPlan, shell_line
from irt_usd.images.atomic import atomic_file


def write_script(plan: JobPlan, path: Path) -> None:
    """A script for one host, or for several that share the work folder: tasks are taken in turn.

    Raises MachineError where it cannot be written.
    """
    with atomic_file(path) as temporary:
        temporary.write_text(shell_script(plan), encoding="utf-8")
    path.chmod(0o755)


def write_outline(plan: JobPlan, path: Path) -> None:
    """A Python outline for OpenCue's pyoutline. Raises MachineError."""
    with atomic_file(path) as temporary:
        temporary.write_text(outline(plan), encoding="utf-8")


def shell_script(plan: JobPlan) -> str:
    """Bash: each task, tried again where it fails; then the merge, and the verification."""
    stage, work, output = str(plan.stage), str(plan.work), str(plan.output)
    tasks = "\n".join(
        f"task {shell_line(plan.render(stage, cells, work, ()))}" for cells in plan.cells
    )
    verify = (
        plan.verify_script(stage, f"{work}/verify", str(plan.output.parent), plan.irt)
        if plan.verified
        else ""
    )
    return f"""#!/usr/bin/env bash
# {plan.name}: a shot by cells, merged. A task that is run again resumes from its checkpoint.
set -euo pipefail
TRIES=${{TRIES:-3}}

task() {{
    for ((try = 1; ; ++try)); do
        "$@" && return 0
        status=$?
        ((try < TRIES && (status == 1 || status > 5))) || return "$status"
    done
}}

{tasks}
{shell_line(plan.merge(work, output, ()))}
{verify}"""


def outline(plan: JobPlan) -> str:
    """The outline: #IFRAME# counts the tasks."""
    stage, work, output = str(plan.stage), str(plan.work), str(plan.output)
    words = shell_line(plan.render(stage, "${cells[#IFRAME#]}", work, ()))
    render = f"cells=({' '.join(plan.cells)}); exec {words}"
    layers = [
        ("render", ["/bin/bash", "-c", render], f"0-{len(plan.cells) - 1}", ""),
        ("merge", plan.merge(work, output, ()), "0-0", "render"),
    ]
    if plan.verified:
        script = plan.verify_script(stage, f"{work}/verify", str(plan.output.parent), plan.irt)
        command = ["/bin/bash", "-c", "set -euo pipefail\n" + script]
        layers.append(("verify", command, "0-0", "merge"))
    lines = [
        f'"""{plan.name}: a shot by cells, merged. Launch it with pycuerun."""',
        "",
        "from outline import Outline, cuerun",
        "from outline.modules.shell import Shell",
        "",
        f"job = Outline({json.dumps(plan.name)})",
    ]
    for name, command, frames, after in layers:
        lines += [
            f"{name} = Shell({name!r}, command={command!r}, range={frames!r})",
            *([f"{name}.depend_all({after})"] if after else []),
            f"job.add_layer({name})",
        ]
    return "\n".join([*lines, "", 'if __name__ == "__main__":', "    cuerun.launch(job)", ""])
