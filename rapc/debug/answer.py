"""Answers (lines of text and tables) and the commands that return answers.

A command is a function that returns an answer. The docstring of the function is the
help of the command. The usage text of a command serves the help and the completion. A
question is a command that reads a history and changes nothing.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import msgspec

from rapc.base.values import format_atom, number
from rapc.debug.arguments import Arguments

Cell = str | int | float | None
"""The value of a cell of a table; None is shown as an empty cell."""


class Table(msgspec.Struct, frozen=True):
    """A table with headings and rows."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


class Answer(msgspec.Struct, frozen=True):
    """The answer of a command."""

    #: The lines above the table.
    lines: tuple[str, ...] = ()
    table: Table | None = None
    #: The lines below the table.
    notes: tuple[str, ...] = ()
    #: Whether the command failed.
    failed: bool = False
    #: Whether the lines are RAP text.
    is_code: bool = False

    @property
    def rows(self) -> list[dict[str, Cell]]:
        """The rows of the table as mappings by column; empty without a table."""
        if self.table is None:
            return []
        columns = self.table.columns
        return [dict(zip(columns, row, strict=True)) for row in self.table.rows]

    def record(self) -> dict[str, Any]:
        """Return the answer as a mapping with stable keys, for programs."""
        found = {"failed": self.failed, "lines": [*self.lines, *self.notes]}
        return found if self.table is None else {**found, "rows": self.rows}


def say(*lines: str) -> Answer:
    """Return an answer with the given lines."""
    return Answer(lines)


def failure(*lines: str) -> Answer:
    """Return the answer of a command that failed; the lines give the reason."""
    return Answer(lines, failed=True)


def table(
    columns: Sequence[str],
    rows: Iterable[Iterable[object]],
    *lines: str,
    none: str = "nothing",
    notes: Sequence[str] = (),
) -> Answer:
    """Return an answer with a table; without rows, with the text `none`.

    Numbers are rounded to 12 significant digits: 0.1 + 0.2 is shown as 0.3, and 1e-25
    is not shown as 0. Values other than symbols and numbers are written as RAP text.
    """
    made = tuple([tuple(map(_cell, row)) for row in rows])
    if not made:
        return Answer((*lines, none), notes=tuple(notes))
    return Answer(lines, Table(tuple(columns), made), tuple(notes))


def _cell(value: object) -> Cell:
    if isinstance(value, float):
        return number(float(f"{value:.12g}"))
    return (
        value if value is None or isinstance(value, str | int) else format_atom(value)
    )


def shown(cell: Cell) -> str:
    """Return a cell as text."""
    if cell is None:
        return ""
    return cell if isinstance(cell, str) else format_atom(cell)


def numbers(tasks: Iterable[int]) -> str:
    """Return the numbers of tasks as text."""
    return " ".join(f"[{number}]" for number in tasks)


def in_pairs(bindings: Mapping[str, Any]) -> str:
    """Return variables and their values as text."""
    return " ".join(f"{name} {format_atom(v)}" for name, v in bindings.items())


def bound_to(bindings: Mapping[str, Any]) -> str:
    """Return ` with` and the bindings as text; empty without bindings."""
    return f" with {in_pairs(bindings)}" if bindings else ""


# --- commands -----------------------------------------------------------------------


class Command(msgspec.Struct, frozen=True):
    """A command of the debugger; its input begins with a colon."""

    #: The name, without the colon.
    name: str
    #: The usage of the arguments, for example `[N]`.
    takes: str
    #: The first sentence of the help.
    doc: str
    #: The function: called with a shell (question: a history) and the arguments.
    does: Callable[[Any, Arguments], Answer]
    examples: tuple[str, ...] = ()
    #: The rest of the help, as one paragraph.
    more: str = ""
    #: The group under which `:help` lists it.
    group: str = ""
    #: Whether the command is a question to a history; if not, it needs the shell.
    asks: bool = False
    #: Whether the command works on a recording without library or world.
    of_recordings: bool = True

    def __call__(self, subject: Any, text: str = "") -> Answer:
        """Run the command and return its answer.

        Args:
            subject: the history for a question, the shell for any other command.
            text: the text after the name of the command.

        Raises:
            Error: if the command fails.
        """
        args = Arguments(text)
        if not self.of_recordings:
            subject.check_is_run()
        found = self.does(subject, args)
        args.end()
        return found


Does = Callable[[Any, Arguments], Answer]


def command(
    takes: str = "",
    *examples: str,
    more: str = "",
    asks: bool = False,
    of_recordings: bool = True,
) -> Callable[[Does], Command]:
    """Return a decorator that turns a function into a command.

    The function supplies the name and, with its docstring, the help.

    Args:
        takes: the usage of the arguments.
        examples: inputs that use the command; default: the name alone.
        more: text to append to the help.
        asks: whether the command is a question.
        of_recordings: whether the command works on a recording without library or
            world.
    """

    def made(does: Does) -> Command:
        name = does.__name__.strip("_").replace("_", "-")
        doc, _, rest = inspect.cleandoc(does.__doc__ or "").partition("\n\n")
        known = " ".join([*rest.split(), *more.split()])
        uses = examples or (f":{name}",)
        return Command(
            name, takes, doc, does, uses, known, asks=asks, of_recordings=of_recordings
        )

    return made


def question(
    takes: str = "", *examples: str, of_recordings: bool = False
) -> Callable[[Does], Command]:
    """Return a decorator that turns a function of a history into a question.

    Args:
        takes: as for `command`.
        examples: as for `command`.
        of_recordings: as for `command`.
    """
    return command(takes, *examples, asks=True, of_recordings=of_recordings)
