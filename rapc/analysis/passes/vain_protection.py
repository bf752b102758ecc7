"""RAP143: formulas with `for` that no step before them can bring about."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.asked import is_computed
from rapc.analysis.certain import contradict, done, fact_name
from rapc.analysis.effects import EFFECTS, Effect, Effects
from rapc.analysis.literals import Literal, literals
from rapc.analysis.passes.hopeless import can_come
from rapc.analysis.passes.task_nets import TASK_NETS, Net
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import formulas

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


def _run(run: Pass) -> None:
    nets = run.result(TASK_NETS)
    known: dict[str, _ByName | None] = {}
    for rap in run.library.raps.values() if run.complete else ():
        for method in rap.methods:
            net = nets.get(id(method.body))
            if not isinstance(method.body, nodes.TaskNet) or net is None:
                continue
            if net.broken or net.order is None or not _protects(method.body):
                continue
            for found in _of_net(run, rap, method.body.steps, net, known):
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


def _of_net(
    run: Pass,
    rap: nodes.DefineRap,
    steps: Sequence[nodes.Step],
    net: Net,
    known: dict[str, _ByName | None],
) -> Iterator[Diagnostic]:
    """Yield what steps protect that no step up to there can bring about."""
    changers: dict[str, list[tuple[int, Sequence[Effect]]]] = {}
    for at, step in enumerate(steps):
        name = step.goal.name
        if name not in known:
            known[name] = _by_name(run.result(EFFECTS), name)
        done = known[name]
        if done is None:
            return
        for fact, effects in done.items():
            changers.setdefault(fact, []).append((at, effects))
    asked = _asked(rap)
    for at, step in enumerate(steps):
        for note in step.annotations:
            if not isinstance(note, nodes.For):
                continue
            for one in literals(note.formula):
                fact = fact_name(one)
                if fact and not one.holds and _undoes(run, step, one):
                    yield _finding(one, step)
                if not fact or fact in asked or not one.holds:
                    continue
                if is_computed(run.library, fact):
                    continue
                there = changers.get(fact, [])
                if len(there) > _MOST or _comes(run, one, there, net, at):
                    continue
                yield _finding(one, step)


_MOST = 20
"""Where more steps than this change a fact, one of them may well bring it about."""


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
    at: int,
) -> bool:
    """Whether a step that is not behind another may make a literal hold."""
    if not there:
        return can_come(run.library, one, ())
    return any(
        can_come(run.library, one, effects)
        and (other == at or not net.is_before(at, other))
        for other, effects in there
    )


def _finding(one: Literal, step: nodes.Step) -> Diagnostic:
    written = format_formula(one.formula)
    return Diagnostic(
        rule=VAIN.name,
        message=f"nothing up to here brings `{written}` about"
        if one.holds
        else f"this step brings `{written}` about, and not the contrary",
        span=one.span,
        labels=(
            Label(
                step.goal.span,
                f"`{format_goal(step.goal)}` does{' not' * one.holds}",
            ),
        ),
        help="protect what the step brings about, or declare that it does",
    )
