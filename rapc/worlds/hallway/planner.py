"""The path planner: a breadth-first search over spaces, as a problem solver [S 3.2].

The interpreter calls the planner if `travel-to-distant-space` has no method for start
and goal. The result becomes a permanent method: a way from this space to that space
through these doorways. Its context excludes doorways recently found closed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from rapc.base.handlers import AskedMemory
from rapc.base.values import Fact
from rapc.ir import nodes
from rapc.worlds import ways

REMEMBERED = 60
"""The seconds for which a doorway found closed counts as closed."""

Joint = tuple[str, str, str]
"""A space, a doorway of the space, and the space beyond."""

Doorways = Sequence[tuple[str, str]]
"""Doorways, each with the space beyond."""


def plan(goal: Fact, memory: AskedMemory) -> Sequence[nodes.Method]:
    """Return a method for `(travel-to-distant-space space)`, or none.

    The result is empty if memory lacks the robot's space. A doorway found closed is
    used only if there is no other way.

    Args:
        goal: the goal of the task.
        memory: the robot's beliefs.
    """
    wanted = str(goal[1])
    spaces = [str(fact[-1]) for fact in memory.query("current-space", "robot", None)]
    if not spaces:
        return []
    here = spaces[-1]
    joined = [
        (str(space), str(mark), str(beyond))
        for _, mark, space, beyond in memory.query("connects", None, None, None)
    ]
    closed = {str(fact[1]) for fact in memory.query("found-closed", None)}
    way = shortest(joined, here, wanted, closed) or shortest(joined, here, wanted)
    return [_method(here, wanted, way)] if way else []


def shortest(
    joined: Iterable[Joint], start: str, goal: str, closed: Collection[str] = ()
) -> Doorways:
    """Return the doorways of a shortest way, or none.

    Args:
        joined: the connections between spaces.
        start: the space at the start.
        goal: the space at the end.
        closed: doorways to avoid.
    """
    behind: dict[str, list[tuple[tuple[str, str], str, int]]] = {}
    for space, doorway, beyond in joined:
        if doorway not in closed:
            behind.setdefault(space, []).append(((doorway, beyond), beyond, 1))
    return ways.shortest(start, goal, lambda space: behind.get(space, ()))


def _method(start: str, goal: str, way: Doorways) -> nodes.Method:
    """Return the method that follows a way from space to space."""
    const = nodes.Const

    def within(space: str) -> nodes.Proposition:
        return nodes.Proposition("current-space", (const("robot"), const(space)))

    steps = [
        (nodes.Goal("go-to-next-space", (const(d), const(to)), ()), within(to))
        for d, to in way
    ]
    wanted = nodes.Compare("=", nodes.Var("?space"), const(goal))
    context = (wanted, within(start), *(_not_closed(doorway) for doorway, _ in way))
    doorways = "-".join(doorway for doorway, _ in way)
    return ways.in_turn(f"{start}-to-{goal}-by-{doorways}", 1, context, steps)


def _not_closed(doorway: str) -> nodes.Formula:
    fact = nodes.Proposition("found-closed", (nodes.Const(doorway),))
    return nodes.Not(nodes.Believe(fact, nodes.Const(REMEMBERED)))
