"""The path planner: a breadth-first search over spaces, as a problem solver [S 3.2].

It is asked when `travel-to-distant-space` has no method for where the robot is and
where it is to go. What it finds becomes a method, which stays: from this space to that
one, by these doorways, as long as none of them was found closed a short while ago.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from rapc.base.handlers import AskedMemory
from rapc.base.values import Fact
from rapc.ir import nodes
from rapc.worlds import ways

REMEMBERED = 60
"""For so many seconds a doorway that was found closed is taken to be so."""

Joint = tuple[str, str, str]
"""A space, a doorway of it, and the space behind that."""

Doorways = Sequence[tuple[str, str]]
"""Doorways, each with the space behind it."""


def plan(goal: Fact, memory: AskedMemory) -> Sequence[nodes.Method]:
    """Return a method for `(travel-to-distant-space space)`, or none.

    There is none if memory does not have the robot's space. A doorway that was found
    closed is used only where there is no other way.

    Args:
        goal: what the task is to bring about.
        memory: what the robot believes.
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
        joined: what leads where.
        start: the space where the way begins.
        goal: the space where it ends.
        closed: doorways that are not to be used.
    """
    behind: dict[str, list[tuple[tuple[str, str], str, int]]] = {}
    for space, doorway, beyond in joined:
        if doorway not in closed:
            behind.setdefault(space, []).append(((doorway, beyond), beyond, 1))
    return ways.shortest(start, goal, lambda space: behind.get(space, ()))


def _method(start: str, goal: str, way: Doorways) -> nodes.Method:
    """Return the method that goes a way, one space after another."""
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
