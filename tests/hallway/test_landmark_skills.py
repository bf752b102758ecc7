"""Skills that find landmarks and doorways, each switched on by hand."""

from __future__ import annotations

import math

import pytest

from rapc.worlds.hallway.map import signs
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from rapc.worlds.skills.runtime import EventTold
from tests.effort import first
from tests.hallway.driver import (
    EAST,
    FOLLOW_HALL,
    NORTH,
    SOUTH,
    Driver,
    to_landmark,
    watch,
)

HUNG = signs(named_map("default"))

SPACES = sorted({sign.space for sign in HUNG} - {"lift", "lab"})
SPACES.insert(0, "lab")
"""Those of the default map, the laboratory first."""


def test_a_watch_tells_when_the_landmark_comes_into_view() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, EAST)
    sign = driver.sim.sign_of("library-door", "north-hall")
    ticket = driver.on(
        *FOLLOW_HALL, watch(sign), events=("landmark-visible", "end-o-hall")
    )
    told: list[EventTold] = []
    while not any(one.event == "landmark-visible" for one in told):
        told = driver.tick()
    (one,) = [one for one in told if one.event == "landmark-visible"]
    assert one.tickets == (ticket,)
    mark, far, heading = one.arguments
    body = driver.sim.state.robot
    assert mark == "library-door"
    assert isinstance(far, float | int)
    assert isinstance(heading, float | int)
    assert far >= math.hypot(sign.x - body.x, sign.y - body.y) - 0.5
    true = math.atan2(sign.y - body.y, sign.x - body.x)
    assert heading == pytest.approx(true, abs=0.1)


def test_landmarks_in_view_are_told_of_in_turn_without_being_watched_for() -> None:
    driver = Driver()
    sign = driver.place_at("charger", "lab")
    driver.on(SkillRequest("see-tags"), events=("tags-seen",))
    driver.tick(45)
    seen = [one.arguments for _, one in driver.heard]
    assert [left for left, *_ in seen] == [0, 2, 8, 0, 2]
    for left, right, spread, heading in (seen[0], seen[3]):
        assert (left, right) == sign.tags
        assert spread == pytest.approx(2 * math.atan(sign.apart / 2), abs=0.06)
        assert abs(math.remainder(float(str(heading)) - math.pi, math.tau)) < 0.05


@pytest.mark.parametrize("space", first(1, SPACES))
def test_every_landmark_is_reached_from_every_other_in_its_space(space: str) -> None:
    for seed, sign in enumerate(HUNG):
        for other in HUNG:
            if sign.space != space:
                continue
            if other.space != sign.space or other.floor != sign.floor:
                continue
            driver = Driver(seed)
            driver.place_at(sign.landmark, sign.space)
            dx, dy = (b - a for a, b in zip(sign.front(1), other.front(1), strict=True))
            move = SkillRequest(
                "move-in-direction", (math.atan2(dy, dx), math.hypot(dx, dy), 0.5)
            )
            events = ("movement-complete", "stuck", "landmark-visible")
            driver.until(move, watch(other), events=events, within=120)
            events = ("at-landmark", "stuck", "lost-landmark")
            outcome = driver.until(to_landmark(other), events=events, within=120)
            name = f"{sign.landmark} to {other.landmark} in {sign.space}"
            assert outcome.event == "at-landmark", name
            assert driver.off_place(other) < 0.3, name
            off = driver.sim.state.robot.heading - other.normal - math.pi
            assert abs(math.remainder(off, math.tau)) < 0.15, name
            assert driver.sim.state.collisions == [], name


def test_a_landmark_out_of_sight_is_lost() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, EAST)
    sign = driver.sim.sign_of("charger", "lab")
    events = ("movement-complete", "lost-landmark", "stuck")
    assert driver.until(to_landmark(sign), events=events).event == "lost-landmark"


@pytest.mark.parametrize("space", first(1, SPACES))
def test_every_doorway_is_passed_both_ways(space: str) -> None:
    for number, sign in enumerate(HUNG):
        if sign.space != space:
            continue
        driver = Driver(number)
        driver.place_at(sign.landmark, sign.space)
        body = driver.sim.state.robot
        off = 0.15 * (number % 3 - 1)
        driver.place(
            body.x + off * math.sin(sign.normal),
            body.y - off * math.cos(sign.normal),
            body.heading + 0.5 * off,
            sign.floor,
        )
        opening = driver.sim.openings.get(sign.landmark)
        if opening is None or "lift" in opening.doorway.joins:
            continue
        through = SkillRequest("move-thru-doorway", (sign.normal + math.pi, 0.3))
        events = ("movement-complete", "door-closed", "stuck")
        outcome = driver.until(through, events=events, within=60)
        name = f"{sign.landmark} from {sign.space}"
        assert outcome.event == "movement-complete", name
        beyond = set(opening.doorway.joins) - {sign.space}
        assert {driver.sim.state.space} == beyond, name
        assert driver.sim.state.collisions == [], name


def test_a_closed_door_is_told_of_and_not_touched() -> None:
    driver = Driver()
    sign = driver.place_at("lab-door", "lab")
    door = next(d for d in driver.sim.state.doors if d.doorway == "lab-door")
    door.closed = True
    driver.sim.restore(driver.sim.save())
    through = SkillRequest("move-thru-doorway", (sign.normal + math.pi, 0.3))
    events = ("movement-complete", "door-closed", "stuck")
    assert driver.until(through, events=events).event == "door-closed"
    assert driver.sim.state.space == "lab"
    assert driver.sim.state.collisions == []


