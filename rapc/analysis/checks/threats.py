"""RAP119 and RAP126: steps that undo what another step protects, or needs to begin.

Between the end of a step with `(formula for t)` and the start of t, any step may run
that order allows there: a threat, as planners with partial orders call it. What a step
brings about is taken from its RAP where that is certain: declared `effects`, `succeed`,
and what all of its primitives do if they end `okay`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.task_nets import Net, sure_nets
from rapc.analysis.facts.effects import done, put_in
from rapc.analysis.facts.logic import Literal, contradict, fact_name, literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import input_terms

WORLD = """\
(declare-memory-proposition bay-open ())
(declare-primitive open-bay () (okay) :on (okay (bay-open)))
(declare-primitive close-bay () (okay) :on (okay (not (bay-open))))
(declare-primitive unload () (okay))
(define-rap (open) (method (primitive (open-bay))))
(define-rap (close) (method (primitive (close-bay))))
(define-rap (empty) (method (primitive (unload))))
"""
"""A bay that opens and closes, for the examples of rules on what steps undo."""

THREAT = Rule(
    code="RAP126",
    name="threatened-protection",
    severity=Severity.WARNING,
    summary="a step may undo what another step protects with `for`",
    why="""A formula with `for` has to hold until the step begins that it is for; if it
does not, the work is done in vain. A step that surely makes it false, and that order
allows in between, may come just then: only priority or chance tells. Put that step
before the one that protects, or after the one that needs what is protected.""",
    ignore="where priorities, or things that both use, keep the step from coming "
    "between",
    source="T 4.7.3, 4.9",
    example=WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty))
    (t3 (close)))))
""",
    better=WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty) (for t3))
    (t3 (close)))))
""",
)

RACING = Rule(
    code="RAP119",
    name="racing-steps",
    severity=Severity.WARNING,
    summary="a step may undo what another step needs before it can begin",
    why="""`preconditions` and `constraints` of a RAP are asked whenever its task comes
up (T 4.4.2). Steps that no `for` puts in order come up as priority and chance have it:
if the one that surely undoes such a fact comes first, the other one fails,
`interference`. Put the step that needs the fact before the one that undoes it, or raise
its priority.""",
    ignore="where what both use keeps the one back until the other is done",
    source="T 4.4.2, 4.5.2",
    example=WORLD
    + """\
(define-rap (empty-well) (preconditions (bay-open)) (method (primitive (unload))))
(define-rap (deliver)
  (method (task-net
    (t1 (empty-well))
    (t2 (close)))))
""",
    better=WORLD
    + """\
(define-rap (empty-well) (preconditions (bay-open)) (method (primitive (unload))))
(define-rap (deliver)
  (method (task-net
    (t1 (empty-well) (for t2))
    (t2 (close)))))
""",
)


@check(THREAT, RACING, needs_whole="method")
def threats(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that undo what another step protects, or needs to begin."""
    for steps, net in sure_nets(run):
        yield from (*_threats(run, steps, net), *_races(run, steps, net))


def _threats(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    protected = list(_protected(steps))
    if not protected or net.order is None:
        return
    places = {step.tag: at for at, step in enumerate(steps)}
    before, after = net.reach()
    every = (1 << len(steps)) - 1
    between: list[tuple[int, nodes.For, Literal]] = []
    for at, note, wanted in protected:
        other = places[note.tag]
        may_come = every & ~(before[at] | after[other] | 1 << at | 1 << other)
        if may_come:
            between.append((may_come, note, wanted))
    changes = _changes(run, steps, net) if between else {}
    changing = {name: _bits(by for by, _ in there) for name, there in changes.items()}
    for may_come, note, wanted in between:
        if not changing.get(fact_name(wanted), 0) & may_come:
            continue
        for by, effect in changes.get(fact_name(wanted), ()):
            if may_come >> by & 1 and contradict(run.signatures, wanted, effect):
                yield _finding(note, wanted, steps[by])


def _changes(
    run: Pass, steps: Sequence[nodes.Step], net: Net
) -> dict[str, list[tuple[int, Literal]]]:
    """Return what steps surely bring about, by names, each with the step's position."""
    changes: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for effect in done(run.library, step.goal) if at not in net.early else ():
            changes.setdefault(fact_name(effect), []).append((at, effect))
    return changes


def _races(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    """Yield the first step that may undo what another needs, in no order with it."""
    needs: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for one in _needed(run, step.goal):
            needs.setdefault(fact_name(one), []).append((at, one))
    if not needs or net.order is None:
        return
    before, after = net.reach()
    for by, step in enumerate(steps):
        for effect in done(run.library, step.goal) if by not in net.early else ():
            for at, wanted in needs.get(fact_name(effect), ())[:_MOST]:
                apart = before[at] | after[at] | 1 << at
                if apart >> by & 1 or steps[at].priority > step.priority:
                    continue
                if contradict(run.signatures, wanted, effect):
                    yield _race(wanted, steps[at], step)
                    return


_MOST = 20
"""So many steps that need a fact are held against one that changes it."""


def _needed(run: Pass, goal: nodes.Goal) -> Iterator[Literal]:
    """Yield the facts that the RAP of a goal asks for before it begins."""
    rap = run.library.raps.get(goal.name)
    if rap is None:
        return
    facts = [
        one
        for clause, formula in clauses.held(clauses.RAP, rap)
        if clause.required and clause.when == "select"
        for one in literals(formula)
        if fact_name(one)
    ]
    yield from put_in(facts, input_terms(rap, goal))


def _race(needed: Literal, step: nodes.Step, by: nodes.Step) -> Diagnostic:
    return RACING.at(
        by.goal.span,
        f"step `{by.tag}` may undo `{_written(needed)}`, which `{step.tag}` needs",
        labels=(
            Label(step.goal.span, f"`{format_goal(step.goal)}` may come later"),
            Label(needed.span, "asked here"),
        ),
        help=f"put `{step.tag}` before it",
    )


def _bits(numbers: Iterable[int]) -> int:
    found = 0
    for one in numbers:
        found |= 1 << one
    return found


def _protected(
    steps: Sequence[nodes.Step],
) -> Iterator[tuple[int, nodes.For, Literal]]:
    """Yield the facts that steps protect, each with the step's position and where."""
    for at, step in enumerate(steps):
        for note in step.annotations:
            if isinstance(note, nodes.For):
                for one in literals(note.formula):
                    if fact_name(one):
                        yield at, note, one


def _written(fact: Literal) -> str:
    written = format_formula(fact.formula)
    return written if fact.holds else f"(not {written})"


def _finding(note: nodes.For, undone: Literal, step: nodes.Step) -> Diagnostic:
    return THREAT.at(
        note.span,
        f"step `{step.tag}` may undo `{_written(undone)}` before `{note.tag}` begins",
        labels=(
            Label(step.goal.span, f"`{format_goal(step.goal)}` may run in between"),
        ),
        help=f"put `{step.tag}` before this step, or after `{note.tag}`",
    )
