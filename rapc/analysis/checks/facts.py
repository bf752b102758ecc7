"""RAP165 and RAP166: facts that come from nowhere, or that nobody asks for.

What a planner is promised in `effects` of RAPs brings nothing about by itself. What
tests give and scripts tell counts where it stands in the same library.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index, NameUse
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library, name_span

_DOOR = """\
(declare-memory-property door (?door ?state) unknown)
(declare-memory-proposition heard (?sound))
(declare-primitive push (?door) (okay)
  :on (okay (door ?door open){}))
(define-rap (open ?door)
  (succeed (door ?door open))
  (method{}(primitive (push ?door))))
"""

UNREAD = Rule(
    code="RAP165",
    name="unread-fact",
    severity=Severity.INFO,
    opt_in=True,
    summary="a fact is put into memory, and nothing asks for it",
    why="""What is kept of a world serves those who ask for it: formulas, functions that
read it (`:reads`), comparators. A fact that nobody asks for costs memory and time, and
often shows that a test is missing, or asks for another fact. A library that describes a
whole world for others tells more than it asks itself; the rule is opt-in for that
reason.""",
    ignore="where the library describes a world for others",
    source="T 2.2",
    example=_DOOR.format(" (heard creaking)", " "),
    better=_DOOR.format(
        " (heard creaking)", "\n    (context (not (heard creaking)))\n    "
    ),
)

UNASSERTED = Rule(
    code="RAP166",
    name="unasserted-fact",
    severity=Severity.INFO,
    opt_in=True,
    summary="a fact is asked for, and nothing in the library brings it there",
    why="""A fact that no primitive, datum, rule, notation or test brings there is what
it was at the start: its default, or what the host or the world has given. For maps and
other things that never change this is as it should be, and the rule is opt-in for that
reason; elsewhere another fact was meant, or an effect is not declared.""",
    ignore="where the host or the world gives the fact at the start, as it gives a map",
    source="T 2.2",
    example=_DOOR.format("", "\n    (context (not (heard creaking)))\n    "),
    better=_DOOR.format(
        " (heard creaking)", "\n    (context (not (heard creaking)))\n    "
    ),
)


class _Uses(msgspec.Struct, frozen=True):
    """The first use of each fact in each way."""

    asked: dict[str, NameUse]
    brought: dict[str, Span]
    taken: dict[str, Span]


@check(UNREAD, UNASSERTED)
def facts(run: Pass) -> Iterator[Diagnostic]:
    """Find facts that come from nowhere, and facts that nobody asks for."""
    library = run.library
    if not run.complete or any(run.unsure(form.span) for form in library.forms):
        return
    uses = _uses(run.result(INDEX))
    declared: dict[str, nodes.DeclareProposition | nodes.DeclareProperty] = {
        **library.propositions,
        **library.properties,
    }
    for name, form in declared.items():
        place = name_span(library.files, form)
        if name in uses.asked and name not in uses.brought:
            yield _unasserted(run, uses, name, place)
        elif name in uses.brought and not _is_read(library, uses, name):
            yield _unread(name, place, uses.brought[name])


def _uses(index: Index) -> _Uses:
    found = _Uses({}, {}, {})
    negated = {
        id(effect.node.pattern)
        for effect in index.of(nodes.DeclaredEffect)
        if effect.node.negated
    }
    promised = {
        id(effect.node.pattern)
        for effect in index.of(nodes.DeclaredEffect)
        if type(effect.parent) is nodes.DefineRap
    }
    for one in index.uses():
        if one.use in ("test", "believed"):
            if type(one.owner) is not nodes.DefineTest:
                found.asked.setdefault(one.name, one)
        elif id(one.node) in promised:
            continue
        elif one.use == "erased" or id(one.node) in negated:
            found.taken.setdefault(one.name, one.span)
        elif one.use == "asserted":
            found.brought.setdefault(one.name, one.span)
    return found


def _is_read(library: Library, uses: _Uses, name: str) -> bool:
    """Whether anything may ask for a fact: a formula, a function, a comparator."""
    return name in uses.asked or any(
        read is None or name in read for read in _readers(library)
    )


def _readers(library: Library) -> Iterator[tuple[str, ...] | None]:
    """Yield what functions and comparators read; None where they do not say."""
    for function in library.functions.values():
        yield function.reads
    for comparator in library.comparators:
        if comparator.function is not None:
            yield None
        yield tuple([row.property for row in comparator.rows])


def _unasserted(run: Pass, uses: _Uses, name: str, place: Span) -> Diagnostic:
    labels = [Label(uses.asked[name].place(run.library.files), "asked here")]
    if name in uses.taken:
        labels.append(Label(uses.taken[name], "taken away here"))
    return UNASSERTED.at(
        place,
        f"nothing in the library ever brings `{name}` there",
        labels=tuple(labels),
        help="ignore this where the host or the world gives it",
    )


def _unread(name: str, place: Span, by: Span) -> Diagnostic:
    return UNREAD.at(
        place,
        f"nothing in the library asks for `{name}`",
        labels=(Label(by, "put into memory here"),),
        help="ask for it, or leave it out",
    )
