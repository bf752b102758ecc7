"""The body, the people, doors and the lift; chance, saving, repeating."""

from __future__ import annotations

import math
import subprocess
import sys
from random import Random
from statistics import fmean

import msgspec
import pytest

from rapc.worlds.hallway.channels import BEARINGS, RADIUS, SONAR_RANGE
from rapc.worlds.hallway.people import GIRTH
from rapc.worlds.hallway.robot import SONAR_MODELS, laser, sonar
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import FOLLOW_HALL, STILL, Driver, to_landmark

LIVELY = HallwaySettings(doors=40, lift=30)


def test_sonars_measure_the_walls_around_with_noise() -> None:
    driver, rng = Driver(), Random(5)
    driver.place(10.0, 14.0, 0.0)
    body, plan = driver.sim.state.robot, driver.sim.plans[1]
    readings = [sonar(body, plan, [], rng) for _ in range(300)]
    for number, wanted in ((6, 1.0), (18, 1.0), (0, 3.6)):
        mine = [r[number] for r in readings if r[number] < SONAR_RANGE]
        if number:
            assert fmean(mine) == pytest.approx(wanted, abs=0.01)
            assert len(set(mine)) > 200
    assert {r[0] for r in readings} == {SONAR_RANGE}
    assert any(r[6] == SONAR_RANGE for r in readings), "no echo was ever lost"


def test_sonars_see_people() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, math.pi / 2)
    body, plan = driver.sim.state.robot, driver.sim.plans[1]
    heard = sonar(body, plan, [(8.5, 14.0, GIRTH)], Random(1))
    assert heard[6] == pytest.approx(1.25, abs=0.06)
    assert BEARINGS[6] == pytest.approx(math.pi / 2)


def test_slanted_walls_are_silent_for_some_sonars() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, 0.0)
    body, plan = driver.sim.state.robot, driver.sim.plans[1]

    def heard(model: str) -> set[int]:
        """Return the angles to the wall's normal of the sonars with an echo."""
        looks = [sonar(body, plan, [], Random(n), SONAR_MODELS[model]) for n in (1, 2)]
        nearest = [min(pair) for pair in zip(*looks, strict=True)]
        left = enumerate(nearest[:13])
        return {abs(n - 6) * 15 for n, far in left if far < SONAR_RANGE}

    slants = {0, 15, 30, 45, 60}
    assert heard("ideal") & slants == slants
    assert heard("slant-50") & slants == {0, 15, 30, 45}
    assert heard("slant-30") & slants == {0, 15, 30}
    someone = [(10.0, 13.0, GIRTH)]
    near = sonar(body, plan, someone, Random(3), SONAR_MODELS["slant-30"])
    assert near[18] == pytest.approx(0.75, abs=0.05)


def test_a_cone_hears_the_nearest_wall_beside_its_axis() -> None:
    driver = Driver()
    driver.place(10.0, 14.0, 0.0)
    body, plan = driver.sim.state.robot, driver.sim.plans[1]
    looks = [sonar(body, plan, [], Random(n), SONAR_MODELS["cone"]) for n in range(9)]
    heard = [sorted(one)[4] for one in zip(*looks, strict=True)]
    assert heard[18] == pytest.approx(1.0, abs=0.02)
    assert heard[20] == pytest.approx(1 / math.cos(math.radians(20)), abs=0.02)


@pytest.mark.parametrize(("odometry", "counted"), [("body", 0), ("wheels", 0.15)])
def test_blocked_wheels_slip_if_only_wheels_are_measured(
    odometry: str, counted: float
) -> None:
    driver = Driver(0, msgspec.structs.replace(STILL, odometry=odometry))
    driver.place(5.0, 13.26, math.pi / 2)
    driver.on(SkillRequest("back-off", (0.5,)))
    driver.tick(20)
    body = driver.sim.state.robot
    assert body.y == pytest.approx(13.25, abs=0.02)
    assert body.y - body.reckoned_y == pytest.approx(counted, abs=0.05)


@pytest.mark.parametrize(("odometry", "missed"), [("body", 0), ("wheels", 0.6)])
def test_wheels_do_not_measure_a_push_to_the_side(odometry: str, missed: float) -> None:
    driver = Driver(0, msgspec.structs.replace(STILL, odometry=odometry))
    driver.place(10.0, 14.0, 0.0)
    driver.sim.push(0.2, 0.3, 2)
    driver.tick(30)
    body = driver.sim.state.robot
    assert (body.x, body.y) == pytest.approx((10.4, 14.6), abs=0.04)
    assert body.x == pytest.approx(body.reckoned_x)
    assert body.y - body.reckoned_y == pytest.approx(missed, abs=0.04)


