"""Unused inputs, variables, declarations, facts and things."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index, NameUse, Occurrence
from rapc.analysis.facts.names import declared_at, renaming
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.graph import reachable
from rapc.base.names import Close, Suggestions, is_row, plural
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import steps
from rapc.library.library import Library, name_span
from rapc.library.signature import Signature
from rapc.library.signatures import Use

UNUSED_INPUT = Rule(
    code="RAP160",
    name="unused-input",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP with methods never uses one of its inputs",
    ignore="where several RAPs must have the same inputs",
    source="T 4.2",
)

UNREACHED_RAP = Rule(
    code="RAP161",
    name="unreached-rap",
    severity=Severity.INFO,
    opt_in=True,
    summary="no task of the agendas leads to a RAP",
    ignore="where the command line, a program or another library submits the RAP",
    source="T 5.4",
)


@check(UNUSED_INPUT, UNREACHED_RAP, needs_whole="form")
def leftovers(run: Pass) -> Iterator[Diagnostic]:
    """Find inputs that their RAP never uses, and RAPs that cannot be reached."""
    index = run.result(INDEX)
    yield from _unused_inputs(run, index)
    read = not any(run.unsure(form.span) for form in run.library.forms)
    if run.library.agendas and run.complete and read:
        yield from _unreached(run, index)


def _unused_inputs(run: Pass, index: Index) -> Iterator[Diagnostic]:
    for rap, names in index.variables():
        if not isinstance(rap, nodes.DefineRap) or not rap.methods:
            continue
        if run.library.raps.get(rap.name) is not rap:
            continue
        for variable in rap.inputs:
            uses = [use for use, _, _ in names[variable.name] if use is not variable]
            if not variable.anonymous and not uses:
                yield UNUSED_INPUT.at(
                    variable.span,
                    f"`{rap.name}` never uses its input `{variable.name}`",
                    help="use the input, or remove it here and in all calls",
                )


def _unreached(run: Pass, index: Index) -> Iterator[Diagnostic]:
    calls: dict[str, list[str]] = {}
    given = []
    for goal in index.of(nodes.Goal):
        if isinstance(goal.owner, nodes.DefineRap):
            calls.setdefault(goal.owner.name, []).append(goal.node.name)
        else:
            given.append(goal.node.name)
    reached = set(reachable(given, lambda name: calls.get(name, ())))
    for rap in run.library.raps.values():
        if rap.name not in reached:
            yield UNREACHED_RAP.at(
                rap.name_span,
                f"no submitted task leads to `{rap.name}`",
                help="submit the RAP as a task, call the RAP in a step, or remove "
                "the RAP",
            )


SINGLETON_VARIABLE = Rule(
    code="RAP163",
    name="singleton-variable",
    severity=Severity.INFO,
    opt_in=True,
    summary="a variable occurs once in its form, where `?` has the same meaning",
    ignore="where the name explains the value to the reader",
    source="T 4.1",
)

UNUSED_DECLARATION = Rule(
    code="RAP162",
    name="unused-declaration",
    severity=Severity.INFO,
    opt_in=True,
    summary="a declaration is never used in the library",
    ignore="where the file declares names for several libraries",
    source="T A.1",
)


@check(SINGLETON_VARIABLE, UNUSED_DECLARATION, needs_whole="form")
def singletons(run: Pass) -> Iterator[Diagnostic]:
    """Find variables that occur once, and declarations without a use."""
    index = run.result(INDEX)
    for variable, parent, form in index.used_once():
        if not isinstance(form, nodes.MemoryRule) or parent is not form.index:
            yield SINGLETON_VARIABLE.at(
                variable.span,
                f"`{variable.name}` occurs only here",
                help="write `?` for any value",
            )
    read = not any(run.unsure(form.span) for form in run.library.forms)
    if run.complete and read:
        for declared, how in _unused_declarations(run, index):
            yield UNUSED_DECLARATION.at(
                declared_at(run, declared),
                f"nothing {how} `{declared.name}`",
                help="use the name, or remove the declaration",
            )


_FACTS: Sequence[Use] = ("test", "believed", "computed")
_TOLD: Sequence[Use] = ("asserted", "erased")


def _unused_declarations(run: Pass, index: Index) -> Iterator[tuple[Signature, str]]:
    """Yield the unused declarations, each with the missing action."""
    used = {(one.use, one.name) for one in index.uses()}
    reads = {name for f in run.library.functions.values() for name in f.reads or ()}
    for name, declared in run.signatures.predicates.items():
        if any((use, name) in used for use in _FACTS) or name in reads:
            continue
        told = any((use, name) in used for use in _TOLD)
        yield declared, "queries" if told else "uses"
    for name, declared in run.signatures.primitives.items():
        if ("primitive", name) not in used:
            yield declared, "requests"
    told_data = {name for p in run.library.primitives.values() for name in p.tells}
    for name, declared in run.signatures.data.items():
        if name not in told_data and ("datum", name) not in used:
            yield declared, "tells"


UNREAD_FACT = Rule(
    code="RAP165",
    name="unread-fact",
    severity=Severity.INFO,
    opt_in=True,
    summary="a fact is asserted, but never queried",
    ignore="where the library describes a world for other libraries",
    source="T 2.2",
)

UNASSERTED_FACT = Rule(
    code="RAP166",
    name="unasserted-fact",
    severity=Severity.INFO,
    opt_in=True,
    summary="a fact is queried, but never asserted in the library",
    ignore="where the host or the world asserts the fact at the start, "
    "for example as a map",
    source="T 2.2",
)


class _Uses(msgspec.Struct, frozen=True):
    """The first use of each fact in each way."""

    asked: dict[str, NameUse]
    brought: dict[str, Span]
    taken: dict[str, Span]


@check(UNREAD_FACT, UNASSERTED_FACT)
def facts(run: Pass) -> Iterator[Diagnostic]:
    """Find facts without a source, and facts without a query."""
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
    """Return whether a formula, a function or a comparator may query a fact."""
    return name in uses.asked or any(
        read is None or name in read for read in _readers(library)
    )


def _readers(library: Library) -> Iterator[tuple[str, ...] | None]:
    """Yield the facts that functions and comparators read; None if undeclared."""
    for function in library.functions.values():
        yield function.reads
    for comparator in library.comparators:
        if comparator.function is not None:
            yield None
        yield tuple([row.property for row in comparator.rows])


def _unasserted(run: Pass, uses: _Uses, name: str, place: Span) -> Diagnostic:
    labels = [Label(uses.asked[name].place(run.library.files), "queried here")]
    if name in uses.taken:
        labels.append(Label(uses.taken[name], "erased here"))
    return UNASSERTED_FACT.at(
        place,
        f"nothing in the library asserts `{name}`",
        labels=tuple(labels),
        help="ignore this finding if the host or the world asserts the fact",
    )


def _unread(name: str, place: Span, by: Span) -> Diagnostic:
    return UNREAD_FACT.at(
        place,
        f"nothing in the library queries `{name}`",
        labels=(Label(by, "asserted here"),),
        help="query the fact, or remove it",
    )


UNUSED_CLAIM = Rule(
    code="RAP084",
    name="unused-claim",
    severity=Severity.WARNING,
    summary="a RAP that runs once claims a thing that nothing else uses or claims",
    fix="unsafe: writes the similar thing, if there is one",
    ignore="where another library that runs at the same time uses the thing",
    source="L 8",
)

MISSPELT_THING = Rule(
    code="RAP086",
    name="misspelt-thing",
    severity=Severity.WARNING,
    summary="a thing is named once, and a similar thing exists",
    fix="unsafe: writes the similar thing",
    ignore="where both things are meant: choose a name that is less similar",
    source="L 8",
)


_Sort = tuple[str, int]
"""The name of a thing and the number of its arguments."""

_Places = Mapping[_Sort, Sequence[Occurrence[nodes.Thing]]]
"""The occurrences of things, each once for each method or declaration."""


@check(UNUSED_CLAIM, MISSPELT_THING)
def unused_claim(run: Pass) -> Iterator[Diagnostic]:
    """Find things without another use or claim, and misspelt names of things."""
    places = _places(run.result(INDEX).of(nodes.Thing))
    settled: set[_Sort] = set()
    for one, other in _misspelt(places):
        settled |= {_sort(one), _sort(other)}
        yield _close(run, one.node, other.node)
    users_known = not any(run.unsure(one.span) for one in _offers(run))
    if not run.complete or not users_known:
        return
    near = Suggestions(sorted({name for name, _ in places}))
    callers = _callers(run)
    for sort, named in places.items():
        if sort not in settled and _is_unused(named, places, callers):
            yield _unused_thing(run, named[0].node, near, places)


def _places(things: Iterable[Occurrence[nodes.Thing]]) -> _Places:
    found: dict[_Sort, dict[int, Occurrence[nodes.Thing]]] = {}
    for thing in things:
        sort = thing.node.name, len(thing.node.args)
        found.setdefault(sort, {}).setdefault(id(thing.parent), thing)
    return {sort: list(named.values()) for sort, named in found.items()}


def _misspelt(
    places: _Places,
) -> Iterator[tuple[Occurrence[nodes.Thing], Occurrence[nodes.Thing]]]:
    """Yield each thing named once that has a similar name, with the similar thing.

    If the similar name occurs several times, that name counts as correct. If both names
    occur once, a claim counts as the fault; of two claims, the claim further down.
    """
    close: dict[int, Close] = {}
    for count in {count for _, count in places}:
        names = sorted(name for name, number in places if number == count)
        close[count] = Close(names, THRESHOLDS.close_thing)
    for (name, count), named in places.items():
        others = [
            places[other, count]
            for other in close[count].all_to(name)
            if not is_row(name, other) and _is_meant(places[other, count], named)
        ]
        if others:
            yield named[0], others[0][0]


def _is_meant(
    other: Sequence[Occurrence[nodes.Thing]], named: Sequence[Occurrence[nodes.Thing]]
) -> bool:
    """Return whether a thing with a similar name is the intended thing."""
    (this, *further), that = named, other[0]
    if further or len(other) > 1:
        return not further
    if not isinstance(this.parent, nodes.Method):
        return False
    return not isinstance(that.parent, nodes.Method) or _is_above(that, this)


def _is_above(one: Occurrence[nodes.Thing], other: Occurrence[nodes.Thing]) -> bool:
    first, second = one.node.span, other.node.span
    return (first.file, first.start) < (second.file, second.start)


def _close(run: Pass, thing: nodes.Thing, other: nodes.Thing) -> Diagnostic:
    return MISSPELT_THING.at(
        thing.span,
        f"nothing else uses or claims `{format_formula(thing)}`",
        labels=(Label(other.span, "a similar thing"),),
        help=f"did you mean `{other.name}`?",
        fix=renaming(run.library.files, thing.name, other.name, [thing.span]),
    )


# --- claims without effect ------------------------------------------------------------


def _callers(run: Pass) -> Mapping[str, Sequence[str | None]]:
    """Return, by RAP, the RAPs whose steps call that RAP; None is an agenda."""
    found: dict[str, list[str | None]] = {}
    for agenda in run.library.agendas.values():
        for task in agenda.tasks:
            found.setdefault(task.goal.name, []).append(None)
    for rap in run.library.raps.values():
        for method in rap.methods:
            for step in steps(method):
                found.setdefault(step.goal.name, []).append(rap.name)
    return found


def _runs_once(name: str, callers: Mapping[str, Sequence[str | None]]) -> bool:
    """Return whether a single task of an agenda leads to a RAP, by single steps.

    A host may start any other RAP several times.
    """
    seen = set[str]()
    here: str | None = name
    while here is not None and here not in seen:
        seen.add(here)
        by = callers.get(here, ())
        if len(by) != 1:
            return False
        here = by[0]
    return here is None


def _is_unused(
    named: Sequence[Occurrence[nodes.Thing]],
    places: _Places,
    callers: Mapping[str, Sequence[str | None]],
) -> bool:
    """Return whether a thing has no other use, so that its claims have no effect.

    A thing that occurs elsewhere with different arguments is a fault in any case.
    """
    first = named[0]
    if any(
        not isinstance(one.parent, nodes.Method) or one.owner is not first.owner
        for one in named
    ):
        return False
    assert isinstance(first.owner, nodes.DefineRap)
    name, count = _sort(first)
    elsewhere = any(other == name and number != count for other, number in places)
    return elsewhere or _runs_once(first.owner.name, callers)


def _offers(run: Pass) -> Iterable[nodes.DeclarePrimitive | nodes.DeclareSkill]:
    """Return the declarations that may use things."""
    return (*run.library.primitives.values(), *run.library.skills.values())


def _sort(thing: Occurrence[nodes.Thing]) -> _Sort:
    return thing.node.name, len(thing.node.args)


def _unused_thing(
    run: Pass, thing: nodes.Thing, near: Suggestions, places: _Places
) -> Diagnostic:
    written = format_formula(thing)
    others = sorted(count for name, count in places if name == thing.name)
    others.remove(len(thing.args))
    help_, meant = near.did_you_mean(thing.name), near.near(thing.name)
    if others:
        meant = None
        amount = plural(others[0], "argument") if others[0] else "no arguments"
        help_ = f"other uses of `{thing.name}` have {amount}"
    return UNUSED_CLAIM.at(
        thing.span,
        f"nothing else uses or claims `{written}`",
        help=help_,
        fix=renaming(run.library.files, thing.name, meant, [thing.span]),
    )
