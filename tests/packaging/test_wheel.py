"""The wheel holds all rapc needs: installed alone, away from the checkout, it runs.

Builds with `python -m build` as a release would: the sdist from the checkout, the
wheel from the sdist.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import msgspec
import pytest

from tests.docs.follow import Session, follow
from tests.docs.test_pages import WIDE

CHECKOUT = Path(__file__).parents[2]
TUTORIALS = sorted(path.stem for path in (CHECKOUT / "docs" / "tutorials").glob("*.md"))
LINKED = ("stdlib", "examples", "editors")

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("wheel")]


class Installed(msgspec.Struct, frozen=True):
    """A wheel in an environment of its own, and a folder far from the checkout."""

    bin: Path
    folder: Path

    def run(self, *command: str) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment in the folder."""
        return _run([str(self.bin / command[0]), *command[1:]], self.folder)


def _run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "RAPC"))}
    return subprocess.run(
        command, cwd=folder, env=keep, capture_output=True, text=True, check=False
    )


def _succeed(command: list[str], folder: Path) -> None:
    done = _run(command, folder)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist and the wheel."""
    folder = tmp_path_factory.mktemp("dist")
    build = [sys.executable, "-m", "build", "--outdir", str(folder), str(CHECKOUT)]
    _succeed(build, folder)
    return folder


@pytest.fixture(scope="module")
def installed(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The wheel and its dependencies, nothing else, in a new environment."""
    folder = tmp_path_factory.mktemp("away")
    _succeed([sys.executable, "-m", "venv", "venv"], folder)
    [wheel] = built.glob("*.whl")
    programs = folder / "venv" / "bin"
    _succeed([str(programs / "pip"), "install", "-q", str(wheel)], folder)
    return Installed(programs, folder)


def _data_files() -> set[str]:
    """The RAP files and configurations of the linked folders, from the checkout."""
    found = {
        path.relative_to(CHECKOUT).as_posix()
        for folder in LINKED
        for path in (CHECKOUT / folder).rglob("*")
        if path.suffix in (".rap", ".lua", ".el", ".js", ".json")
        and "node_modules" not in path.parts
    }
    assert {"stdlib/truck/world.rap", "examples/rock-order.rap"} <= found
    return found


def test_wheel_holds_libraries_examples_and_types(built: Path) -> None:
    [wheel] = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    needed = {f"rapc/{name}" for name in _data_files()}
    needed |= {"rapc/py.typed", "rapc/language/rap.lark"}
    pages = (CHECKOUT / "rapc" / "rules").iterdir()
    needed |= {path.relative_to(CHECKOUT).as_posix() for path in pages}
    assert needed <= names
    assert any(name.endswith("licenses/LICENSE") for name in names)
    others = {name.partition("/")[0] for name in names} - {"rapc"}
    assert [name.endswith(".dist-info") for name in others] == [True]


def test_sdist_holds_what_is_linked_and_the_links(built: Path) -> None:
    [sdist] = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    data = _data_files()
    assert data | {f"rapc/{name}" for name in data} <= names
    assert {"LICENSE", "README.md", "tests/packaging/test_wheel.py"} <= names


def test_installed_alone_it_checks_a_library(installed: Installed) -> None:
    path = installed.folder / "mine.rap"
    path.write_text('(require "truck")\n(define-rap (mine)\n  (method (task-net)))\n')
    done = installed.run("rapc", "check", "mine.rap")
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    path.write_text('(require "truk")\n')
    done = installed.run("rapc", "check", "mine.rap")
    assert done.returncode == 1
    assert "did you mean `truck`?" in done.stdout


def test_installed_alone_it_does_the_main_job(installed: Installed) -> None:
    text = ';;; The main job,\n;;; from anywhere.\n(require "truck")\n'
    (installed.folder / "order.rap").write_text(text)
    task = "(fill-order red 4 factory-1)"
    command = ["run", "order.rap", "--world", "truck", "--task", task]
    done = installed.run("rapc", *command, "--trace", "trace.jsonl")
    assert (done.returncode, done.stderr) == (0, "")
    assert f"... task accomplished {task} [1]" in done.stdout
    last = (installed.folder / "trace.jsonl").read_bytes().splitlines()[-1]
    assert msgspec.json.decode(last)["reason"] == "done"


def test_what_runs_is_what_was_installed(installed: Installed) -> None:
    code = "import rapc; print(rapc.__file__)"
    done = installed.run("python", "-c", code)
    assert Path(done.stdout.strip()).is_relative_to(installed.folder)


def test_installed_alone_it_colours_rap(installed: Installed) -> None:
    code = (
        "from pygments.lexers import get_lexer_by_name as get; print(get('rap').name)"
    )
    assert installed.run("python", "-c", code).stdout == "RAP\n"


def test_installed_alone_it_runs_the_experiments_that_come_with_it(
    installed: Installed,
) -> None:
    batch = ("experiment", "chapter6", "--part", "still", "--seeds", "1")
    done = installed.run("rapc", *batch)
    told = "plots not drawn: install `rapc[viz]`\n"
    assert (done.returncode, done.stderr) == (0, told), done.stdout
    assert "T 6.2 behind the stroke" in done.stdout
    done = installed.run("rapc", *batch, "--cluster", "tcp://127.0.0.1:1", "--out", "x")
    told = "error: --cluster requires Dask: install `rapc[cluster]`\n"
    assert (done.returncode, done.stderr) == (2, told)


@pytest.mark.parametrize("name", TUTORIALS)
def test_installed_alone_it_does_as_the_tutorials_show(
    name: str, installed: Installed, tmp_path: Path
) -> None:
    """Inputs of the debugger must succeed; tests/docs compares the answers."""
    sessions: list[subprocess.Popen[str]] = []

    def start(command: str) -> Session:
        args = [str(installed.bin / "rapc"), *shlex.split(command)[1:], "--json"]
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            args, cwd=tmp_path, stdin=pipe, stdout=pipe, text=True, bufsize=1
        )
        sessions.append(process)
        assert process.stdin is not None
        assert process.stdout is not None
        given, answers = process.stdin, process.stdout

        def answer(said: str, _: list[str]) -> None:
            given.write(f"{said}\n")
            given.flush()
            assert not json.loads(answers.readline())["failed"], said

        return answer

    def python(code: str) -> None:
        (tmp_path / "page.py").write_text(code, encoding="utf-8")
        _succeed([str(installed.bin / "python"), "page.py"], tmp_path)

    text = (CHECKOUT / "docs" / "tutorials" / f"{name}.md").read_text(encoding="utf-8")
    columns = 100 if f"tutorials/{name}" in WIDE else 76
    try:
        follow(text, tmp_path, installed.bin, start, python, columns)
    finally:
        for process in sessions:
            process.communicate()
