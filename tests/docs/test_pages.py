"""Each page of the manual does as it shows, typed from top to bottom in a folder.

- A block with `title="F"` is written to the file F, with `title="F (continued)"` to the
  end of F.
- In a `console` block a line after `$ ` is a command; the lines below are its whole
  output, with `...` for lines that are left out. `\\` continues a command.
- `$ rapc repl ...` starts a session; a `rapc` block has its inputs after `rapc> `, each
  with its answer.
- Untitled `python` blocks run one after the other, as one program; an untitled `rap`
  block has no error of form.
- Blocks in an HTML comment count, too: a reader does not see them.

The folder is empty, except that `examples` and `stdlib` are those of the repository if
commands, programs or configurations of the page name them.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import pytest

from rapc.base.source import SourceFile
from rapc.cli.main import cli
from rapc.parser.formatter import formatted
from rapc.repl.draw import draw
from rapc.repl.shell import Shell

from .pages import CHECKOUT, agrees, blocks, commands, page

DOCS = CHECKOUT / "docs"
COLUMNS = 76
"""The columns of a block of code on the site, and of the terminal in pages."""

WIDE = frozenset(
    {
        "how-to/behaviour-trees",
        "how-to/ci",
        "how-to/experiments",
        "how-to/idioms",
        "index",
        "language/1-text",
        "language/2-queries",
        "language/8-things",
        "language/9-skills",
        "libraries/hallway",
        "libraries/truck-beyond",
        "reference/cli",
        "reference/hallway",
        "reference/repl",
        "reference/trace",
        "reference/truck",
        "tutorials/debugger",
        "tutorials/skill-world",
        "tutorials/standard-library",
    }
)
"""The pages with wider code, on a terminal of 100 columns."""

MORE = " (continued)"
"""The end of the title of a block that continues a file."""

PAGES = sorted(
    path.relative_to(DOCS).with_suffix("").as_posix()
    for path in DOCS.rglob("*.md")
    if path.parent.name != "rules"
)


def typed(command: str, status: int, width: int) -> tuple[int, list[str]]:
    """Type a command after one that ended with `status`: its own status and output."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", f"(exit {status}); {command}"],
        env={**os.environ, "PATH": path, "COLUMNS": str(width)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, [line.rstrip() for line in done.stdout.splitlines()]


def started(command: str) -> Shell:
    """Start the session of a command `rapc repl ...`."""
    with mock.patch("rapc.cli.repl.run_script", return_value=True) as run:
        cli.main(shlex.split(command)[1:], standalone_mode=False)
    shell = run.call_args.args[0]
    assert isinstance(shell, Shell)
    return shell


def answered(
    shell: Shell, text: str, width: int
) -> Iterator[tuple[str, list[str], list[str]]]:
    """Yield the inputs of a block with the answers on the page and of the session."""
    for part in re.split(r"^rapc> ", text, flags=re.M)[1:]:
        said, *told = part.rstrip("\n").split("\n")
        drawn = draw(shell.answer(said), width, color=False)
        yield said, _bare(told), _bare(drawn.rstrip("\n").split("\n"))


def _bare(lines: list[str]) -> list[str]:
    return [line.strip() for line in lines]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder; modules that a page has written are forgotten at the end."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name, module in [*sys.modules.items()]:
        if str(getattr(module, "__file__", None)).startswith(str(tmp_path)):
            del sys.modules[name]


@pytest.mark.parametrize("name", PAGES)
def test_page_does_as_it_shows(name: str, folder: Path) -> None:
    text = page(name)
    languages = ("console", "python", "toml")
    shown = "".join(b.text for b in blocks(text) if b.language in languages)
    for link in ("examples", "stdlib"):
        if f"{link}/" in shown:
            (folder / link).symlink_to(CHECKOUT / link)
    status, shell = 0, None
    width = 100 if name in WIDE else COLUMNS
    names: dict[str, object] = {"__name__": "page"}
    for block in blocks(text):
        if block.name:
            file = folder / block.name.removesuffix(MORE)
            before = file.read_text(encoding="utf-8") if MORE in block.name else ""
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(before + block.text, encoding="utf-8")
        elif block.language == "console":
            for command, told in commands(block.text):
                if command.startswith("rapc repl ") and " -c " not in command:
                    shell = started(command)
                    continue
                status, printed = typed(command, status, width)
                assert agrees(printed, told), "\n".join([f"$ {command}", *printed])
        elif block.language == "rapc":
            assert shell is not None, "a `rapc` block follows `$ rapc repl ...`"
            for said, told, printed in answered(shell, block.text, width):
                assert agrees(printed, told), "\n".join([f"rapc> {said}", *printed])
        elif block.language == "rap":
            assert formatted(SourceFile(name, block.text)).diagnostics == ()
        elif block.language == "python":
            exec(compile(block.text, name, "exec"), names)  # noqa: S102  # our own page


@pytest.mark.parametrize("name", PAGES)
def test_code_fits_the_column_of_the_site(name: str) -> None:
    lines = [line for block in blocks(page(name)) for line in block.text.splitlines()]
    wide = [line for line in lines if len(line) > COLUMNS]
    assert wide == [] or name in WIDE


def test_lines_that_differ_do_not_agree() -> None:
    assert agrees(["a", "b", "c"], ["a", "...", "c"])
    assert agrees(["a"], ["a", "..."])
    assert not agrees(["a", "b"], ["a"])
    assert not agrees(["a", "x"], ["a", "...", "c"])
