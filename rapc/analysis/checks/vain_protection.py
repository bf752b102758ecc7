"""RAP143: formulas with `for` that no step before them can bring about."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.hopeless import can_come
from rapc.analysis.checks.task_nets import TASK_NETS, Net
from rapc.analysis.facts.bindings import MayBeBound
from rapc.analysis.facts.effects import EFFECTS, Effect, Effects, done
from rapc.analysis.facts.logic import (
    Literal,
    contradict,
    fact_name,
    is_computed,
    literals,
)
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import FormulaAt, formulas, steps, variable_names

_WORLD = """\
(declare-memory-proposition bay-open ())
(declare-memory-proposition hatch-open ())
(declare-primitive open-bay () (okay) :on (okay (bay-open)))
(declare-primitive unload () (okay) :on (okay (not (bay-open))))
(define-rap (open) (method (primitive (open-bay))))
(define-rap (empty) (method (primitive (unload))))
"""

VAIN = Rule(
    code="RAP143",
    name="vain-protection",
    severity=Severity.WARNING,
    summary="a formula with `for` asks for what no step up to there can bring about",
    why="""A formula with `for` has to hold when its step has ended and until the other
one begins; if it does not, the method fails with `interference` (T 4.7.3). Here neither
the step nor one before it changes the fact in that way, as far as declarations say, and
no clause of the RAP asks for it: it holds by luck alone. Another fact was meant, or an
effect is not declared.""",
    ignore="where the fact holds from the start, and nothing is to take it away",
    source="T 4.7.3",
    example=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((hatch-open) for t2))
    (t2 (empty)))))
""",
    better=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty)))))
""",
)


@check(VAIN, needs_whole="form")
def vain_protection(run: Pass) -> Iterator[Diagnostic]:
    """Find formulas with `for` that no step before them can bring about."""
    nets = run.result(TASK_NETS)
    known: dict[str, _ByName | None] = {}
    for rap in run.library.raps.values() if run.complete else ():
        for method in rap.methods:
            net = nets.get(id(method.body))
            if not isinstance(method.body, nodes.TaskNet) or net is None:
                continue
            if net.broken or net.order is None or not _protects(method.body):
                continue
            yield from _of_net(run, rap, method, net, known)


def _asked(rap: nodes.DefineRap) -> set[str]:
    """The facts that the clauses of a RAP ask for: they may hold before it begins.

    Those that the clauses deny surely do not.
    """
    found = set()
    waiting = [
        (one.formula, True)
        for one in formulas(rap)
        if one.clause.required and one.step is None
    ]
    while waiting:
        formula, holds = waiting.pop()
        match formula:
            case nodes.And() | nodes.Or():
                waiting += [(part, holds) for part in formula.parts]
            case nodes.Not():
                waiting.append((formula.part, not holds))
            case nodes.Believe() if holds:
                found.add(formula.pattern.name)
            case nodes.Proposition() if holds:
                found.add(formula.name)
    return found


_ByName = Mapping[str, Sequence[Effect]]
"""What a RAP may do, by the names of facts."""


def _protects(body: nodes.TaskNet) -> bool:
    notes = [note for step in body.steps for note in step.annotations]
    return any(isinstance(n, nodes.For) and n.formula is not None for n in notes)


def _by_name(effects: Effects, name: str) -> _ByName | None:
    done = effects.of(name)
    if done is None:
        return None
    found: dict[str, list[Effect]] = {}
    for effect in done:
        found.setdefault(effect.name, []).append(effect)
    return found


_Changers = Mapping[str, Sequence[tuple[int, Sequence[Effect]]]]
"""By the names of facts: the steps that may change them, each with its effects."""


def _changers(
    run: Pass, steps: Sequence[nodes.Step], known: dict[str, _ByName | None]
) -> _Changers | None:
    """Return which steps may change which facts; None if not all of that is known."""
    changers: dict[str, list[tuple[int, Sequence[Effect]]]] = {}
    for at, step in enumerate(steps):
        name = step.goal.name
        if name not in known:
            known[name] = _by_name(run.result(EFFECTS), name)
        done = known[name]
        if done is None:
            return None
        for fact, effects in done.items():
            changers.setdefault(fact, []).append((at, effects))
    return changers


def _of_net(
    run: Pass,
    rap: nodes.DefineRap,
    method: nodes.Method,
    net: Net,
    known: dict[str, _ByName | None],
) -> Iterator[Diagnostic]:
    """Yield what steps protect that no step before the other one can bring about."""
    every = steps(method)
    changers = _changers(run, every, known)
    if changers is None:
        return
    asked = _asked(rap)
    bound = MayBeBound(rap, run.library.functions)
    places = {step.tag: at for at, step in enumerate(every)}
    for at, step in enumerate(every):
        for note in step.annotations:
            if not isinstance(note, nodes.For) or note.formula is None:
                continue
            given = bound.at(FormulaAt(note.formula, clauses.FOR, method, step))
            until = places[note.tag]
            for one in literals(note.formula):
                fact = fact_name(one)
                there = changers.get(fact, [])
                if not fact or len(there) > _MOST:
                    continue
                if not one.holds:
                    others = [change for change in there if change[0] != at]
                    if _undoes(run, step, one) and not _comes(
                        run, one, others, net, until
                    ):
                        yield _finding(one, step)
                elif not (
                    fact in asked
                    or is_computed(run.library, fact)
                    or _is_looked_up(one, given)
                    or _may_be_default(run, one)
                    or _comes(run, one, there, net, until)
                ):
                    yield _finding(one, step)


_MOST = 20
"""Where more steps than this change a fact, one of them may well bring it about."""


def _is_looked_up(one: Literal, given: Container[str]) -> bool:
    """Whether a fact is asked for the sake of a variable that has no value yet."""
    return any(name not in given for name in variable_names(one.formula))


def _may_be_default(run: Pass, one: Literal) -> bool:
    """Whether a property may hold where nothing was ever said of it."""
    assert isinstance(one.formula, nodes.Proposition)
    declared = run.signatures.relations.get(one.formula.name)
    if declared is None or not declared.is_property:
        return False
    value = declared.full(one.formula.args)[-1:]
    return declared.default_function is not None or any(
        isinstance(term, nodes.Const) and term.value == declared.default
        for term in value
    )


def _undoes(run: Pass, step: nodes.Step, denied: Literal) -> bool:
    """Whether a step surely brings about what is to be protected from being so."""
    return any(
        fact_name(effect) == fact_name(denied)
        and contradict(run.signatures, denied, effect)
        for effect in done(run.library, step.goal)
    )


def _comes(
    run: Pass,
    one: Literal,
    there: Sequence[tuple[int, Sequence[Effect]]],
    net: Net,
    until: int,
) -> bool:
    """Whether a step that may run before another may make a literal hold."""
    if not there:
        return can_come(run.library, one, ())
    return any(
        can_come(run.library, one, effects)
        and other != until
        and not net.is_before(until, other)
        for other, effects in there
    )


def _finding(one: Literal, step: nodes.Step) -> Diagnostic:
    written = format_formula(one.formula)
    return VAIN.at(
        one.span,
        f"nothing up to here brings `{written}` about"
        if one.holds
        else f"this step brings `{written}` about, and not the contrary",
        labels=(
            Label(
                step.goal.span,
                f"`{format_goal(step.goal)}` does{' not' * one.holds}",
            ),
        ),
        help="protect what the step brings about, or declare that it does",
    )
