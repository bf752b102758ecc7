"""The hallway behind the port: activations, signals, time, figures, facts."""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

import pytest

from rapc.base.values import Atom, Text
from rapc.world import NOT_KNOWN, Signal
from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_text import read_map
from rapc.worlds.hallway.world import HallwayWorld
from tests.hallway.test_map import SMALL

QUIET: Mapping[str, Atom | bool] = {"doors": 0, "people": 0, "lift": 0, "drift": 0}
FOLLOW = [(":detect-obstacles",), (":track-hallway",), (":follow-trajectory",)]


def _world(seed: int = 0, **options: Atom | bool) -> HallwayWorld:
    return HallwayWorld(Random(seed), {**QUIET, **options})


def test_what_is_offered_carries_colons() -> None:
    offered = HallwayWorld.kit.offer
    assert offered.skills[":move-to-landmark"] == 6
    assert offered.skills[":detect-obstacles"] == 0
    assert offered.events[":landmark-visible"] == 3
    assert offered.events[":bump"] == 0
    assert offered.primitives == {}


def test_signals_carry_the_activation_they_arose_under() -> None:
    world = _world()
    move = (":turn-to", 1)
    assert world.activate(5, [move], [":movement-complete"]) is None
    world.advance(60)
    assert world.messages() == [Signal((":movement-complete",), (5,))]
    assert 0 < world.now() < 6


def test_time_stops_at_the_first_thing_to_send_and_goes_on_from_there() -> None:
    world = _world()
    world.activate(1, [(":report-position",)], [":position"])
    times = []
    while world.now() < 3:
        assert world.next_time() == NOT_KNOWN
        world.advance(3)
        times.append(world.now())
        world.messages()
    assert times == [0.1, 1.1, 2.1, 3]
    assert [type(t) for t in times] == [float, float, float, int]


def test_time_does_not_pass_while_something_waits_to_be_fetched() -> None:
    world = _world()
    world.activate(1, [(":report-position",)], [":position"])
    world.advance(3)
    assert world.next_time() == world.now() == 0.1
    world.advance(3)
    assert world.now() == 0.1
    assert len(world.messages()) == 1


def test_time_between_ticks_is_kept() -> None:
    world = _world()
    world.advance(0.25)
    assert world.now() == 0.25
    assert world.simulation.state.ticks == 2
    world.advance(0.1)
    assert world.now() == 0.25
    world.advance(0.3)
    assert world.simulation.state.ticks == 3


def test_a_conflict_names_the_activation_under_way() -> None:
    world = _world()
    world.activate(1, [(":move-in-direction", 0, 3, 0.5)], [])
    refused = world.activate(2, [(":turn-to", 0)], [])
    assert refused is not None
    assert refused.conflicts == (1,)
    world.cancel(1)
    assert world.activate(2, [(":turn-to", 0)], []) is None


def test_what_can_never_run_names_nobody() -> None:
    world = _world()
    refused = world.activate(1, [(":move-in-direction", 0, 3, 99)], [])
    assert refused is not None
    assert refused.conflicts == ()
    assert "`speed` must not be above 0.6" in refused.reason


def test_there_are_no_primitives() -> None:
    with pytest.raises(ValueError, match="has no primitive `grasp`"):
        _world().perform(1, ("grasp",))


@pytest.mark.parametrize("map", ["default", SMALL])
def test_facts_are_those_of_the_paper(map: str) -> None:
    world = _world(map=Text(map))
    known = list(world.facts())
    names = {fact[0] for fact in known}
    assert {"location-data", "connects", "relative-loc", "current-space"} <= names
    assert all(type(part) in (str, int, float, Text) for f in known for part in f)
    data = [fact for fact in known if fact[0] == "location-data"]
    assert len({fact[1] for fact in data}) == len(data)
    assert len(known) == len(set(known))


def test_a_relation_is_told_from_where_the_robot_looks() -> None:
    known = list(_world(map=Text(SMALL)).facts())
    assert ("relative-loc", "lab", "clock", "door", -3, 4) in known
    assert ("connects", "door", "lab", "hall") in known
    assert ("location-data", "clock", 0, 1, 1, Text("clock")) in known
    assert ("orientation", "robot", 1, 2, 3.14) in known


def test_figures_tell_the_truth() -> None:
    world = _world(drift=1)
    world.activate(1, [(":move-in-direction", 0, 2, 0.5)], [])
    world.advance(20)
    truth = world.figures()
    assert truth.space == "lab"
    assert truth.distance == pytest.approx(1.75, abs=0.2)
    assert (truth.collisions, truth.fastest) == (0, 0)
    assert 0 < truth.drift < 0.2
    assert truth.battery < 100


def test_an_empty_battery_ends_the_run() -> None:
    world = _world(usage=2000)
    assert world.ended() is None
    world.advance(10)
    assert world.ended() == "the battery is empty"


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ({"people": -1}, "`people` must not be below 0"),
        ({"careless": 1.5}, "`careless` must not be above 1"),
        (
            {"sonar": "bat"},
            "unknown `sonar` `bat`; expected one of `ideal`, `slant-50`",
        ),
        ({"odometry": "eye"}, "unknown `odometry` `eye`; expected one of `body`, `wh"),
        ({"map": Text("start = 3")}, "`map`: `start`: expected `str`, got `int`"),
        ({"map": Text("cellar")}, "`map`: unknown map `cellar`; there are `"),
        (
            {"map": Text(SMALL.replace("[2, 3]", "[0, 3]"))},
            "`map`: `tags` of the doorw",
        ),
    ],
)
def test_options_that_make_no_sense_are_refused(
    options: Mapping[str, Atom | bool], fault: str
) -> None:
    with pytest.raises(ValueError, match=fault):
        HallwayWorld(Random(0), options)


def test_a_map_can_be_made_at_random() -> None:
    one, other = _world(**{"random-map": 3}), _world(**{"random-map": 4})
    maps: list[Map] = [one.simulation.map, other.simulation.map]
    assert maps[0] != maps[1]
    assert maps[0] != read_map(SMALL)
    assert list(one.facts()) == list(_world(9, **{"random-map": 3}).facts())


@pytest.mark.parametrize("sonar", ["ideal", "slant-50", "slant-30", "cone"])
@pytest.mark.parametrize("seconds", [0, 0.1, 3.3, 17.2])
def test_a_saved_world_goes_on_the_same(seconds: float, sonar: str) -> None:
    def live(world: HallwayWorld) -> list[object]:
        told: list[object] = []
        for moment in range(12):
            world.advance(seconds + moment)
            told += [world.now(), *world.messages(), world.figures()]
        return told

    body: Mapping[str, Atom] = {"sonar": sonar, "odometry": "wheels", "careless": 0.5}
    world, other = (HallwayWorld(Random(seed), body) for seed in (1, 2))
    world.activate(1, FOLLOW, [":end-o-hall", ":hall-blocked"])
    world.activate(2, [(":report-position",)], [":position"])
    world.advance(seconds)
    saved = world.save()
    other.restore(saved)
    assert other.save() == saved
    assert live(other) == live(world)
    assert other.save() == world.save()
    with pytest.raises(ValueError, match="no state of the world `hallway`"):
        other.restore(b"{}")
