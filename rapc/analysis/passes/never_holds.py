"""RAP111: methods that are never chosen.

That is told by literals (`rapc.analysis.literals`). Where a method is chosen the
monitor, preconditions and constraints of its RAP hold, `succeed` has no solution, and
`repeat-while` holds together with the context; what clauses of the RAP bind stays
theirs.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.following import follows
from rapc.analysis.literals import Literal, apart, literals, names
from rapc.analysis.passes.contradictions import ANALYZER as CONTRADICTIONS
from rapc.analysis.passes.contradictions import Reports, first_clash, said
from rapc.analysis.passes.settled import ANALYZER as SETTLED
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.clauses import Clause

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


class _Goal(msgspec.Struct, frozen=True):
    """A way to succeed, in variables of its own."""

    span: Span
    literals: Sequence[Literal]
    #: Its variables that are no inputs or resources.
    free: Container[str]


def _goal(formula: nodes.Formula, given: Container[str]) -> _Goal:
    renamed = apart(formula, given, "@goal")
    free = {name for name in names(renamed) if name not in given}
    return _Goal(formula.span, tuple(literals(renamed)), free)


def _run(run: Pass) -> None:
    for rap in run.library.forms:
        if isinstance(rap, nodes.DefineRap):
            _rap(run, rap)


ANALYZER = Analyzer(
    name="never-holds",
    doc="Finds methods that are never chosen.",
    run=_run,
    needs=(CONTRADICTIONS, SETTLED),
    rules=(UNREACHABLE,),
    needs_whole="form",
)


def _rap(run: Pass, rap: nodes.DefineRap) -> None:
    given = {v.name for v in rap.inputs} | {r.variable.name for r in rap.resources}
    reports = Reports(run, given)
    never = run.result(CONTRADICTIONS)
    held = list(_held(rap, given, never))
    goals = [_goal(formula, given) for formula in _ways_to_succeed(rap)]
    if id(rap) in run.result(SETTLED):
        goals = []
    if _succeeds_first(reports, rap, held, goals) or _apart(reports, rap, held):
        return
    looped = rap.repeat_while
    if looped is not None and id(looped) not in never:
        if _never(reports, looped, held, goals, "repeat-while"):
            return
        held += [_Asked(one, "repeat-while") for one in literals(looped)]
    always: nodes.Method | None = None
    behind: list[nodes.Formula] = []
    for method in rap.methods:
        if method.context is None:
            always = always or method
        elif id(method.context) not in never:
            if always is not None and _asks_otherwise(method.context):
                behind.append(method.context)
            else:
                _never(reports, method.context, held, goals, "this method")
    if always is not None and behind:
        _report_otherwise(run, behind, always)


def _succeeds_first(
    reports: Reports,
    rap: nodes.DefineRap,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
) -> bool:
    """Report a clause that has to hold for a method, and holds with `succeed` alone."""
    for clause, formula in _required(rap) if rap.methods else ():
        own = [one.literal for one in held if one.clause == clause.word]
        for goal in goals if own else ():
            if follows(goal.literals, own, goal.free):
                reports.report(
                    UNREACHABLE,
                    f"no method is ever chosen: where `{clause.word}` holds, "
                    "`succeed` does",
                    formula.span,
                    Label(goal.span, "the RAP has succeeded then"),
                )
                return True
    return False


def _apart(reports: Reports, rap: nodes.DefineRap, held: Sequence[_Asked]) -> bool:
    """Report clauses that have to hold for any method, and never hold together."""
    every = [one.literal for one in held]
    clash = first_clash(reports, (), every) if every and rap.methods else None
    if clash is None:
        return False
    clauses = {id(one.literal): one.clause for one in held}
    one = clauses.get(id(clash.first))
    if one is None or one == clauses.get(id(clash.second)):
        return False
    reports.report(
        UNREACHABLE,
        f"no method is ever chosen: {said(clash.second)} never holds where "
        f"`{one}` does",
        clash.second.span,
        Label(clash.first.span, _why(one)),
    )
    return True


def _held(
    rap: nodes.DefineRap, given: set[str], never: Container[int]
) -> Iterator[_Asked]:
    """Yield what holds where a method is chosen, in variables of its own.

    Clauses whose ids are among `never` hold nowhere, as is said of them already.
    """
    for clause, formula in _required(rap):
        if id(formula) not in never:
            for one in literals(apart(formula, given, f"@{clause.word}")):
                yield _Asked(one, clause.word)
    goal = rap.succeed
    parts = goal.parts if isinstance(goal, nodes.Or) else (goal,)
    for part in parts:
        if isinstance(part, nodes.Not):
            for one in literals(apart(part.part, given, "@succeed")):
                yield _Asked(one, "succeed")


def _required(rap: nodes.DefineRap) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield the clauses that hold where a method is chosen and keep no bindings."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        if clause.required and not clause.hands_on:
            yield clause, formula


def _ways_to_succeed(rap: nodes.DefineRap) -> Iterator[nodes.Formula]:
    """The conjunctions of which none has a solution where a method is chosen."""
    goal = rap.succeed
    if goal is None:
        okay = nodes.Const("okay", rap.name_span)
        yield nodes.HistoryTest("last-result", (okay,), rap.name_span)
    elif isinstance(goal, nodes.Or):
        yield from goal.parts
    elif not isinstance(goal, nodes.Truth):
        yield goal


def _never(
    reports: Reports,
    formula: nodes.Formula,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
    what: str,
) -> bool:
    """Report a formula, or branches of it, that never holds with what is held."""
    own = list(literals(formula))
    whole = _refuted(reports, own, formula.span, held, goals, what)
    if whole is not None:
        reports.report(UNREACHABLE, *whole)
        return True
    for literal in own:
        if isinstance(literal.formula, nodes.Or) and literal.holds:
            others = [one for one in own if one is not literal]
            parts = literal.formula.parts
            found = [
                _refuted(
                    reports,
                    [*others, *literals(part)],
                    part.span,
                    held,
                    goals,
                    "this branch",
                )
                for part in parts
            ]
            if parts and all(found):
                message = f"{what} is never chosen: no branch of this ever holds"
                label = found[0][2] if found[0] else Label(formula.span, "")
                reports.report(UNREACHABLE, message, literal.span, label)
                return True
            for one in found:
                if one is not None:
                    reports.report(UNREACHABLE, *one)
    return False


_Refuted = tuple[str, Span, Label]
"""What is said of something that never holds, where, and beside what."""


def _refuted(
    reports: Reports,
    own: Sequence[Literal],
    span: Span,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
    what: str,
) -> _Refuted | None:
    """Say why literals, none of which contradict each other, never hold."""
    clash = first_clash(reports, [a.literal for a in held], own) if held else None
    if clash is not None:
        clause = next((a.clause for a in held if a.literal is clash.first), None)
        if clause is None:
            return None
        return (
            f"{said(clash.second)} never holds when a method is chosen",
            clash.second.span,
            Label(clash.first.span, _why(clause)),
        )
    everything = [*(a.literal for a in held if a.clause != "succeed"), *own]
    for goal in goals:
        if follows(goal.literals, everything, goal.free):
            return (
                f"{what} is never chosen: where this holds, `succeed` does",
                span,
                Label(goal.span, "the RAP has succeeded then"),
            )
    return None


def _why(clause: str) -> str:
    if clause == "succeed":
        return "this holds as long as `succeed` does not"
    return f"`{clause}` asks for this"


def _asks_otherwise(context: nodes.Formula) -> bool:
    return any(isinstance(one.formula, nodes.Otherwise) for one in literals(context))


def _report_otherwise(
    run: Pass, contexts: Sequence[nodes.Formula], always: nodes.Method
) -> None:
    further = [Label(other.span, "nor is this one") for other in contexts[1:]]
    run.report(
        Diagnostic(
            rule=UNREACHABLE.name,
            message="this method is never chosen: one before it has no context",
            span=contexts[0].span,
            labels=(Label(always.span, "this one holds whatever happens"), *further),
        )
    )
