"""RAP111: methods that are never chosen.

That is told by literals (`rapc.analysis.facts.logic`). Where a method is chosen the
monitor, preconditions and constraints of its RAP hold, `succeed` has no solution, and
`repeat-while` holds together with the context; what clauses of the RAP bind stays
theirs.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.contradictions import (
    CONTRADICTIONS,
    clash_at,
    first_clash,
    one_for_each_place,
    said,
)
from rapc.analysis.facts.logic import Clash, Literal, apart, follows, literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.clauses import Clause
from rapc.ir.walk import variable_names

UNREACHABLE = Rule(
    code="RAP111",
    name="unreachable-method",
    severity=Severity.WARNING,
    summary="a method is never chosen, whatever happens",
    why="""A method is chosen when `succeed` has no solution and the monitor, the
preconditions and the constraints of its RAP hold (T 3.2.3). A context that contradicts
one of these, or from which `succeed` follows, never holds then; nor does `otherwise`
behind a method without a context. Where these clauses contradict each other no method
is ever chosen. The plan for that situation is missing, though it stands in the
text.""",
    ignore="where a method is kept for a situation that other libraries will bring "
    "about",
    source="T 3.2.2",
    example="""\
(declare-memory-proposition cart-at (?place))
(declare-primitive drive (?place) (okay))
(declare-primitive turn-round () (okay))
(define-rap (go-to ?place)
  (succeed (cart-at ?place))
  (method (context (not (cart-at ?place))) (primitive (drive ?place)))
  (method (context (cart-at ?place)) (primitive (turn-round))))
""",
    better="""\
(declare-memory-proposition cart-at (?place))
(declare-primitive drive (?place) (okay))
(declare-primitive turn-round () (okay))
(define-rap (go-to ?place)
  (succeed (cart-at ?place))
  (method (context (not (cart-at home))) (primitive (drive ?place)))
  (method (context (cart-at home)) (primitive (turn-round))))
