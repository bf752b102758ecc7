"""Each skill by itself, switched on by hand: what it does, and what it tells.

Those for landmarks and doorways are in `test_landmark_skills.py`.
"""

from __future__ import annotations

import math

import pytest

from rapc.base.values import Text
from rapc.world import Refused
from rapc.worlds.hallway.channels import DRIVE, TRAJECTORY
from rapc.worlds.hallway.map_text import read_map
from rapc.worlds.hallway.skills.all import catalogue
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import (
    EAST,
    FOLLOW_HALL,
    NORTH,
    SOUTH,
    STILL,
    WEST,
    Driver,
    to_landmark,
)

BLOCKED_HALL = """
start = "clock"
[[space]]
name = "hall"
kind = "hall"
box = [0, 0, 14, 2]
[[space]]
name = "room"
box = [0, 2.2, 6, 8]
[[doorway]]
name = "door"
joins = ["hall", "room"]
at = 3
tags = [2, 3]
[[landmark]]
name = "clock"
space = "hall"
wall = "west"
at = 1
tags = [0, 1]
[[obstacle]]
box = [8, 0, 8.6, 1.3]
[[obstacle]]
box = [8.3, 1.3, 8.9, 1.5]
"""


def test_skills_are_those_of_the_paper_by_their_names() -> None:
    made = catalogue()
    assert {"detect-obstacles", "track-hallway", "follow-trajectory"} <= set(
        made.entries
    )
    assert made.describe("watch-for-landmark").events == ("landmark-visible",)
    assert {"movement-complete", "stuck"} <= set(
        made.describe("move-in-direction").events
    )
    assert {"movement-complete", "lost-landmark", "landmark-visible", "stuck"} <= set(
        made.describe("move-to-landmark").events
    )
    assert {"movement-complete", "door-closed", "stuck"} <= set(
        made.describe("move-thru-doorway").events
    )
    assert made.describe("track-hallway").events == ("end-o-hall", "hall-blocked")


def test_two_movements_are_in_conflict() -> None:
    driver = Driver()
    one = driver.on(SkillRequest("move-in-direction", (0, 5, 0.5)))
    sign = driver.sim.sign_of("lab-door", "lab")
    refused = driver.sim.runtime.activate(99, [to_landmark(sign)], [])
    assert refused is not None
    assert refused.conflicts == (one,)
    backing = driver.sim.runtime.activate(98, [SkillRequest("back-off", (0.2,))], [])
    assert isinstance(backing, Refused)
    assert backing.conflicts == (one,)


@pytest.mark.parametrize("seed", first(2, range(6)))
def test_a_hall_is_followed_to_its_end(seed: int) -> None:
    driver = Driver(seed)
    driver.place(3.5, 14.0 + 0.1 * (seed - 3), 0.1 * (seed - 3))
    outcome = driver.until(*FOLLOW_HALL, events=("end-o-hall", "hall-blocked"))
    body = driver.sim.state.robot
    assert outcome.event == "end-o-hall"
    assert 18.2 < body.x < 19.4
    assert body.y == pytest.approx(14.0, abs=0.3)
    assert driver.sim.state.collisions == []


def test_a_hall_is_followed_the_way_the_robot_points() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, WEST + 0.3)
    outcome = driver.until(*FOLLOW_HALL, events=("end-o-hall", "hall-blocked"))
    assert outcome.event == "end-o-hall"
    assert driver.sim.state.robot.x < 4


def test_a_blocked_hall_is_told_from_its_end() -> None:
    driver = Driver(1, STILL, read_map(BLOCKED_HALL))
    driver.place(2.0, 1.0, EAST)
    outcome = driver.until(*FOLLOW_HALL, events=("end-o-hall", "hall-blocked"))
    assert outcome.event == "hall-blocked"
    assert driver.sim.state.robot.x < 8
    assert driver.sim.state.collisions == []


