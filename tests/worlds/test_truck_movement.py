"""Turning, speed and trips: time, fuel, and the ways a trip can end (T B.1)."""

from __future__ import annotations

import pytest

from rapc.base.values import Text

from .drive import Driver, map_text, rock, thing


def test_a_trip_takes_the_road_ahead() -> None:
    driver = Driver(fuel_spread=0, time_spread=0)
    driver.do("truck-turn north")
    assert driver.data("truck-move") == (("new-location", "zone-1"), ("fuel-level", 29))
    assert driver.world.now() == 1 + 1 + 30
    assert driver.drive("east", "west", "south") == "okay"
    assert driver.world.state.truck.place == "depot"


def test_there_must_be_a_road_ahead() -> None:
    driver = Driver()
    assert driver.do("truck-turn east", "truck-move") == "truck-cant-move"
    assert driver.world.state.truck.place == "depot"


def test_the_truck_does_not_start_with_an_arm_outside() -> None:
    driver = Driver()
    assert driver.do("arm-move arm2 external", "truck-move") == "truck-cant-move"
    assert driver.do("arm-move arm2 bay1", "truck-move") == "okay"


@pytest.mark.parametrize("direction", ["up", "external", "7"])
def test_there_are_eight_directions(direction: str) -> None:
    assert Driver().do(f"truck-turn {direction}") == "truck-bad-direction"


def test_there_are_three_speeds() -> None:
    assert Driver().do("truck-speed reckless") == "truck-bad-speed"


@pytest.mark.parametrize(
    ("speed", "time", "fuel"),
    [("slow", 45, 29.1), ("medium", 30, 29), ("fast", 22.5, 28.7)],
)
def test_speed_trades_fuel_for_time(speed: str, time: float, fuel: float) -> None:
    driver = Driver(fuel_spread=0, time_spread=0)
    assert driver.data(f"truck-speed {speed}") == (("speed", speed),)
    driver.do("truck-turn north", "truck-move")
    assert driver.world.now() == 3 + time
    assert driver.world.state.truck.fuel == fuel


def test_trip_times_vary_around_the_map_value() -> None:
    times, fuels = [], []
    for seed in range(200):
        driver = Driver(seed=seed)
        driver.drive("north")
        times.append(driver.world.now() - 2)
        fuels.append(30 - driver.world.state.truck.fuel)
    assert all(24 <= time <= 36 for time in times)
    assert all(0.8 <= fuel <= 1.21 for fuel in fuels)
    assert abs(sum(times) / 200 - 30) < 1
    assert abs(sum(fuels) / 200 - 1) < 0.05
    assert len(set(times)) > 150


def test_running_out_of_fuel_ends_the_run_on_the_road() -> None:
    driver = Driver([rock()], fuel=0.5, fuel_spread=0, time_spread=0)
    driver.do("truck-turn north")
    assert driver.world.ended() is None
    reply = driver.ask("truck-move")
    assert reply.result == "truck-mishap"
    assert reply.data == (("fuel-level", 0), ("clock", 17))
    assert driver.world.ended() == "out of fuel on road-1"
    assert driver.do("eye-examine external rock-1") == "eye-cant-find"


def test_fuel_use_can_be_switched_off() -> None:
    driver = Driver(fuel=0, fuel_use=0)
    assert driver.drive("north", "east", "west") == "okay"


def test_a_risky_road_punishes_high_speed_alone() -> None:
    risky = Text(map_text(mishap=1))
    assert Driver(map=risky).drive("north") == "okay"
    driver = Driver(map=risky)
    driver.do("truck-speed fast")
    assert driver.drive("north") == "truck-mishap"
    assert driver.world.ended() == "mishap on road-1"


def test_carried_items_move_with_the_truck() -> None:
    driver = Driver([rock(), thing("fuel-drum")])
    driver.do("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
    driver.do("arm-move arm1 bay2", "arm-ungrasp arm1 rock-1", "arm-move arm1 external")
    driver.do("arm-move arm1 fuel-drum-1", "arm-grasp arm1 fuel-drum-1")
    driver.do("arm-move arm1 folded")
    assert driver.drive("north") == "okay"
    assert driver.data("eye-scan bay2")[0][2] == "rock-1"
    assert driver.data("eye-scan arm1")[0][2] == "fuel-drum-1"
    driver.do("arm-move arm1 external")
    assert driver.do("arm-ungrasp arm1 fuel-drum-1") == "okay"
    assert driver.place("fuel-drum-1") == "zone-1"