@pytest.mark.parametrize("careless", [0, 1])
def test_careless_people_run_into_the_robot(careless: int) -> None:
    driver = Driver(2, msgspec.structs.replace(STILL, people=1, careless=careless))
    driver.place(10.0, 14.0, 0.0)
    (walker,) = driver.sim.state.walkers
    walker.x, walker.y, walker.space = 12.0, 14.0, "north-hall"
    walker.way, walker.towards = [(8.0, 14.0)], "north-hall"
    walker.careless, walker.pause = careless > 0, 0.0
    driver.tick(40)
    body, collisions = driver.sim.state.robot, driver.sim.state.collisions
    assert [(c.what, c.speed) for c in collisions] == [
        ("push", walker.speed)
    ] * careless
    assert [told.event for _, told in driver.heard] == ["bump"] * careless
    assert 10.0 - body.x == pytest.approx(0.24 * careless, abs=0.09)


def test_the_laser_gives_bearings_of_tags_that_can_be_seen() -> None:
    driver = Driver()
    sign = driver.place_at("charger", "lab")
    body, plan = driver.sim.state.robot, driver.sim.plans[1]
    seen = {t.code: t.bearing for t in laser(body, plan, [sign], [], Random(1))}
    half = math.atan(sign.apart / 2)
    assert seen == pytest.approx({0: half, 1: -half}, abs=0.03)
    someone = [(sign.x + 0.4, sign.y, 0.15)]
    assert laser(body, plan, [sign], someone, Random(1)) != ()
    wide = [(sign.x + 0.4, sign.y, 0.39)]
    assert laser(body, plan, [sign], wide, Random(1)) == ()
    driver.place(10.0, 14.0, 0.0)
    assert laser(body, plan, [sign], [], Random(1)) == ()


def test_dead_reckoning_drifts_and_differs_by_seed() -> None:
    off = []
    for seed in range(4):
        driver = Driver(seed, HallwaySettings(doors=0, people=0, lift=0))
        driver.place(3.0, 14.0, 0.0)
        driver.until(*FOLLOW_HALL, events=("end-o-hall",))
        body = driver.sim.state.robot
        assert body.distance > 14
        off.append(math.hypot(body.x - body.reckoned_x, body.y - body.reckoned_y))
    assert all(0.01 < o < 2.5 for o in off)
    assert len(set(off)) == 4


def test_without_drift_dead_reckoning_is_true() -> None:
    driver = Driver()
    driver.place(3.0, 14.0, 0.0)
    driver.until(*FOLLOW_HALL, events=("end-o-hall",))
    body = driver.sim.state.robot
    assert (body.reckoned_x, body.reckoned_y) == pytest.approx((body.x, body.y))


def test_running_into_a_wall_is_a_collision_and_a_bump() -> None:
    driver = Driver()
    driver.place(5.0, 13.5, math.pi / 2)
    driver.on(SkillRequest("back-off", (0.5,)))
    told = [one for _ in range(60) for one in driver.tick()]
    assert [(t.event, t.tickets) for t in told] == [("bump", ())]
    (collision,) = driver.sim.state.collisions
    assert collision.what == "wall"
    assert 0.05 < collision.speed < 0.1
    assert driver.sim.state.robot.y == pytest.approx(13.0 + RADIUS, abs=0.02)


def test_people_walk_about_but_not_into_walls_or_the_robot() -> None:
    driver = Driver(2, LIVELY)
    driver.place(10.0, 14.0, 0.0)
    sim, spaces = driver.sim, set()
    moved = [0.0] * len(sim.state.walkers)
    for _ in range(4000):
        before = [(w.x, w.y) for w in sim.state.walkers]
        driver.tick()
        for number, walker in enumerate(sim.state.walkers):
            moved[number] += math.dist(before[number], (walker.x, walker.y))
            spaces.add(walker.space)
            near = sim.plans[walker.floor].nearest(walker.x, walker.y, 0.5)[0]
            assert near > 0.05
            if walker.floor == 1:
                body = sim.state.robot
                away = math.hypot(walker.x - body.x, walker.y - body.y)
                assert away > RADIUS + GIRTH
    assert min(moved) > 20
    assert len(spaces) > 6
    assert sim.state.collisions == []


def test_doors_close_and_open_but_not_on_anybody() -> None:
    driver, closings = Driver(4, LIVELY), 0
    driver.place(5.0, 15.25, 0.0)
    for _ in range(3000):
        driver.tick()
        for door in driver.sim.state.doors:
            assert not (door.closed and door.doorway == "lab-door")
            closings += door.closed
    assert closings > 100
    assert not all(door.closed for door in driver.sim.state.doors)


def test_there_can_be_no_doors_and_nobody() -> None:
    driver = Driver()
    driver.tick(600)
    assert driver.sim.state.walkers == []
    assert not any(door.closed for door in driver.sim.state.doors)


def test_an_idle_world_senses_nothing_and_says_nothing() -> None:
    driver = Driver(1, LIVELY)
    driver.tick(300)
    assert driver.heard == []
    assert driver.sim.now == 30


