"""Folders with the small experiment, run and not yet run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.cli.command import rapc

from .small_experiment import TRUCK


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small experiment that has been run, in `out`."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "truck.toml").write_text(TRUCK)
    done = rapc("experiment", "truck.toml", "--out", "out", "--jobs", "2", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    (folder / "printed").write_text(done.stdout)
    return folder


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """A copy of that folder, to be worked on."""
    return shutil.copytree(finished, tmp_path / "copied")


@pytest.fixture
def truck(tmp_path: Path) -> Path:
    """A folder with the same experiment, not yet run."""
    (tmp_path / "truck.toml").write_text(TRUCK)
    return tmp_path
