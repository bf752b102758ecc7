"""Plans for goals: model, grounding, search and sketch together."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple, Protocol

from rapc.base.values import Fact, Number
from rapc.ir import nodes
from rapc.library.library import usable_in_plans
from rapc.library.operators import Conjunction, LeftOut, Model, constants_of
from rapc.planning.ground import (
    Action,
    Computing,
    Grounding,
    Problem,
    Situation,
    TooLargeError,
)
from rapc.planning.search import Found, Search
from rapc.planning.sketch import Sketch, achieved, goal_atoms, method, sketch
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.planner import BUILT_IN, Planned, PlanRequest


class Engine(Protocol):
    """A planner that is not part of rapc; see `rapc.planning.engines`."""

    @property
    def name(self) -> str:
        """Return the name of the engine."""

    def ask(self, problem: Problem) -> tuple[Action, ...] | str:
        """Return actions that solve a problem, or the reason why there are none."""


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
    #: The planner that was asked last.
    engine: str = BUILT_IN
    #: The reason why the answer of an engine was not used; empty if there is none.
    refused: str = ""


def situation(memory: MemoryView) -> Situation:
    """Return the facts of a memory, each with its age."""
    now, found = memory.now, dict[Fact, Number | None]()
    for fact in memory:
        since = memory.since(fact)
        found[fact] = None if since is None else now - since
    return found


def solve(  # noqa: PLR0913  # all but three have defaults and go by name
    model: Model,
    facts: Situation,
    goal: Sequence[Conjunction],
    *,
    limit: int,
    tries: int = 0,
    excluded: Collection[Fact] = (),
    compute: Computing | None = None,
    last: nodes.Method | None = None,
    late: Collection[Fact] = (),
    engine: Engine | None = None,
) -> Solution:
    """Return a plan for a goal.

    Args:
        model: the operators.
        facts: the situation.
        goal: the branches of the goal.
        limit: the greatest number of states to look at.
        tries: the number of further states to look at for a cheaper plan.
        excluded: the goals of steps that must not be used.
        compute: computes the costs of steps in memory; without it each cost is 1.
        last: an earlier plan, whose steps are used where they still apply.
        late: the goals of steps that come as late as possible.
        engine: asked before the search; the search is asked if the engine fails.
    """
    left_out = tuple(model.left_out)
    try:
        problem = Grounding(model, facts, goal, excluded, compute).problem()
    except TooLargeError:
        return Solution("limit", None, 0, 0, left_out, (), None)
    name, refused, found = BUILT_IN, "", None
    if engine is not None and problem.goal and goal_atoms(problem, ()) is None:
        answer = engine.ask(problem)
        if isinstance(answer, str):
            refused = answer
        else:
            found, name = Found("solved", answer), engine.name
    if found is None:
        steps = () if last is None else _goals(last)
        found = Search(problem, limit, steps, late).run(tries)
    solved = found.outcome == "solved"
    return Solution(
        found.outcome,
        sketch(problem, found.actions) if solved else None,
        sum([action.cost for action in found.actions]),
        found.expanded,
        left_out,
        () if solved else problem.unreachable,
        problem,
        name,
        refused,
    )


def _goals(last: nodes.Method) -> tuple[nodes.Goal, ...]:
    """Return the goals of the steps of a method."""
    body = last.body
    return (
        tuple([s.goal for s in body.steps]) if isinstance(body, nodes.TaskNet) else ()
    )


def plan_for_task(request: PlanRequest, engine: Engine | None = None) -> Planned:
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
                compute=request.compute,
                last=request.last,
                late=request.avoided,
                engine=engine,
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
        found.engine,
        found.refused,
    )
