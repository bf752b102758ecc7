"""The hallway library drives the robot: journeys, a tour, the battery, saved runs."""

from __future__ import annotations

from random import Random

import pytest

from rapc import events
from rapc.base.values import Text
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.random_map import random_map
from tests.effort import first
from tests.hallway.duties import attend
from tests.hallway.sent import HONEST, begin, travel


@pytest.mark.parametrize("seed", first(1, range(1000, 1012)))
def test_the_robot_arrives_and_knows_where_it_is(seed: int) -> None:
    journey = travel(seed)
    assert journey.arrived, journey
    assert journey.strays == []
    assert journey.truth.fastest <= 0.1


@pytest.mark.parametrize("building", first(1, [5, 2]))
def test_the_same_library_drives_a_building_made_at_random(building: int) -> None:
    journey = travel(3, random_map(building), {"random-map": building})
    assert journey.arrived, journey


@pytest.mark.parametrize("seed", first(1, range(5)))
def test_the_same_library_drives_a_building_of_another_shape(seed: int) -> None:
    """Seed 0 goes up in a lift that is left on the other side."""
    journey = travel(seed, named_map("museum"), {"map": Text("museum")})
    assert journey.arrived, journey
    assert journey.strays == []


@pytest.mark.parametrize("sonar", first(2, ["slant-50", "slant-30", "cone"]))
def test_the_robot_arrives_with_an_honest_body(sonar: str) -> None:
    fastest = 0.3 if sonar == "slant-30" else 0.1
    for seed in (0, 3):
        journey = travel(seed, options={**HONEST, "sonar": sonar})
        assert journey.arrived, journey
        assert journey.truth.fastest <= fastest


@pytest.mark.slow
def test_a_tour_visits_every_landmark_and_speaks_its_name() -> None:
    run, world = begin(1, agenda="sightseeing", options={"random-map": 3})
    run.run(until=6000)
    said = [words for _, words in world.simulation.state.said]
    assert sorted(said) == sorted(m.says or m.name for m in random_map(3).landmark)
    assert [t.outcome for t in run.results() if not t.background] == ["succeeded"]


@pytest.mark.slow
def test_the_robot_charges_on_its_tour_and_goes_on_with_it() -> None:
    run, world = begin(1, agenda="sightseeing", options={"usage": 6})
    charged: list[float] = []
    run.listen(lambda _: charged.append(world.figures().battery), events.SignalReceived)
    run.run(until=6000)
    assert min(charged) < 40
    assert [t.outcome for t in run.results() if not t.background] == ["succeeded"]
    assert run.memory.query("battery-low", "robot") == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_a_tour_an_order_and_the_battery_share_one_body(seed: int) -> None:
    """Under seed 3 a door is shut in the robot's face, and it tries again there."""
    duties = attend(seed)
    assert duties.done, duties
    assert duties.strays == []


@pytest.mark.slow
def test_a_way_that_was_planned_once_is_not_planned_again() -> None:
    """What the planner finds stays a method [S 3.2]."""
    goals = ["coffee-machine", "charger", "coffee-machine", "charger"]
    tasks = [f"(go-to {goal}) :at {300 * at + 1}" for at, goal in enumerate(goals)]
    run, _ = begin(2, *tasks, options={"doors": 0, "people": 0})
    asked: list[events.Event] = []
    run.listen(asked.append, events.SolverCalled)
    run.run(until=3000)
    sent = [task.outcome for task in run.results() if not task.background]
    assert sent == ["succeeded"] * len(goals)
    assert len(asked) == 2


@pytest.mark.parametrize("points", first(1, [4, 200]))
def test_a_journey_that_is_saved_goes_on_the_same(points: int) -> None:
    run, _ = begin(7, "(go-to chest) :at 1")
    chance = Random(points)
    for _ in range(points):
        if run.reason is not None or run.now > 400:
            run, _ = begin(chance.randint(8, 99), "(go-to chest) :at 1")
        other, cycles = run.fork(), chance.randint(1, 8)
        expected = _next(run, cycles)
        assert _next(other, cycles) == expected
        assert other.save() == run.save()


def _next(run: Interpreter, cycles: int) -> list[events.Event]:
    """Return what happens in the next cycles of a run."""
    heard: list[events.Event] = []
    run.listen(heard.append)
    for _ in range(cycles):
        run.step()
    return heard
