"""A robot between the jambs of a doorway is told to pass it, or stopped as it does."""

from __future__ import annotations

import math
from random import Random

import pytest

from rapc import events
from rapc.base.values import Atom, Text
from rapc.worlds.hallway.map import Sign, signs
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import EAST, Driver
from tests.hallway.sent import begin
from tests.hallway.strays import Strays

TOLD = ("movement-complete", "door-closed", "stuck")


def _doorways(map: str) -> list[tuple[str, Sign]]:
    """Return the doorways of a building from both sides, but for those of a lift."""
    building = named_map(map)
    lift = {space.name for space in building.space if space.kind == "lift"}
    names = {d.name for d in building.doorway if not lift & set(d.joins)}
    return [(map, sign) for sign in signs(building) if sign.landmark in names]


DOORWAYS = _doorways("default") + _doorways("museum")

INTO = (0.25, 0.15, 0.0, -0.1, -0.2, -0.35)
"""Metres from the wall's near face to the robot's middle; below 0 it is past it."""


@pytest.mark.parametrize("number", first(1, range(len(DOORWAYS))))
def test_a_robot_between_the_jambs_goes_on_through(number: int) -> None:
    map, sign = DOORWAYS[number]
    for into in INTO:
        rng = Random(f"{number} {into}")
        driver = Driver(number, map=named_map(map))
        driver.place_at(sign.landmark, sign.space)
        body, ahead = driver.sim.state.robot, sign.normal + math.pi
        x, y = sign.front(into)
        aside, skew = rng.uniform(-0.1, 0.1), rng.uniform(-0.15, 0.15)
        body.x, body.y = x - aside * math.sin(ahead), y + aside * math.cos(ahead)
        body.heading = math.remainder(ahead + rng.uniform(-0.3, 0.3), math.tau)
        body.reckoned_heading = body.heading + skew
        through = SkillRequest("move-thru-doorway", (round(ahead + skew, 3), 0.3))
        outcome = driver.until(through, events=TOLD, within=60)
        name = f"{sign.landmark} of {map} from {sign.space}, {into}"
        assert outcome.event == "movement-complete", name
        assert driver.sim.state.space != sign.space, name
        assert driver.sim.state.collisions == [], name


@pytest.mark.parametrize("seed", first(2, range(20)))
def test_between_two_who_stand_in_a_room_there_is_no_doorway(seed: int) -> None:
    """Both are as near as jambs, and nothing is ahead; no wall is beside them."""
    rng = Random(f"two {seed}")
    driver = Driver(seed, HallwaySettings(doors=0, people=2, lift=0, drift=0, usage=0))
    driver.place(17.0, 17.0, EAST)
    for walker, side in zip(driver.sim.state.walkers, (1, -1), strict=True):
        walker.floor, walker.way, walker.pause = 1, [], 1000.0
        walker.x = 17.0 + rng.uniform(-0.1, 0.1)
        walker.y = 17.0 + side * rng.uniform(0.6, 0.8)
    through = SkillRequest("move-thru-doorway", (EAST, 0.3))
    outcome = driver.until(through, events=TOLD, within=60)
    assert outcome.event == "door-closed"
    assert driver.sim.state.space == "library"


QUIET: dict[str, Atom | bool] = {
    "doors": 0,
    "people": 0,
    "lift": 0,
    "start": Text("charger"),
}


@pytest.mark.parametrize("time", first(1, range(122, 134)))
def test_who_is_bumped_into_in_a_doorway_goes_on_through(time: int) -> None:
    """The robot backs away between the jambs, and takes no open door for closed.

    It is pushed against a jamb of the laboratory's door on its way out.
    """
    believed: list[events.FactAsserted] = []
    run, world = begin(1, "(go-to coffee-machine) :at 1", options=QUIET)
    run.listen(
        lambda event: believed.extend(
            [event]
            if isinstance(event, events.FactAsserted)
            and event.fact[0] == "found-closed"
            else []
        ),
        events.FactAsserted,
    )
    strays = Strays(run, world)
    run.call_at(time / 10, lambda: world.simulation.push(0.6, 0, 1.2))
    run.run(until=40)
    assert "push" in [run_into.what for run_into in world.simulation.state.collisions]
    assert world.figures().fastest <= 0.1
    assert believed == []
    assert strays.found == []
    assert world.figures().space != "lab"