NEAR = [
    (far, aside, turned, skew)
    for skew in (0.15, -0.15)
    for turned in (0.0, 0.2, -0.2)
    for aside in (0.1, 0.0, -0.1)
    for far in (0.3, 0.35, 0.4, 0.5, 0.7)
]
"""Where a robot stands close before a doorway whose door has closed, or has opened:
metres to the wall and to the side, radians by which it is turned, and by which dead
reckoning is.
"""


def _goes_through(closed: bool, near: tuple[float, float, float, float]) -> str:
    """Let the robot go through a doorway that it is close to; return what it tells.

    Dead reckoning counts from a place far away, and has turned on the way.
    """
    far, aside, turned, skew = near
    driver = Driver(NEAR.index(near))
    sign = driver.sim.sign_of("workshop-store-door", "workshop")
    x, y = sign.front(far)
    driver.place(x + aside, y, SOUTH + turned)
    body = driver.sim.state.robot
    body.reckoned_heading += skew
    body.reckoned_x, body.reckoned_y = x + 1.2, y + 2.4
    for door in driver.sim.state.doors:
        door.closed = closed and door.doorway == sign.landmark
    driver.sim.restore(driver.sim.save())
    through = SkillRequest("move-thru-doorway", (round(SOUTH + skew, 3), 0.3))
    events = ("movement-complete", "door-closed", "stuck")
    outcome = driver.until(through, events=events, within=60)
    assert driver.sim.state.space == ("workshop" if closed else "store")
    assert driver.sim.state.collisions == []
    return outcome.event


@pytest.mark.parametrize("near", first(1, NEAR))
def test_whose_doorway_is_shut_in_its_face_does_not_take_itself_for_through(
    near: tuple[float, float, float, float],
) -> None:
    """It tries again from where it stopped, close to the door."""
    assert _goes_through(True, near) == "door-closed"


@pytest.mark.parametrize("near", first(1, NEAR))
def test_from_close_before_a_doorway_the_robot_goes_through(
    near: tuple[float, float, float, float],
) -> None:
    assert _goes_through(False, near) == "movement-complete"


def test_pushed_through_a_door_the_robot_notices_by_sonar() -> None:
    driver = Driver()
    driver.place(5.0, 14.3, EAST)
    ticket = driver.on(SkillRequest("detect-doorway"), events=("passed-doorway",))
    driver.tick(5)
    driver.sim.runtime.activate(
        50, [SkillRequest("move-thru-doorway", (NORTH, 0.3))], ["movement-complete"]
    )
    driver.tick(25)
    driver.off(50)
    driver.sim.push(0.0, 0.4, 6.0)
    driver.tick(80)
    assert driver.sim.state.space == "lab"
    (told,) = [one for _, one in driver.heard if one.event == "passed-doorway"]
    assert told.tickets == (ticket,)
    x, y, heading = told.arguments
    assert (x, y) == pytest.approx((5.0, 15.1), abs=0.2)
    assert heading == pytest.approx(NORTH, abs=0.05)


def _passes(place: tuple[float, float, float], person: tuple[float, float]) -> Driver:
    """Drive to the east for five metres past somebody who stands there."""
    settings = HallwaySettings(doors=0, people=1, lift=0, drift=0, usage=0)
    driver = Driver(0, settings)
    driver.place(*place)
    (walker,) = driver.sim.state.walkers
    walker.x, walker.y = person
    driver.on(SkillRequest("detect-doorway"), events=("passed-doorway",))
    ticket = driver.on(SkillRequest("move-in-direction", (EAST, 5.0, 0.5)))
    for _ in range(160):
        walker.pause = 9.0
        driver.tick()
    driver.off(ticket)
    return driver


@pytest.mark.parametrize("aside", first(1, [1.62, 1.55, 1.7, 1.75]))
def test_between_a_box_and_somebody_there_is_no_doorway(aside: float) -> None:
    driver = _passes((6.0, 0.95, EAST), (8.35, aside))
    assert driver.sim.state.robot.x > 10
    assert [told.event for _, told in driver.heard] == []


@pytest.mark.parametrize("at", first(1, [4.9, 4.75, 5.1, 5.3]))
def test_who_swerves_through_a_doorway_at_an_angle_notices_it(at: float) -> None:
    driver = Driver(3)
    driver.place(3.2, 0.45, EAST)
    driver.on(SkillRequest("detect-doorway"), events=("passed-doorway",))
    events = ("movement-complete", "stuck")
    for x, y in ((at - 0.6, 0.45), (at, -0.6), (at - 1.2, -1.2)):
        body = driver.sim.state.robot
        heading = math.atan2(y - body.reckoned_y, x - body.reckoned_x)
        far = math.hypot(x - body.reckoned_x, y - body.reckoned_y)
        move = SkillRequest("move-in-direction", (heading, far + 0.25, 0.4))
        driver.until(move, events=events, within=30)
    assert driver.sim.state.space == "kitchen"
    (told,) = [one for _, one in driver.heard if one.event == "passed-doorway"]
    x, y, heading = (float(str(value)) for value in told.arguments)
    assert (x, y) == pytest.approx((5.0, -0.1), abs=0.25)
    assert heading == pytest.approx(SOUTH, abs=0.1)