def test_an_empty_battery_stops_the_robot() -> None:
    driver = Driver(0, HallwaySettings(doors=0, people=0, lift=0, usage=1))
    driver.place(3.0, 14.0, 0.0)
    driver.sim.state.robot.battery = 0.02
    driver.on(*FOLLOW_HALL, events=())
    driver.tick(100)
    assert driver.sim.state.robot.battery == 0
    assert driver.sim.state.robot.speed == 0
    assert driver.sim.state.robot.x < 4


def _drive(driver: Driver, rng: Random, moments: int) -> None:
    """Skills on and off at random, as a life of the robot."""
    signs = driver.sim.signs
    for _ in range(moments):
        for ticket in list(driver.sim.runtime.activations):
            driver.off(ticket)
        sign = rng.choice(signs)
        wheels = rng.choice(
            [
                FOLLOW_HALL,
                (to_landmark(sign),),
                (SkillRequest("move-in-direction", (rng.uniform(-3, 3), 4, 0.5)),),
                (SkillRequest("move-thru-doorway", (rng.uniform(-3, 3), 0.3)),),
                (SkillRequest("call-lift", (rng.choice((1, 2)),)),),
            ]
        )
        describe = driver.sim.runtime.catalogue.describe
        told = [event for r in wheels for event in describe(r.skill).events]
        driver.on(*wheels, events=told)
        driver.on(SkillRequest("report-position"), events=("position",))
        driver.on(SkillRequest("see-tags"), events=("tags-seen",))
        driver.tick(rng.randrange(60))


@pytest.mark.parametrize("seed", first(3, range(25)))
def test_a_saved_simulation_goes_on_as_if_nothing_had_been(seed: int) -> None:
    rng = Random(seed)
    driver, other = Driver(seed, LIVELY), Driver(seed + 1, LIVELY)
    _drive(driver, rng, rng.randrange(1, 8))
    _drive(other, Random(0), 2)
    saved = driver.sim.save()
    other.sim.restore(saved)
    assert other.sim.save() == saved
    driver.heard, other.heard, other.ticket = [], [], driver.ticket
    state = rng.getstate()
    _drive(driver, rng, 5)
    rng.setstate(state)
    _drive(other, rng, 5)
    assert other.heard == driver.heard
    assert other.sim.save() == driver.sim.save()


def test_what_is_no_state_of_this_hallway_is_refused() -> None:
    driver = Driver()
    before = driver.sim.save()
    for bad in (b"", b"{}", before[:-2], b"null"):
        with pytest.raises(ValueError, match="no state of a hallway"):
            driver.sim.restore(bad)
    with pytest.raises(ValueError, match="with other options"):
        driver.sim.restore(Driver(0, LIVELY).sim.save())
    assert driver.sim.save() == before


HISTORY = """
from random import Random
from tests.hallway.test_simulation import LIVELY, Driver, _drive
driver = Driver(11, LIVELY)
_drive(driver, Random(11), 6)
print(driver.heard, driver.sim.save())
"""


def test_a_seed_gives_the_same_history_in_another_process() -> None:
    histories = {
        subprocess.run(
            [sys.executable, "-c", HISTORY],
            check=True,
            capture_output=True,
            env={"PYTHONHASHSEED": str(number), "PYTHONPATH": ":".join(sys.path)},
        ).stdout
        for number in (1, 2)
    }
    assert len(histories) == 1
    other = Driver(12, LIVELY)
    _drive(other, Random(11), 6)
    assert str(other.sim.save()).encode() not in histories.pop()


def test_the_still_world_is_still() -> None:
    assert STILL.people == 0


def _clears(doorway: str) -> float:
    """Return how long somebody is in a doorway, of a minute, behind which the robot is.

    They are on their way through when they meet it.
    """
    settings = HallwaySettings(doors=0, people=1, lift=0, drift=0, usage=0)
    driver = Driver(0, settings)
    gap, (walker,) = driver.sim.openings[doorway], driver.sim.state.walkers
    left, bottom, right, top = gap.box
    x, y = (left + right) / 2, (bottom + top) / 2
    dx, dy = (0.7, 0.0) if gap.side in ("east", "west") else (0.0, 0.7)
    walker.x, walker.y, walker.floor, walker.pause = x - dx, y - dy, gap.floor, 0.0
    driver.place(x - dx, y - dy, 0.0)
    walker.space = driver.sim.state.space
    first, second = gap.doorway.joins
    walker.towards = second if walker.space == first else first
    walker.way = [(x - dx, y - dy), (x + dx, y + dy)]
    driver.place(x + 1.3 * dx, y + 1.3 * dy, math.atan2(-dy, -dx))
    inside = 0
    for _ in range(600):
        driver.tick()
        inside += math.hypot(walker.x - x, walker.y - y) < 0.5
    return inside / 10


@pytest.mark.parametrize(
    "doorway", first(2, ["library-door", "kitchen-door", "lab-door", "workshop-door"])
)
def test_who_meets_the_robot_in_a_doorway_turns_back(doorway: str) -> None:
    assert 0 < _clears(doorway) < 8
