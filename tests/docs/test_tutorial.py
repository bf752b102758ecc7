"""docs/tutorial.md is true: its files are written, its commands typed, its output read.

A block ` ```rap name ` or ` ```python name ` is the file of that name. In a `console`
block a line after `$ ` is a command, and what follows is all that it prints, with `...`
for any lines left out. The `sh` block that installs rapc is what tests/packaging does.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

PAGE = Path(__file__).parents[2] / "docs" / "tutorial.md"
_BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```$", re.M | re.S)


class Block(msgspec.Struct, frozen=True):
    """A fenced block: its language, the file it stands for, its text."""

    language: str
    name: str
    text: str


def blocks() -> tuple[Block, ...]:
    """All blocks of the page, in order."""
    text = PAGE.read_text(encoding="utf-8")
    return tuple(Block(*found.groups()) for found in _BLOCK.finditer(text))


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """The commands of a `console` block with the lines they are to print."""
    for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, *lines = part.rstrip("\n").split("\n")
        while command.endswith("\\"):
            command = command[:-1] + lines.pop(0).lstrip("> ")
        yield command, lines


def agrees(printed: Sequence[str], told: Sequence[str]) -> bool:
    """Whether lines are as told, a line `...` standing for any number of them."""
    pattern = "".join("(?:.*\n)*?" if t == "..." else re.escape(t) + "\n" for t in told)
    return re.fullmatch(pattern, "".join(line + "\n" for line in printed)) is not None


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
    for block in blocks():
        if block.name:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            for command, told in commands(block.text):
                status, printed = _type(command, tmp_path, status)
                assert agrees(printed, told), "\n".join([f"$ {command}", *printed])


def test_times_that_are_told_are_those_that_are_printed() -> None:
    text = PAGE.read_text(encoding="utf-8")
    told = re.findall(r"At time ([0-9.]+\d)", _BLOCK.sub("", text))
    printed = " ".join(block.text for block in blocks()).split()
    assert told
    assert set(told) <= set(printed)


def test_tutorial_has_what_it_is_for() -> None:
    typed = [
        command
        for block in blocks()
        if block.language == "console"
        for command, _ in commands(block.text)
    ]
    for command in ("rapc check", "rapc rule", "rapc run"):
        assert any(one.startswith(command) for one in typed)
    assert {block.language for block in blocks()} == {"sh", "rap", "console", "python"}


def test_lines_that_differ_do_not_agree() -> None:
    assert agrees(["a", "b", "c"], ["a", "...", "c"])
    assert agrees(["a"], ["a", "..."])
    assert not agrees(["a", "b"], ["a"])
    assert not agrees(["a", "x"], ["a", "...", "c"])
