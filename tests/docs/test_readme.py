"""The README: its commands are what is tested, its code is clean."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from rapc.analysis import driver, registry
from rapc.library.loader import load_text

CHECKOUT = Path(__file__).parents[2]
README = (CHECKOUT / "README.md").read_text(encoding="utf-8")
VENV = "python3 -m venv .venv && .venv/bin/pip install -q "
MAIN = f"{VENV}. && .venv/bin/"
TEST = f"{VENV}'.[dev]' && .venv/bin/pytest"


def _commands() -> list[str]:
    blocks = re.findall(r"^```sh\n(.*?)^```$", README, re.M | re.S)
    return [line for block in blocks for line in block.splitlines()]


def test_two_commands_set_up_and_do_everything() -> None:
    main, test = _commands()
    assert main.startswith(f"{MAIN}rapc run ")
    assert test == TEST


def test_readme_has_the_number_of_rules() -> None:
    assert f"finds {len(registry.rules())} kinds of mistakes" in README


def test_ci_types_the_test_command_of_the_readme() -> None:
    script = (CHECKOUT / ".ci" / "run").read_text(encoding="utf-8")
    [pattern] = re.findall(r"^command=\$\(grep -x '(.*)' README\.md\)$", script, re.M)
    assert [c for c in README.splitlines() if re.fullmatch(pattern, c)] == [TEST]
    assert os.access(CHECKOUT / ".ci" / "run", os.X_OK)


def test_main_job_does_what_it_is_for() -> None:
    command = shlex.split(_commands()[0].removeprefix(MAIN))
    code = "from rapc.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, *command[1:]],
        cwd=CHECKOUT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    goal = command[command.index("--task") + 1]
    assert f"--> considering {goal} [1]" in done.stdout
    assert f"[1] {goal} succeeded" in done.stdout


def test_rap_code_in_the_readme_is_clean() -> None:
    [block] = re.findall(r"^```rap title=.*?\n(.*?)^```$", README, re.M | re.S)
    report = driver.check_library(load_text(block))
    assert (report.raps, report.findings) == (1, ())
