# SPDX-License-Identifier: Apache-2.0
"""A plan as a job bundle of Open Job Description (jobtemplate-2023-09)."""

import json
from pathlib import Path
from typing import Any

from irt_usd.farm.plan import JobPlan
from irt_usd.images.atomic import atomic_file

_OPENJD = ("--progress", "openjd")
_STAGE, _WORK, _OUT, _IRT = (
    "{{Param.Stage}}",
    "{{Param.WorkDir}}",
    "{{Param.OutputDir}}",
    "{{Param.Irt}}",
)


def write_bundle(plan: JobPlan, folder: Path) -> None:
    """template.yaml, parameter_values.yaml and asset_references.yaml; JSON, which YAML is too.

    Raises MachineError where they cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, contents in (
        ("template", template(plan)),
        ("parameter_values", _values(plan)),
        ("asset_references", _assets(plan)),
    ):
        with atomic_file(folder / f"{name}.yaml") as temporary:
            temporary.write_text(json.dumps(contents, indent=2) + "\n", encoding="utf-8")


def template(plan: JobPlan) -> dict[str, Any]:
    """The job's template."""
    steps = [_render_step(plan), _merge_step(plan)]
    if plan.verified:
        steps.append(_verify_step(plan))
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": "{{Param.JobName}}",
        "description": "irt: cells of a shot by task, merged"
        + (", and sampled frames verified" if plan.verified else ""),
        "parameterDefinitions": _parameters(plan),
        "jobEnvironments": [_environment()],
        "steps": steps,
    }


def _parameters(plan: JobPlan) -> list[dict[str, Any]]:
    return [
        {"name": "JobName", "type": "STRING", "default": plan.name[:128]},
        {
            "name": "Stage",
            "type": "PATH",
            "objectType": "FILE",
            "dataFlow": "IN",
            "description": "The stage's root layer.",
        },
        {
            "name": "OutputDir",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "OUT",
            "description": "Where whole frames go.",
        },
        {
            "name": "WorkDir",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "INOUT",
            "description": "Partial frames and checkpoints; all hosts must see it.",
        },
        {
            "name": "Irt",
            "type": "STRING",
            "default": plan.irt,
            "description": "The program, as workers find it.",
        },
    ]


def _environment() -> dict[str, Any]:
    return {
        "name": "Irt",
        "description": "That irt is there, and the folders; says what irt it is.",
        "script": {
            "actions": {
                "onEnter": {"command": "bash", "args": ["{{Env.File.Enter}}"], "timeout": 300}
            },
            "embeddedFiles": [
                {
                    "name": "Enter",
                    "type": "TEXT",
                    "data": "set -euo pipefail\n"
                    f'"{_IRT}" --version\n'
                    f'mkdir -p "{_WORK}/parts" "{_WORK}/checkpoints" "{_OUT}"\n',
                }
            ],
        },
    }


def _action(plan: JobPlan, command: str, arguments: list[str]) -> dict[str, Any]:
    return {
        "command": command,
        "args": arguments,
        "timeout": plan.timeout,
        "cancelation": {
            "mode": "NOTIFY_THEN_TERMINATE",
            "notifyPeriodInSeconds": max(1, min(plan.grace, 600)),
        },
    }


def _render_step(plan: JobPlan) -> dict[str, Any]:
    _, *arguments = plan.render(_STAGE, "{{Task.Param.Cells}}", _WORK, _OPENJD)
    return {
        "name": "Render",
        "parameterSpace": {
            "taskParameterDefinitions": [{"name": "Cells", "type": "STRING", "range": plan.cells}]
        },
        "script": {"actions": {"onRun": _action(plan, _IRT, arguments)}},
    }


def _merge_step(plan: JobPlan) -> dict[str, Any]:
    _, *arguments = plan.merge(_WORK, f"{_OUT}/{plan.output.name}", _OPENJD)
    return {
        "name": "Merge",
        "dependencies": [{"dependsOn": "Render"}],
        "script": {"actions": {"onRun": _action(plan, _IRT, arguments)}},
    }


def _verify_step(plan: JobPlan) -> dict[str, Any]:
    folder = "{{Session.WorkingDirectory}}/verify"
    script = "set -euo pipefail\n" + plan.verify_script(_STAGE, folder, _OUT, _IRT)
    return {
        "name": "Verify",
        "dependencies": [{"dependsOn": "Merge"}],
        "script": {
            "actions": {"onRun": _action(plan, "bash", ["{{Task.File.Verify}}"])},
            "embeddedFiles": [{"name": "Verify", "type": "TEXT", "data": script}],
        },
    }


def _values(plan: JobPlan) -> dict[str, Any]:
    values = {
        "Stage": plan.stage,
        "OutputDir": plan.output.parent,
        "WorkDir": plan.work,
    }
    return {
        "parameterValues": [{"name": name, "value": str(path)} for name, path in values.items()]
    }


def _assets(plan: JobPlan) -> dict[str, Any]:
    return {
        "assetReferences": {
            "inputs": {"filenames": [str(path) for path in plan.inputs], "directories": []},
            "outputs": {"directories": [str(plan.output.parent)]},
            "referencedPaths": [],
        }
    }
