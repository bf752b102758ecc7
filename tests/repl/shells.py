"""A shell with the truck, for tests of commands."""

from __future__ import annotations

from rapc.debug.answer import Answer
from rapc.repl.commands.table import commands
from rapc.repl.draw import draw
from rapc.repl.shell import Shell
from tests.debug.sessions import truck


def truck_shell(*tasks: str) -> Shell:
    """Return a shell whose robot was given some tasks."""
    return Shell(truck(*tasks), commands())


def said(shell: Shell, *inputs: str, width: int = 100) -> str:
    """Return what the shell says to the last of some inputs, as text."""
    answer = Answer()
    for text in inputs:
        answer = shell.answer(text)
    return draw(answer, width, color=False)


def rows(shell: Shell, *inputs: str) -> list[tuple[object, ...]]:
    """Return the rows of the table that the last of some inputs gives."""
    answer = Answer()
    for text in inputs:
        answer = shell.answer(text)
    assert answer.table is not None, answer.lines
    return list(answer.table.rows)
