"""Which method a task tries: what holds, what failed least, what was chosen least.

Semantics 3, steps 5 to 7 (T 3.2.2, 3.2.5, 7.4.1).
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from rapc.compiler.plans import MethodPlan
from rapc.ir import nodes
from rapc.resources import Value, frozen
from rapc.runtime.events import SolverCalled
from rapc.runtime.machine import Machine
from rapc.runtime.task import Task


class Choice(msgspec.Struct, frozen=True):
    """A method with what its choice binds.

    `key` is what the futile-loop detector sees: the method and every binding alive,
    resources by value.
    """

    method: MethodPlan
    found: dict[str, Value]
    key: tuple[object, ...]


def choose(machine: Machine, task: Task) -> Choice | None:
    """The method to try, or None if there is none; asks a solver in that case."""
    machine.context.task = task
    repeat = task.plan.repeat_while
    if repeat is not None and not repeat.holds(machine.context, task.env):
        return None
    holding = _holding(machine, task)
    if not holding and _ask_solver(machine, task):
        holding = _holding(machine, task)
    if len(holding) > 1:
        holding = _least(holding, [_failures(task, c) for c in holding])
    if len(holding) > 1:
        holding = _least(holding, [task.choices.get(c.key, 0) for c in holding])
    if len(holding) > 1:
        return holding[machine.rng.randrange(len(holding))]
    return holding[0] if holding else None


def _failures(task: Task, choice: Choice) -> int:
    return task.failures.get(choice.method.index, 0)


def _least(choices: Sequence[Choice], counts: Sequence[int]) -> list[Choice]:
    least = min(counts)
    return [c for c, count in zip(choices, counts, strict=True) if count == least]


def _holding(machine: Machine, task: Task) -> list[Choice]:
    """The methods that hold, in the order of the text, with their first bindings."""
    context = machine.context
    context.task = task
    held = tuple((name, frozen(value)) for name, value in task.env.items())
    choices = []
    for method in machine.methods(task.plan):
        found: dict[str, Value] | None = {}
        if method.choice is not None:
            found = method.choice.first(context, task.env)
            if machine.context_asked is not None and method.node.context is not None:
                machine.context_asked(task.plan.name, method.name, found is not None)
        if found is not None:
            bound = tuple((name, frozen(value)) for name, value in found.items())
            choices.append(Choice(method, found, (method.index, held, bound)))
    return choices


def _ask_solver(machine: Machine, task: Task) -> bool:
    """Ask the problem solver of a RAP; whether it has returned any method."""
    solver = machine.solvers.get(task.plan.name)
    if solver is None:
        return False
    inputs = [task.env[name] for name in task.plan.inputs]
    returned = list(solver((task.plan.name, *inputs), machine.context.view))
    for node in returned:
        if not any(_same(node, known.node) for known in machine.methods(task.plan)):
            index = len(machine.methods(task.plan))
            compiler = machine.library.compiler
            plan = MethodPlan(compiler, task.plan.node, node, index)
            machine.add_method(task.plan, plan)
    if machine.recorder.on:
        machine.recorder.emit(
            SolverCalled, task=task.number, goal=task.goal(), methods=len(returned)
        )
    return bool(returned)


def _same(a: nodes.Method, b: nodes.Method) -> bool:
    """Whether two methods are one but for where they stand."""
    return (a.name, a.context, a.notations, a.body) == (
        b.name,
        b.context,
        b.notations,
        b.body,
    )
