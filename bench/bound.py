"""How soon nine orders could be filled: a lower bound, by a planner that knows all.

    python -m bench.bound                 # mean and deviation over thirty worlds
    python -m bench.bound --last 3 --usual

prints a row for the still world and one for a world in which things are shuffled, in
time units.

What is searched is the basic experiment (T 6.3.1) with these relaxations. Each takes
something from the truck's burden, and so none can make the bound greater than what a
truck may do at best:

- All is known beforehand: when each quarry makes its rocks, and where all of them lie.
- A rock takes the truck what no plan can save: an arm that moves to it and closes, and
  opens again. Nothing is dropped, nothing looked at, and no bay is ever full.
- Each trip is driven at high speed, and takes the least that chance allows. With
  `--usual` trips take their nominal time at medium speed: what remains then is a bound
  for plans made beforehand at that speed, and the price of the rest can be seen.
- Fuel lasts for ever, troops do not come, the weapon is mounted as quickly as arms and
  roads allow. Rocks may be brought before they are ordered.
- Of each colour only the `last` rocks that are made have to be brought; those before
  are there for nothing. With 12 nothing of that kind is left out.
- In the shuffled world a rock may be taken up at any place that is no factory, from
  the moment when it is made: whatever a demon does, it cannot put it nearer.

How long a quarry rests is drawn for each world as the truck's world draws it, from a
stream of its own: what is to be compared with the bound's mean is the mean of runs.

The search is exact. It goes through states (where the truck is, what it has taken up,
what it has delivered) by the earliest time at which each can be reached. To be
somewhere sooner with the same rocks is never worse, and on a visit to a factory it is
never worse to leave all that it wants.
"""

from __future__ import annotations

import argparse
import heapq
import random
from collections.abc import Iterator, Mapping, Sequence
from statistics import mean, pstdev
from typing import NamedTuple

from rapc.worlds.maps import shipped_map
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.movement import SPEEDS
from rapc.worlds.truck.options import TruckSettings

ROCKS = 12
"""The rocks wanted of each colour: three orders of four."""

FACTORIES: Mapping[str, str] = {
    "red": "factory-1",
    "yellow": "factory-3",
    "blue": "factory-2",
}
"""Where the rocks of a colour go."""


class Problem(NamedTuple):
    """What a planner is set."""

    #: Time units from any place to any other, by both.
    legs: Mapping[tuple[str, str], float]
    #: All places, in the order of the map.
    places: Sequence[str]
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
    parser.add_argument("--last", type=int, default=2, help="rocks of each colour")
    parser.add_argument("--usual", action="store_true", help="trips at medium speed")
    given = parser.parse_args()
    if given.seeds < 1 or not 1 <= given.last <= ROCKS:
        parser.error(f"--seeds is 1 or more, --last from 1 to {ROCKS}")
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    for name, anywhere in (("still", False), ("shuffled", True)):
        times = [
            quickest(problem(seed, given.last, given.usual, anywhere)) for seed in seeds
        ]
        spread = f"{mean(times):6.0f} ± {pstdev(times):3.0f}"
        print(f"{name:9} {spread} time units, {mean(times) / 9:4.0f} an order")


def problem(seed: int, last: int, usual: bool, anywhere: bool) -> Problem:
    """Return the relaxed problem of a world.

    Args:
        seed: of the quarries' rests.
        last: how many rocks of each colour are to be brought.
        usual: whether trips take their nominal time at medium speed.
        anywhere: whether rocks may be taken up at any place that is no factory.
    """
    settings, ground = TruckSettings(), read_map(shipped_map("truck", "default"))
    rng = random.Random(f"{seed}:bound")
    quarries = {str(place.color): place.name for place in ground.places}
    open_places = [place.name for place in ground.places if place.kind != "factory"]
    fastest = min(time for time, _ in SPEEDS.values())
    shortest = 1 if usual else fastest * (1 - settings.time_spread / 100)
    legs = _legs(ground, shortest, float(settings.truck_move_time))
    arms = settings.arm_move_time + settings.arm_grasp_time
    return Problem(
        legs=legs,
        places=[place.name for place in ground.places],
        sources=[open_places if anywhere else [quarries[c]] for c in FACTORIES],
        targets=list(FACTORIES.values()),
        made=[_made(ground, c, settings, rng)[-last:] for c in FACTORIES],
        begin=legs[ground.start, "warehouse"] + _mounting(settings),
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


def _legs(ground: Map, shortest: float, start: float) -> dict[tuple[str, str], float]:
    """Time units of the quickest way between any two places.

    Args:
        ground: the map.
        shortest: what part of its nominal time a trip takes.
        start: what each trip takes besides.
    """
    return {
        (place.name, to): time
        for place in ground.places
        for to, time in _reached(ground, place.name, shortest, start)
    }


def _reached(
    ground: Map, origin: str, shortest: float, start: float
) -> Iterator[tuple[str, float]]:
    frontier, seen = [(0.0, origin)], set[str]()
    while frontier:
        time, place = heapq.heappop(frontier)
        if place in seen:
            continue
        seen.add(place)
        yield place, time
        for leg in ground.legs(place):
            takes = float(leg.road.time) * shortest + start
            heapq.heappush(frontier, (time + takes, leg.to))


State = tuple[str, tuple[int, ...], tuple[int, ...]]
"""Where the truck is, and how many of each colour it has taken up and delivered."""


def quickest(problem: Problem) -> float:
    """Return when the quickest plan ends, by uniform-cost search."""
    none = (0,) * len(problem.made)
    goal = tuple(len(times) for times in problem.made)
    frontier: list[tuple[float, State]] = [(problem.begin, (problem.start, none, none))]
    done: set[State] = set()
    while True:
        time, state = heapq.heappop(frontier)
        if state in done:
            continue
        done.add(state)
        if state[2] == goal:
            return time
        for then, after in _next(problem, state, time):
            if after not in done:
                heapq.heappush(frontier, (then, after))


def _next(problem: Problem, state: State, time: float) -> Iterator[tuple[float, State]]:
    """What can come next: a rock taken up here, or a trip to where one is wanted."""
    place, taken, given = state
    for color, times in enumerate(problem.made):
        if place in problem.sources[color] and taken[color] < len(times):
            there = max(time, times[taken[color]])
            yield there + problem.up, (place, _more(taken, color), given)
    for to in problem.places:
        if to == place or not _worth_going(problem, state, to):
            continue
        left = tuple(
            taken[color] if problem.targets[color] == to else given[color]
            for color in range(len(given))
        )
        down = problem.down * (sum(left) - sum(given))
        yield time + problem.legs[place, to] + down, (to, taken, left)


def _worth_going(problem: Problem, state: State, to: str) -> bool:
    """Whether a rock is wanted at a place, or may be taken up there."""
    _, taken, given = state
    return any(
        (problem.targets[color] == to and taken[color] > given[color])
        or (to in problem.sources[color] and taken[color] < len(times))
        for color, times in enumerate(problem.made)
    )


def _more(counts: tuple[int, ...], index: int) -> tuple[int, ...]:
    return (*counts[:index], counts[index] + 1, *counts[index + 1 :])


if __name__ == "__main__":
    main()
