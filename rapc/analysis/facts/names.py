"""Uses of names that do not match their declaration.

The signature table (`rapc.library.signatures`) finds the faults; this module adds the
position of each fault. The checks of `unknown-rap`, `undeclared-predicate`,
`functions`, `primitives`, `signals` and similar rules select their faults.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.index import INDEX, USES, Form, NameUse
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Subject,
)
from rapc.base.names import is_slip
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.library.library import word_span
from rapc.library.signature import Signature
from rapc.library.signatures import Fault, Use

_SHOWN = 2
"""The maximum number of places shown after the first place."""


class Misuse(msgspec.Struct, frozen=True):
    """A use of a name, and its fault."""

    used: NameUse
    fault: Fault


def _run(run: Pass) -> Sequence[Misuse]:
    faults = run.signatures.fault
    index = run.result(INDEX)
    found: list[Misuse] = []
    for used in index.uses():
        owner = used.owner
        within = ""
        if used.use == "goal" and isinstance(owner, nodes.DefineRap):
            within = owner.name
        fault = faults(used.use, used.name, used.count, used.outputs, within)
        if fault is not None:
            found.append(Misuse(used, fault))
    return found


MISUSES = Fact(_run)
"""The comparison of every use of a name with its declaration."""


def misuses(run: Pass, uses: Container[Use], sort: str) -> Iterator[Misuse]:
    """Yield the faults of one sort in some uses, in the order of uses."""
    for one in run.result(MISUSES):
        if one.used.use in uses and one.fault.sort == sort:
            yield one


def declared_at(run: Pass, signature: Signature) -> Span:
    """Return the span of the declaration of a name of the library."""
    if signature.kind == "RAP":
        return signature.span
    return word_span(run.library.files, signature.span, 1)


class UnknownNames:
    """The uses of unknown names, with one finding for each name.

    Args:
        rule: the rule of the findings.
    """

    def __init__(self, rule: Rule) -> None:
        self._rule = rule
        self._uses: dict[tuple[str, int], list[tuple[Fault, Span]]] = {}
        self._about: dict[str, list[Subject]] = {}

    def add(
        self, fault: Fault, span: Span, owner: Form, about: Iterable[Subject] = ()
    ) -> None:
        """Record a use of an unknown name in the top-level form `owner`.

        A test is run alone; for this reason each test has separate findings.
        """
        test = id(owner) if type(owner) is nodes.DefineTest else 0
        self._uses.setdefault((fault.message, test), []).append((fault, span))
        self._about.setdefault(fault.message, []).extend(about)

    def findings(self, run: Pass) -> Iterator[Diagnostic]:
        """Yield the findings, unless a missing file may declare the names."""
        if not run.complete:
            return
        for uses in self._uses.values():
            sure = [(fault, span) for fault, span in uses if not run.unsure(span)]
            if sure:
                fault, first = sure[0]
                here = [use for use in sure if use[1].file == first.file]
                alike = all(use.meant == fault.meant for use, _ in here)
                meant = fault.meant if alike else None
                places = [span for _, span in here]
                fix = renaming(run.library.files, fault.name, meant, places)
                spans = [span for _, span in sure]
                found = self._finding(fault, spans, _unused(run, fault.near))
                yield msgspec.structs.replace(found, fix=fix)

    def _finding(
        self, fault: Fault, spans: Sequence[Span], meant: Iterable[Label]
    ) -> Diagnostic:
        first, *further = spans
        left = len(further) - _SHOWN
        places = "one other place" if left == 1 else f"{left} other places"
        return self._rule.at(
            first,
            fault.message,
            labels=(*meant, *(Label(s, "also used here") for s in further[:_SHOWN])),
            notes=(f"used in {places}",) if left > 0 else (),
            help=fault.help,
            about=tuple(self._about[fault.message]),
        )


def _unused(run: Pass, meant: Signature | None) -> Iterator[Label]:
    """Yield a label at the declaration with a similar name, if the name is unused."""
    if meant is None or meant.kind not in _SAME:
        return
    uses = run.result(USES)
    if not any(uses[use, meant.name] for use in _SAME[meant.kind]):
        label = "nothing uses this similar name"
        yield Label(declared_at(run, meant), label)


_OF_FACTS: Sequence[Use] = ("test", "believed", "asserted", "erased", "computed")

_SAME: Mapping[str, Sequence[Use]] = {
    "RAP": ("goal",),
    "primitive": ("primitive",),
    **dict.fromkeys(("proposition", "property", "function", "query"), _OF_FACTS),
}
"""By type of declaration, the uses of its name."""


# --- the fix for a name -----------------------------------------------------------

_WORD = r"[^\s()\";']"
"""The characters of a name, as a regular expression."""


def renaming(
    files: Mapping[str, SourceFile],
    name: str,
    meant: str | None,
    places: Iterable[Span],
) -> Fix | None:
    """Return the fix that replaces a name at some places, or None.

    A name with too many different letters (`is_slip`) may appear in a question, but not
    in a fix.

    Args:
        files: the files of the library.
        name: the name in the text.
        meant: the correct name; None without a candidate.
        places: the spans of the names, or spans in which the name occurs once.
    """
    if not meant or not is_slip(name, meant):
        return None
    edits = []
    for place in places:
        word = _word(files.get(place.file), name, place)
        if word is None:
            return None
        edits.append(Edit(word, meant))
    return Fix(Applicability.UNSAFE, f"write `{meant}`", tuple(edits))


def _word(source: SourceFile | None, name: str, place: Span) -> Span | None:
    """Return the span of a name at a place; None if the span is not certain."""
    if source is None:
        return None
    whole = rf"(?<!{_WORD}){re.escape(name)}(?!{_WORD})"
    text = source.text[place.start : place.end]
    found = [match.span() for match in re.finditer(whole, text, re.IGNORECASE)]
    if len(found) != 1:
        return None
    ((start, end),) = found
    return source.span(place.start + start, place.start + end)
