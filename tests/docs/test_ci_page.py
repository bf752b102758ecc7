"""What is offered to CI systems, run as they would run it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.command import rapc

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
HOOKS = (ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8")
ACTION = (ROOT / "action.yml").read_text(encoding="utf-8")

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
    ids = re.findall(r"^- id: (\S+)$", HOOKS, re.MULTILINE)
    assert re.findall(r"- id: (rapc-\S+)", PAGE) == ids
    assert len(ids) == 3


@pytest.mark.parametrize(
    "entry", re.findall(r"^  entry: rapc (.*)$", HOOKS, re.MULTILINE)
)
def test_hooks_pass_for_a_sound_library_and_fail_for_a_faulty_one(
    entry: str, folder: Path
) -> None:
    file = "my-library/a.test.rap" if "test" in entry else "my-library/a.rap"
    assert rapc(*shlex.split(entry), file, cwd=folder).returncode == 0
    (folder / "my-library" / "a.rap").write_text("(define-rap (a) (succeed (b))")
    assert rapc(*shlex.split(entry), file, cwd=folder).returncode in (1, 2)


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
