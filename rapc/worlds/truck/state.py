"""The complete changing state of the truck world, as a value that can be saved."""

from __future__ import annotations

import msgspec

from rapc.base.values import Fact, Number

ARMS = ("arm1", "arm2")
CARGO_BAYS = ("bay1", "bay2")
BAYS = (*CARGO_BAYS, "weapon-bay", "fuel-bay")
EXTERNAL = "external"
FOLDED = "folded"


class TruckItem(msgspec.Struct):
    """An item. `place` is a place or road of the map, a bay, an arm or a container.

    `liquid` and `amount` are the contents of a vessel or weapon; a machine may be
    `broken`.
    """

    name: str
    kind: str
    place: str
    color: str | None = None
    liquid: str | None = None
    amount: Number = 0
    broken: bool = False


class Arm(msgspec.Struct):
    """An arm's position (external, folded or a bay), and the item it is at, if any."""

    place: str = FOLDED
    at: str | None = None


class Truck(msgspec.Struct):
    """The truck's body; items record their own places in arms and bays."""

    place: str
    heading: str
    fuel: Number
    speed: str = "medium"
    arms: dict[str, Arm] = msgspec.field(
        default_factory=lambda: {name: Arm() for name in ARMS}
    )


class Demon(msgspec.Struct):
    """A future event: a job of `demons.JOBS`, at a place or without a place."""

    job: str
    place: str
    time: Number


class Order(msgspec.Struct):
    """An order of rocks of a colour for a factory, open from a time on.

    `filled` is the time of the last rock's delivery, or None.
    """

    time: Number
    color: str
    rocks: int
    factory: str
    received: int = 0
    filled: Number | None = None


class Delivery(msgspec.Struct, frozen=True):
    """A delivery of a rock to a factory."""

    time: Number
    item: str
    color: str
    factory: str


class Encounter(msgspec.Struct):
    """A meeting of enemies and truck at a place, from a time on.

    `until` is the end of the meeting, None while the meeting lasts. `how` is `shot` if
    no unit was left, `left` if the truck departed, or `captured`.
    """

    time: Number
    place: str
    units: int
    until: Number | None = None
    how: str | None = None


class TruckState(msgspec.Struct):
    """The complete state.

    Args:
        sighted: the items sensed since the truck arrived, with their spots.
        names: sensor names that are valid for one visit.
        made: the number of items of each kind ever made.
        gone: the number of items taken in by factories, removed by the depot, or shot.
        raining: the sectors with rain.
        pending: data for `messages`.
    """

    truck: Truck
    now: Number = 0
    items: dict[str, TruckItem] = msgspec.field(default_factory=dict)
    demons: list[Demon] = msgspec.field(default_factory=list)
    orders: list[Order] = msgspec.field(default_factory=list)
    deliveries: list[Delivery] = msgspec.field(default_factory=list)
    encounters: list[Encounter] = msgspec.field(default_factory=list)
    sighted: dict[str, str] = msgspec.field(default_factory=dict)
    names: dict[str, str] = msgspec.field(default_factory=dict)
    named: int = 0
    monitored: list[str] = msgspec.field(default_factory=list)
    made: dict[str, int] = msgspec.field(default_factory=dict)
    gone: int = 0
    raining: list[str] = msgspec.field(default_factory=list)
    pending: list[Fact] = msgspec.field(default_factory=list)
    ended: str | None = None
