"""Buildings in which skills once failed: journeys arrive, with the right belief."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.corridors import corridors, toml_text
from rapc.base.values import Atom, Text
from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_text import read_map
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import (
    EAST,
    FOLLOW_HALL,
    STILL,
    WEST,
    Driver,
    to_landmark,
)
from tests.hallway.sent import travel

MAPS = Path(__file__).parent / "maps"


def _text(name: str) -> str:
    return (MAPS / f"{name}.toml").read_text(encoding="utf-8")


def _map(name: str) -> Map:
    return read_map(_text(name))


@pytest.mark.parametrize("seed", first(2, [4, 1, 2, 6, 15, 18, 19]))
def test_landmark_beside_an_open_doorway_is_found_in_its_space(seed: int) -> None:
    journey = travel(seed, _map("behind"), {"map": Text(_text("behind"))})
    assert journey.arrived, journey
    assert journey.away < 0.3
    assert journey.strays == []


def test_landmark_is_not_reached_while_a_tag_is_out_of_view() -> None:
    """Somebody stands before its left tag when the robot comes to its place."""
    settings = HallwaySettings(doors=0, people=1, lift=0, drift=0, usage=0)
    driver = Driver(0, settings)
    sign = driver.place_at("charger", "lab")
    ticket = driver.on(to_landmark(sign, standoff=1.4), events=("at-landmark",))
    driver.tick(2)
    (walker,) = driver.sim.state.walkers
    x, y = sign.front(0.4)
    walker.x, walker.y, walker.floor, walker.way = x, y - 0.45, 1, []
    walker.pause = 100.0
    driver.tick(70)
    assert [told.event for _, told in driver.heard if ticket in told.tickets] == []
    walker.x += 3.0
    driver.tick(30)
    told = [told.event for _, told in driver.heard if ticket in told.tickets]
    assert told == ["at-landmark"]


@pytest.mark.parametrize("seed", first(1, range(5)))
def test_widest_doorway_is_noticed_by_sonar(seed: int) -> None:
    driver = Driver(seed, STILL, _map("behind"))
    driver.place(1.3, 2.7, EAST)
    driver.on(SkillRequest("detect-doorway"), events=("passed-doorway",))
    move = SkillRequest("move-in-direction", (EAST, 3.5, 0.5))
    driver.until(move, events=("movement-complete", "stuck"), within=60)
    assert driver.sim.state.space == "room"
    (told,) = [one for _, one in driver.heard if one.event == "passed-doorway"]
    assert told.arguments == pytest.approx((2.66, 2.7, EAST), abs=0.15)


@pytest.mark.parametrize("seed", first(1, [4, 6, 8, 10, 14]))
def test_doorway_at_the_end_of_a_narrow_hall_is_open(seed: int) -> None:
    text = _text("narrow-hall")
    journey = travel(seed, _map("narrow-hall"), {"map": Text(text)})
    assert journey.arrived, journey
    assert journey.time < 60
    assert journey.strays == []


ENDS = [
    (width, aside, turned)
    for turned in (0.0, 0.1, -0.1)
    for aside in (0.0, 0.1, -0.1)
    for width in (1.3, 1.2, 1.0, 0.8)
]
"""Width of the doorway, metres of the robot to the side, radians by which it is turned.
"""


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("end", first(2, ENDS))
def test_little_wall_beside_a_doorway_tells_it_from_a_closed_one(
    end: tuple[float, float, float], closed: bool
) -> None:
    width, aside, turned = end
    text = _text("narrow-hall").replace("width = 1.3", f"width = {width}\ndoor = true")
    driver = Driver(ENDS.index(end), STILL, read_map(text))
    driver.place(9.0, 0.85 + aside, EAST + turned)
    driver.sim.state.doors[0].closed = closed
    driver.sim.restore(driver.sim.save())
    outcome = driver.until(
        SkillRequest("move-thru-doorway", (EAST, 0.3)),
        events=("movement-complete", "door-closed", "stuck"),
        within=60,
    )
    assert outcome.event == ("door-closed" if closed else "movement-complete")
    assert driver.sim.state.space == ("one" if closed else "two")
    assert driver.sim.state.collisions == []


@pytest.mark.parametrize("seed", first(1, [2004, 2032, 2098, 2114]))
def test_doorway_far_from_where_dead_reckoning_has_it_ends_the_search(
    seed: int,
) -> None:
    """Somebody is in the way, and the robot swerves into a room of a long corridor."""
    map = corridors(seed, (1.1, 1.3))
    options: dict[str, Atom] = {"map": Text(toml_text(map))}
    options |= {"drift": 3, "doors": 40}
    journey = travel(seed, map, options)
    assert journey.arrived, journey
    assert journey.strays == []


@pytest.mark.parametrize("apart", first(1, [5.0, 3.0, 0.2]))
def test_landmark_is_reached_whether_its_tags_are_far_apart_or_near(
    apart: float,
) -> None:
    """One metre before tags that are 5 m apart, the angle between them is obtuse."""
    text = _text("behind").replace(
        'wall = "west"\nat = 4.28', f'wall = "east"\nat = 3.2\napart = {apart}'
    )
    journey = travel(4, read_map(text), {"map": Text(text)})
    assert (journey.goal, journey.arrived) == ("m", True), journey
    assert journey.away < 0.3


@pytest.mark.parametrize("seed", first(1, [9022, 9008, 9047, 9054, 9060]))
def test_wall_of_a_room_is_no_end_of_the_hall_beside_it(seed: int) -> None:
    """The robot swerves around somebody into an open doorway."""
    map = corridors(seed, (1.0, 1.3))
    driver = Driver(seed, HallwaySettings(doors=120, people=9, lift=0, usage=0), map)
    _, _, length, width = map.space[0].box
    east = seed % 2 == 0
    driver.place(1.2 if east else length - 1.2, width / 2, EAST if east else WEST)
    events = ("end-o-hall", "hall-blocked", "stuck")
    outcome = driver.until(*FOLLOW_HALL, events=events, within=400)
    body = driver.sim.state.robot
    there = (length - body.x if east else body.x) < 1.6
    assert outcome.event in {"hall-blocked", "end-o-hall"}
    assert (outcome.event == "end-o-hall") is there
