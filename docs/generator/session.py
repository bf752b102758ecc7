"""The picture of a session of the debugger: a terminal as SVG with text."""

from __future__ import annotations

import io
import re
from pathlib import Path

from rich.console import Console
from rich.text import Text

import rapc
from rapc.debug.history import History
from rapc.language.highlight import tokens
from rapc.repl.commands.table import commands
from rapc.repl.draw import draw
from rapc.repl.shell import Shell

PAGE = Path(__file__).parents[1] / "tutorials" / "debugger.md"
"""The page with the library, in its first titled block."""

TASK = "(night-shift red factory-1)"
BEFORE = (":show none", ":run")
SHOWN = (":why failed", ":why-not (produces quarry-1 stone)")
"""The inputs in the picture, after `BEFORE`."""

WIDTH = 92
STYLES = {"keyword": "magenta", "number": "yellow", "variable": "cyan"}


def session() -> str:
    """Return the picture."""
    text = PAGE.read_text(encoding="utf-8")
    found = re.search(r'^```rap title="(.+?)"\n(.*?)^```$', text, re.M | re.S)
    assert found is not None
    library = rapc.loads(found[2], found[1])
    shell = Shell(History.open(library, "truck", tasks=[TASK], seed=7), commands())
    for said in BEFORE:
        shell.answer(said)
    console = Console(record=True, width=WIDTH, file=io.StringIO(), highlight=False)
    for said in SHOWN:
        line = Text("rapc> ", style="bold")
        for kind, part in tokens(said):
            line.append(part, style=STYLES.get(kind, "not bold"))
        console.print(line)
        console.print(Text(draw(shell.answer(said), WIDTH, color=False).rstrip("\n")))
    drawn = console.export_svg(title="rapc repl", unique_id="rapc-repl")
    return re.sub(r"@font-face \{.*?\}\s*|<!--.*?-->", "", drawn, flags=re.S)
