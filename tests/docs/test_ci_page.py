"""What is offered to CI systems, run as they would run it."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from tests.cli.command import rapc

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "ci.md").read_text(encoding="utf-8")
HOOKS = (ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8")
ACTION = (ROOT / "action.yml").read_text(encoding="utf-8")

IDS = re.findall(r"^- id: (\S+)$", HOOKS, re.MULTILINE)

LAB = """\
from rapc.world import Kit
from rapc.worlds.scripted import ScriptedWorld

class Lab(ScriptedWorld):
    name = "lab"
    kit = Kit()
    def __init__(self, rng, options):
        super().__init__(())
"""

LIBRARY = "(define-rap (a)\n  (succeed t))\n"
TEST = """\
(define-test a-is-done
  (require "a")
  (task (a))
  (expect
    (succeeds (a))))
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A project with a sound library and a test."""
    (tmp_path / "my-library").mkdir()
    (tmp_path / "my-library" / "a.rap").write_text(LIBRARY)
    (tmp_path / "my-library" / "a.test.rap").write_text(TEST)
    return tmp_path


def _commands(text: str) -> list[list[str]]:
    found = re.findall(r"(?:- |run: )(?:run: )?rapc (.*)", text)
    return [shlex.split(command) for command in found]


def test_the_page_names_every_hook() -> None:
    assert re.findall(r"- id: (rapc-\S+)", PAGE) == IDS
    assert len(IDS) == 3


def _commit(
    hook: str, *files: str, cwd: Path
) -> subprocess.CompletedProcess[str] | None:
    """Run a hook for a commit of some files as pre-commit does; None if it is skipped.

    The hook runs in the root of the repository, once for all files that it is for.
    """
    block = re.split(r"^- id: ", HOOKS, flags=re.M)[1:][IDS.index(hook)]
    fields = dict(re.findall(r"^  (\w+): (.*)$", block, re.M))
    assert (fields["language"], fields["require_serial"]) == ("python", "true")
    chosen = [file for file in files if re.search(fields["files"], file)]
    if not chosen:
        return None
    args = json.loads(fields.get("args", "[]"))
    passed = chosen if fields.get("pass_filenames", "true") == "true" else []
    command, *entry = shlex.split(fields["entry"])
    assert command == "rapc"
    return rapc(*entry, *args, *passed, cwd=cwd)


@pytest.mark.parametrize("hook", IDS)
def test_hooks_run_when_a_library_changes(hook: str, folder: Path) -> None:
    assert _commit(hook, "README.md", "lab.py", cwd=folder) is None
    for file in ("my-library/a.rap", "my-library/a.test.rap"):
        done = _commit(hook, "README.md", file, cwd=folder)
        assert done is not None
        assert (done.returncode, done.stderr) == (0, "")
    (folder / "my-library" / "a.rap").write_text("(define-rap (a) (succeed (b))")
    done = _commit(hook, "my-library/a.rap", cwd=folder)
    assert done is not None
    assert done.returncode in (1, 2)


def test_the_hook_of_tests_finds_what_a_library_breaks(folder: Path) -> None:
    """Though the library itself is sound, and no test is committed."""
    broken = "(define-rap (a)\n  (succeed nil)\n  (method\n    (primitive (fail))))\n"
    (folder / "my-library" / "a.rap").write_text(
        f"(declare-primitive fail () (okay))\n{broken}"
    )
    done = _commit("rapc-test", "my-library/a.rap", cwd=folder)
    assert done is not None
    assert (done.returncode, done.stderr) == (1, "")
    assert "failed  a-is-done" in done.stdout


def test_the_hook_of_tests_runs_in_a_world_of_the_project(folder: Path) -> None:
    """Permitted as the page says."""
    test = '(define-test lab (world "lab:Lab") (require "a") (task (a)))\n'
    (folder / "my-library" / "lab.test.rap").write_text(test)
    (folder / "lab.py").write_text(LAB)
    done = _commit("rapc-test", "my-library/a.rap", cwd=folder)
    assert done is not None
    assert done.returncode == 2
    (configured,) = re.findall(r"```toml\n(.*?)```", PAGE, re.S)
    (folder / "rapc.toml").write_text(configured)
    done = _commit("rapc-test", "my-library/a.rap", cwd=folder)
    assert done is not None
    assert (done.returncode, done.stderr) == (0, "")


def test_commands_of_the_page_run(folder: Path) -> None:
    commands = _commands(PAGE)
    assert len(commands) == 4
    for command in commands:
        done = rapc(*command, cwd=folder)
        assert (done.returncode, done.stderr) == (0, ""), command
    assert (folder / "rapc.sarif").exists()
    assert (folder / "check.xml").exists()
    assert (folder / "tests.xml").exists()


def test_the_command_of_the_action_runs(folder: Path) -> None:
    (command,) = re.findall(r"run: rapc (check .*)$", ACTION, re.MULTILINE)
    args = command.replace("$ARGS", "").replace("$PATHS", "my-library").split()
    assert rapc(*args, cwd=folder).returncode == 0
    (folder / "my-library" / "a.rap").write_text("(define-rap (a) (succeed (b)))")
    done = rapc(*args, cwd=folder)
    assert (done.returncode, done.stdout[:24]) == (1, "::error file=my-library/")
