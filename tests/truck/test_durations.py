"""How long primitives take is bounded by T's traces, and by its setup (T 6.2, 6.3.1).

The two traces come about in the simulator as T has them, request by request, from its
own chance; when the situation monitor wakes, and when the fight is broken off, is a
matter of durations alone. The names of things are ours.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest

from rapc.base.values import Text
from rapc.experiments import definition
from rapc.worlds.truck.options import TruckSettings, read_settings

from .runs import EXAMPLES, STDLIB, Run, agenda, library, task

WATCH = task("watch-surroundings", priority=8, background=True)

WAREHOUSE = {
    "start": "depot",
    "places": [
        {"name": "depot", "kind": "depot"},
        {"name": "warehouse", "kind": "warehouse"},
    ],
    "roads": [
        {
            "name": "road-1",
            "from": "depot",
            "direction": "north",
            "to": "warehouse",
            "time": 30,
            "fuel": 1,
        }
    ],
    "items": [
        {"kind": kind, "place": "warehouse"} for kind in ("ammo-box", "gun-tool", "gun")
    ],
}

TRACE_1 = (
    "eye-examine external item-1",
    "eye-examine external gun-tool-1",
    "eye-examine external gun-1",
    "arm-move arm1 external",
    "arm-move arm1 gun-tool-1",
    "arm-grasp arm1 gun-tool-1",
    "arm-move arm1 gun-1",
    "arm-grasp arm1 gun-1",
    "arm-grasp arm1 gun-1",
    "arm-move arm1 bay1",
    "arm-ungrasp arm1 gun-tool-1",
    "arm-move arm2 bay1",
    "arm-move arm2 gun-tool-1",
    "eye-scan external",
    "arm-grasp arm2 gun-tool-1",
    "arm-move arm1 folded",
    "arm-grasp arm2 gun-tool-1",
    "arm-grasp arm2 gun-tool-1",
    "arm-grasp arm2 gun-tool-1",
    "arm-move arm2 external",
    "arm-move arm2 gun-1",
    "arm-grasp arm2 gun-1",
    "eye-scan external",
    "arm-move arm2 weapon-bay",
    "arm-ungrasp arm2 gun-1",
)
"""The 25 requests of T 6.2.1 after the trip and the look at its end."""

ROADS = (("quarry-2", "zone-4"), ("zone-4", "zone-3"), ("zone-3", "factory-2"))

TROOPS = {
    "start": "quarry-2",
    "heading": "north",
    "places": [
        {"name": "quarry-2", "kind": "quarry", "color": "blue"},
        {"name": "zone-4", "kind": "zone"},
        {"name": "zone-3", "kind": "zone"},
        {"name": "factory-2", "kind": "factory"},
    ],
    "roads": [
        {"name": f"road-{n}", "from": a, "direction": "west", "to": b}
        | {"time": 32, "fuel": 1}
        for n, (a, b) in enumerate(ROADS, 4)
    ],
    "items": [
        {"kind": "gun", "place": "quarry-2"},
        {"kind": "gun-tool", "place": "quarry-2"},
        {"kind": "enemy-unit", "place": "zone-4", "count": 6},
    ],
}

FIGHT = (
    "truck-move",
    "eye-scan external",
    "arm-toggle arm2 gun-1",
    "eye-scan external",
    "arm-examine arm2 gun-1",
    "arm-toggle arm2 gun-1",
    "eye-scan external",
    "truck-speed medium",
    "truck-move",
    "eye-scan external",
)
"""The requests of T 6.2.2 from the first trip to the look after the flight."""


def requests(run: Run) -> list[str]:
    return [request.strip("()") for request in run.requests]


def mounting(seed: int) -> Sequence[str]:
    """What is asked for at the warehouse, after the two looks on arrival."""
    options = {"warehouse-interval": 0, "depot-interval": 0, "enemy-interval": 0}
    run = Run(
        *agenda("mounting-a-weapon"),
        seed=seed,
        options={"map": Text(json.dumps(WAREHOUSE)), **options},
        compiled=library(STDLIB / "truck"),
    )
    made = requests(run)
    return made[made.index("truck-move") + 3 :]


def test_trace_1_comes_about() -> None:
    assert tuple(mounting(53)[: len(TRACE_1)]) == TRACE_1


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 6, 8, 9, 10, 11])
def test_the_monitor_wakes_where_it_does_in_trace_1(seed: int) -> None:
    """In all seeds under which the first arm does not drop the tool."""
    until = TRACE_1.index("arm-grasp arm2 gun-tool-1")
    assert tuple(mounting(seed)[:until]) == TRACE_1[:until]


@pytest.mark.parametrize("seed", range(10))
def test_trace_2_comes_about(seed: int) -> None:
    options = {"gun-rounds": 15, "quarry-interval": 0, "enemy-interval": 0}
    run = Run(
        *agenda("meeting-troops"),
        seed=seed,
        options={"map": Text(json.dumps(TROOPS)), "capture-time": 0, **options},
        compiled=library(STDLIB / "truck"),
    )
    made = requests(run)
    begun = made.index("truck-move")
    assert set(made[begun - 2 : begun]) == {"truck-turn west", "truck-speed medium"}
    assert tuple(made[begun : begun + len(FIGHT)]) == FIGHT
    assert run.world.encounters[0].how == "left"
    assert run.outcomes == ["succeeded"] * 5


def calibrated() -> TruckSettings:
    """The world that is calibrated on T's tables."""
    file = EXAMPLES / "experiments" / "calibrated.toml"
    return read_settings(
        {**definition.read_experiment(file).set["truck"], "map": Text("")}
    )


@pytest.mark.parametrize(
    ("one", "interval"),
    [(TruckSettings(), 15), (calibrated(), 20)],
    ids=["default", "calibrated"],
)
def test_hands_are_within_the_bounds_of_the_traces(
    one: TruckSettings, interval: int
) -> None:
    """With the situation monitor's interval: 15 (T figure 5.7) or 20 (T 5.4.1)."""
    look, feel, scan = one.eye_examine_time, one.arm_examine_time, one.eye_scan_time
    move, grasp, ungrasp = one.arm_move_time, one.arm_grasp_time, one.arm_ungrasp_time
    before = 3 * look + 5 * move + 3 * grasp + ungrasp
    assert before < interval <= before + move
    assert 3 * move + 4 * grasp < interval <= 3 * move + 5 * grasp
    burst = 2 * one.arm_toggle_time + scan + feel
    assert burst < 18 <= burst + scan


@pytest.mark.parametrize("seed", range(5))
def test_two_orders_have_come_when_the_truck_is_set_up(seed: int) -> None:
    """T 6.3.1: about 200 time units; orders come at 120, 180 and 240."""
    run = Run(
        WATCH,
        task("watch-fuel", priority=4, background=True),
        task("handle-enemy-troops", priority=6, background=True),
        task("set-up", priority=3),
        seed=seed,
        compiled=library(STDLIB / "truck"),
    )
    assert run.outcomes == ["succeeded"]
    assert 180 <= run.interpreter.now < 250
