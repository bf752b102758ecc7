"""The table of the truck's primitives (T B.1) and data (T B.2): the world's offer.

docs/reference/truck.md has the results beyond T's lists, with reasons.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from rapc.base.values import Number
from rapc.world import OKAY, Offer, Reply
from rapc.worlds.truck import arms, eye, movement
from rapc.worlds.truck.options import TruckSettings


class TruckPrimitive(msgspec.Struct, frozen=True):
    """A primitive and its effect at its end."""

    #: The names of its arguments.
    takes: tuple[str, ...]
    act: Callable[..., Reply]
    #: Its results besides `okay`.
    failures: tuple[str, ...] = ()
    by_eye: bool = False


_GRASP = (
    "arm-too-full",
    "arm-not-at",
    "arm-dropped",
    "arm-cant-grasp",
    "arm-interference",
)
_MOVE = ("truck-cant-move", "truck-mishap")
_NO_DIRECTION, _NO_SPEED = ("truck-bad-direction",), ("truck-bad-speed",)
_HOLDS, _ITEM, _VESSEL = ("arm-not-holding",), ("arm", "item"), ("arm", "vessel")
_AT, _SEEN = ("arm-not-at",), ("eye-cant-find",)

PRIMITIVES: Mapping[str, TruckPrimitive] = {
    "arm-move": TruckPrimitive(("arm", "place"), arms.arm_move, ("arm-cant-find",)),
    "arm-grasp": TruckPrimitive(_ITEM, arms.arm_grasp, _GRASP),
    "arm-ungrasp": TruckPrimitive(_ITEM, arms.arm_ungrasp, (*_HOLDS, "container-full")),
    "arm-pour": TruckPrimitive(_VESSEL, arms.arm_pour, _HOLDS),
    "arm-ladle": TruckPrimitive(_VESSEL, arms.arm_ladle, (*_HOLDS, *_AT)),
    "arm-toggle": TruckPrimitive(_ITEM, arms.arm_toggle, (*_AT, "arm-cant-toggle")),
    "arm-examine": TruckPrimitive(_ITEM, arms.arm_examine, _AT),
    "truck-turn": TruckPrimitive(("direction",), movement.truck_turn, _NO_DIRECTION),
    "truck-speed": TruckPrimitive(("speed",), movement.truck_speed, _NO_SPEED),
    "truck-move": TruckPrimitive((), movement.truck_move, _MOVE),
    "eye-examine": TruckPrimitive(
        ("place", "item"), eye.eye_examine, _SEEN, by_eye=True
    ),
    "eye-scan": TruckPrimitive(("place",), eye.eye_scan, _SEEN, by_eye=True),
    "eye-monitor": TruckPrimitive(("class",), eye.eye_monitor),
    "eye-unmonitor": TruckPrimitive(("class",), eye.eye_unmonitor),
}


def time_of(settings: TruckSettings, name: str) -> Number:
    """Return the duration of a primitive, trips excluded: the option of its name."""
    option = name.replace("unmonitor", "monitor").replace("-", "_")
    takes: Number = getattr(settings, f"{option}_time")
    return takes


DATA: Mapping[str, tuple[str, ...]] = {
    "object-seen": ("place", "item", "class"),
    "object-gone": ("place", "item"),
    "road-seen": ("direction", "road"),
    "weather": ("place", "sky"),
    "light": ("place", "light"),
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
}
"""Argument names of each datum."""

OFFER = Offer(
    primitives={n: (len(p.takes), (OKAY, *p.failures)) for n, p in PRIMITIVES.items()},
    data={name: len(called) for name, called in DATA.items()},
    sensors=("arm-examine", "eye-examine", "eye-scan", "eye-monitor", "eye-unmonitor"),
    arguments={**{name: p.takes for name, p in PRIMITIVES.items()}, **DATA},
)
