"""Draws docs/figures/repl.svg: a terminal with a part of docs/tutorials/debugger.md.

`python -m tests.docs.repl_picture` writes it anew.
"""

from __future__ import annotations

import io
import os
import re
import tempfile
from pathlib import Path

from rich.console import Console
from rich.text import Text

from rapc.language.highlight import tokens
from rapc.repl.draw import draw
from tests.docs.pages import CHECKOUT, blocks, commands, page
from tests.docs.test_pages import started

PICTURE = CHECKOUT / "docs" / "figures" / "repl.svg"

WIDTH = 92

SHOWN = (
    ":why failed",
    ":find back task-selected stock-up",
    ":back",
    ":why-not (produces quarry-1 stone)",
    ":what-if (assert (produces quarry-1 stone)) 2",
)
"""The inputs that are shown; those before them are typed unseen."""

_STYLES = {"keyword": "magenta", "number": "yellow", "variable": "cyan"}


def svg() -> str:
    """Return the picture."""
    console = Console(record=True, width=WIDTH, file=io.StringIO(), highlight=False)
    with tempfile.TemporaryDirectory() as folder:
        here = Path.cwd()
        os.chdir(folder)
        try:
            _fill(console)
        finally:
            os.chdir(here)
    drawn = console.export_svg(title="rapc repl", unique_id="rapc-repl")
    return re.sub(r"@font-face \{.*?\}\s*|<!--.*?-->", "", drawn, flags=re.S)


def _fill(console: Console) -> None:
    """Type the inputs of the page as far as they are shown."""
    shell = None
    for block in blocks(page("tutorials/debugger")):
        if block.name and not Path(block.name).exists():
            Path(block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "console" and shell is None:
            [(command, _)] = commands(block.text)
            shell = started(command)
    assert shell is not None
    shell.answer(":show none")
    shell.answer(":run")
    for said in SHOWN:
        line = Text("rapc> ", style="bold")
        for kind, part in tokens(said):
            line.append(part, style=_STYLES.get(kind, "not bold"))
        console.print(line)
        console.print(Text(draw(shell.answer(said), WIDTH, color=False).rstrip("\n")))


if __name__ == "__main__":
    PICTURE.write_text(svg(), encoding="utf-8")
