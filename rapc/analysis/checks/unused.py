"""Unused inputs, variables, declarations and facts."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import (
    EFFECTS,
    declared_effects,
    may_establish,
    rule_effects,
)
from rapc.analysis.facts.index import INDEX, Index, NameUse
from rapc.analysis.facts.logic import Literal, asked_by, fact_name, literals
from rapc.analysis.facts.names import declared_at
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.graph import reachable
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import formulas
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


FORGOTTEN = Rule(
    code="RAP190",
    name="forgotten-rap",
    severity=Severity.WARNING,
    summary="tasks lead to all RAPs but the one that brings about a queried fact",
    ignore="where the command line, a program or another library submits the RAP",
    source="T 5.4",
)


@check(UNUSED_INPUT, UNREACHED_RAP, FORGOTTEN, needs_whole="form")
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
    unreached = [rap for rap in run.library.raps.values() if rap.name not in reached]
    below = {name for rap in unreached for name in calls.get(rap.name, ())}
    roots = [rap for rap in unreached if rap.name not in below]
    forgotten = (
        len(roots) == 1
        and len(reached) >= THRESHOLDS.all_reached
        and _is_missed(run, roots[0], reached)
    )
    rule = FORGOTTEN if forgotten else UNREACHED_RAP
    for rap in roots if forgotten else unreached:
        why = ", the only RAP for a fact that others require" if forgotten else ""
        yield rule.at(
            rap.name_span,
            f"no submitted task leads to `{rap.name}`{why}",
            help="submit the RAP as a task, call the RAP in a step, or remove the RAP",
        )


def _is_missed(run: Pass, rap: nodes.DefineRap, reached: Container[str]) -> bool:
    """Return whether only a RAP brings about what the reached RAPs require.

    A context beside other methods is a choice, and requires nothing.
    """
    library, effects = run.library, run.result(EFFECTS)
    others = [one for one in library.raps.values() if one.name in reached]
    known = [effect for one in others for effect in effects.known(one.name)]
    for datum in library.data.values():
        known += declared_effects(datum.on or ())
    for rule in library.event_rules:
        known += rule_effects(rule.rules)
    asked = {
        name
        for one in others
        for formula in formulas(one)
        if formula.clause.word != "context" or len(one.methods) == 1
        for name in asked_by(library, formula.formula)
    }
    goals = [one for one in literals(rap.succeed) if fact_name(one)]
    promised = [Literal(one.pattern, not one.negated) for one in rap.effects]
    return any(
        fact_name(one) in asked and not may_establish(library, one, known)
        for one in (*goals, *promised)
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
