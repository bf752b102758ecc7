"""Follow a page of the manual from top to bottom in a folder.

- A block with `title="F"` is written to the file F, with `title="F (continued)"` to the
  end of F.
- In a `console` block a line after `$ ` is a command; the lines below are its whole
  output, with `...` for lines that are left out. `\\` continues a command.
- `$ rapc repl ...` starts a session; a `rapc` block has its inputs after `rapc> `, each
  with its answer.
- Untitled `python` blocks are parts of one program.
- Blocks in an HTML comment count, too: a reader does not see them.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

from .pages import agrees, blocks, commands

MORE = " (continued)"
"""The end of the title of a block that continues a file."""

Session = Callable[[str, list[str]], None]
"""Give a session an input, and compare the answer with the lines of the page."""


def follow(
    text: str,
    folder: Path,
    programs: Path,
    start: Callable[[str], Session],
    python: Callable[[str], None],
    columns: int = 76,
) -> None:
    """Follow a page; raise AssertionError for an output that the page does not show.

    Args:
        text: the page.
        folder: the working directory.
        programs: the folder with the programs `rapc` and `python`.
        start: starts the session of a command `rapc repl ...`.
        python: runs a block of Python code.
        columns: the width of the terminal.
    """
    status, session = 0, None
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "RAPC"))}
    environment = {**keep, "PATH": path, "COLUMNS": str(columns)}
    for block in blocks(text):
        if block.name:
            _write(folder / block.name.removesuffix(MORE), block.text, block.name)
        elif block.language == "console":
            for command, told in commands(block.text):
                if command.startswith("rapc repl ") and " -c " not in command:
                    session = start(command)
                    continue
                done = subprocess.run(
                    ["bash", "-c", f"(exit {status}); {command}"],
                    cwd=folder,
                    env=environment,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    check=False,
                )
                status = done.returncode
                printed = [line.rstrip() for line in done.stdout.splitlines()]
                assert agrees(printed, told), "\n".join([f"$ {command}", *printed])
        elif block.language == "rapc":
            assert session is not None, "a `rapc` block follows `$ rapc repl ...`"
            for part in re.split(r"^rapc> ", block.text, flags=re.M)[1:]:
                said, *told = part.rstrip("\n").split("\n")
                session(said, told)
        elif block.language == "python":
            python(block.text)


def _write(file: Path, text: str, title: str) -> None:
    """Write a block to its file, or to the end of the file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a" if title.endswith(MORE) else "w", encoding="utf-8") as out:
        out.write(text)
