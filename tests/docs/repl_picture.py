"""Draws docs/figures/repl.svg: a terminal with a part of docs/tutorial/repl.md.

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

from rapc.language.heads import QUERIES
from rapc.repl.draw import draw
from rapc.repl.highlight import tokens
from tests.docs.test_repl_tutorial import PAGE, begun, blocks

PICTURE = PAGE.parents[1] / "figures" / "repl.svg"

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
    for language, name, text in blocks():
        if language == "rap" and not Path(name).exists():
            Path(name).write_text(text, encoding="utf-8")
        elif language == "sh":
            shell = begun(text)
    assert shell is not None
    shell.answer(":show none")
    shell.answer(":run")
    for said in SHOWN:
        line = Text("rapc> ", style="bold")
        for kind, part in tokens(said, QUERIES):
            line.append(part, style=_STYLES.get(kind, "not bold"))
        console.print(line)
        console.print(Text(draw(shell.answer(said), WIDTH, color=False).rstrip("\n")))


if __name__ == "__main__":
    PICTURE.write_text(svg(), encoding="utf-8")
