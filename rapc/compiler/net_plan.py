"""Executable task-nets: steps, their order, and their annotations.

The execution of a step's task is in `rapc.runtime`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rapc.compiler.compiler import Compiler
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.ir import nodes
from rapc.ir.walk import variable_names


class StepPlan:
    """A step of a task-net: the goal of its task, and its order."""

    def __init__(self, compiler: Compiler, node: nodes.Step, position: int) -> None:
        self.node = node
        self.position = position
        self.priority = node.priority
        where = compiler.place(f"step `{node.tag}`", node.span)
        self.args = tuple(TermValue(arg, where) for arg in node.goal.args)
        self.computes = any(isinstance(arg, nodes.Call) for arg in node.goal.args)
        self.outputs = tuple(OutputTarget(out, where) for out in node.goal.outputs)
        #: The number of steps that must end before this step may start.
        self.before = 0
        #: Positions of the steps ordered directly after this one, each once.
        self.after: list[int] = []
        #: The `for` formulas that refer to this step, each with the position of the
        #: step that carries the formula, in the order of the text.
        self.conditions: list[tuple[int, Query]] = []
        self.until: list[tuple[int, bool]] = []
        self.windows: tuple[WindowPlan, ...] = ()
        self.effects: list[EffectPlan] = []
        self.waits: list[WaitPlan] = []
        #: Whether its start depends on more than order, or ends other steps.
        self.has_timing = False
        #: Whether its success returns outputs or has effects.
        self.has_results = False


class OutputTarget:
    """The target of an output value: a variable to bind or a value to compare."""

    def __init__(self, term: nodes.Term, where: str) -> None:
        self.term = TermValue(term, where)
        self.variable = term.name if isinstance(term, nodes.Var) else None
        self.anonymous = isinstance(term, nodes.Var) and term.anonymous


class WaitPlan:
    """A `wait-for` of a step: the signal, its arguments, and its mode."""

    def __init__(self, node: nodes.WaitFor, where: str) -> None:
        self.signal = node.signal
        self.pattern = nodes.Signal(node.signal, node.args)
        self.mode = node.mode
        self.args = tuple(OutputTarget(arg, where) for arg in node.args)


class WindowPlan:
    """A time window: `reference` is `now`, `absolute` or the position of a step.

    `uses` are the variables in its times.
    """

    def __init__(self, reference: str | int, start: TermValue, stop: TermValue) -> None:
        self.reference = reference
        self.start = start
        self.stop = stop
        self.uses = frozenset(variable_names(start.term, stop.term))


class EffectPlan:
    """An effect of a step on a resource."""

    def __init__(self, compiler: Compiler, node: nodes.ResourceChange) -> None:
        where = compiler.place(f"effect `{node.op}`", node.span)
        self.node = node
        self.resource = TermValue(node.resource, where)
        self.amount = TermValue(node.amount, where)


def steps_of(compiler: Compiler, net: nodes.TaskNet) -> tuple[StepPlan, ...]:
    """Return the steps of a task-net in the order of the text, with their order."""
    plans = tuple(StepPlan(compiler, step, at) for at, step in enumerate(net.steps))
    at_tag = {step.tag: at for at, step in enumerate(net.steps)}
    for plan in plans:
        for annotation in plan.node.annotations:
            _annotate(compiler, plans, at_tag, plan, annotation)
    for plan in plans:
        plan.after.sort()
        plan.has_timing = bool(plan.windows or plan.waits or plan.until)
        plan.has_results = bool(plan.outputs or plan.effects)
    return plans


def _annotate(
    compiler: Compiler,
    plans: Sequence[StepPlan],
    at_tag: Mapping[str, int],
    plan: StepPlan,
    annotation: nodes.Annotation,
) -> None:
    if isinstance(annotation, nodes.For):
        target = plans[at_tag[annotation.tag]]
        _order(plan, target)
        if annotation.formula is not None:
            what = f"`for {annotation.tag}` formula"
            query = compiler.query(annotation.formula, what, annotation.span)
            target.conditions.append((plan.position, query))
    elif isinstance(annotation, nodes.UntilEnd | nodes.UntilStart):
        ended = isinstance(annotation, nodes.UntilEnd)
        target = plans[at_tag[annotation.tag]]
        if target is not plan:
            target.until.append((plan.position, ended))
    elif isinstance(annotation, nodes.Window):
        reference: str | int = annotation.reference
        if annotation.reference not in ("now", "absolute"):
            reference = at_tag[annotation.reference]
            _order(plans[reference], plan)
        where = compiler.place("window", annotation.span)
        start = TermValue(annotation.start, where)
        stop = TermValue(annotation.stop, where)
        plan.windows += (WindowPlan(reference, start, stop),)
    elif isinstance(annotation, nodes.WaitFor):
        where = compiler.place("wait-for", annotation.span)
        plan.waits.append(WaitPlan(annotation, where))
    elif isinstance(annotation, nodes.ResourceChange):
        plan.effects.append(EffectPlan(compiler, annotation))


def steps_using(steps: Sequence[StepPlan]) -> Mapping[str, Sequence[int]]:
    """Return for each variable the positions of steps that use it as input or time."""
    users: dict[str, list[int]] = {}
    for step in steps:
        used = frozenset(variable_names(*step.node.goal.args))
        for name in used.union(*(window.uses for window in step.windows)):
            users.setdefault(name, []).append(step.position)
    return users


def _order(first: StepPlan, then: StepPlan) -> None:
    if then.position not in first.after:
        first.after.append(then.position)
        then.before += 1
