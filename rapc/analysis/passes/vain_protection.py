"""RAP143: formulas with `for` that no step before them can bring about."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.certain import fact_name
from rapc.analysis.effects import EFFECTS, Effect, Effects
from rapc.analysis.literals import literals
from rapc.analysis.passes.hopeless import can_come
from rapc.analysis.passes.task_nets import TASK_NETS, Net
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import subformulas

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


def _run(run: Pass) -> None:
    if not run.complete:
        return
    nets = run.result(TASK_NETS)
    for rap in run.library.raps.values():
        asked: set[str] | None = None
        for method in rap.methods:
            net = nets.get(id(method.body))
            if not isinstance(method.body, nodes.TaskNet) or net is None:
                continue
            if net.broken or net.order is None:
                continue
            for at, step in enumerate(method.body.steps):
                for note in step.annotations:
                    if isinstance(note, nodes.For) and note.formula is not None:
                        asked = _asked(rap) if asked is None else asked
                        before = _done(run.result(EFFECTS), method.body, net, at)
                        for found in _vain(run, note, step, before, asked):
                            run.report(found)


ANALYZER = Analyzer(
    name="vain-protection",
    doc="Finds formulas with `for` that no step before them can bring about.",
    run=_run,
    needs=(EFFECTS, TASK_NETS),
    rules=(VAIN,),
    needs_whole="form",
)


def _asked(rap: nodes.DefineRap) -> set[str]:
    """The facts that the clauses of a RAP ask for: they may hold before it begins."""
    clauses = [rap.monitor_state, rap.preconditions, rap.constraints, rap.repeat_while]
    for method in rap.methods:
        clauses += [method.context, method.constraints]
    return {
        part.name
        for formula in clauses
        if formula is not None
        for part in subformulas(formula)
        if isinstance(part, nodes.Proposition)
    }


def _done(
    effects: Effects, body: nodes.TaskNet, net: Net, at: int
) -> Sequence[Effect] | None:
    """Return what a step and those not ordered behind it may do, if all is known."""
    found: list[Effect] = []
    for other, step in enumerate(body.steps):
        if other != at and net.is_before(at, other):
            continue
        done = effects.of(step.goal.name)
        if done is None:
            return None
        found += done
    return found


def _vain(
    run: Pass,
    note: nodes.For,
    step: nodes.Step,
    done: Sequence[Effect] | None,
    asked: set[str],
) -> Iterator[Diagnostic]:
    for one in literals(note.formula) if done is not None else ():
        assert done is not None
        fact = fact_name(one)
        if not fact or fact in asked or not one.holds:
            continue
        if not can_come(run.library, one, done):
            yield Diagnostic(
                rule=VAIN.name,
                message=f"nothing up to here brings `{format_formula(one.formula)}` "
                "about",
                span=one.span,
                labels=(Label(step.goal.span, f"`{format_goal(step.goal)}` does not"),),
                help="protect what the step brings about, or declare that it does",
            )
