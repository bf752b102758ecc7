"""The world of docs/worlds.md, installed as a package of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PACKAGE = HERE / "lamps"
DOCS = HERE.parents[1] / "docs" / "worlds.md"

SCRIPT = """
import json, random, sys
from pathlib import Path
sys.path.append(sys.argv[1])
from tests.worlds.contract import check_world
from rapc.library.loader import load
from rapc.worlds import registry

library = load([Path(sys.argv[2])]).library
world = registry.find_world("lamps")
check_world(
    lambda: registry.build_world(world, 3, {"rooms": 2}),
    library,
    [("look", "room-1"), *[("press", "room-1"), ("press", "room-2")] * 20],
)
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


def test_it_keeps_to_the_port_and_is_found_by_its_entry_point(installed: Path) -> None:
    checkout, words = str(HERE.parents[1]), str(PACKAGE / "lamps.rap")
    done = run([sys.executable, "-c", SCRIPT, checkout, words], installed)
    assert done.returncode == 0, done.stderr
    names, file = json.loads(done.stdout)
    assert names == ["lamps", "truck"]
    assert Path(file) == installed / "lamps.py"


def test_it_is_listed_and_described(installed: Path) -> None:
    listed = rapc(installed, "worlds")
    assert listed.returncode == 0, listed.stderr
    assert "lamps  A corridor of rooms with lamps" in listed.stdout
    described = rapc(installed, "worlds", "lamps")
    assert "press/1  okay, stuck" in described.stdout
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


@pytest.mark.parametrize("file", ["pyproject.toml", "lamps.py", "lamps.rap"])
def test_the_manual_quotes_it_word_for_word(file: str) -> None:
    assert (PACKAGE / file).read_text().strip() in DOCS.read_text()
