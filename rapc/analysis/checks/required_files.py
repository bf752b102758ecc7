"""Files that use names of other files without requiring the files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os.path import basename, dirname
from typing import NamedTuple

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, NameUse
from rapc.analysis.facts.usage import SPACES
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.files import SUFFIX
from rapc.base.graph import reachable
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.library.library import Library, name_span
from rapc.library.signature import Declared

MISSING_REQUIRE = Rule(
    code="RAP088",
    name="missing-require",
    severity=Severity.WARNING,
    summary="a file uses a name of another file without requiring the file",
    fix="unsafe: writes the `require`, if only one file has the name",
    ignore="where the files are always used together",
    source="L 1",
)


@check(MISSING_REQUIRE)
def missing_require(run: Pass) -> Iterator[Diagnostic]:
    """Find names of files that a file does not require."""
    library = run.library
    if not run.required or not run.complete:
        return
    homes = _homes(library)
    brought = _Brought(run.required)
    first: dict[tuple[str, str], tuple[_Use, nodes.TopForm]] = {}
    for use in _uses(run):
        here = use.span.file
        form = homes.get((use.space, use.name))
        if form is None or form.span.file == here or not brought.stands_alone(here):
            continue
        if form.span.file in brought.by(here):
            continue
        known = first.setdefault((here, form.span.file), (use, form))
        if use.span.start < known[0].span.start:
            first[here, form.span.file] = use, form
    for use, form in first.values():
        yield _finding(run, use, form)


class _Use(NamedTuple):
    """A use of a name of a name space."""

    space: str
    name: str
    #: The list or the word with the name.
    span: Span
    node: NameUse | nodes.DefineMethod

    def place(self, files: Mapping[str, SourceFile]) -> Span:
        """Return the span of the name."""
        return self.node.place(files) if isinstance(self.node, NameUse) else self.span


def _uses(run: Pass) -> Iterator[_Use]:
    for use in run.result(INDEX).uses():
        yield _Use(SPACES[use.use], use.name, use.span, use)
    for form in run.library.methods:
        yield _Use("RAP", form.rap, form.name_span, form)


def _homes(library: Library) -> dict[tuple[str, str], nodes.TopForm]:
    """Return the definition of each name with a single definition."""
    tables: Mapping[str, tuple[Mapping[str, nodes.TopForm], ...]] = {
        "RAP": (library.raps,),
        "predicate": (
            library.propositions,
            library.properties,
            library.functions,
            library.queries,
        ),
        "primitive": (library.primitives,),
        "datum": (library.data,),
        "skill": (library.skills,),
        "event": (library.events,),
    }
    linked = {id(form) for rows in tables.values() for t in rows for form in t.values()}
    others = {
        form.name
        for form in library.forms
        if isinstance(form, _NAMED) and id(form) not in linked
    }
    return {
        (space, name): form
        for space, rows in tables.items()
        for table in rows
        for name, form in table.items()
        if name not in others
    }


_NAMED = nodes.DefineRap | Declared
"""The forms whose names are used in other forms."""


class _Brought:
    """The files that a file requires.

    Args:
        required: by file, the files that the file itself requires.
    """

    def __init__(self, required: Mapping[str, tuple[str, ...]]) -> None:
        self._required = required
        self._known: dict[str, set[str]] = {}
        self._by_others = {file for there in required.values() for file in there}

    def stands_alone(self, file: str) -> bool:
        """Return whether a file is required, or requires files."""
        return file in self._required or file in self._by_others

    def by(self, file: str) -> set[str]:
        """Return a file and all required files, directly or indirectly."""
        if file not in self._known:
            every = reachable([file], lambda one: self._required.get(one, ()))
            self._known[file] = set(every)
        return self._known[file]


def _finding(run: Pass, use: _Use, form: nodes.TopForm) -> Diagnostic:
    library = run.library
    here, there = use.span.file, form.span.file
    fix = None
    help_ = "add `require` for that file"
    if dirname(here) == dirname(there) and there.endswith(SUFFIX):
        word = f'(require "{basename(there).removesuffix(SUFFIX)}")'
        help_ = f"write `{word}`"
        fix = Fix(Applicability.UNSAFE, help_, tuple(_edits(run, here, word)))
    return MISSING_REQUIRE.at(
        use.place(library.files),
        f"`{use.name}` is defined in `{basename(there)}`, which "
        f"`{basename(here)}` does not require",
        labels=(Label(name_span(library.files, form), "defined here"),),
        help=help_,
        fix=fix,
    )


def _edits(run: Pass, here: str, word: str) -> Iterator[Edit]:
    """Yield the edits that add a `require` after the last, or before the first form."""
    own = [form for form in run.library.forms if form.span.file == here]
    last = [form for form in own if isinstance(form, nodes.Require)][-1:]
    if last:
        end = last[0].span.end
        yield Edit(Span(here, end, end), f"\n{word}")
    else:
        every = (*run.library.forms, *run.library.methods, *run.library.tests)
        start = min(form.span.start for form in every if form.span.file == here)
        yield Edit(Span(here, start, start), f"{word}\n\n")
