"""Planned ways through a map: shortest paths, and the methods for them.

Independent of the kind of map: the caller supplies connections and steps.
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
    """Return the steps of the shortest way; empty without a way.

    Of equally short ways the first found is returned, in the order of the steps.

    Args:
        start: the start of the way.
        goal: the end of the way.
        steps_from: returns the steps from a place, each with its end and its length.
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
    """Return a method with a sequence of steps.

    Args:
        name: the name of the method.
        position: the position of the method.
        context: the formulas that must all hold.
        goals: the goal of each step, and the formula that the next step requires.
    """
    steps = []
    for number, (goal, result) in enumerate(goals, 1):
        last = number == len(goals)
        order = () if last else (nodes.For(result, f"t{number + 1}"),)
        steps.append(nodes.Step(f"t{number}", 0, goal, order))
    return nodes.Method(
        name, position, nodes.And(tuple(context)), (), nodes.TaskNet(tuple(steps))
    )
