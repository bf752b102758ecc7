"""Many journeys of the hallway library: how many arrive, and what became of the others.

python -m bench.journeys                     500 journeys in the default building
python -m bench.journeys --pairs 60 --random-map 5
python -m bench.journeys --pairs 60 --map museum
python -m bench.journeys --pairs 60 --map @FILE        a map in TOML
python -m bench.journeys --pairs 200 --corridors       another building for each seed
python -m bench.journeys --pairs 200 --buildings     another random map for each seed
python -m bench.journeys --pairs 30 --set drift=4 sonar=cone
python -m bench.journeys --honest            with the honest body

The seed of a journey draws start and goal among all landmarks, and all chance of the
run. A line is printed for each journey that failed, and for each time at which the
robot was wrong about the space that it was in; then the sums.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from bench.corridors import DOORWAYS, corridors, toml_text
from rapc.base.values import Atom, Text, number
from rapc.runtime.events.report import cause_lines
from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.random_map import random_map
from tests.hallway.sent import HONEST, Journey, travel

NEAR = 0.5
"""So near to its place before the landmark the robot is at the landmark, in metres."""


def main() -> None:
    """Send the robot, and print what came of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pairs", type=int, default=500, help="how many journeys")
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument(
        "--map", default="default", help="a map of rapc by name, or @FILE"
    )
    parser.add_argument("--random-map", type=int, help="the seed of a building")
    parser.add_argument(
        "--corridors",
        action="store_true",
        help="long corridors and narrow doorways, another building for each seed",
    )
    parser.add_argument(
        "--buildings",
        action="store_true",
        help="a building made at random, another one for each seed",
    )
    parser.add_argument(
        "--honest",
        action="store_true",
        help="the honest body: " + ", ".join(f"{n}={v}" for n, v in HONEST.items()),
    )
    parser.add_argument(
        "--doorways",
        nargs=2,
        type=float,
        default=DOORWAYS,
        metavar="METRES",
        help="the narrowest and the widest doorway of --corridors",
    )
    parser.add_argument(
        "--set",
        nargs="*",
        default=[],
        metavar="NAME=VALUE",
        help="options of the world",
    )
    given = parser.parse_args()
    settings: dict[str, Atom] = dict(HONEST) if given.honest else {}
    for name, _, value in (text.partition("=") for text in given.set):
        symbol = value[:1].isalpha()
        settings[name] = value if symbol else number(float(value))
    map, options = building(given.map, given.random_map)
    start, journeys = time.process_time(), []
    for seed in range(given.first_seed, given.first_seed + given.pairs):
        if given.corridors:
            map = corridors(seed, tuple(given.doorways))
            options = {"map": Text(toml_text(map))}
        elif given.buildings:
            map, options = building("", seed)
        journey = travel(seed, map, options | settings)
        journeys.append(journey)
        for line in told(seed, journey):
            print(line, flush=True)
    used = time.process_time() - start
    for line in sums(journeys):
        print(line)
    driven = sum(journey.time for journey in journeys)
    print(f"{driven / 3600:.1f} hours, in {used:.0f} s of processor time")


def building(name: str, seed: int | None) -> tuple[Map, dict[str, Atom]]:
    """Return a map, and the options of the world that ask for it."""
    if seed is not None:
        return random_map(seed), {"random-map": seed}
    if name.startswith("@"):
        text = Path(name[1:]).read_text(encoding="utf-8")
        return read_map(text), {"map": Text(text)}
    return named_map(name), {"map": Text(name)}


def told(seed: int, journey: Journey) -> Iterator[str]:
    """Yield what there is to say of one journey: nothing if all went well."""
    faults = faults_of(journey)
    if not faults and not journey.strays:
        return
    said = f"seed {seed}, {journey.start} to {journey.goal}, {journey.time:.0f} s: "
    yield said + (", ".join(faults) or "arrived")
    for stray in journey.strays:
        yield f"    {stray}"
    if not journey.succeeded:
        yield from (f"    {line}" for line in cause_lines(journey.because))


def faults_of(journey: Journey) -> list[str]:
    """Return what a journey lacks to be a good one, in words."""
    truth, faults = journey.truth, []
    if not journey.succeeded:
        faults.append("did not arrive")
    elif truth.space != journey.space or journey.away > NEAR:
        faults.append(f"is in {truth.space}, {journey.away:.1f} m away")
    if truth.space != journey.believed:
        faults.append(f"believes to be in {journey.believed}")
    if truth.fastest > 0.1:
        faults.append(f"ran into something at {truth.fastest} m/s")
    return faults


def sums(journeys: Sequence[Journey]) -> Iterator[str]:
    """Yield what all journeys come to."""
    arrived = [journey for journey in journeys if journey.arrived]
    yield f"{len(arrived)} of {len(journeys)} arrived"
    right = sum(journey.truth.space == journey.believed for journey in journeys)
    yield f"{right} of {len(journeys)} believed the right space at the end"
    there = sum(journey.away <= NEAR for journey in arrived)
    furthest = max((journey.away for journey in arrived), default=0)
    yield f"{there} of {len(arrived)} within {NEAR} m, the furthest {furthest:.2f} m"
    fastest = max((journey.truth.fastest for journey in journeys), default=0)
    count = sum(journey.truth.collisions for journey in journeys)
    yield f"{count} collisions, the fastest at {fastest} m/s"
    yield f"{sum(journey.pushes for journey in journeys)} pushes by people"
    strayed = [journey for journey in journeys if journey.strays]
    yield f"{len(strayed)} journeys with a wrong belief about the space on the way"
    causes = Counter(s.cause for journey in strayed for s in journey.strays)
    for cause, times in causes.most_common():
        yield f"    {times} {cause}"


if __name__ == "__main__":
    main()
