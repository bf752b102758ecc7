"""How soon nine orders could be filled: a lower bound, by a planner that knows everything.

    python -m bench.bound                 # mean and deviation over thirty worlds
    python -m bench.bound --seeds 5 --last 12

prints a row for the still world and one for a world in which things are shuffled, in time
units, with the number of roads that the plan for the still world drives.

What is searched is the basic experiment (T 6.3.1) with these relaxations. Each takes
something from the truck's burden, and so none can make the bound greater than what a
truck may do at best:

- All is known beforehand: when each quarry makes its rocks, and where all of them lie.
- A rock takes the truck what no plan can save: an arm that moves to it and closes, and
  opens again. Nothing is dropped, nothing looked at, and no bay is ever full.
- Fuel lasts for ever, troops do not come, the weapon is mounted as quickly as arms and
  roads allow. Rocks may be brought before they are ordered.
- Of each colour only the `last` rocks that are made have to be brought; those before are
  there for nothing. With 12 nothing of that kind is left out.
- In the shuffled world a rock may be taken up at any place that is no factory, from the
  moment when it is made: whatever a demon does, it cannot put it nearer.
- A trip takes its nominal time. So the bound holds for a plan that is made beforehand;
  for one that makes use of trips that happened to be short, it holds with `--quick`, where
  each of them takes the least that chance allows.

How long a quarry rests is drawn for each world as the truck's world draws it, from a
stream of its own: what is to be compared with the bound's mean is the mean of runs.

The search is exact: it goes through states (where the truck is, what it has taken up, what
it has delivered) by the time at which they can be reached at the earliest. To be somewhere
sooner with the same rocks is never worse, and on a visit to a factory it is never worse to
leave all that it wants.
"""

from __future__ import annotations

import argparse
import heapq
import random
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, product
from statistics import mean, pstdev
from typing import NamedTuple

from rapc.worlds.truck.default_map import MAP
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.options import TruckSettings

ROCKS = 12
"""The rocks wanted of each colour: three orders of four."""

FACTORIES: Mapping[str, str] = {
    "red": "factory-1",
    "yellow": "factory-3",
    "blue": "factory-2",
}
"""Where the rocks of a colour go."""


class Plan(NamedTuple):
    """The quickest plan: when it ends, and how many roads it drives."""

    time: float
    roads: int


class Problem(NamedTuple):
    """What a planner is set."""

    #: Time units and roads from any place to any other.
    legs: Mapping[tuple[str, str], tuple[float, int]]
    #: Where rocks of each colour may be taken up.
    sources: Sequence[Sequence[str]]
    #: Where each colour goes.
    targets: Sequence[str]
    #: When each of the rocks of each colour is there.
    made: Sequence[Sequence[float]]
    #: When the truck is ready, and where.
    begin: float
    start: str
    #: What a rock takes at the least, up and down.
    up: float
    down: float


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=30, help="worlds drawn")
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--last", type=int, default=3, help="rocks of each colour")
    parser.add_argument("--quick", action="store_true", help="trips as short as may be")
    given = parser.parse_args()
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    for name, anywhere in (("still", False), ("shuffled", True)):
        plans = [
            quickest(problem(seed, given.last, given.quick, anywhere)) for seed in seeds
        ]
        times = [plan.time for plan in plans]
        print(
            f"{name:9} {mean(times):6.0f} ± {pstdev(times):3.0f} time units,"
            f" {mean(times) / 9:4.0f} an order, {mean(p.roads for p in plans):4.1f} roads"
        )


def problem(seed: int, last: int, quick: bool, anywhere: bool) -> Problem:
    """Return the relaxed problem of a world.

    Args:
        seed: of the quarries' rests.
        last: how many rocks of each colour are to be brought.
        quick: whether trips take the least that chance allows.
        anywhere: whether rocks may be taken up at any place that is no factory.
    """
    settings, ground = TruckSettings(), read_map(MAP)
    rng = random.Random(f"{seed}:bound")
    quarries = {place.color: place.name for place in ground.places if place.color}
    open_places = [place.name for place in ground.places if place.kind != "factory"]
    shortest = 1 - settings.time_spread / 100 if quick else 1
    legs = _legs(ground, shortest, float(settings.truck_move_time))
    arms = settings.arm_move_time + settings.arm_grasp_time
    return Problem(
        legs=legs,
        sources=[open_places if anywhere else [quarries[c]] for c in FACTORIES],
        targets=list(FACTORIES.values()),
        made=[_made(ground, c, settings, rng)[-last:] for c in FACTORIES],
        begin=legs[ground.start, "warehouse"][0] + _mounting(settings),
        start="warehouse",
        up=float(arms),
        down=float(settings.arm_ungrasp_time),
    )


