"""Ways through a map as robots plan them: shortest paths, and methods that take them.

Nothing here knows what a map is: who asks says what leads where, and what a step is.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Sequence
from itertools import count
from typing import TypeVar

from rapc.base.values import Atom, Number
from rapc.ir import nodes

Place = TypeVar("Place", bound=Atom)
Step = TypeVar("Step")


def shortest(
    start: Place,
    goal: Place,
    steps_from: Callable[[Place], Iterable[tuple[Step, Place, Number]]],
) -> tuple[Step, ...]:
    """Return the steps of the shortest way; none if there is no way.

    Of ways equally short, the one found first, in the order of the steps.

    Args:
        start: where the way begins.
        goal: where it ends.
        steps_from: returns the steps from a place: each with its end and its length.
    """
    best: dict[Place, Number] = {start: 0}
    ways: dict[Place, tuple[Step, ...]] = {start: ()}
    serial = count()
    frontier: list[tuple[Number, int, Place]] = [(0, next(serial), start)]
    while frontier:
        far, _, place = heapq.heappop(frontier)
        if place == goal:
            return ways[place]
        for step, end, length in steps_from(place) if far <= best[place] else ():
            if end not in best or far + length < best[end]:
                best[end], ways[end] = far + length, (*ways[place], step)
                heapq.heappush(frontier, (best[end], next(serial), end))
    return ()


def in_turn(
    name: str,
    position: int,
    context: Sequence[nodes.Formula],
    goals: Sequence[tuple[nodes.Goal, nodes.Formula | None]],
) -> nodes.Method:
    """Return a method whose steps are taken one after another.

    Args:
        name: of the method.
        position: of the method.
        context: what has to hold, all of it.
        goals: the step's goal, and what it is to bring about for the next one.
    """
    steps = []
    for number, (goal, result) in enumerate(goals, 1):
        last = number == len(goals)
        order = () if last else (nodes.For(result, f"t{number + 1}"),)
        steps.append(nodes.Step(f"t{number}", 0, goal, order))
    return nodes.Method(
        name, position, nodes.And(tuple(context)), (), nodes.TaskNet(tuple(steps))
    )
