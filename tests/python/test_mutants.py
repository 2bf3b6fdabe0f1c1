# SPDX-License-Identifier: Apache-2.0
"""That the tests can fail: each fault of cpp/irt/mutant.h shows in one of them; without a fault, or
without one of the structures that only save work, none does. `make mutants` builds what this needs
and runs it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
BUILD = os.environ.get("IRT_TEST_BUILD", "")
if not BUILD:
    pytest.skip("needs the core's test build: make mutants", allow_module_level=True)

RANDOM_SHOTS = 200
UNITS = "Footprint.*:Regions.*:PathTable.*:DynamicSet.*:Twin.*"


def run(*command: str, **switches: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, **switches}
    return subprocess.run(command, capture_output=True, text=True, env=environment, cwd=HERE)


def names(kind: str) -> list[str]:
    code = f"import core_of_test_build; from irt_usd import _core; print(*_core.{kind})"
    return run(sys.executable, "-c", code).stdout.split()


def shown_by_shots(count: int, **switches: str) -> str:
    """How the first shot fails; empty if none does."""
    done = run(sys.executable, "mutant_worker.py", str(count), **switches)
    if done.returncode < 0:
        return f"killed by signal {-done.returncode}"
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def shown_by_units(**switches: str) -> str:
    """The first C++ test that fails; empty if none does."""
    done = run(f"{BUILD}/irt_tests", f"--gtest_filter={UNITS}", **switches)
    failed = [line for line in done.stdout.splitlines() if line.startswith("[  FAILED  ]")]
    assert (done.returncode == 0) == (not failed), done.stderr
    return failed[0].split()[3] if failed else ""


@pytest.mark.parametrize("name", names("MUTANTS"))
def test_every_fault_is_caught(name: str) -> None:
    shown = shown_by_shots(RANDOM_SHOTS, IRT_MUTANT=name) or shown_by_units(IRT_MUTANT=name)
    assert shown
    print(f"{name}: {shown}")


def test_without_a_fault_nothing_is() -> None:
    assert len(names("MUTANTS")) >= 12
    assert shown_by_shots(RANDOM_SHOTS) == ""
    assert shown_by_units() == ""


@pytest.mark.parametrize("name", names("STRUCTURES"))
def test_structures_save_work_and_show_nowhere(name: str) -> None:
    assert shown_by_shots(60, IRT_WITHOUT=name) == ""


def test_a_fault_that_there_is_none_of_is_refused() -> None:
    done = run(sys.executable, "mutant_worker.py", "1", IRT_MUTANT="no_such_fault")
    assert done.returncode != 0
    assert "names nothing: no_such_fault" in done.stderr