def _made(
    ground: Map, color: str, settings: TruckSettings, rng: random.Random
) -> list[float]:
    """When the rocks of a colour that are wanted are there, in turn."""
    lying = sum(item.count for item in ground.items if item.color == color)
    times, now = [0.0] * min(lying, ROCKS), 0.0
    while len(times) < ROCKS:
        now += settings.quarry_interval * rng.uniform(0.5, 1.5)
        times.append(now)
    return times


def _mounting(settings: TruckSettings) -> float:
    """What no plan can save of mounting and loading the weapon.

    An arm moves out, to the tool and to the gun, closes twice, moves in and opens; one
    moves out and to the box, closes, moves in and to the gun, and pours.
    """
    moves, grasps = 8 * settings.arm_move_time, 3 * settings.arm_grasp_time
    return float(moves + grasps + settings.arm_ungrasp_time + settings.arm_pour_time)


def _legs(
    ground: Map, shortest: float, start: float
) -> dict[tuple[str, str], tuple[float, int]]:
    """Time units and roads of the quickest way between any two places."""
    legs = {}
    for place in ground.places:
        reached = dict(_reached(ground, place.name, shortest, start))
        legs.update({(place.name, to): way for to, way in reached.items()})
    return legs


def _reached(
    ground: Map, origin: str, shortest: float, start: float
) -> Iterator[tuple[str, tuple[float, int]]]:
    frontier, seen = [(0.0, 0, origin)], set()
    while frontier:
        time, roads, place = heapq.heappop(frontier)
        if place in seen:
            continue
        seen.add(place)
        yield place, (time, roads)
        for leg in ground.legs(place):
            takes = leg.road.time * shortest + start
            heapq.heappush(frontier, (time + takes, roads + 1, leg.to))


State = tuple[str, tuple[int, ...], tuple[int, ...]]
"""Where the truck is, and how many of each colour it has taken up and delivered."""


def quickest(problem: Problem) -> Plan:
    """Return the quickest plan by uniform-cost search."""
    none = (0,) * len(problem.made)
    goal = tuple(len(times) for times in problem.made)
    serial = count()
    frontier = [(problem.begin, next(serial), 0, (problem.start, none, none))]
    done: set[State] = set()
    while True:
        time, _, roads, state = heapq.heappop(frontier)
        if state in done:
            continue
        done.add(state)
        if state[2] == goal:
            return Plan(time, roads)
        for then, driven, after in _next(problem, state, time):
            if after not in done:
                found = (then, next(serial), roads + driven, after)
                heapq.heappush(frontier, found)


def _next(
    problem: Problem, state: State, time: float
) -> Iterator[tuple[float, int, State]]:
    """What can come next: another rock taken up here, or a trip to where one is wanted."""
    place, taken, given = state
    for color, times in enumerate(problem.made):
        if place in problem.sources[color] and taken[color] < len(times):
            there = max(time, times[taken[color]])
            yield there + problem.up, 0, (place, _more(taken, color), given)
    for to in _worth_going(problem, state):
        takes, roads = problem.legs[place, to]
        left = tuple(
            taken[color] if problem.targets[color] == to else given[color]
            for color in range(len(given))
        )
        down = problem.down * (sum(left) - sum(given))
        yield time + takes + down, roads, (to, taken, left)


def _worth_going(problem: Problem, state: State) -> Iterator[str]:
    place, taken, given = state
    for to in {to for pair in problem.legs for to in pair} - {place}:
        wanted = any(
            problem.targets[color] == to and taken[color] > given[color]
            for color in range(len(taken))
        )
        lies = any(
            to in problem.sources[color] and taken[color] < len(problem.made[color])
            for color in range(len(taken))
        )
        if wanted or lies:
            yield to


def _more(counts: tuple[int, ...], index: int) -> tuple[int, ...]:
    return (*counts[:index], counts[index] + 1, *counts[index + 1 :])


if __name__ == "__main__":
    main()
