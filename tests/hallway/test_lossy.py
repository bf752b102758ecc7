"""Skills for sonars that lose the echoes of slanted walls."""

from __future__ import annotations

import math

import msgspec
import pytest

from rapc.worlds.hallway.channels import (
    OBSTACLES,
    SONAR_RANGE,
    SONARS,
    SPEED_LIMIT,
    TOP_SPEED,
    TRAJECTORY,
    Pose,
)
from rapc.worlds.hallway.skills.all import catalogue
from rapc.worlds.hallway.skills.lossy import CAREFUL, KEPT
from rapc.worlds.skills.catalogue import SkillRequest
from rapc.worlds.skills.runtime import SkillRuntime
from tests.hallway.driver import STILL, Driver

SLANT = msgspec.structs.replace(STILL, sonar="slant-30", odometry="wheels")

START = Pose(0.0, 0.0, 0.0)


def _ring(heard: dict[int, float]) -> tuple[float, ...]:
    return tuple(heard.get(number, SONAR_RANGE) for number in range(SONARS))


class _Obstacles:
    """The skill `detect-obstacles`, tick by tick."""

    def __init__(self) -> None:
        self.runtime, self.now = SkillRuntime(catalogue("slant-30")), 0.0
        self.runtime.activate(1, [SkillRequest("detect-obstacles")], [])

    def look(self, pose: Pose, heard: dict[int, float]) -> dict[int, float]:
        """Return the obstacles by sonar after a tick."""
        self.now += 0.1
        ring = _ring(heard)
        self.runtime.tick(self.now, {"sonar": lambda: ring, "pose": lambda: pose})
        found = enumerate(self.runtime.value(OBSTACLES) or ())
        return {number: round(far, 2) for number, far in found if far < SONAR_RANGE}


def test_an_obstacle_is_remembered_in_silence() -> None:
    obstacles = _Obstacles()
    assert obstacles.look(START, {0: 1.0}) == {0: 1.0}
    turned = Pose(0.0, 0.0, math.pi / 2)
    assert obstacles.look(turned, {}) == {18: 1.0}
    nearer = Pose(0.5, 0.0, math.pi / 2)
    assert obstacles.look(nearer, {}) == {18: 0.5}
    obstacles.now += KEPT
    assert obstacles.look(nearer, {}) == {}


def test_the_robot_is_slow_at_an_angle_to_the_walls() -> None:
    driver = Driver(0, SLANT)
    driver.place(10.0, 14.0, 0.0)
    driver.on(SkillRequest("detect-obstacles"))
    driver.tick(5)
    assert driver.sim.runtime.value(SPEED_LIMIT) == TOP_SPEED
    driver.place(10.0, 14.0, 0.5)
    driver.tick(5)
    assert driver.sim.runtime.value(SPEED_LIMIT) == CAREFUL


def test_an_echo_from_behind_an_obstacle_shows_that_it_is_gone() -> None:
    obstacles = _Obstacles()
    obstacles.look(START, {0: 1.0})
    assert obstacles.look(START, {0: 2.0}) == {0: 2.0}
    assert obstacles.look(START, {}) == {}


@pytest.mark.parametrize("heading", [-0.1, 0.0, 0.1])
def test_a_doorway_is_passed_straight_on_in_full_silence(heading: float) -> None:
    runtime, pose = SkillRuntime(catalogue("slant-30")), Pose(0.0, 0.0, heading)
    through = SkillRequest("move-thru-doorway", (0.0, 0.3))
    runtime.activate(1, [through], ["door-closed"])
    sensors = {"sonar": lambda: _ring({}), "pose": lambda: pose}
    told = [one for tick in range(60) for one in runtime.tick(tick / 10, sensors)]
    assert told == []
    way = runtime.value(TRAJECTORY)
    assert way is not None
    assert way.bearing == pytest.approx(-heading)
    assert way.speed == 0.3


@pytest.mark.parametrize("shut", [False, True])
@pytest.mark.parametrize("doorway", ["lab-door", "workshop-door", "court-door"])
def test_doorways_whose_jambs_are_silent_are_passed_if_open(
    doorway: str, shut: bool
) -> None:
    driver = Driver(0, SLANT)
    gap = driver.sim.openings[doorway]
    sign = driver.place_at(doorway, gap.doorway.joins[0])
    for door in driver.sim.state.doors:
        door.closed = shut and door.doorway == doorway
    driver.sim.restore(driver.sim.save())
    request = SkillRequest("move-thru-doorway", (sign.normal + math.pi, 0.3))
    told = driver.until(
        request, events=("movement-complete", "door-closed", "stuck"), within=60
    )
    assert told.event == ("door-closed" if shut else "movement-complete")
    assert driver.sim.state.space == gap.doorway.joins[0 if shut else 1]
    assert driver.sim.state.collisions == []
