"""The route planner: a problem solver for the RAP `travel-route` (T 7.4.1).

Asked for a route between two places, it finds the quickest one over the roads that
memory knows and returns it as a method, one `travel-road` step after another. It
sees memory only, never the simulator. How a road is driven is for
`stdlib/truck/travel.rap` to say.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from itertools import count

import msgspec

from rapc.base.handlers import AskedMemory
from rapc.base.values import Atom, Fact, Number
from rapc.ir import nodes
from rapc.ir.nodes import And, Compare, Const, For, Method, Step, TaskNet, Var

SOLVED_RAP = "travel-route"
"""The RAP that is helped: `(travel-route ?from ?to)`."""


class Leg(msgspec.Struct, frozen=True):
    """One road of a route, driven from a place in a direction to another."""

    origin: Atom
    direction: Atom
    to: Atom


def plan_route(goal: Fact, memory: AskedMemory) -> Sequence[Method]:
    """The quickest route as a method, or nothing if no roads lead there.

    Args:
        goal: `("travel-route", from, to)`.
        memory: is asked for `road` and `road-time` facts.
    """
    _, origin, target = goal
    legs = find_route(memory, origin, target)
    return (_method(origin, target, legs),) if legs else ()


def find_route(memory: AskedMemory, origin: Atom, target: Atom) -> tuple[Leg, ...]:
    """The roads of the quickest route by nominal time; none if there is no way.

    Of routes equally quick, the one found first, in the order of the map.
    """
    best: dict[Atom, Number] = {origin: 0}
    came_by: dict[Atom, Leg] = {}
    serial = count()
    frontier: list[tuple[Number, int, Atom]] = [(0, next(serial), origin)]
    while frontier:
        time, _, place = heapq.heappop(frontier)
        if place == target:
            return _trace_back(came_by, origin, target)
        if time > best[place]:
            continue
        for leg, takes in _roads_from(memory, place):
            arrival = time + takes
            if leg.to not in best or arrival < best[leg.to]:
                best[leg.to] = arrival
                came_by[leg.to] = leg
                heapq.heappush(frontier, (arrival, next(serial), leg.to))
    return ()


def _roads_from(memory: AskedMemory, place: Atom) -> Iterator[tuple[Leg, Number]]:
    for _, road, _, direction, to in memory.query("road", None, place, None, None):
        for _, _, time in memory.query("road-time", road, None):
            if isinstance(time, int | float):
                yield Leg(place, direction, to), time


def _trace_back(
    came_by: dict[Atom, Leg], origin: Atom, target: Atom
) -> tuple[Leg, ...]:
    legs: list[Leg] = []
    place = target
    while place != origin:
        leg = came_by[place]
        legs.append(leg)
        place = leg.origin
    return tuple(reversed(legs))


def _method(origin: Atom, target: Atom, legs: Sequence[Leg]) -> Method:
    """A method that holds for these two places alone and drives the legs in turn."""
    pair = (
        Compare("=", Var("?from"), Const(origin)),
        Compare("=", Var("?to"), Const(target)),
    )
    return Method(
        name=f"{origin}-to-{target}",
        position=0,
        context=And(pair),
        notations=(),
        body=TaskNet(tuple(_steps(legs))),
    )


def _steps(legs: Sequence[Leg]) -> Iterator[Step]:
    """A step per leg; each is for the next, which needs the truck where it ends."""
    for number, leg in enumerate(legs, start=1):
        args = (Const(leg.origin), Const(leg.direction), Const(leg.to))
        order = (For(None, f"t{number + 1}"),) if number < len(legs) else ()
        yield Step(f"t{number}", 0, nodes.Goal("travel-road", args, ()), order)
