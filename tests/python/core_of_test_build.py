# SPDX-License-Identifier: Apache-2.0
"""The core's test build, with the faults and ablations of cpp/irt/mutant.h, in the product's place.

IRT_TEST_BUILD names its folder. To be imported before anything that imports `irt_usd._core`.
"""

import importlib.util
import os
import sys
from pathlib import Path

import irt_usd

NAME = "irt_usd._core"


def take_its_place() -> None:
    """Makes `irt_usd._core` the module of the test build."""
    assert NAME not in sys.modules, "the product's core was imported already"
    (file,) = Path(os.environ["IRT_TEST_BUILD"]).glob("_core.*.so")
    spec = importlib.util.spec_from_file_location(NAME, file)
    assert spec
    assert spec.loader
    core = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(core)
    sys.modules[NAME] = core
    setattr(irt_usd, "_core", core)  # noqa: B010  mypy knows no such name


take_its_place()
