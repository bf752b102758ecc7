"""Completion of an unfinished input: words, names and values.

The usage text of a command determines the completions of its arguments. For RAP text,
the grammar determines the expected kind of name. The library supplies the names, and
memory supplies the values for an argument of a fact.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import msgspec

from rapc.analysis.completion import FIELDS
from rapc.base.values import format_atom
from rapc.debug.arguments import split
from rapc.debug.breakpoints import KINDS
from rapc.debug.names import definition_names
from rapc.debug.questions.idle import bare_things
from rapc.events import kinds
from rapc.language.complete import fits
from rapc.library.library import Library
from rapc.repl.shell import Shell

_WORD = re.compile(r"[^\s()\"]*$")


Named = Iterable[tuple[str, str]]
"""Names, each with a line of documentation."""


class Candidate(msgspec.Struct, frozen=True):
    """A completion."""

    text: str
    #: The number of characters before the cursor that the completion replaces.
    replaces: int
    #: The documentation, as a line.
    doc: str = ""


def candidates(shell: Shell, text: str) -> list[Candidate]:
    """Return the completions at the end of an input, sorted, without duplicates."""
    found: Iterable[Candidate] = ()
    if text.startswith(":"):
        found = _of_command(shell, text)
    elif shell.history.is_run:
        found = _of_text(shell, text)
    return list({one.text: one for one in found}.values())


def _matching(named: Named, prefix: str) -> Iterator[Candidate]:
    for name, doc in sorted(named):
        if name.startswith(prefix):
            yield Candidate(name, len(prefix), doc)


# --- commands -------------------------------------------------------------------------


def _of_command(shell: Shell, text: str) -> Iterable[Candidate]:
    name, space, rest = text[1:].partition(" ")
    if not space:
        names = ((f":{c.name}", c.doc) for c in shell.commands.values())
        return _matching(names, f":{name}")
    open_at = _open_list(rest)
    if open_at is not None:
        return _of_text(shell, rest[open_at:]) if shell.history.is_run else ()
    word = _WORD.search(rest)
    prefix = "" if word is None else word.group()
    before = split(rest[: len(rest) - len(prefix)])
    return _matching(_arguments(shell, name, before, prefix), prefix)


def _open_list(text: str) -> int | None:
    """Return the start of the outermost list that is not closed, or None."""
    depth, start = 0, 0
    for at, char in enumerate(text):
        if char == "(":
            start = at if depth == 0 else start
            depth += 1
        elif char == ")":
            depth = max(depth - 1, 0)
    return start if depth else None


_IN_BRACKETS = re.compile(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]")
_ALTERNATIVES = re.compile(r" \| (?![^\[]*\])")
_GROUP = re.compile(r"\[[^\]]*\]|[^\s\[\]]+")


def _unwrapped(usage: str) -> str:
    """Return a usage without brackets around the whole text."""
    found = _IN_BRACKETS.fullmatch(usage)
    return found[1] if found else usage


class _Slot(NamedTuple):
    """An argument of a usage, with its allowed words."""

    words: list[str]
    #: Whether the argument is optional, and whether it belongs to the preceding word.
    optional: bool
    follows: bool


def _slots(usage: str) -> Iterator[_Slot]:
    """Yield the arguments of a usage without alternatives, in order."""
    for group in _GROUP.findall(_unwrapped(usage)):
        inner = group.strip("[]")
        words = [inner.split(" | ")] if " | " in inner else [[w] for w in inner.split()]
        for at, slot in enumerate(words):
            yield _Slot(slot, group.startswith("["), at > 0)


def next_words(takes: str, before: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield the possible next words of a command, each with the argument after it.

    Args:
        takes: the usage of the command: `[TASK] [in CYCLE] | failed [TASK]`.
        before: the preceding arguments.
    """
    for usage in _ALTERNATIVES.split(_unwrapped(takes)):
        slots = list(_slots(usage))
        for said in before:
            fitting = [at for at, slot in enumerate(slots) if said in slot.words]
            fitting += [at for at, s in enumerate(slots) if s.words[0].isupper()]
            slots = slots[fitting[0] + 1 :] if fitting else []
        for at, slot in enumerate(slots):
            if not (slot.follows and at):
                then = slots[at + 1].words[0] if slots[at + 1 :] else ""
                then = then if then.isupper() else ""
                yield from ((word, then) for word in slot.words if word[0].isalpha())
                if slot.words[0].isupper() or not slot.optional:
                    break


