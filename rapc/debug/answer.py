"""Answers: lines of text and tables, for people and for programs; and what gives them.

A command is a function whose answer is shown. Its docstring is its help; what it takes
is written once, for the help and for completion. A question is a command that asks a
history, and changes nothing.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import msgspec

from rapc.base.values import format_atom, number
from rapc.debug.arguments import Arguments

Cell = str | int | float | None
"""What a cell of a table holds; None is shown as nothing."""


class Table(msgspec.Struct, frozen=True):
    """Rows under headings."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


class Answer(msgspec.Struct, frozen=True):
    """What a command has to say."""

    #: Lines before the table.
    lines: tuple[str, ...] = ()
    table: Table | None = None
    #: Lines after the table.
    notes: tuple[str, ...] = ()
    #: Whether the command could not be carried out.
    failed: bool = False
    #: Whether the lines are RAP text.
    is_code: bool = False

    @property
    def rows(self) -> list[dict[str, Cell]]:
        """The rows of the table, each by its columns; none if there is no table."""
        if self.table is None:
            return []
        columns = self.table.columns
        return [dict(zip(columns, row, strict=True)) for row in self.table.rows]

    def record(self) -> dict[str, Any]:
        """Return the answer as an object for programs: its keys are stable."""
        found = {"failed": self.failed, "lines": [*self.lines, *self.notes]}
        return found if self.table is None else {**found, "rows": self.rows}


def say(*lines: str) -> Answer:
    """Return an answer of some lines."""
    return Answer(lines)


def failure(*lines: str) -> Answer:
    """Return an answer that says why a command could not be carried out."""
    return Answer(lines, failed=True)


def table(
    columns: Sequence[str],
    rows: Iterable[Iterable[object]],
    *lines: str,
    none: str = "nothing",
    notes: Sequence[str] = (),
) -> Answer:
    """Return an answer with a table, or the words for `none` where it has no rows.

    Numbers are rounded to twelve digits: 0.1 + 0.2 is 0.3 to whoever reads a table, and
    1e-25 is not 0. Values that are not symbols or numbers are written as RAP text.
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
    """Return bindings as text that follows other text; nothing if there are none."""
    return f" with {in_pairs(bindings)}" if bindings else ""


# --- commands -----------------------------------------------------------------------


class Command(msgspec.Struct, frozen=True):
    """Something that begins with a colon."""

    #: Its name, without the colon.
    name: str
    #: What it is given, as it is written in the help: `[N]`.
    takes: str
    #: What it does, in one sentence.
    doc: str
    #: Called with a shell and arguments; a question with a history and arguments.
    does: Callable[[Any, Arguments], Answer]
    examples: tuple[str, ...] = ()
    #: What else there is to know, a paragraph.
    more: str = ""
    #: The group under which `:help` lists it.
    group: str = ""
    #: Whether it asks a history; else it is for the shell.
    asks: bool = False
    #: Whether a recording can be asked that is only played.
    of_recordings: bool = True

    def __call__(self, subject: Any, text: str = "") -> Answer:
        """Carry out the command, and return its answer.

        Args:
            subject: the history that is asked; a shell for what is no question.
            text: what stands behind the name of the command.

        Raises:
            Error: if it cannot be carried out.
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
    """Return what makes a command of a function, by its name and its docstring.

    Args:
        takes: what the command is given.
        examples: inputs that use it; its name alone if there are none.
        more: what else there is to know, after the further paragraphs of the docstring.
        asks: whether it is a question.
        of_recordings: whether a recording can be asked that is only played.
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
    """Return what makes a question of a function of a history; see `command`.

    Args:
        takes: what the question is given.
        examples: inputs that ask it.
        of_recordings: whether a recording can be asked that is only played.
    """
    return command(takes, *examples, asks=True, of_recordings=of_recordings)
