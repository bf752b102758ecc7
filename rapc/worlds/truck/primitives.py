"""The table of the truck's primitives (T B.1) and data (T B.2): all that it offers.

Results beyond T's lists, and why, are in docs/truck.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from rapc.world import Offer, Reply
from rapc.worlds.truck import arms, eye, movement


class TruckPrimitive(msgspec.Struct, frozen=True):
    """A primitive: how long it takes, its results, and what it does at its end."""

    time: str
    results: tuple[str, ...]
    act: Callable[..., Reply]
    arity: int
    by_eye: bool = False


_MOVE = ("okay", "truck-cant-move", "truck-mishap")
_GRASP = (
    "okay",
    "arm-too-full",
    "arm-not-at",
    "arm-dropped",
    "arm-cant-grasp",
    "arm-interference",
)

PRIMITIVES: Mapping[str, TruckPrimitive] = {
    "arm-move": TruckPrimitive(
        "arm_move_time", ("okay", "arm-cant-find"), arms.arm_move, 2
    ),
    "arm-grasp": TruckPrimitive("arm_grasp_time", _GRASP, arms.arm_grasp, 2),
    "arm-ungrasp": TruckPrimitive(
        "arm_ungrasp_time",
        ("okay", "arm-not-holding", "container-full"),
        arms.arm_ungrasp,
        2,
    ),
    "arm-pour": TruckPrimitive(
        "arm_pour_time", ("okay", "arm-not-holding"), arms.arm_pour, 2
    ),
    "arm-ladle": TruckPrimitive(
        "arm_ladle_time", ("okay", "arm-not-holding", "arm-not-at"), arms.arm_ladle, 2
    ),
    "arm-toggle": TruckPrimitive(
        "arm_toggle_time", ("okay", "arm-not-at", "arm-cant-toggle"), arms.arm_toggle, 2
    ),
    "arm-examine": TruckPrimitive(
        "arm_examine_time", ("okay", "arm-not-at"), arms.arm_examine, 2
    ),
    "truck-turn": TruckPrimitive(
        "truck_turn_time", ("okay", "truck-bad-direction"), movement.truck_turn, 1
    ),
    "truck-speed": TruckPrimitive(
        "truck_speed_time", ("okay", "truck-bad-speed"), movement.truck_speed, 1
    ),
    "truck-move": TruckPrimitive("truck_move_time", _MOVE, movement.truck_move, 0),
    "eye-examine": TruckPrimitive(
        "eye_examine_time", ("okay", "eye-cant-find"), eye.eye_examine, 2, by_eye=True
    ),
    "eye-scan": TruckPrimitive(
        "eye_scan_time", ("okay", "eye-cant-find"), eye.eye_scan, 1, by_eye=True
    ),
    "eye-monitor": TruckPrimitive("eye_monitor_time", ("okay",), eye.eye_monitor, 1),
    "eye-unmonitor": TruckPrimitive(
        "eye_monitor_time", ("okay",), eye.eye_unmonitor, 1
    ),
}

OFFER = Offer(
    primitives={name: (p.arity, p.results) for name, p in PRIMITIVES.items()},
    data={
        "object-seen": 3,
        "object-gone": 2,
        "road-seen": 2,
        "weather": 2,
        "light": 2,
        "new-location": 1,
        "vessel": 3,
        "capacity": 2,
        "shots-left": 2,
        "holds": 2,
        "machine": 2,
        "color": 2,
        "size": 2,
        "heading": 1,
        "speed": 1,
        "fuel-level": 1,
        "clock": 1,
    },
    sensors=(
        "arm-examine",
        "eye-examine",
        "eye-scan",
        "eye-monitor",
        "eye-unmonitor",
    ),
    arguments={
        "arm-move": ("arm", "place"),
        "arm-grasp": ("arm", "item"),
        "arm-ungrasp": ("arm", "item"),
        "arm-pour": ("arm", "vessel"),
        "arm-ladle": ("arm", "vessel"),
        "arm-toggle": ("arm", "item"),
        "arm-examine": ("arm", "item"),
        "truck-turn": ("direction",),
        "truck-speed": ("speed",),
        "eye-examine": ("place", "item"),
        "eye-scan": ("place",),
        "eye-monitor": ("class",),
        "eye-unmonitor": ("class",),
        "object-seen": ("place", "item", "class"),
        "object-gone": ("place", "item"),
        "road-seen": ("direction", "road"),
        "new-location": ("place",),
        "vessel": ("item", "liquid", "amount"),
        "capacity": ("item", "size"),
        "shots-left": ("item", "number"),
        "holds": ("item", "size"),
        "machine": ("item", "state"),
        "color": ("item", "color"),
        "size": ("item", "size"),
        "heading": ("direction",),
        "speed": ("speed",),
        "fuel-level": ("fuel",),
        "clock": ("time",),
        "weather": ("place", "sky"),
        "light": ("place", "light"),
    },
)
