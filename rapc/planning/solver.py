"""Plans for goals: model, grounding, search and sketch together."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from rapc.base.values import Fact, Number
from rapc.ir import nodes
from rapc.library.library import usable_in_plans
from rapc.planning.ground import Grounding, Problem, Situation, TooLargeError
from rapc.planning.model import Conjunction, LeftOut, Model, constants_of
from rapc.planning.search import Search
from rapc.planning.sketch import Sketch, achieved, method, sketch
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.planner import Planned, PlanRequest


class Solution(NamedTuple):
    """A plan, or the reason why there is none."""

    outcome: str
    sketch: Sketch | None
    cost: Number
    expanded: int
    left_out: tuple[LeftOut, ...]
    unreachable: tuple[str, ...]
    #: The problem; None for a problem that is too large.
    problem: Problem | None


def situation(memory: MemoryView) -> Situation:
    """Return the facts of a memory, each with its age."""
    now, found = memory.now, dict[Fact, Number | None]()
    for fact in memory:
        since = memory.since(fact)
        found[fact] = None if since is None else now - since
    return found


def solve(  # all but three have defaults and go by name
    model: Model,
    facts: Situation,
    goal: Sequence[Conjunction],
    *,
    limit: int,
    tries: int = 0,
    excluded: Collection[Fact] = (),
    last: nodes.Method | None = None,
) -> Solution:
    """Return a plan for a goal.

    Args:
        model: the operators.
        facts: the situation.
        goal: the branches of the goal.
        limit: the greatest number of states to look at.
        tries: the number of further states to look at for a cheaper plan.
        excluded: the goals of steps that must not be used.
        last: an earlier plan, whose steps are used where they still apply.
    """
    left_out = tuple(model.left_out)
    try:
        problem = Grounding(model, facts, goal, excluded).problem()
    except TooLargeError:
        return Solution("limit", None, 0, 0, left_out, (), None)
    steps = () if last is None else _goals(last)
    found = Search(problem, limit, steps).run(tries)
    if found.outcome != "solved":
        rest = left_out, problem.unreachable, problem
        return Solution(found.outcome, None, 0, found.expanded, *rest)
    made = sketch(problem, found.actions)
    cost = sum(action.operator.cost for action in found.actions)
    return Solution("solved", made, cost, found.expanded, left_out, (), problem)


def _goals(last: nodes.Method) -> tuple[nodes.Goal, ...]:
    """Return the goals of the steps of a method."""
    body = last.body
    return (
        tuple([s.goal for s in body.steps]) if isinstance(body, nodes.TaskNet) else ()
    )


def plan_for_task(request: PlanRequest) -> Planned:
    """Return a method that brings about `succeed` of a RAP with `(plan)`."""
    rap, program = request.rap, request.library
    use = usable_in_plans(program.library.raps, rap)
    model = Model(program.library, program.signatures, use)
    goal = model.goal(rap, request.values)
    facts, found = situation(request.memory), None
    for excluded in (request.avoided, request.failed):
        if found is None or (found.sketch is None and excluded != request.avoided):
            found = solve(
                model,
                facts,
                goal,
                limit=request.limit,
                tries=request.tries,
                excluded=excluded,
                last=request.last,
            )
    assert found is not None
    made = None
    if found.sketch is not None and found.sketch.actions:
        inputs = constants_of(request.values)
        made = method(found.sketch, request.name, inputs)
    outcome = found.outcome if made or found.sketch is None else "unsolvable"
    return Planned(
        outcome,
        made,
        found.expanded,
        len(found.left_out),
        found.unreachable,
        achieved(found.sketch) if made and found.sketch else (),
    )