""",
)


class _Asked(msgspec.Struct, frozen=True):
    """A literal that holds where a method is chosen, and the clause that says so."""

    literal: Literal
    clause: str
    #: The literal as it is written, where its variables were given other names.
    written: Literal


class _Goal(msgspec.Struct, frozen=True):
    """A way to succeed, in variables of its own."""

    span: Span
    literals: Sequence[Literal]
    #: Its variables that are no inputs or resources.
    free: Container[str]


class _Chosen(msgspec.Struct, frozen=True):
    """What is so wherever a method of a RAP is chosen, and where findings go."""

    run: Pass
    #: The inputs and resources of the RAP.
    given: Container[str]
    held: list[_Asked]
    goals: Sequence[_Goal]

    def clash(self, own: Sequence[Literal]) -> Clash | None:
        """Return two literals that never hold together, of what is so and some more."""
        held = [one.literal for one in self.held]
        return first_clash(self.run, held, own, self.given) if held else None

    def goal_of(self, held: Sequence[Literal]) -> _Goal | None:
        """Return a way to succeed that follows from literals, if any does."""
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
    never = {id(one.formula) for one in run.result(CONTRADICTIONS)}
    for rap in run.library.forms:
        if isinstance(rap, nodes.DefineRap):
            yield from one_for_each_place(_rap(run, rap, never))


def _rap(
    run: Pass, rap: nodes.DefineRap, never: Container[int]
) -> Iterator[Diagnostic]:
    given = {v.name for v in rap.inputs} | {r.variable.name for r in rap.resources}
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
        at.held.extend(_Asked(one, "repeat-while", one) for one in literals(looped))
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
    """Find a clause that has to hold for a method, and holds with `succeed` alone."""
    for clause, formula in _required(rap) if rap.methods else ():
        own = [one.literal for one in at.held if one.clause == clause.word]
        goal = at.goal_of(own)
        if goal is not None:
            return clash_at(
                UNREACHABLE,
                f"no method is ever chosen: where `{clause.word}` holds, "
                "`succeed` does",
                formula.span,
                Label(goal.span, "the RAP has succeeded then"),
            )
    return None


def _apart(at: _Chosen, rap: nodes.DefineRap) -> Diagnostic | None:
    """Find clauses that have to hold for any method, and never hold together."""
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
        f"no method is ever chosen: {said(second.written)} never holds where "
        f"`{first.clause}` does",
        clash.second.span,
        Label(clash.first.span, _why(first.clause)),
    )


def _held(
    rap: nodes.DefineRap, given: set[str], never: Container[int]
) -> Iterator[_Asked]:
    """Yield what holds where a method is chosen, in variables of its own.

    Clauses whose ids are among `never` hold nowhere, as is said of them already.
    """
    for clause, formula in _required(rap):
        if id(formula) not in never:
            yield from _named_apart(formula, given, clause.word)
    goal = rap.succeed
    parts = goal.parts if isinstance(goal, nodes.Or) else (goal,)
    for part in parts:
        if isinstance(part, nodes.Not):
            yield from _named_apart(part.part, given, "succeed")


def _named_apart(
    formula: nodes.Formula, given: Container[str], clause: str
) -> Iterator[_Asked]:
    renamed = literals(apart(formula, given, f"@{clause}"))
    for one, written in zip(renamed, literals(formula), strict=True):
        yield _Asked(one, clause, written)


def _required(rap: nodes.DefineRap) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield the clauses that hold where a method is chosen and keep no bindings."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        if clause.required and not clause.hands_on:
            yield clause, formula


def _ways_to_succeed(rap: nodes.DefineRap) -> Iterator[nodes.Formula]:
    """The conjunctions of which none has a solution where a method is chosen."""
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
    """Say whether a formula never holds at a choice, or which branches of it do not."""
    dead: list[Diagnostic] = []
    own = list(literals(formula))
    whole = _refuted(at, own, own, formula.span, what)
    if whole is not None:
        return True, [whole]
    for place, literal in enumerate(own):
        if isinstance(literal.formula, nodes.Or) and literal.holds:
            before, behind = own[:place], own[place + 1 :]
            parts = literal.formula.parts
            branches = [(part.span, list(literals(part))) for part in parts]
            found = [
                _refuted(at, [*before, *branch, *behind], branch, span, "this branch")
                for span, branch in branches
            ]
            if parts and all(found):
                message = f"{what} is never chosen: no branch of this ever holds"
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
    """Say why literals, none of which contradict each other, never hold.

    Args:
        at: what is so where a method is chosen.
        own: the literals, in the order in which they are asked.
        about: those of them that may be told of.
        span: where they stand.
        what: what they are.
    """
    clash = at.clash(own)
    if clash is not None:
        clause = next((a.clause for a in at.held if a.literal is clash.first), None)
        if clause is None or not any(clash.second is one for one in about):
            return None
        return clash_at(
            UNREACHABLE,
            f"{said(clash.second)} never holds when a method is chosen",
            clash.second.span,
            Label(clash.first.span, _why(clause)),
        )
    held = [one.literal for one in at.held if one.clause != "succeed"]
    goal = at.goal_of([*held, *own])
    if goal is None:
        return None
    return clash_at(
        UNREACHABLE,
        f"{what} is never chosen: where this holds, `succeed` does",
        span,
        Label(goal.span, "the RAP has succeeded then"),
    )


def _why(clause: str) -> str:
    if clause == "succeed":
        return "this holds as long as `succeed` does not"
    return f"`{clause}` asks for this"


def _asks_otherwise(context: nodes.Formula) -> bool:
    return any(isinstance(one.formula, nodes.Otherwise) for one in literals(context))


def _after_always(
    contexts: Sequence[nodes.Formula], always: nodes.Method
) -> Diagnostic:
    further = [Label(other.span, "nor is this one") for other in contexts[1:]]
    return UNREACHABLE.at(
        contexts[0].span,
        "this method is never chosen: one before it has no context",
        labels=(Label(always.span, "this one holds whatever happens"), *further),
    )