def test_the_network_of_figure_5_has_its_boxes() -> None:
    driver = Driver()
    driver.on(*FOLLOW_HALL, events=("end-o-hall", "hall-blocked"))
    drawing = driver.sim.runtime.network.graph()
    kinds = {box.label: box.kind for box in drawing.vertices}
    assert kinds == {
        "sonar": "sensor",
        "pose": "sensor",
        "detect-obstacles": "skill",
        "track-hallway": "skill",
        "follow-trajectory": "skill",
        "end-o-hall": "event",
        "hall-blocked": "event",
        "drive": "actuator",
    }


def test_a_speed_limit_holds_while_its_skill_is_on() -> None:
    driver = Driver()
    driver.place(3.5, 14.0, EAST)
    driver.on(*FOLLOW_HALL, events=())
    limits = [driver.on(SkillRequest("limit-speed", (s,))) for s in (0.3, 0.1)]
    driver.tick(30)
    assert driver.sim.state.robot.speed == pytest.approx(0.1, abs=0.01)
    driver.off(limits[1])
    driver.tick(30)
    assert driver.sim.state.robot.speed == pytest.approx(0.3, abs=0.01)
    driver.off(limits[0])
    driver.tick(30)
    assert driver.sim.state.robot.speed == pytest.approx(0.5, abs=0.02)


def test_moving_in_a_direction_ends_after_its_distance() -> None:
    driver = Driver()
    driver.place(3.5, 14.0, SOUTH)
    request = SkillRequest("move-in-direction", (EAST, 5, 0.5))
    outcome = driver.until(request, events=("movement-complete", "stuck"))
    assert outcome.event == "movement-complete"
    assert driver.sim.state.robot.x == pytest.approx(8.2, abs=0.15)
    driver.tick(20)
    assert driver.sim.state.robot.speed == 0


def test_moving_in_a_direction_goes_around_a_box() -> None:
    driver = Driver()
    driver.place(11.0, 11.6, SOUTH)
    request = SkillRequest("move-in-direction", (SOUTH, 5, 0.5))
    outcome = driver.until(request, events=("movement-complete", "stuck"))
    assert outcome.event == "movement-complete"
    assert driver.sim.state.robot.y < 7
    assert driver.sim.state.collisions == []


def test_moving_into_a_wall_gets_stuck_before_it() -> None:
    driver = Driver()
    driver.place(4.0, 17.0, NORTH)
    request = SkillRequest("move-in-direction", (NORTH, 9, 0.5))
    outcome = driver.until(request, events=("movement-complete", "stuck"))
    assert outcome.event == "stuck"
    assert driver.sim.state.space == "lab"
    assert driver.sim.state.collisions == []


@pytest.mark.parametrize("heading", first(2, [-3.0, 0.5, -1.0, 2.0, 3.1]))
def test_turning_ends_at_the_heading(heading: float) -> None:
    driver = Driver()
    outcome = driver.until(
        SkillRequest("turn-to", (heading,)), events=("movement-complete",), within=10
    )
    assert outcome.event == "movement-complete"
    driver.tick(5)
    off = math.remainder(driver.sim.state.robot.heading - heading, math.tau)
    assert abs(off) < 0.12


def test_a_push_against_a_wall_is_no_collision_of_the_robots_own() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, EAST)
    driver.sim.push(0.0, 0.6, 5.0)
    driver.tick(60)
    assert {c.what for c in driver.sim.state.collisions} == {"push"}
    assert driver.fastest_collision() == 0


def test_the_battery_is_charged_where_the_charger_is() -> None:
    driver = Driver(0, HallwaySettings(doors=0, people=0, lift=0, drift=0))
    driver.place_at("charger", "lab")
    driver.sim.state.robot.battery = 40.0
    events = ("charged", "not-docked")
    outcome = driver.until(SkillRequest("charge"), events=events)
    assert outcome.event == "charged"
    assert outcome.seconds == pytest.approx(60, abs=2)
    driver.place_at("desk", "office")
    driver.sim.state.robot.battery = 40.0
    assert driver.until(SkillRequest("charge"), events=events).event == "not-docked"
    assert driver.sim.state.robot.battery < 40


