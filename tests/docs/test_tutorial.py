"""docs/tutorials/standard-library.md does as printed: files, commands and output.

A block with `title="NAME"` is the file of that name. In a `console`
block a line after `$ ` is a command, and what follows is all that it prints, with `...`
for any lines left out. The `sh` block that installs rapc is what tests/packaging does.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from .pages import agrees, blocks, commands, page

PAGE = page("tutorials/standard-library")


def _type(command: str, folder: Path, status: int) -> tuple[int, list[str]]:
    """Type a command after one that ended with `status`: its own status and output."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", f"(exit {status}); {command}"],
        cwd=folder,
        env={**os.environ, "PATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, [line.rstrip() for line in done.stdout.splitlines()]


def test_tutorial_does_as_it_says(tmp_path: Path) -> None:
    status = 0
    for block in blocks(PAGE):
        if block.name:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            for command, told in commands(block.text):
                status, printed = _type(command, tmp_path, status)
                assert agrees(printed, told), "\n".join([f"$ {command}", *printed])


def test_times_that_are_told_are_those_that_are_printed() -> None:
    prose = re.sub(r"^```.*?^```$", "", PAGE, flags=re.M | re.S)
    told = re.findall(r"At time ([0-9.]+\d)", prose)
    printed = " ".join(block.text for block in blocks(PAGE)).split()
    assert told
    assert set(told) <= set(printed)


def test_tutorial_has_what_it_is_for() -> None:
    typed = [
        command
        for block in blocks(PAGE)
        if block.language == "console"
        for command, _ in commands(block.text)
    ]
    for command in ("rapc check", "rapc rule", "rapc run"):
        assert any(one.startswith(command) for one in typed)
    assert {block.language for block in blocks(PAGE)} == {
        "sh",
        "rap",
        "console",
        "python",
    }


def test_lines_that_differ_do_not_agree() -> None:
    assert agrees(["a", "b", "c"], ["a", "...", "c"])
    assert agrees(["a"], ["a", "..."])
    assert not agrees(["a", "b"], ["a"])
    assert not agrees(["a", "x"], ["a", "...", "c"])
