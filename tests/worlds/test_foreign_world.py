"""A world that is installed as a package of its own."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("lamps")

HERE = Path(__file__).parent
PACKAGE = HERE / "lamps"

SCRIPT = """
import json, sys
from rapc.worlds import registry

world = registry.find_world("lamps")
file = sys.modules[world.__module__].__file__
print(json.dumps([registry.available(), file]))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that pip has put the package into."""
    folder = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps"]
    done = run([*pip, "--target", str(folder), str(PACKAGE)], folder)
    assert done.returncode == 0, done.stderr
    return folder


def run(
    command: list[str], site: Path, columns: int = 80
) -> subprocess.CompletedProcess[str]:
    """Run a command that sees the packages of a folder, away from the checkout."""
    env = {**os.environ, "PYTHONPATH": str(site), "COLUMNS": str(columns)}
    return subprocess.run(
        command, cwd=site, env=env, capture_output=True, text=True, check=False
    )


def rapc(site: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    main = "from rapc.cli.main import main; main()"
    return run([sys.executable, "-c", main, *arguments], site)


def test_it_is_found_by_its_entry_point(installed: Path) -> None:
    done = run([sys.executable, "-c", SCRIPT], installed)
    assert done.returncode == 0, done.stderr
    names, file = json.loads(done.stdout)
    assert "lamps" in names
    assert Path(file) == installed / "lamps.py"


def test_installed_world_keeps_to_the_port(installed: Path) -> None:
    (installed / "lamps.rap").write_text((PACKAGE / "lamps.rap").read_text())
    done = rapc(installed, "worlds", "lamps", "--test", "lamps.rap")
    assert (done.returncode, done.stderr) == (0, "")
    assert "lamps: 6 checks passed" in done.stdout


def test_its_declarations_are_a_library(installed: Path) -> None:
    declared = rapc(installed, "worlds", "lamps", "--declare")
    assert declared.stdout.splitlines()[0] == (
        "(declare-primitive press (?a) (okay stuck none))"
    )
    (installed / "words.rap").write_text(declared.stdout)
    assert rapc(installed, "check", "words.rap").returncode == 0
    assert rapc(installed, "worlds", "lamps", "--test", "words.rap").returncode == 1


def test_it_is_listed_and_described(installed: Path) -> None:
    listed = rapc(installed, "worlds")
    assert listed.returncode == 0, listed.stderr
    assert re.search("^lamps +A corridor of rooms with lamps", listed.stdout, re.M)
    described = rapc(installed, "worlds", "lamps")
    assert "press/1  okay, stuck, none" in described.stdout
    assert "every  40 time units: between visits of somebody" in described.stdout


@pytest.mark.parametrize("name", ["lamps", "lamps:LampWorld"])
def test_a_library_runs_in_it(installed: Path, name: str) -> None:
    words = str(PACKAGE / "lamps.rap")
    done = rapc(installed, "run", words, "--world", name, "--task", "(light-all)", "-q")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "(light-all)" in done.stdout
    other = rapc(
        installed, "run", words, "--world", name, "--task", "(light-all)", "-q",
        "--set", "lamps.rooms=9",
    )  # fmt: skip
    assert other.returncode == 0, other.stderr
    assert other.stdout != done.stdout
