"""The pages do as printed: files are written, commands and Python code are run.

The blocks of a page are taken in order, in an empty folder with the folder `examples`
of the checkout:

- a block with `title="NAME"` is the file NAME;
- in a `console` block, a line after `$ ` is a command of rapc; the lines below it are
  the complete output, with `...` for lines left out;
- a `python` block without a title is run with the names of the preceding ones;
- a `rap` block without a title must have no error of form.
"""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from rapc.base.source import SourceFile
from rapc.parser.formatter import formatted
from tests.cli.command import BARE, from_the_beginning, rapc

from .pages import CHECKOUT, agrees, blocks, commands, page

PAGES = (
    "explanation/checker",
    "explanation/determinism",
    "explanation/how-raps-work",
    "explanation/rap-or-tree",
    "how-to/test",
    "how-to/write-a-world",
)
WIDTH = 76
"""The columns of a block of code on the site."""


@pytest.mark.parametrize("name", PAGES)
def test_page_does_as_printed(name: str, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(CHECKOUT / "examples")
    code: list[str] = []
    for block in blocks(page(name)):
        if block.name:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            for command, told in commands(block.text):
                done = rapc(*shlex.split(command)[1:], cwd=tmp_path)
                printed = [line.rstrip() for line in done.stdout.splitlines()]
                printed += done.stderr.splitlines()
                assert agrees(printed, told), "\n".join([f"$ {command}", *printed])
        elif block.language == "python":
            code.append(block.text)
        elif block.language == "rap":
            assert formatted(SourceFile(name, block.text)).diagnostics == ()
    (tmp_path / "page.py").write_text("\n".join(code), encoding="utf-8")
    done = from_the_beginning([sys.executable, "page.py"], tmp_path, BARE, "")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", PAGES)
def test_code_of_a_page_fits_the_column_of_the_site(name: str) -> None:
    lines = [line for block in blocks(page(name)) for line in block.text.splitlines()]
    assert [line for line in lines if len(line) > WIDTH] == []
