"""Definitions of a library: found by name or by file and line."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.base.names import hint
from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.debug.history import History
from rapc.errors import ArgumentError
from rapc.ir import nodes
from rapc.ir.walk import through_queries
from rapc.library.library import KINDS, Library, Named


def definitions(program: Program, text: str, *, near: bool = False) -> list[Named]:
    """Return the definitions for NAME, (NAME ...) or FILE:LINE.

    A rule has the name of its signal or of its RAP. A line stands for the definition
    around it.

    Args:
        program: the library.
        text: the name or the line.
        near: whether a line between definitions stands for the nearest one.

    Raises:
        ArgumentError: if no definition has the name or contains the line.
    """
    file, _, row = text.rpartition(":")
    if file and row.isdecimal():
        return _at_line(program.library, file, int(row), near)
    name = text.strip("()").partition(" ")[0].lower()
    found = list(_of_name(program.library, name))
    if not found:
        known = [one for one, _ in definition_names(program.library)]
        raise ArgumentError(f"no definition of `{name}`{hint(name, known)}")
    return found


def definition_names(library: Library) -> Iterator[tuple[str, str]]:
    """Yield the names of all definitions, each with its definition in words."""
    for form in _all(library):
        for name in names_of(form):
            yield name, definition_in_words(form)


def names_of(form: Named) -> tuple[str, ...]:
    """Return the names of a definition: for a rule, its RAP and its signals."""
    if isinstance(form, nodes.EventRule):
        return (form.signal,)
    if isinstance(form, nodes.DefineMethod):
        return (form.rap,)
    if isinstance(form, nodes.MemoryRule):
        results = (case.result for case in form.cases)
        signals = (one.name for one in results if isinstance(one, nodes.Signal))
        return (form.index.name, *signals)
    return (str(getattr(form, "name", "")),)


def definition_in_words(form: Named) -> str:
    """Return the kind and the name of a definition as text: "query `low`"."""
    kind = KINDS.get(type(form))
    if kind is not None:
        return f"{kind[2]} `{names_of(form)[0]}`"
    if isinstance(form, nodes.EventRule):
        return f"rule for `{form.signal}`"
    if isinstance(form, nodes.MemoryRule):
        return f"rule of `{form.index.name}`"
    if isinstance(form, nodes.DefineMethod):
        return f"method `{form.method.name}` of `{form.rap}`"
    return type(form).__name__


def predicates(library: Library, formula: nodes.Formula) -> dict[str, None]:
    """Return the names of the predicates of a formula, also inside named queries."""
    parts = through_queries(formula, library.queries)
    return {part.name: None for part in parts if isinstance(part, nodes.Proposition)}


def program_of(history: History) -> Program | None:
    """Return the library of a run; None for a playback."""
    return history.library.program if history.is_run else None


def _all(library: Library) -> Iterator[Named]:
    for field, _, _ in KINDS.values():
        yield from getattr(library, field).values()
    yield from _unnamed(library)


def _of_name(library: Library, name: str) -> Iterator[Named]:
    for field, _, _ in KINDS.values():
        table = getattr(library, field)
        if name in table:
            yield table[name]
    for rule in _unnamed(library):
        if name in names_of(rule):
            yield rule


def _unnamed(library: Library) -> tuple[Named, ...]:
    """Return the definitions without a name of their own; see `names_of`."""
    return (*library.methods, *library.memory_rules, *library.event_rules)


def _at_line(library: Library, file: str, row: int, near: bool) -> list[Named]:
    placed = [
        (
            max(source.row(form.span.start) - row, row - source.row(form.span.end), 0),
            form,
        )
        for form in _all(library)
        for source in [library.files.get(form.span.file)]
        if source is not None and _is_file(source, file)
        for first, last in [(source.row(form.span.start), source.row(form.span.end))]
    ]
    nearest = min((distance for distance, _ in placed), default=0) if near else 0
    found = [form for distance, form in placed if distance == nearest]
    if not found:
        raise ArgumentError(f"no definition at {file}:{row}")
    return found if not nearest else found[:1]


def _is_file(source: SourceFile, file: str) -> bool:
    """Return whether a text is the path or the end of the path of a file."""
    path = source.name.replace("\\", "/")
    return f"/{path}".endswith(f"/{file}")
