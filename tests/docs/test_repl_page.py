"""The page of the debugger tells of every command and every kind of breakpoint."""

from __future__ import annotations

import re
from pathlib import Path

from rapc.debug.breakpoints import KINDS
from rapc.repl.commands.table import commands

PAGE = (Path(__file__).parents[2] / "docs" / "repl.md").read_text(encoding="utf-8")


def test_page_names_every_command_and_no_other() -> None:
    told = set(re.findall(r"`:([a-z][a-z-]*)", PAGE))
    assert told == {command.name for command in commands()}


def test_page_names_every_kind_of_breakpoint() -> None:
    section = PAGE.partition("## Stopping")[2].partition("`:watch")[0]
    rows = re.findall(r"^\| (`.*?) \|", section, re.M)
    told = {name for row in rows for name in re.findall(r"`([a-z]+)", row)}
    assert told == set(KINDS)


def test_what_the_page_shows_of_python_runs() -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.S)
    names: dict[str, object] = {}
    exec("\n".join(blocks), names)  # noqa: S102  # our own page
    assert "session" in names
