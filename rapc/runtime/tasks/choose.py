"""The choice of a method: holding, then least failed, then least chosen.

[L 3.27] to [L 3.40] (T 3.2.2, 3.2.5, 7.4.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import count, islice
from typing import TypeVar

from rapc.base.chance import below
from rapc.base.code_places import place_of
from rapc.base.resources import frozen
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.errors import PortError
from rapc.events import PlanMade, SolverCalled
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.library.saved_check import UnsoundError
from rapc.runtime.planner import PLAN, PlanRequest, computed
from rapc.runtime.run import Run
from rapc.runtime.state.task import Env, Task
from rapc.runtime.tasks.hold_things import must_wait

_Any = TypeVar("_Any")


Held = tuple[MethodPlan, Env]
"""A method that holds, with the first bindings of its choice."""

Key = tuple[object, ...]
"""The key of a choice for the futile-loop detector: the method with all bindings.

The key contains resources by value.
"""


Choice = tuple[MethodPlan, Env, Sequence[Held]]
"""The method to try, its bindings, and all choices for whose things the task may wait.

The latter are empty if the things of the method are available.
"""


def choose(run: Run, task: Task, asked: int = 0) -> Choice | None:
    """Return the method to try, or None if there is none.

    If no method holds, ask the problem solver, then the planner, unless the caller has
    `asked` so many of them before. A sole method is not compared with others: its
    context alone decides.
    """
    context, sole = run.context, task.plan.sole
    context.task = task
    if sole is not None and run.context_listener is None and not run.solvers:
        found = context.bound[sole.choice].first(task.env)
        return None if found is None else (sole, found, ())
    plan, env, bound = task.plan, task.env, context.bound
    listener = run.context_listener
    repeat = plan.repeat_while
    if repeat is not None and not (asked or bound[repeat].holds(env)):
        return None
    holding: list[Held] = []
    for method in run.state.methods(plan):
        ruled_out = method.otherwise and holding
        found = None if ruled_out else bound[method.choice].first(env)
        if found is not None:
            holding.append((method, found))
        if listener is not None and method.node.context is not None:
            listener(plan.name, method.name, found is not None)
    if len(holding) > 1 or (holding and holding[0][0].things_vary):
        return _draw(run, task, holding)
    if holding:
        return (*holding[0], ())
    for number, ask in enumerate((_ask_solver, _ask_planner), 1):
        if number > asked and ask(run, task):
            return choose(run, task, number)
    return None


def _draw(run: Run, task: Task, holding: list[Held]) -> Choice:
    """Choose: least failed, least chosen, not forced to wait, then by chance."""
    holding = _least(holding, [task.failures_of(method) for method, _ in holding])
    if len(holding) > 1:
        holding = _least(holding, [task.times_tried(method) for method, _ in holding])
    waiting: list[Held] = []
    if any(method.things for method, _ in holding):
        found = [_available(run, task, *held) for held in holding]
        free = [held for held, _ in found if held is not None]
        waiting = [] if free else [one for _, before in found for one in before]
        holding = free or holding
    at = below(run.rng, len(holding)) if len(holding) > 1 else 0
    return (*holding[at], waiting)


def _available(
    run: Run, task: Task, method: MethodPlan, found: Env
) -> tuple[Held | None, Sequence[Held]]:
    """Return the first solution with available things, and the preceding solutions."""
    first = (method, found)
    if not must_wait(run, task, *first):
        return first, ()
    waiting = [first]
    if method.things_vary:
        solutions = run.context.bound[method.choice].solutions(task.env)
        for solution in islice(solutions, 1, None):
            if not must_wait(run, task, method, solution):
                return (method, solution), waiting
            waiting.append((method, solution))
    return None, waiting


def choice_key(method: MethodPlan, env: Env, found: Env) -> Key:
    """Return the key of a choice, with the current values of the environment."""
    held = frozen(env.values())
    if not found:
        return (method.index, *held)
    return (method.index, *held, *zip(found, frozen(found.values()), strict=True))


def _least(choices: Sequence[_Any], counts: Sequence[int]) -> list[_Any]:
    least = min(counts)
    return [c for c, count in zip(choices, counts, strict=True) if count == least]


def _ask_solver(run: Run, task: Task) -> bool:
    """Ask the problem solver of a RAP; return whether the result has any method."""
    solver = run.solvers.get(task.plan.name)
    if solver is None:
        return False
    inputs = [task.env[name] for name in task.plan.inputs]
    goal, answers = (task.plan.name, *inputs), run.answers
    if answers is None:
        returned = solver(goal, run.context.view)
    else:
        ask = partial(solver, goal, run.context.view)
        returned = answers.solve(run.recorder.cycle, goal, ask)
    if not isinstance(returned, tuple | list) or not all(
        isinstance(node, nodes.Method) for node in returned
    ):
        name = task.plan.name
        raise PortError(
            f"the solver of `{name}`{place_of(solver)} returned {returned!a:.60}"
        )
    for node in returned:
        if not any(_same(node, known.node) for known in run.state.methods(task.plan)):
            _add_method(run, task.plan, node, solver)
    if run.recorder.on:
        run.recorder.emit(
            SolverCalled, task=task.number, goal=task.goal(), methods=len(returned)
        )
    return bool(returned)


_RELUCTANT, _HOPELESS = 2, 4
"""The numbers of failures after which a step is avoided, and not used [L 10.7]."""


def _ask_planner(run: Run, task: Task) -> bool:
    """Ask the planner for a method of a RAP with `(plan)`; return whether it has one.

    The last plan of the task goes with the request: its steps are used where they still
    apply.
    """
    rap, planner = task.plan, run.planner
    if rap.node.plan is None or planner is None:
        return False
    added = run.state.added_methods.get(rap.name, ())
    tried = () if task.history is None else task.history.results
    taken = {method.node.name for method in run.state.methods(rap)}
    failed = {} if task.history is None else task.history.failed_steps
    view = run.context.view
    request = PlanRequest(
        library=run.library,
        rap=rap.node,
        values={name: task.env[name] for name in rap.inputs},
        memory=view,
        compute=partial(computed, run.explaining_context),
        name=next(n for at in count(1) if (n := f"plan-{at}") not in taken),
        last=next(
            (
                plan.node
                for plan in reversed(added)
                if plan is task.method or plan.node.name in tried
            ),
            None,
        ),
        avoided=[view.canonical(one) for one, n in failed.items() if n >= _RELUCTANT],
        failed=[view.canonical(one) for one, n in failed.items() if n >= _HOPELESS],
        limit=run.settings.plan_limit,
        tries=run.settings.plan_tries,
    )
    ask = partial(planner, request)
    answers = run.answers
    run.in_wait = True
    if run.state.stops:  # interrupted just before
        raise KeyboardInterrupt
    if answers is None:
        planned = ask()
    else:
        goal = (PLAN, rap.name, *request.values.values())
        planned = answers.solve(run.recorder.cycle, goal, ask)
    run.in_wait = False
    if planned.method is not None:
        _add_method(run, rap, planned.method, planner)
    run.planned = task, planned
    if run.recorder.on:
        run.recorder.emit(
            PlanMade,
            task=task.number,
            goal=task.goal(),
            outcome=planned.outcome,
            method=request.name if planned.method else None,
            text=format_node(planned.method) if planned.method else "",
            steps=planned.steps,
            expanded=planned.expanded,
            left_out=planned.left_out,
            unreachable=planned.unreachable,
            engine=planned.engine,
            refused=planned.refused,
        )
    return planned.method is not None


def _add_method(run: Run, rap: RapPlan, node: nodes.Method, solver: object) -> None:
    """Add a method that a solver has returned to a RAP, for the rest of the run.

    Raises:
        PortError: for a method with names that the library does not declare.
    """
    index = len(run.state.methods(rap))
    try:
        plan = run.library.added_method(rap, node, index)
    except (UnsoundError, AttributeError, TypeError) as error:
        whose = f"the solver of `{rap.name}`{place_of(solver)}"
        said = f"{whose} returned a method that cannot be run: {error}"
        raise PortError(said) from error
    run.state.added_methods.setdefault(rap.name, []).append(plan)


def _same(a: nodes.Method, b: nodes.Method) -> bool:
    """Return whether two methods are equal but for their positions in the text."""
    fields = (name for name in a.__struct_fields__ if not name.endswith("span"))
    return all(
        getattr(a, name) == getattr(b, name) for name in fields if name != "position"
    )
