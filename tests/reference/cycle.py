"""One task's cycle, step by step as [L 3] numbers them; methods in `methods`."""

from __future__ import annotations

from rapc.ir import nodes
from tests.reference.endings import (
    bindings_repeat,
    end_by_until,
    fail,
    follow,
    method_badly,
    succeed,
)
from tests.reference.methods import choose_method
from tests.reference.run import Run
from tests.reference.tasks import Running, Task, method_name
from tests.reference.waking import block, monitors_hold, read_inputs

_DONE = nodes.HistoryTest("last-result", (nodes.Const("okay"),))


def process(run: Run, task: Task) -> None:
    """Steps 1 to 5: whatever may end the cycle before a method is chosen."""
    task.wanted = []
    if not task.begun and not task.monitored:
        until_start(run, task)
    if not inputs_bound(run, task):
        return
    if not task.begun and monitors_hold(run, task):
        until_start(run, task)
    found = run.holds(task, task.rap.succeed or _DONE, task.own, "succeed")
    if found is not None:
        succeed(run, task, found)
        return
    task.once = False
    if task.monitored and not monitors_hold(run, task):
        block(run, task)
        return
    if not conditions_hold(run, task):
        return
    if run.holds(task, task.rap.repeat_while, task.own, "repeat-while") is None:
        fail(run, task, "no-method")
        return
    choose_method(run, task)


# --- step 1 -----------------------------------------------------------------------


def inputs_bound(run: Run, task: Task) -> bool:
    """Step 1; False if it settled the matter."""
    if not task.full:
        read_inputs(run, task)
    if not task.full:
        for_formulas(run, task)
        read_inputs(run, task)
        if task.parent is not None and bindings_repeat(run, task.parent):
            return False
    if task.full and not task.broken:
        return True
    if not task.full:
        trace_inputs(run, task)
    fail(run, task, "interference")
    return False


def trace_inputs(run: Run, task: Task) -> None:
    """Trace which inputs have no value, and why."""
    assert task.parent is not None
    assert task.place is not None
    for term in task.place.step.goal.args:
        _, why = run.value(task.parent.task, term, task.parent.env)
        if why:
            clause = f"step `{task.place.step.tag}`"
            run.fault(task.parent.task, clause, task.place.step, why)


def for_formulas(run: Run, task: Task, to_the_first: bool = False) -> bool:
    """Ask the `for` formulas that point at a step; what they bind is kept.

    All are asked, or those up `to_the_first` that does not hold.
    """
    if task.parent is None or task.place is None:
        return True
    every = True
    clause = f"`for {task.place.step.tag}` formula"
    for formula in task.parent.conditions(task.place):
        found = run.holds(task.parent.task, formula, task.parent.env, clause)
        if found is not None:
            task.parent.env.update(found)
            continue
        every = False
        if to_the_first:
            break
    return every


def until_start(run: Run, task: Task) -> None:
    """A first selection, its monitors holding, ends what runs until this starts."""
    task.begun = True
    if task.parent is not None and task.place is not None:
        for other in task.parent.places:
            notes = other.step.annotations
            tags = [n.tag for n in notes if isinstance(n, nodes.UntilStart)]
            if task.place.step.tag in tags:
                end_by_until(run, other)
        follow(run, task.parent)


# --- step 4 -----------------------------------------------------------------------


def conditions_hold(run: Run, task: Task) -> bool:
    """Step 4; False if it settled the matter."""
    held = for_formulas(run, task, to_the_first=True)
    if held and task.parent is not None and bindings_repeat(run, task.parent):
        return False
    held = held and (
        run.holds(task, task.rap.preconditions, task.own, "preconditions") is not None
    )
    for each in task.line():
        held = held and (
            run.holds(each, each.rap.constraints, each.own, "constraints") is not None
        )
        if held and each.parent is not None and not method_holds(run, each.parent):
            method_badly(run, each.parent, "interference", "parent-failed")
            return False
    if not held:
        fail(run, task, "interference")
    return held


def method_holds(run: Run, running: Running) -> bool:
    """Whether the constraints of a method hold, over what it has bound by now."""
    formula = running.method.constraints
    clause = f"constraints of method `{method_name(running.method)}`"
    return run.holds(running.task, formula, running.env, clause) is not None
