"""Who has to do with a fact: who asserted it, who asks for it, who waits for it."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rapc.analysis.facts.index import Index
from rapc.base.values import Fact, match_pattern
from rapc.compiler.watches import WatchKey
from rapc.debug.clause import Support, support
from rapc.debug.history import History
from rapc.debug.why import Origin, origins
from rapc.errors import ArgumentError
from rapc.events import Goal
from rapc.library.signatures import Use

_READS: tuple[Use, ...] = ("test", "believed")
_WRITES: tuple[Use, ...] = ("asserted", "erased")


class Mention(msgspec.Struct, frozen=True):
    """A place in the library that names the fact."""

    place: str
    #: `test`, `believed`, `asserted` or `erased`.
    use: str
    #: The form that it stands in: `define-rap fetch`.
    form: str


class Listener(msgspec.Struct, frozen=True):
    """A task whose monitor hears of changes of the fact."""

    task: int
    goal: Goal
    state: str


class Who(msgspec.Struct, frozen=True):
    """Who has to do with a fact."""

    #: The facts that are believed, with who asserted each last.
    believed: tuple[Origin, ...]
    #: Where the library asks for it or makes it so.
    places: tuple[Mention, ...]
    listeners: tuple[Listener, ...]
    #: The methods under way that have noted it, by task.
    noted_by: tuple[int, ...]


def who(history: History, pattern: Fact) -> Who:
    """Return who has to do with the facts that a pattern matches.

    Raises:
        ArgumentError: if nothing is declared by that name.
    """
    machine = history.run.machine
    name = str(pattern[0])
    if name not in machine.library.signatures.relations:
        raise ArgumentError(str(machine.library.signatures.unknown("test", name)))
    facts = [
        fact
        for fact in machine.memory.facts.table(name).stamps
        if match_pattern(pattern, fact[: len(pattern)]) is not None
    ]
    found: list[Support] = [support(machine, fact) for fact in facts]
    entries = {entry.task: entry for entry in history.run.agenda()}
    listening = tuple(
        Listener(task.number, entries[task.number].goal, entries[task.number].state)
        for task in machine.state.live_tasks()
        if task.wait is not None
        and any(_hears(key, pattern) for key in task.wait.keys or ())
    )
    return Who(
        believed=origins(history, found, history.cycle + 1),
        places=tuple(_places(history, name)),
        listeners=listening,
        noted_by=tuple(_noting(history, facts)),
    )


def _hears(key: WatchKey, pattern: Fact) -> bool:
    """Whether a change of a fact that fits the pattern may touch a listener's key."""
    if not isinstance(key, tuple) or key[0] != pattern[0]:
        return False
    if len(key) == 1:
        return True
    at, value = int(str(key[1])), key[2]
    if at >= len(pattern):
        return True
    return str(pattern[at]).startswith("?") or pattern[at] == value


def _places(history: History, name: str) -> Iterator[Mention]:
    library = history.library.program.library
    compiler = history.library.program.compiler
    index = Index(library)
    for use in (*_READS, *_WRITES):
        for one in index.uses_of(use, name):
            head = type(one.owner).__name__
            named = getattr(one.owner, "name", "")
            yield Mention(
                compiler.row(one.span), use, f"{_words(head)} {named}".strip()
            )


def _words(name: str) -> str:
    """Return the name of a class of nodes as the language writes it."""
    return "".join(f"-{c.lower()}" if c.isupper() else c for c in name).lstrip("-")


def _noting(history: History, facts: list[Fact]) -> Iterator[int]:
    notations = history.run.machine.memory.notations
    for task in history.run.machine.state.live_tasks():
        if task.run is not None and task.run.notations:
            noted = notations.facts(task.run.notations)
            if any(fact in noted for fact in facts):
                yield task.number
