"""RAP110 and RAP111: formulas that never hold, and methods never chosen.

Both are told by literals (`rapc.analysis.literals`). Where a method is chosen the
monitor, preconditions and constraints of its RAP hold, `succeed` has no solution, and
`repeat-while` holds together with the context; what clauses of the RAP bind stays
theirs.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.literals import (
    Clash,
    Conjunction,
    Literal,
    apart,
    follows,
    literals,
    names,
)
from rapc.analysis.passes.settled import ANALYZER as SETTLED
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import formulas

CONTRADICTION = Rule(
    code="RAP110",
    name="contradiction",
    severity=Severity.WARNING,
    summary="two parts of a formula never hold together",
    why="""A property has one value at a time; what is asked cannot be denied as well;
no number is below 3 and above 5. A conjunction, or a branch of an `or`, with two such
parts never holds, whatever happens: mostly `or` was meant, or one of the two speaks of
another thing (T 4.1).""",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (and (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (or (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
)

UNREACHABLE = Rule(
    code="RAP111",
    name="unreachable-method",
    severity=Severity.WARNING,
    summary="a method is never chosen, whatever happens",
    why="""A method is chosen when `succeed` has no solution and the monitor, the
preconditions and the constraints of its RAP hold (T 3.2.3). A context that contradicts
one of these, or from which `succeed` follows, never holds then; nor does `otherwise`
behind a method without a context. The plan for that situation is missing, though it
stands in the text.""",
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


class _Reports:
    """Where the findings of one form go: each place is told of once."""

    def __init__(self, run: Pass, given: Container[str]) -> None:
        self.run = run
        self.given = given
        self._told: set[Span] = set()

    def report(self, rule: Rule, message: str, span: Span, label: Label) -> None:
        """Report a place that no finding was about before."""
        if span in self._told:
            return
        self._told.add(span)
        labels = (label,) if label.span != span else ()
        self.run.report(Diagnostic(rule.name, message, span, labels=labels))

    def conjunction(self, held: Sequence[_Asked]) -> Conjunction:
        """Return a conjunction that has literals of other clauses in it."""
        made = Conjunction(self.run.signatures.relations, self.given)
        for one in held:
            made.add(one.literal)
        return made


def _run(run: Pass) -> None:
    for form in run.library.forms:
        if isinstance(form, nodes.DefineRap):
            _rap(run, form)
        elif isinstance(form, nodes.DefineQuery):
            given = {arg.variable.name for arg in form.args}
            _contradictions(_Reports(run, given), form.formula)
        elif isinstance(form, nodes.MemoryRule | nodes.EventRule):
            for formula in _queries(form):
                _contradictions(_Reports(run, ()), formula)


ANALYZER = Analyzer(
    name="never-holds",
    doc="Finds formulas that never hold, and methods that are never chosen.",
    run=_run,
    needs=(SETTLED,),
    rules=(CONTRADICTION, UNREACHABLE),
    needs_whole="form",
)


def _queries(form: nodes.MemoryRule | nodes.EventRule) -> Iterator[nodes.Formula]:
    rules = (
        form.rules
        if isinstance(form, nodes.EventRule)
        else [rule for case in form.cases for rule in case.rules]
    )
    for rule in rules:
        for alternative in rule.alternatives:
            yield alternative.query


# --- one formula ---------------------------------------------------------------------


def _contradictions(reports: _Reports, formula: nodes.Formula) -> bool:
    """Report what never holds in a formula; return whether anything was found."""
    if not isinstance(formula, nodes.And | nodes.Or | nodes.Not):
        return False
    found = False
    waiting: list[tuple[nodes.Formula, list[Literal]]] = [(formula, [])]
    while waiting:
        here, outer = waiting.pop()
        made = reports.conjunction([_Asked(one, "") for one in outer])
        own = list(literals(here))
        clash = _first_clash(made, own)
        if clash is not None:
            _report_contradiction(reports, clash)
            found = True
            continue
        for literal in own:
            if isinstance(literal.formula, nodes.Or):
                others = [*outer, *(one for one in own if one is not literal)]
                kept = others if literal.holds else []
                waiting += [(part, kept) for part in reversed(literal.formula.parts)]
            elif isinstance(literal.formula, nodes.And | nodes.Not):
                waiting.append((literal.formula, []))
    return found


def _first_clash(made: Conjunction, own: Sequence[Literal]) -> Clash | None:
    for literal in own:
        clash = made.add(literal)
        if clash is not None:
            return clash
    return None


def _report_contradiction(reports: _Reports, clash: Clash) -> None:
    reports.report(
        CONTRADICTION,
        f"{_said(clash.second)} and {_said(clash.first)} never hold together",
        clash.second.span,
        Label(clash.first.span, "asked here" if clash.first.holds else "denied here"),
    )


def _said(literal: Literal) -> str:
    text = format_formula(literal.formula)
    if len(text) > _LONG:
        text = text[:_LONG] + "..."
    return f"`{text}`" if literal.holds else f"`(not {text})`"


_LONG = 50
"""How many letters of a formula are told."""


# --- a RAP --------------------------------------------------------------------------


def _rap(run: Pass, rap: nodes.DefineRap) -> None:
    given = {v.name for v in rap.inputs} | {r.variable.name for r in rap.resources}
    reports = _Reports(run, given)
    sound = {
        id(one.formula): not _contradictions(reports, one.formula)
        for one in formulas(rap)
    }
    held = list(_held(rap, given))
    goals = [_goal(formula, given) for formula in _ways_to_succeed(rap)]
    if id(rap) in run.result(SETTLED):
        goals = []
    if _succeeds_first(reports, rap, held, goals):
        return
    looped = rap.repeat_while
    if looped is not None and sound[id(looped)]:
        if _never(reports, looped, held, goals, "repeat-while"):
            return
        held += [_Asked(one, "repeat-while") for one in literals(looped)]
    always: nodes.Method | None = None
    behind: list[nodes.Formula] = []
    for method in rap.methods:
        if method.context is None:
            always = always or method
        elif sound[id(method.context)]:
            if always is not None and _asks_otherwise(method.context):
                behind.append(method.context)
            else:
                _never(reports, method.context, held, goals, "this method")
    if always is not None and behind:
        _report_otherwise(run, behind, always)


def _succeeds_first(
    reports: _Reports,
    rap: nodes.DefineRap,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
) -> bool:
    """Report a clause that has to hold for a method, and holds with `succeed` alone."""
    clauses = {
        "monitor-state": rap.monitor_state,
        "preconditions": rap.preconditions,
        "constraints": rap.constraints,
    }
    for clause, formula in clauses.items() if rap.methods else ():
        own = [one.literal for one in held if one.clause == clause]
        for goal in goals if own and formula is not None else ():
            assert formula is not None
            if follows(goal.literals, own, goal.free):
                reports.report(
                    UNREACHABLE,
                    f"no method is ever chosen: where `{clause}` holds, `succeed` does",
                    formula.span,
                    Label(goal.span, "the RAP has succeeded then"),
                )
                return True
    return False


def _held(rap: nodes.DefineRap, given: set[str]) -> Iterator[_Asked]:
    """Yield what holds where a method is chosen, in variables of its own."""
    clauses: Mapping[str, nodes.Formula | None] = {
        "monitor-state": rap.monitor_state,
        "preconditions": rap.preconditions,
        "constraints": rap.constraints,
    }
    for clause, formula in clauses.items():
        if formula is not None:
            for one in literals(apart(formula, given, f"@{clause}")):
                yield _Asked(one, clause)
    goal = rap.succeed
    parts = goal.parts if isinstance(goal, nodes.Or) else (goal,)
    for part in parts:
        if isinstance(part, nodes.Not):
            for one in literals(apart(part.part, given, "@succeed")):
                yield _Asked(one, "succeed")


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
    reports: _Reports,
    formula: nodes.Formula,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
    what: str,
) -> bool:
    """Report a formula, or branches of it, that never holds with what is held."""
    own = list(literals(formula))
    if _refuted(reports, own, formula.span, held, goals, what):
        return True
    for literal in own:
        if isinstance(literal.formula, nodes.Or) and literal.holds:
            others = [one for one in own if one is not literal]
            for part in literal.formula.parts:
                branch = [*others, *literals(part)]
                _refuted(reports, branch, part.span, held, goals, "this branch")
    return False


def _refuted(
    reports: _Reports,
    own: Sequence[Literal],
    span: Span,
    held: Sequence[_Asked],
    goals: Sequence[_Goal],
    what: str,
) -> bool:
    """Report literals, none of which contradict each other, that never hold."""
    clash = _first_clash(reports.conjunction(held), own) if held else None
    if clash is not None:
        clause = next((a.clause for a in held if a.literal is clash.first), None)
        if clause is None:
            return True
        reports.report(
            UNREACHABLE,
            f"{_said(clash.second)} never holds when a method is chosen",
            clash.second.span,
            Label(clash.first.span, _why(clause)),
        )
        return True
    everything = [*(a.literal for a in held if a.clause != "succeed"), *own]
    for goal in goals:
        if follows(goal.literals, everything, goal.free):
            reports.report(
                UNREACHABLE,
                f"{what} is never chosen: where this holds, `succeed` does",
                span,
                Label(goal.span, "the RAP has succeeded then"),
            )
            return True
    return False


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
