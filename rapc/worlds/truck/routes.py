"""The route planner: a problem solver for the RAP `travel-route` (T 7.4.1).

Asked for a route between two places, it finds the quickest one over the roads that
memory knows and returns it as a method, one `travel-road` step after another. It
sees memory only, never the simulator. How a road is driven is for
`stdlib/truck/travel.rap` to say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.handlers import AskedMemory
from rapc.base.values import Atom, Fact, Number
from rapc.ir.nodes import Compare, Const, Goal, Method, Var
from rapc.worlds.ways import in_turn, shortest

SOLVED_RAP = "travel-route"
"""The RAP that is helped: `(travel-route ?from ?to)`."""

Leg = tuple[Atom, Atom, Atom]
"""One road of a route: from where, in which direction, to where."""


def plan_route(goal: Fact, memory: AskedMemory) -> Sequence[Method]:
    """The quickest route as a method, or nothing if no roads lead there.

    The method holds for these two places alone and drives the roads in turn.

    Args:
        goal: `("travel-route", from, to)`.
        memory: is asked for `road` and `road-time` facts.
    """
    _, origin, target = goal
    legs = find_route(memory, origin, target)
    between = [("?from", origin), ("?to", target)]
    ends = [Compare("=", Var(name), Const(place)) for name, place in between]
    steps = [(Goal("travel-road", tuple(map(Const, leg)), ()), None) for leg in legs]
    return (in_turn(f"{origin}-to-{target}", 0, ends, steps),) if legs else ()


def find_route(memory: AskedMemory, origin: Atom, target: Atom) -> tuple[Leg, ...]:
    """The roads of the quickest route by nominal time; none if there is no way."""

    def roads_from(place: Atom) -> Iterator[tuple[Leg, Atom, Number]]:
        for _, road, _, direction, to in memory.query("road", None, place, None, None):
            for _, _, time in memory.query("road-time", road, None):
                if isinstance(time, int | float):
                    yield (place, direction, to), to, time

    return shortest(origin, target, roads_from)
