# SPDX-License-Identifier: Apache-2.0
"""irt under another OpenUSD than the wheel's: a studio's own, its resolver, or none at all."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cli_support import SHOT, SIZE, command, environment, failure, write_stage
from irt_usd.images.exr import read_beauty

ROOT = Path(__file__).parents[2]
OTHER = ROOT / "build" / "studio-usd"
"""Put there by `make test`."""

needs_other = pytest.mark.skipif(not (OTHER / "pxr").is_dir(), reason=f"no OpenUSD in {OTHER}")


def run(*arguments: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    env = {**environment(), **variables}
    if "PYTHONPATH" in variables:
        env["PYTHONPATH"] = os.pathsep.join((variables["PYTHONPATH"], environment()["PYTHONPATH"]))
    return subprocess.run(
        command(*arguments), capture_output=True, text=True, timeout=120, cwd=cwd, env=env,
        check=False,
    )  # fmt: skip


@needs_other
@pytest.mark.parametrize("stage", [None, "shots/features/features.usda", "shots/demo/chess.usda"])
def test_a_studios_own_pxr_comes_first(tmp_path: Path, stage: str | None) -> None:
    shot = write_stage(tmp_path) if stage is None else str(ROOT / stage)
    first = ("-f", "1:3") if stage is None else ()
    given = (shot, *SIZE, *first, "-q", "--exr-type", "float")
    if stage is not None:
        from pxr import Usd

        start = int(Usd.Stage.Open(shot).GetStartTimeCode())
        given = (*given, "-f", f"{start}:{start + 1}")
    versions = run("--version", cwd=tmp_path, PYTHONPATH=str(OTHER))
    assert "OpenUSD 24.11" in versions.stdout
    for name, variables in (("wheel", {}), ("other", {"PYTHONPATH": str(OTHER)})):
        done = run("render", *given, "-o", f"{name}/f.####.exr", cwd=tmp_path, **variables)
        assert done.returncode == 0, done.stderr
    files = sorted((tmp_path / "wheel").iterdir())
    assert files
    for file in files:
        ours, theirs = read_beauty(file), read_beauty(tmp_path / "other" / file.name)
        np.testing.assert_array_equal(ours, theirs)


def test_stages_and_textures_are_where_the_resolver_finds_them(tmp_path: Path) -> None:
    """Names that are no files: the search path stands for whatever a site's resolver does."""
    (tmp_path / "site").mkdir()
    write_stage(tmp_path / "site", SHOT, "resolved.usda")
    done = run("render", "resolved.usda", *SIZE, "-f", "1", "-o", "f.exr", cwd=tmp_path,
               PXR_AR_DEFAULT_SEARCH_PATH=str(tmp_path / "site"))  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "f.exr").is_file()
    lost = run("render", "resolved.usda", cwd=tmp_path)
    assert lost.returncode == 2
    assert "no such file" in lost.stderr


def test_an_openusd_too_old_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pxr import Usd

    monkeypatch.setattr(Usd, "GetVersion", lambda: (0, 23, 8))
    said = failure("render", write_stage(tmp_path), status=1)
    assert "OpenUSD 23.08" in said
    assert "24.11 or newer" in said


def test_without_any_pxr_it_says_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\n"
        "class Refuse:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'pxr':\n"
        "            raise ModuleNotFoundError(\"No module named 'pxr'\", name='pxr')\n"
        "sys.meta_path.insert(0, Refuse())\n"
    )
    shot = write_stage(tmp_path)
    for arguments in (("render", shot), ("changes", shot), ("verify", shot)):
        done = run(*arguments, cwd=tmp_path, PYTHONPATH=str(tmp_path))
        assert done.returncode == 1
        assert "irt-usd[usd]" in done.stderr
        assert "hython" in done.stderr
        assert "Traceback" not in done.stderr


def test_the_wheel_is_no_requirement() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert not any(name.startswith("usd-core") for name in project["dependencies"])
    assert any(name.startswith("usd-core") for name in project["optional-dependencies"]["usd"])
