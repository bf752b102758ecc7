"""Effects of a step's success on sets and counters: all of them, or none.

Not here: whether a step has succeeded (`rapc.runtime.tasks.finish`) [T 4.8.2; L 6].
"""

from __future__ import annotations

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Number, is_number
from rapc.compiler.net_plan import EffectPlan, StepPlan
from rapc.compiler.query.builtin import QueryFault, add, subtract
from rapc.events import ResourceChange, ResourceChanged
from rapc.runtime.query_context import QueryContext
from rapc.runtime.run import Run
from rapc.runtime.state.task import Env, MethodRun, Task

Change = tuple[str, Counter | SetResource, Value]
"""An effect with its resource and its amount or member."""


def changes_of(
    run: Run, method_run: MethodRun, step: StepPlan, bound: Env
) -> list[Change] | None:
    """Return the changes by a step's effects; None if a change is impossible."""
    changes: list[Change] = []
    totals: dict[Counter, Number] = {}
    env = {**method_run.env, **bound} if step.effects else method_run.env
    run.context.task = method_run.task
    for effect in step.effects:
        change = _change(run.context, effect, env)
        if change is None:
            return None
        changes.append(change)
        try:
            _count(totals, change)
        except QueryFault as fault:
            run.context.fault(effect.amount.where, str(fault))
            return None
    return changes


def _count(totals: dict[Counter, Number], change: Change) -> None:
    """Add a change to the totals of counters. Raises QueryFault for huge numbers."""
    op, resource, amount = change
    if isinstance(resource, Counter):
        compute = add if op == "counter-add" else subtract
        totals[resource] = compute([totals.get(resource, resource.value), amount])


def _change(context: QueryContext, effect: EffectPlan, env: Env) -> Change | None:
    resource = effect.resource.needed(context, env)
    amount = None if resource is None else effect.amount.needed(context, env)
    if resource is None or amount is None:
        return None
    op, where = effect.node.op, effect.amount.where
    kind = Counter if op.startswith("counter") else SetResource
    if not isinstance(resource, kind):
        context.unfit(where, resource, "a counter" if kind is Counter else "a set")
    elif kind is Counter and not is_number(amount):
        context.unfit(where, amount, "a number")
    elif isinstance(amount, Counter | SetResource):
        context.unfit(where, amount, "a symbol, number or string")
    else:
        return op, resource, amount
    return None


def carry_out(run: Run, task: Task, change: Change) -> None:
    """Make one change of a resource, on behalf of the step's task."""
    op, resource, by = change
    if isinstance(resource, Counter):
        assert isinstance(by, int | float)
        resource.add(by if op == "counter-add" else -by)
    elif op == "set-add":
        resource.add(by)  # type: ignore[arg-type]  # resources were refused
    else:
        resource.remove(by)  # type: ignore[arg-type]  # resources were refused
    run.monitors.listeners.resource_changed(resource)
    if run.recorder.on:
        what = ResourceChange(op, by, str(resource))  # type: ignore[arg-type]
        run.recorder.emit(ResourceChanged, task=task.number, what=what)