def test_a_low_battery_is_told_of_once() -> None:
    driver = Driver(0, HallwaySettings(doors=0, people=0, lift=0, drift=0))
    driver.sim.state.robot.battery = 30.02
    driver.on(SkillRequest("watch-battery", (30,)), events=("battery-low",))
    driver.tick(300)
    assert [(one.event, one.arguments) for _, one in driver.heard] == [
        ("battery-low", (30.0,))
    ]


def test_the_lift_comes_and_takes_the_robot_along() -> None:
    driver = Driver(3)
    sign = driver.place_at("lower-lift-door", "west-hall")
    through = SkillRequest("move-thru-doorway", (sign.normal + math.pi, 0.3))
    events = ("movement-complete", "door-closed", "stuck")
    assert driver.until(through, events=events).event == "movement-complete"
    assert driver.sim.state.space == "lift"
    call = SkillRequest("call-lift", (2,))
    outcome = driver.until(call, events=("lift-here",), within=30)
    assert outcome.arguments == (2,)
    assert driver.sim.state.robot.floor == 2
    through = SkillRequest("move-thru-doorway", (sign.normal, 0.3))
    assert driver.until(through, events=events).event == "movement-complete"
    assert driver.sim.state.space == "upper-hall"
    assert driver.sim.state.collisions == []


def test_the_lift_door_is_closed_where_the_cabin_is_not() -> None:
    driver = Driver(3)
    sign = driver.place_at("upper-lift-door", "upper-hall")
    through = SkillRequest("move-thru-doorway", (sign.normal + math.pi, 0.3))
    events = ("movement-complete", "door-closed", "stuck")
    assert driver.until(through, events=events).event == "door-closed"
    call = SkillRequest("call-lift", (2,))
    assert driver.until(call, events=("lift-here",)).event == "lift-here"
    assert driver.until(through, events=events).event == "movement-complete"


def test_others_use_the_lift_too_but_not_while_the_robot_is_in_it() -> None:
    driver = Driver(5, HallwaySettings(doors=0, people=0, lift=20))
    cabin, floors = driver.sim.state.lift, set()
    assert cabin is not None
    for _ in range(1500):
        driver.tick()
        floors.add(cabin.floor)
    assert floors == {1, 2}
    while cabin.floor != 1 or cabin.towards is not None:
        driver.tick()
    driver.place(-1.3, 7.1, EAST)
    driver.tick(1500)
    assert (cabin.floor, driver.sim.state.robot.floor) == (1, 1)


def test_what_the_robot_says_is_logged() -> None:
    driver = Driver()
    words = Text("I am at the charger.")
    outcome = driver.until(SkillRequest("speak", (words,)), events=("spoken",))
    assert outcome.seconds == pytest.approx(len(words.value) / 15, abs=0.3)
    assert [text for _, text in driver.sim.state.said] == ["I am at the charger."]


def test_the_position_comes_every_second() -> None:
    driver = Driver()
    driver.place(3.5, 14.0, EAST)
    driver.on(*FOLLOW_HALL, events=())
    driver.on(SkillRequest("report-position"), events=("position",))
    driver.tick(50)
    assert [round(at, 1) for at, _ in driver.heard] == [0.1, 1.1, 2.1, 3.1, 4.1]
    steps = [float(str(one.arguments[0])) for _, one in driver.heard]
    assert steps == sorted(steps)
    assert steps[-1] > steps[0] + 1


def test_skills_that_go_off_stop_the_robot() -> None:
    driver = Driver()
    driver.place(3.5, 14.0, EAST)
    ticket = driver.on(*FOLLOW_HALL, events=())
    driver.tick(30)
    assert driver.sim.state.robot.speed > 0.4
    driver.off(ticket)
    assert driver.sim.runtime.value(DRIVE) is None
    assert driver.sim.runtime.value(TRAJECTORY) is None
    driver.tick(10)
    assert driver.sim.state.robot.speed == 0
