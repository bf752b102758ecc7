"""Driving by skills alone, many seeds: nobody is run into, and journeys arrive.

The controller of `journey` decides what RAPs will decide; it hears of nothing but the
events of the skills.
"""

from __future__ import annotations

from random import Random

import pytest

from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.random_map import random_map
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import FOLLOW_HALL, STILL, Driver
from tests.hallway.journey import Traveller

CROWDED = HallwaySettings(doors=60, lift=60, usage=0)

GENTLE = 0.1
"""No collision may be faster, in metres a second."""


def _journey(seed: int, settings: HallwaySettings, map: Map | None = None) -> Traveller:
    """One journey between two landmarks chosen by the seed."""
    rng, driver = Random(seed), Driver(seed, settings, map)
    lift = [space.name for space in driver.sim.map.space if space.kind == "lift"]
    signs = [sign for sign in driver.sim.signs if sign.space not in lift]
    start, goal = rng.choice(signs), rng.choice(signs)
    driver.place_at(start.landmark, start.space)
    traveller = Traveller(driver, start.space, start.landmark)
    arrived = traveller.travel(goal.landmark, goal.space)
    at_goal = driver.sim.state.space == goal.space and driver.off_place(goal) < 0.4
    if not (arrived and at_goal):
        traveller.trouble.append("not there")
    return traveller


@pytest.mark.parametrize("block", first(1, range(10)))
def test_in_a_still_building_every_journey_goes_well(block: int) -> None:
    for seed in (2 * block, 2 * block + 1):
        traveller = _journey(seed, STILL)
        assert traveller.trouble == [], seed
        assert traveller.driver.sim.state.collisions == [], seed


@pytest.mark.parametrize("block", first(1, range(10)))
def test_among_people_and_doors_nobody_is_run_into(block: int) -> None:
    lost, fastest = [], 0.0
    for seed in range(1000 + 4 * block, 1004 + 4 * block):
        traveller = _journey(seed, CROWDED)
        fastest = max(fastest, traveller.driver.fastest_collision())
        if "not there" in traveller.trouble:
            lost.append((seed, traveller.trouble))
    assert fastest <= GENTLE
    assert len(lost) <= 1, lost


@pytest.mark.slow
def test_the_same_skills_drive_buildings_made_at_random() -> None:
    lost = []
    for seed in range(8):
        traveller = _journey(seed, CROWDED, random_map(seed))
        assert traveller.driver.fastest_collision() <= GENTLE, seed
        if "not there" in traveller.trouble:
            lost.append((seed, traveller.trouble))
    assert len(lost) <= 1, lost


@pytest.mark.parametrize("seed", first(1, range(6)))
def test_following_halls_for_long_among_people_hurts_nobody(seed: int) -> None:
    driver = Driver(seed, CROWDED)
    driver.place(10.0 + seed, 1.0, 0.0)
    for _ in range(12):
        events = ("end-o-hall", "hall-blocked")
        driver.until(*FOLLOW_HALL, events=events, within=60)
        heading = driver.sim.state.robot.reckoned_heading + 2.2
        turn = SkillRequest("turn-to", (round(heading, 2),))
        driver.until(turn, events=("movement-complete",), within=15)
    assert driver.sim.state.robot.distance > 30
    assert driver.fastest_collision() <= GENTLE