def _arguments(shell: Shell, name: str, before: list[str], prefix: str) -> Named:
    """Yield the possible next arguments of a command."""
    takes = shell.commands[name].takes if name in shell.commands else ""
    named: dict[str, Callable[[], Named]] = {
        "COMMAND": lambda: [(c.name, c.doc) for c in shell.commands.values()],
        "FILE": lambda: _files(prefix),
        "PATH": lambda: _files(prefix),
        "KIND": lambda: [(kind, "") for kind in kinds()],
    }
    if shell.history.is_run:
        library = _library(shell)
        named |= {
            "ITEM": lambda: _items(shell),
            "NAME": lambda: definition_names(library),
            "PREDICATE": lambda: _of_kind(library, "PREDICATE"),
            "memory NAME": lambda: _of_kind(library, "PREDICATE"),
            "RAP": lambda: _raps(library),
            "TASK": lambda: _tasks(shell),
            "branch NAME": lambda: _branches(shell),
            "diff NAME": lambda: _branches(shell),
            "THING": lambda: [(thing, "") for thing in sorted(bare_things(library))],
            "break KIND": KINDS.items,
            "break WHAT": lambda: _of_break(library, before[0]),
        }
        if name == "break" and before[:1] == ["method"]:
            yield from _of_methods(library, before[1:])
            if before[2:] == ["of"]:
                return
    for word, then in next_words(takes, before):
        if word.isupper():
            yield from named.get(f"{name} {word}", named.get(word, tuple))()
        else:
            yield word, then


def _library(shell: Shell) -> Library:
    return shell.history.run.library.library


def _of_break(library: Library, kind: str) -> Named:
    """Return the possible arguments of a kind of breakpoint."""
    if kind == "method":
        methods = [
            (m.name, rap.name) for rap in library.raps.values() for m in rap.methods
        ]
        return [(str(name), rap) for name, rap in methods if name is not None]
    return _raps(library) if kind == "rap" else ()


def _of_methods(library: Library, before: list[str]) -> Named:
    """Return the possible words after the name of a method: `of RAP`."""
    if before[1:] != ["of"]:
        return [("of", "RAP")] if len(before) == 1 else ()
    name, raps = before[0], library.raps.values()
    having = [r for r in raps if name in [str(m.name) for m in r.methods]]
    return [(rap.name, f"method {name}") for rap in having]


def _branches(shell: Shell) -> Named:
    return [(one.name, one.begun) for one in shell.history.branches]


def _items(shell: Shell) -> Named:
    return [(item.name, item.kind) for item in shell.history.run.memory.items()]


def _tasks(shell: Shell) -> Named:
    for entry in shell.history.run.agenda():
        yield str(entry.task), f"{entry.goal} {entry.state}"


def _files(prefix: str) -> Iterator[tuple[str, str]]:
    folder = os.path.dirname(prefix)
    try:
        with os.scandir(folder or ".") as entries:
            for entry in entries:
                path = os.path.join(folder, entry.name)
                yield (f"{path}/" if entry.is_dir() else path), ""
    except OSError:  # the folder does not exist: no completions
        return


# --- RAP text -----------------------------------------------------------------------


def _of_text(shell: Shell, text: str) -> Iterable[Candidate]:
    found: list[Candidate] = []
    library = _library(shell)
    starts = ("start",) if _is_definition(text) else ("formula", "goal", "proposition")
    for start in starts:
        fit = fits(text, start=start)
        size = len(text) - fit.start
        found += [Candidate(word, size, "a word of the language") for word in fit.words]
        for kind in sorted(fit.kinds):
            for name, doc in sorted(_of_kind(library, kind)):
                if name.startswith(fit.prefix):
                    found.append(Candidate(name, size, doc))
    found += _values(shell, text)
    return found


def _is_definition(text: str) -> bool:
    """Return whether a text is the start of a top-level form of a file."""
    head = text[1:].split(maxsplit=1)[:1]
    return bool(head) and any(
        head[0].startswith(word) for word in ("def", "declare", "require")
    )


def _raps(library: Library) -> Iterator[tuple[str, str]]:
    for rap in library.raps.values():
        yield rap.name, f"({' '.join([rap.name, *(v.name for v in rap.inputs)])})"


def _of_kind(library: Library, kind: str) -> Iterator[tuple[str, str]]:
    """Yield the names of a grammar kind, each with its documentation."""
    if kind == "RAP":
        yield from _raps(library)
        return
    for field in FIELDS.get(kind, ()):
        for name, node in getattr(library, field).items():
            yield name, _doc(name, node)


def _doc(name: str, node: Any) -> str:
    doc = getattr(node, "doc", "")
    args = getattr(node, "args", None) or ()
    shown = " ".join([name, *(arg.variable.name for arg in args)])
    return f"({shown}) {doc}".strip()


def _values(shell: Shell, text: str) -> Iterator[Candidate]:
    """Yield the values in memory for the argument at the cursor."""
    start = text.rfind("(")
    words = text[start + 1 :].split(" ") if start >= 0 else []
    if len(words) < 2 or ")" in text[start:]:
        return
    run = shell.history.run
    name, prefix, at = words[0].lower(), words[-1], len([w for w in words[:-1] if w])
    if name not in run.library.signatures.relations:
        return
    seen = {format_atom(fact[at]) for fact in run.memory.facts(name) if at < len(fact)}
    yield from _matching(((value, "") for value in seen), prefix)
