"""What fits at the end of an unfinished input: words, names and values.

Commands complete by what they take. RAP text completes by the grammar, which says what
kind of name is wanted; the names are those of the library, the values those that stand
in memory at that place of a fact.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import msgspec

from rapc.base.values import format_atom
from rapc.debug.breakpoints import KINDS
from rapc.events import kinds
from rapc.language.complete import fits
from rapc.library.library import Library
from rapc.repl.arguments import split
from rapc.repl.shell import Shell

_WORD = re.compile(r"[^\s()\"]*$")


Named = Iterable[tuple[str, str]]
"""Names, each with a line on it."""


class Candidate(msgspec.Struct, frozen=True):
    """Something that fits."""

    text: str
    #: How many characters before the place it takes the place of.
    replaces: int
    #: What there is to say of it, in a line.
    doc: str = ""


def candidates(shell: Shell, text: str) -> list[Candidate]:
    """Return what fits at the end of an input, sorted, each once."""
    found: Iterable[Candidate] = ()
    if text.startswith(":"):
        found = _of_command(shell, text)
    elif shell.history.is_run:
        found = _of_text(shell, text)
    return list({one.text: one for one in found}.values())


_TOLD = ("help", "find", "show", "to", "goto")
"""The commands that complete by what needs no run."""


def _matching(named: Named, prefix: str) -> Iterator[Candidate]:
    for name, doc in sorted(named):
        if name.startswith(prefix):
            yield Candidate(name, len(prefix), doc)


# --- commands -----------------------------------------------------------------------


def _of_command(shell: Shell, text: str) -> Iterable[Candidate]:
    name, space, rest = text[1:].partition(" ")
    if space and not shell.history.is_run and name not in _TOLD:
        return ()
    if not space:
        return _matching(
            ((f":{c.name}", c.doc) for c in shell.commands.values()), f":{name}"
        )
    open_at = _open_list(rest)
    if open_at is not None:
        return _of_text(shell, rest[open_at:])
    word = _WORD.search(rest)
    prefix = "" if word is None else word.group()
    before = split(rest[: len(rest) - len(prefix)])
    return _matching(_arguments(shell, name, before, prefix), prefix)


def _open_list(text: str) -> int | None:
    """Return where a list begins that is still open, the outermost one."""
    depth, start = 0, 0
    for at, char in enumerate(text):
        if char == "(":
            start = at if depth == 0 else start
            depth += 1
        elif char == ")":
            depth = max(depth - 1, 0)
    return start if depth else None


def _arguments(shell: Shell, name: str, before: list[str], prefix: str) -> Named:
    """Return what a command may be given next."""
    if name == "break":
        return _of_break(shell, before, prefix)
    if name == "history":
        return _of_history(shell, before)
    fixed: Mapping[str, Callable[[], Named]] = {
        "help": lambda: [(c.name, c.doc) for c in shell.commands.values()],
        "find": lambda: [("back", "backwards"), *((kind, "") for kind in kinds())],
        "branch": lambda: [(one.name, one.begun) for one in shell.history.branches],
        "memory": lambda: _of_kind(_library(shell), "PREDICATE"),
        "show": lambda: [("all", ""), ("requests", ""), ("none", "")],
        "to": lambda: [("at", "a time")],
        "goto": lambda: [("at", "a time"), ("end", "as far as was seen")],
        "source": lambda: [*_tasks(shell), *_raps(_library(shell))],
        "why": lambda: [("failed", "why a task failed"), *_tasks(shell)],
        "when": lambda: [("chosen", "what a choice rested on"), *_tasks(shell)],
    }
    if name in fixed:
        return fixed[name]()
    takes = shell.commands[name].takes if name in shell.commands else ""
    return _tasks(shell) if "TASK" in takes and not before else ()


def _library(shell: Shell) -> Library:
    return shell.history.run.machine.library.library


def _of_break(shell: Shell, before: list[str], prefix: str) -> Named:
    library = _library(shell)
    if not before:
        files = (("save", "keep them in a file"), ("load", "take them from a file"))
        return [*KINDS.items(), *files]
    if before[0] in ("save", "load"):
        return _files(prefix)
    if before == ["rap"]:
        return _raps(library)
    if before[0] == "method":
        return _of_break_method(library, before[1:])
    return _AFTER_BREAK


def _of_break_method(library: Library, before: list[str]) -> Named:
    raps = library.raps.values()
    if not before:
        methods = [(one.name, rap.name) for rap in raps for one in rap.methods]
        return [(str(name), rap) for name, rap in methods if name is not None]
    if before[1:] == ["of"]:
        having = [r for r in raps if before[0] in [str(m.name) for m in r.methods]]
        return [(rap.name, f"method {before[0]}") for rap in having]
    return [*_AFTER_BREAK, ("of", "a RAP")] if not before[1:] else _AFTER_BREAK


_AFTER_BREAK = (("if", "a query"), ("after", "times"), ("log", ""), ("before", ""))


def _of_history(shell: Shell, before: list[str]) -> Named:
    machine = shell.history.run.machine
    if before:
        return _of_kind(machine.library.library, "PREDICATE")
    return [(item.name, item.kind) for item in machine.memory.items.known.values()]


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
    except OSError:  # there is no such folder, so nothing fits
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
    """Whether a text is, or may become, a form that stands at the top of a file."""
    head = text[1:].split(maxsplit=1)[:1]
    return bool(head) and any(
        head[0].startswith(word) for word in ("def", "declare", "require")
    )


def _raps(library: Library) -> Iterator[tuple[str, str]]:
    for rap in library.raps.values():
        yield rap.name, f"({' '.join([rap.name, *(v.name for v in rap.inputs)])})"


_FIELDS: Mapping[str, tuple[str, ...]] = {
    "PREDICATE": ("propositions", "properties", "functions", "queries"),
    "FUNCTION": ("functions",),
    "QUERY": ("queries",),
    "PRIMITIVE": ("primitives",),
    "DATUM": ("data",),
    "SKILL": ("skills",),
    "SIGNAL": ("events",),
    "EVENT": ("events",),
    "KIND": ("kinds",),
    "AGENDA": ("agendas",),
}
"""The tables of a library in which a kind of name is found."""


def _of_kind(library: Library, kind: str) -> Iterator[tuple[str, str]]:
    """Iterate over the names of a kind, as the grammar calls it, with their docs."""
    if kind == "RAP":
        yield from _raps(library)
    for field in _FIELDS.get(kind, ()):
        for name, node in getattr(library, field).items():
            yield name, _doc(name, node)


def _doc(name: str, node: Any) -> str:
    doc = getattr(node, "doc", "")
    args = getattr(node, "args", None) or ()
    shown = " ".join([name, *(arg.variable.name for arg in args)])
    return f"({shown}) {doc}".strip()


def _values(shell: Shell, text: str) -> Iterator[Candidate]:
    """Iterate over what facts in memory have at the place that is being written."""
    start = text.rfind("(")
    words = text[start + 1 :].split(" ") if start >= 0 else []
    if len(words) < 2 or ")" in text[start:]:
        return
    machine = shell.history.run.machine
    name, prefix, at = words[0].lower(), words[-1], len([w for w in words[:-1] if w])
    if name not in machine.library.signatures.relations:
        return
    seen = {
        format_atom(fact[at])
        for fact in machine.memory.facts.table(name).stamps
        if at < len(fact)
    }
    yield from _matching(((value, "") for value in seen), prefix)
