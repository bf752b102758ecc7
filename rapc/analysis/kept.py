"""What is kept of a check, so that the next one need not look at all forms again.

A `State` holds for each file what its text tells of its forms, and everything that was
found. Which forms have to be looked at again is for `rapc.analysis.affected` to say.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.census import CENSUS
from rapc.analysis.driver import Examined, Written
from rapc.analysis.file_census import FileCensus, FormKey, form_key
from rapc.analysis.index import INDEX, Index
from rapc.analysis.passes.constants import ANALYZER as CONSTANTS
from rapc.analysis.place_kinds import PLACE_KINDS, Inputs
from rapc.analysis.suppressions import Suppression
from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.walk import subformulas
from rapc.parser.unit import SourceUnit

_DIGEST = 8
"""How many bytes tell the text of a form from all others."""

AGENDAS: FormKey = ("", 0)
"""The owner of what is found by agendas, wherever it is found."""


class FormState(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """What a form shows of itself."""

    #: Its name, if it is a RAP; else nothing.
    rap: str
    start: int
    end: int
    #: What tells its text from others.
    digest: bytes
    #: What tells from others all that a RAP shows to those that ask for it: its text
    #: without what the contexts of its methods say of other things than its inputs.
    shown: bytes
    #: What it is, if it is no RAP: `agenda`, `require`, or nothing.
    sort: str
    #: Whether it may name things, skills, sets or counters, which lead to other forms.
    is_entangled: bool


class FileState(msgspec.Struct, array_like=True, frozen=True):
    """What the text of a file tells."""

    name: str
    digest: str
    forms: tuple[FormState, ...]
    census: FileCensus
    suppressions: tuple[Suppression, ...]
    wrong: tuple[Diagnostic, ...]


class State(msgspec.Struct, array_like=True, frozen=True):
    """What is kept of a library that was checked."""

    files: tuple[FileState, ...]
    #: What was found before suppressions, by the form that it is said of.
    found: tuple[tuple[FormKey, Diagnostic], ...]
    #: The forms that are to be looked at each time.
    watched: tuple[FormKey, ...]
    #: The files of which all forms are to be looked at if one is.
    watched_files: tuple[str, ...]
    #: The variables for which constants stand, with their forms.
    unmarked: tuple[tuple[FormKey, str], ...]
    #: The files that files require themselves, by their names.
    required: Mapping[str, tuple[str, ...]]
    #: The kinds of the inputs of RAPs.
    inputs: Inputs


def state_of(examined: Examined, digest: Mapping[str, str]) -> State | None:
    """Return what to keep of a check; None if the library is always checked as a whole.

    That is so with slips of the pen, tests and skills.

    Args:
        examined: the check.
        digest: what tells the texts of files from others, by their names.
    """
    loaded, analysis = examined.loaded, examined.analysis
    library = loaded.library
    if loaded.diagnostics or loaded.partial or library.tests or library.skills:
        return None
    censuses = analysis.result(CENSUS).files
    entangled = entangled_in(analysis.result(INDEX))
    owners = Owners(loaded.units)
    found = [
        (AGENDAS if analyzer.by_agendas else owners.of(one.span), one)
        for analyzer, one in analysis.found
    ]
    unmarked = analysis.result(CONSTANTS)
    return State(
        tuple(
            [
                file_state(
                    unit,
                    digest[unit.file.name],
                    censuses.get(unit.file.name, FileCensus()),
                    examined.written,
                    entangled,
                )
                for unit in loaded.units
            ]
        ),
        tuple(found),
        tuple(sorted(analysis.watched)),
        tuple(sorted(analysis.watched_files)),
        tuple([(key, name) for (_, name), key in unmarked.items()]),
        loaded.required,
        analysis.result(PLACE_KINDS).inputs,
    )


def file_state(
    unit: SourceUnit,
    digest: str,
    census: FileCensus,
    written: Written,
    entangled: Container[FormKey],
) -> FileState:
    """Return what the text of a file tells.

    Args:
        unit: the file.
        digest: what tells its text from others.
        census: what it tells of places and constants.
        written: the suppressions of this file, among others.
        entangled: the forms that are entangled with others, among others.
    """
    name = unit.file.name
    return FileState(
        name,
        digest,
        tuple(
            [
                _form_state(
                    unit.file,
                    form,
                    form_key(form) in entangled,
                    is_whole=form not in unit.partial,
                )
                for form in unit.forms
            ]
        ),
        census,
        tuple(written.right.get(name, ())),
        tuple(written.wrong.get(name, ())),
    )


class Owners:
    """Tells in which form a place is.

    Args:
        units: the files.
    """

    def __init__(self, units: Iterable[SourceUnit]) -> None:
        self._forms = {
            unit.file.name: [(form.span.start, form.span.end) for form in unit.forms]
            for unit in units
        }

    def of(self, place: Span) -> FormKey:
        """Return the form at a place; where there is none, the place itself."""
        return place.file, form_at(self._forms.get(place.file, ()), place)


def form_at(forms: Sequence[tuple[int, int]], place: Span) -> int:
    """Return where the form at a place begins, or the place if it is in none.

    Args:
        forms: where the forms of the file begin and end, in the order of the text.
        place: the place.
    """
    low, high = 0, len(forms)
    while low < high:
        middle = (low + high) // 2
        if forms[middle][1] <= place.start:
            low = middle + 1
        else:
            high = middle
    inside = low < len(forms) and forms[low][0] <= place.start
    return forms[low][0] if inside else place.start


def entangled_in(index: Index) -> set[FormKey]:
    """Return the forms that lead to others by things, sets or counters."""
    found: set[FormKey] = set()
    for kind in _ENTANGLED:
        found.update(form_key(one.owner) for one in index.of(kind))
    for call in index.of(nodes.Call):
        if call.node.function in ("size-of", "value"):
            found.add(form_key(call.owner))
    return found


_ENTANGLED: Sequence[type[nodes.Node]] = (
    nodes.Thing,
    nodes.Resource,
    nodes.ResourceChange,
    nodes.SetTest,
)


def _form_state(
    source: SourceFile, form: nodes.TopForm, is_entangled: bool, *, is_whole: bool
) -> FormState:
    """Return what a form shows; one with a slip shows all, and is like no whole one."""
    start, end = form.span.start, form.span.end
    text = source.text[start:end]
    digest = _told(text if is_whole else f"{text};")
    if not isinstance(form, nodes.DefineRap):
        sort = _SORTS.get(type(form), "")
        return FormState("", start, end, digest, digest, sort, is_entangled)
    shown = _told("".join(_shown(source.text, form))) if is_whole else digest
    return FormState(form.name, start, end, digest, shown, "", is_entangled)


_SORTS: Mapping[type, str] = {nodes.DefineAgenda: "agenda", nodes.Require: "require"}


def _told(text: str) -> bytes:
    data = text.encode("utf-8", "surrogatepass")
    return hashlib.blake2b(data, digest_size=_DIGEST).digest()


def _shown(text: str, rap: nodes.DefineRap) -> Iterator[str]:
    inputs = {variable.name for variable in rap.inputs}
    at = rap.span.start
    for method in rap.methods:
        if method.context is not None:
            span = method.context.span
            yield text[at : span.start]
            at = span.end
            for part in subformulas(method.context):
                args = part.args if isinstance(part, nodes.Proposition) else ()
                if any(isinstance(a, nodes.Var) and a.name in inputs for a in args):
                    yield text[part.span.start : part.span.end]
    yield text[at : rap.span.end]
