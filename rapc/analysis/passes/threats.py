"""RAP126 and RAP129: steps that undo what a step protects, or a constraint asks.

Between the end of a step with `(formula for t)` and the start of t, any step may run
that order allows there: a threat, as planners with partial orders call it. What a step
brings about is taken from its RAP where that is certain: declared `effects`, `succeed`,
and what all of its primitives do if they end `okay`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.certain import contradict, done, fact_name
from rapc.analysis.literals import Literal, literals
from rapc.analysis.passes.task_nets import TASK_NETS, Net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal

_WORLD = """\
(declare-memory-proposition bay-open ())
(declare-primitive open-bay () (okay) :on (okay (bay-open)))
(declare-primitive close-bay () (okay) :on (okay (not (bay-open))))
(declare-primitive unload () (okay))
(define-rap (open) (method (primitive (open-bay))))
(define-rap (close) (method (primitive (close-bay))))
(define-rap (empty) (method (primitive (unload))))
"""

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
    example=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty))
    (t3 (close)))))
""",
    better=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty) (for t3))
    (t3 (close)))))
""",
)

BROKEN = Rule(
    code="RAP129",
    name="broken-constraint",
    severity=Severity.WARNING,
    summary="a step undoes what a constraint asks for while other steps are left",
    why="""`constraints` have to hold for all that is done below (T 4.4.3). A step that
surely makes one false is the end of those that come after it: they fail with
`interference`. Ask for it in the context, if it has to hold at first only, or let the
step come last.""",
    ignore="where the steps that are left are to be dropped then",
    source="T 4.4.3, 5.3.4",
    example=_WORLD
    + """\
(define-rap (deliver)
  (method
    (constraints (bay-open))
    (task-net
      (t1 (close) (for t2))
      (t2 (empty)))))
""",
    better=_WORLD
    + """\
(define-rap (deliver)
  (method
    (constraints (bay-open))
    (task-net
      (t1 (empty) (for t2))
      (t2 (close)))))
""",
)


def _run(run: Pass) -> None:
    for steps, net in sure_nets(run):
        for found in _threats(run, steps, net):
            run.report(found)
    nets = run.result(TASK_NETS)
    for rap in run.library.raps.values():
        for method in rap.methods:
            net_there = nets.get(id(method.body))
            asked = [*literals(rap.constraints), *literals(method.constraints)]
            asked = [one for one in asked if fact_name(one)]
            if isinstance(method.body, nodes.TaskNet) and net_there and asked:
                for found in _broken(run, method.body.steps, net_there, asked):
                    run.report(found)


ANALYZER = Analyzer(
    name="threats",
    doc="Finds steps that undo what another step protects, or a constraint asks for.",
    run=_run,
    needs=(TASK_NETS,),
    rules=(THREAT, BROKEN),
    needs_whole="method",
)


def _threats(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    protected = list(_protected(steps))
    if not protected or net.order is None:
        return
    places = {step.tag: at for at, step in enumerate(steps)}
    before, after = _reach(net, net.order)
    changes: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for effect in done(run.library, step.goal) if at not in net.early else ():
            changes.setdefault(fact_name(effect), []).append((at, effect))
    changing = {name: _bits(by for by, _ in there) for name, there in changes.items()}
    for at, note, wanted in protected:
        other = places[note.tag]
        apart = before[at] | after[other] | 1 << at | 1 << other
        if not changing.get(fact_name(wanted), 0) & ~apart:
            continue
        for by, effect in changes.get(fact_name(wanted), ()):
            if not apart >> by & 1 and contradict(run.signatures, wanted, effect):
                yield _finding(note, wanted, steps[by])


def _broken(
    run: Pass, steps: Sequence[nodes.Step], net: Net, asked: Sequence[Literal]
) -> Iterator[Diagnostic]:
    """Yield the steps that surely undo what is asked, with others not yet ended."""
    if net.broken or net.order is None:
        return
    before, _ = _reach(net, net.order)
    everything = (1 << len(steps)) - 1
    for at, step in enumerate(steps):
        if before[at] | 1 << at == everything:
            continue
        for effect in done(run.library, step.goal):
            for wanted in asked:
                if fact_name(wanted) == fact_name(effect) and contradict(
                    run.signatures, wanted, effect
                ):
                    yield Diagnostic(
                        rule=BROKEN.name,
                        message=f"step `{step.tag}` undoes "
                        f"`{format_formula(wanted.formula)}`, a constraint of the "
                        "steps that are left",
                        span=step.goal.span,
                        labels=(Label(wanted.span, "asked here"),),
                        help="let it come last, or ask for this in the context",
                    )
                    return


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


def _reach(net: Net, order: Sequence[int]) -> tuple[list[int], list[int]]:
    """Return for each step those before it and those after it, as sets of bits."""
    before = [0] * len(order)
    after = [0] * len(order)
    for at in order:
        for edge in net.edges[at]:
            before[at] |= before[edge.before] | 1 << edge.before
    for at in reversed(order):
        for edge in net.edges[at]:
            after[edge.before] |= after[at] | 1 << at
    return before, after


def _finding(note: nodes.For, undone: Literal, step: nodes.Step) -> Diagnostic:
    written = format_formula(undone.formula)
    if not undone.holds:
        written = f"(not {written})"
    return Diagnostic(
        rule=THREAT.name,
        message=f"step `{step.tag}` may undo `{written}` before `{note.tag}` begins",
        span=note.span,
        labels=(
            Label(step.goal.span, f"`{format_goal(step.goal)}` may run in between"),
        ),
        help=f"put `{step.tag}` before this step, or after `{note.tag}`",
    )
