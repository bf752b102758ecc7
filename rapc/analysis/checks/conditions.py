"""RAP110, RAP111, RAP117: conditions that never hold or have duplicate parts.

A conjunction is split into literals (`rapc.analysis.facts.logic`); the checks find two
literals that never hold together. Each branch of an `or` is combined with the formulas
around the `or`. When a method is chosen, the monitor, preconditions and constraints of
its RAP hold, `succeed` has no solution, and `repeat-while` holds together with the
context. Bindings in the clauses of the RAP are local to the clause.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from typing import NamedTuple

import msgspec

from rapc.analysis.check import Fact, Pass, RapFact, check
from rapc.analysis.facts.bindings import Bound, whole_formulas
from rapc.analysis.facts.clashes import clash_at, first_clash, said
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import (
    Clash,
    Literal,
    apart,
    follows,
    literals,
)
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.clauses import Clause
from rapc.ir.printer import format_formula
from rapc.ir.walk import given_names, subformulas, variable_names, ways

CONTRADICTION = Rule(
    code="RAP110",
    name="contradiction",
    severity=Severity.WARNING,
    summary="two parts of a formula contradict each other",
    ignore="where a method is disabled on purpose: write `nil` as its context",
    source="T 4.1.3",
)


class Contradiction(NamedTuple):
    """A formula of a clause that never holds, and its contradictory literals."""

    formula: nodes.Formula
    clash: Clash


def _run(run: Pass) -> Sequence[Contradiction]:
    return [
        one
        for form in run.library.forms
        for one in (
            run.of(_OF_RAP, form)
            if isinstance(form, nodes.DefineRap)
            else _of_form(run, form)
        )
    ]


def _of_form(run: Pass, form: nodes.TopForm) -> Sequence[Contradiction]:
    return tuple(
        [
            Contradiction(formula, clash)
            for formula, given in whole_formulas(form, run.library.functions)
            for clash in _contradictions(run, formula, given)
        ]
    )


_OF_RAP = RapFact(_of_form)
"""The contradictions in the clauses of a RAP."""


CONTRADICTIONS = Fact(_run)
"""The contradictions in clauses, in the order of the text."""


@check(CONTRADICTION, needs_whole="form")
def contradictions(run: Pass) -> Iterable[Diagnostic]:
    """Find formulas that never hold."""
    every = run.result(CONTRADICTIONS)
    return one_for_each_place(_contradiction(one.clash) for one in every)


def one_for_each_place(found: Iterable[Diagnostic]) -> Iterable[Diagnostic]:
    """Return the first finding at each place."""
    first: dict[Span, Diagnostic] = {}
    for one in found:
        first.setdefault(one.span, one)
    return first.values()


class _Asked(NamedTuple):
    """A formula, and the literals evaluated together with the formula."""

    formula: nodes.Formula
    #: The variables that may have values before the first literal.
    given: Container[str]
    before: Sequence[Literal] = ()
    behind: Sequence[Literal] = ()


def _contradictions(
    run: Pass, formula: nodes.Formula, given: Container[str]
) -> Iterator[Clash]:
    """Yield the contradictions in a formula.

    Args:
        run: the pass.
        formula: the formula.
        given: the variables that may have values before the formula.
    """
    if not isinstance(formula, _JOINED):
        return
    waiting = [_Asked(formula, given)]
    while waiting:
        here = waiting.pop()
        own = literals(here.formula)
        after = [*own, *here.behind]
        clash = first_clash(run, here.before, after, here.given)
        if clash is not None:
            if any(clash.second is one for one in here.behind):
                clash = Clash(clash.second, clash.first)
            if any(clash.second is one for one in own):
                yield clash
            continue
        for at, literal in enumerate(own):
            inner = literal.formula
            if not isinstance(inner, _JOINED):
                continue
            before = [*here.before, *own[:at]]
            if literal.holds:
                asked = _Asked(inner, here.given, before, after[at + 1 :])
            else:
                asked = _Asked(inner, _bound_by(here.given, before))
            waiting += [asked._replace(formula=w) for w in reversed(ways(inner))]


def _bound_by(given: Container[str], before: Iterable[Literal]) -> Container[str]:
    """Return the variables that may have values after some literals."""
    held = [set(variable_names(one.formula)) for one in before if one.holds]
    return Bound(given, set().union(*held)) if held else given


_JOINED = (nodes.And, nodes.Or, nodes.Not)
"""The formulas that combine other formulas."""


def _contradiction(clash: Clash) -> Diagnostic:
    return clash_at(
        CONTRADICTION,
        f"{said(clash.second)} and {said(clash.first)} contradict each other",
        clash.second.span,
        Label(clash.first.span, "queried here" if clash.first.holds else "denied here"),
    )


UNREACHABLE = Rule(
    code="RAP111",
    name="unreachable-method",
    severity=Severity.WARNING,
    summary="a method can never be chosen",
    ignore="where other libraries make the context of the method possible",
    source="T 3.2.2",
)


class _Held(msgspec.Struct, frozen=True):
    """A literal that holds when a method is chosen, and its clause."""

    literal: Literal
    clause: str
    #: The literal as written, if its variables were renamed.
    written: Literal


class _Goal(msgspec.Struct, frozen=True):
    """A way to succeed, with renamed variables."""

    span: Span
    literals: Sequence[Literal]
    #: The variables that are not inputs or resources.
    free: Container[str]


class _Chosen(msgspec.Struct, frozen=True):
    """The literals that hold when a method of a RAP is chosen, and its goals."""

    run: Pass
    #: The inputs and resources of the RAP.
    given: Container[str]
    held: list[_Held]
    goals: Sequence[_Goal]

    def clash(self, own: Sequence[Literal]) -> Clash | None:
        """Return two contradictory literals of the held literals and `own`, or None."""
        held = [one.literal for one in self.held]
        return first_clash(self.run, held, own, self.given) if held else None

    def goal_of(self, held: Sequence[Literal]) -> _Goal | None:
        """Return a way to succeed that some literals entail, or None."""
        relations = self.run.signatures.relations
        for goal in self.goals if held else ():
            if follows(goal.literals, held, goal.free, relations, self.given):
                return goal
        return None


def _goal(formula: nodes.Formula, given: Container[str]) -> _Goal:
    renamed = apart(formula, given, "@goal")
    free = {name for name in variable_names(renamed) if name not in given}
    return _Goal(formula.span, tuple(literals(renamed)), free)


@check(UNREACHABLE, needs_whole="form")
def never_holds(run: Pass) -> Iterator[Diagnostic]:
    """Find methods that are never chosen."""
    for rap in run.library.forms:
        if isinstance(rap, nodes.DefineRap):
            yield from run.of(UNREACHABLE_METHODS, rap)


def _never_holds(run: Pass, rap: nodes.DefineRap) -> Sequence[Diagnostic]:
    return tuple(one_for_each_place(_rap(run, rap)))


UNREACHABLE_METHODS = RapFact(_never_holds)
"""The findings about methods of a RAP that are never chosen."""


def _rap(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    never = {id(one.formula) for one in run.of(_OF_RAP, rap)}
    given = given_names(rap)
    goals = [_goal(formula, given) for formula in _ways_to_succeed(rap)]
    at = _Chosen(run, given, list(_held(rap, given, never)), goals)
    hopeless = _succeeds_first(at, rap) or _apart(at, rap)
    if hopeless is not None:
        yield hopeless
        return
    looped = rap.repeat_while
    if looped is not None and id(looped) not in never:
        whole, found = _never(at, looped, "repeat-while")
        yield from found
        if whole:
            return
        at.held.extend(_Held(one, "repeat-while", one) for one in literals(looped))
    always: nodes.Method | None = None
    behind: list[nodes.Formula] = []
    for method in rap.methods:
        if method.context is None:
            always = always or method
        elif id(method.context) not in never:
            if always is not None and _asks_otherwise(method.context):
                behind.append(method.context)
            else:
                yield from _never(at, method.context, "this method")[1]
    if always is not None and behind:
        yield _after_always(behind, always)


def _succeeds_first(at: _Chosen, rap: nodes.DefineRap) -> Diagnostic | None:
    """Find a clause that every method requires, and that entails `succeed`."""
    for clause, formula in _required(rap) if rap.methods else ():
        own = [one.literal for one in at.held if one.clause == clause.word]
        goal = at.goal_of(own)
        if goal is not None:
            return clash_at(
                UNREACHABLE,
                "no method can be chosen: `succeed` holds wherever "
                f"`{clause.word}` holds",
                formula.span,
                Label(goal.span, "the RAP has already succeeded then"),
            )
    return None


def _apart(at: _Chosen, rap: nodes.DefineRap) -> Diagnostic | None:
    """Find clauses that every method requires, but that never hold together."""
    every = [one.literal for one in at.held]
    if not every or not rap.methods:
        return None
    clash = first_clash(at.run, (), every, at.given)
    if clash is None:
        return None
    asked = {id(one.literal): one for one in at.held}
    first, second = asked.get(id(clash.first)), asked.get(id(clash.second))
    if first is None or second is None or first.clause == second.clause:
        return None
    return clash_at(
        UNREACHABLE,
        f"no method can be chosen: {said(second.written)} contradicts `{first.clause}`",
        clash.second.span,
        Label(clash.first.span, _why(first.clause)),
    )


def _held(
    rap: nodes.DefineRap, given: set[str], never: Container[int]
) -> Iterator[_Held]:
    """Yield the literals that hold when a method is chosen, with renamed variables.

    Clauses whose ids are in `never` are left out, because these clauses are reported by
    another check.
    """
    for clause, formula in _required(rap):
        if id(formula) not in never:
            yield from _named_apart(formula, given, clause.word)
    goal = rap.succeed
    for part in ways(goal):
        if isinstance(part, nodes.Not):
            yield from _named_apart(part.part, given, "succeed")


def _named_apart(
    formula: nodes.Formula, given: Container[str], clause: str
) -> Iterator[_Held]:
    renamed = literals(apart(formula, given, f"@{clause}"))
    for one, written in zip(renamed, literals(formula), strict=True):
        yield _Held(one, clause, written)


def _required(rap: nodes.DefineRap) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield the clauses that hold when a method is chosen and keep no bindings."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        if clause.required and not clause.hands_on:
            yield clause, formula


def _ways_to_succeed(rap: nodes.DefineRap) -> Iterator[nodes.Formula]:
    """Yield the conjunctions without a solution when a method is chosen."""
    goal = rap.succeed
    if goal is None:
        okay = nodes.Const("okay", span=rap.name_span)
        yield nodes.HistoryTest("last-result", (okay,), span=rap.name_span)
    elif isinstance(goal, nodes.Or):
        yield from goal.parts
    elif not isinstance(goal, nodes.Truth):
        yield goal


def _never(
    at: _Chosen, formula: nodes.Formula, what: str
) -> tuple[bool, Sequence[Diagnostic]]:
    """Return whether a formula never holds at a choice, with findings."""
    dead: list[Diagnostic] = []
    own = literals(formula)
    whole = _refuted(at, own, own, formula.span, what)
    if whole is not None:
        return True, [whole]
    for place, literal in enumerate(own):
        if isinstance(literal.formula, nodes.Or) and literal.holds:
            before, behind = own[:place], own[place + 1 :]
            parts = literal.formula.parts
            branches = [(part.span, literals(part)) for part in parts]
            found = [
                _refuted(at, [*before, *branch, *behind], branch, span, "this branch")
                for span, branch in branches
            ]
            if parts and all(found):
                message = (
                    f"{what} can never be chosen: no branch of this formula can hold"
                )
                label = (
                    found[0].labels[0]
                    if found[0] and found[0].labels
                    else Label(formula.span, "")
                )
                return True, [clash_at(UNREACHABLE, message, literal.span, label)]
            dead += [one for one in found if one is not None]
    return False, dead


def _refuted(
    at: _Chosen,
    own: Sequence[Literal],
    about: Sequence[Literal],
    span: Span,
    what: str,
) -> Diagnostic | None:
    """Return a finding if literals, consistent in themselves, never hold.

    Args:
        at: the literals that hold when a method is chosen.
        own: the literals, in the order of evaluation.
        about: the literals of `own` that may be reported.
        span: the span of the literals.
        what: the description of the literals.
    """
    clash = at.clash(own)
    if clash is not None:
        clause = next((a.clause for a in at.held if a.literal is clash.first), None)
        if clause is None or not any(clash.second is one for one in about):
            return None
        return clash_at(
            UNREACHABLE,
            f"{said(clash.second)} cannot hold when a method is chosen",
            clash.second.span,
            Label(clash.first.span, _why(clause)),
        )
    held = [one.literal for one in at.held if one.clause != "succeed"]
    goal = at.goal_of([*held, *own])
    if goal is None:
        return None
    return clash_at(
        UNREACHABLE,
        f"{what} can never be chosen: `succeed` holds wherever this formula holds",
        span,
        Label(goal.span, "the RAP has already succeeded then"),
    )


def _why(clause: str) -> str:
    if clause == "succeed":
        return "this formula holds until `succeed` holds"
    return f"`{clause}` requires this formula"


def _asks_otherwise(context: nodes.Formula) -> bool:
    return any(isinstance(one.formula, nodes.Otherwise) for one in literals(context))


def _after_always(
    contexts: Sequence[nodes.Formula], always: nodes.Method
) -> Diagnostic:
    further = [
        Label(other.span, "this method can never be chosen, either")
        for other in contexts[1:]
    ]
    return UNREACHABLE.at(
        contexts[0].span,
        "this method can never be chosen: a method before it has no context",
        labels=(Label(always.span, "this method can always be chosen"), *further),
    )


TWICE = Rule(
    code="RAP117",
    name="said-twice",
    severity=Severity.WARNING,
    summary="duplicate part of an `and` or `or`",
    fix="safe: removes the second part",
    ignore="never: the second part changes nothing",
    source="T 4.1.3",
)


@check(TWICE)
def said_twice(run: Pass) -> Iterator[Diagnostic]:
    """Find duplicate parts of an `and` or `or`."""
    index = run.result(INDEX)
    for conjunction in index.of(nodes.And):
        yield from _look(run, conjunction.node.parts, joined=True)
    for choice in index.of(nodes.Or):
        yield from _look(run, choice.node.parts, joined=False)


def _look(
    run: Pass, parts: tuple[nodes.Formula, ...], *, joined: bool
) -> Iterator[Diagnostic]:
    if len({_head(part) for part in parts}) == len(parts):
        return
    first: dict[nodes.Formula, nodes.Formula] = {}
    for at, part in enumerate(parts):
        other = first.setdefault(part, part)
        if other is part or (joined and _is_another(run, parts[:at], part)):
            continue
        whole = Span(part.span.file, parts[at - 1].span.end, part.span.end)
        fix = Fix(Applicability.SAFE, "remove the part", (Edit(whole, ""),))
        yield TWICE.at(
            part.span,
            f"duplicate part `{format_formula(part)}`",
            labels=(Label(other.span, "the first part"),),
            fix=fix,
        )


def _is_another(
    run: Pass, before: Sequence[nodes.Formula], part: nodes.Formula
) -> bool:
    """Return whether a part may differ in meaning from an equal part before.

    A formula between two equal `not` parts may bind a variable of the `not`. The first
    `not` is then about all things, the second about a single thing. A default or a
    query may hold for that thing and still not bind a free variable [L 2.21]. An age
    that a `believe` has bound is a limit in the following formulas [L 2.56].
    """
    if isinstance(part, nodes.Believe):
        return isinstance(part.age, nodes.Var) and not part.age.anonymous
    if not isinstance(part, nodes.Not):
        return False
    at = before.index(part)
    late = set(_bound(before[at:])) - set(_bound(before[:at]))
    relations = run.signatures.relations
    return not late.isdisjoint(variable_names(part)) and any(
        isinstance(one, nodes.SensorName)
        or (
            isinstance(one, nodes.Proposition)
            and (one.name not in relations or relations[one.name].is_property)
        )
        for one in subformulas(part)
    )


def _bound(parts: Sequence[nodes.Formula]) -> Sequence[str]:
    return variable_names(*[one for one in parts if not isinstance(one, nodes.Not)])


def _head(part: nodes.Formula) -> object:
    """Return a key that is equal for duplicate parts and rarely for others."""
    return part.name if type(part) is nodes.Proposition else type(part)
