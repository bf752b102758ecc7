"""Runs with plans: one trace, byte for byte, in each process and each Python."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.planning.made_plans import ENDS

ROOT = Path(__file__).parents[2]
VERSIONS = ("3.11", "3.12", "3.13")


def traces(python: Path | str, hash_seed: int) -> bytes:
    command = [str(python), "-m", "tests.planning.made_plans"]
    found = {"PYTHONHASHSEED": str(hash_seed), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, **found},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    return done.stdout


def test_plans_do_not_depend_on_the_hash_seed() -> None:
    one = traces(sys.executable, 1)
    assert one.count(b'"event":"plan-made"') > len(ENDS)
    assert traces(sys.executable, 2) == one


def python_of(version: str) -> Path | None:
    """Return a Python of a version, on the path or beside others of pyenv."""
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    folders = [Path(one) for one in os.environ["PATH"].split(os.pathsep)]
    folders += sorted(root.glob(f"versions/{version}.*/bin"))
    for folder in folders:
        python = folder / f"python{version}"
        command = [str(python), "-c", "import venv"]
        if python.is_file() and subprocess.run(command, check=False).returncode == 0:
            return python
    return None


@pytest.mark.nightly
@pytest.mark.parametrize("version", VERSIONS)
def test_plans_do_not_depend_on_the_python(tmp_path: Path, version: str) -> None:
    python = python_of(version)
    if python is None:
        pytest.skip(f"no Python {version} on this machine")
    subprocess.run([str(python), "-m", "venv", "venv"], cwd=tmp_path, check=True)
    own = tmp_path / "venv" / "bin" / "python"
    install = [str(own), "-m", "pip", "install", "-q", str(ROOT)]
    subprocess.run(install, check=True)
    assert traces(own, 5) == traces(sys.executable, 1)
