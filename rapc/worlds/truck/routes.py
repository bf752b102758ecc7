"""The route planner: a problem solver for the RAP `travel-route` (T 7.4.1).

For two places, the planner finds the quickest route over the roads known in memory. The
result is a method with a `travel-road` step for each road. The planner reads memory
only, never the simulator. Not here: driving a road, see `stdlib/truck/travel.rap`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.handlers import AskedMemory
from rapc.base.values import Atom, Fact, Number
from rapc.ir.nodes import Compare, Const, Goal, Method, Var
from rapc.worlds.ways import in_turn, shortest

SOLVED_RAP = "travel-route"
"""The RAP that the planner solves: `(travel-route ?from ?to)`."""

Leg = tuple[Atom, Atom, Atom]
"""A road of a route: start, direction, end."""


def plan_route(goal: Fact, memory: AskedMemory) -> Sequence[Method]:
    """Return the quickest route as a method, or nothing if no route exists.

    The method applies to these two places only and drives the roads in turn.

    Args:
        goal: `("travel-route", from, to)`.
        memory: the source of `road` and `road-time` facts.
    """
    _, origin, target = goal
    legs = find_route(memory, origin, target)
    between = [("?from", origin), ("?to", target)]
    ends = [Compare("=", Var(name), Const(place)) for name, place in between]
    steps = [(Goal("travel-road", tuple(map(Const, leg)), ()), None) for leg in legs]
    return (in_turn(f"{origin}-to-{target}", 0, ends, steps),) if legs else ()


def find_route(memory: AskedMemory, origin: Atom, target: Atom) -> tuple[Leg, ...]:
    """Return the roads of the quickest route by nominal time; empty without a route."""

    def roads_from(place: Atom) -> Iterator[tuple[Leg, Atom, Number]]:
        for _, road, _, direction, to in memory.query("road", None, place, None, None):
            for _, _, time in memory.query("road-time", road, None):
                if isinstance(time, int | float):
                    yield (place, direction, to), to, time

    return shortest(origin, target, roads_from)
