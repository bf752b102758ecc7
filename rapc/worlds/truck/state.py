"""All that changes in the truck world, as one value that can be saved exactly."""

from __future__ import annotations

import msgspec

from rapc.base.values import Fact, Number

ARMS = ("arm1", "arm2")
CARGO_BAYS = ("bay1", "bay2")
BAYS = (*CARGO_BAYS, "weapon-bay", "fuel-bay")
EXTERNAL = "external"
FOLDED = "folded"


class TruckItem(msgspec.Struct):
    """A thing. `place` is a place or road of the map, a bay, an arm or a container.

    `liquid` and `amount` are what a vessel or weapon holds; a machine may be `broken`.
    """

    name: str
    kind: str
    place: str
    color: str | None = None
    liquid: str | None = None
    amount: Number = 0
    broken: bool = False


class Arm(msgspec.Struct):
    """Where an arm is (external, folded or a bay) and the item it is at, if any."""

    place: str = FOLDED
    at: str | None = None


class Truck(msgspec.Struct):
    """The truck's body; what its arms and bays hold is said by the items."""

    place: str
    heading: str
    fuel: Number
    speed: str = "medium"
    arms: dict[str, Arm] = msgspec.field(
        default_factory=lambda: {name: Arm() for name in ARMS}
    )


class Demon(msgspec.Struct):
    """Something that will happen: a job of `demons.JOBS`, at a place or at none."""

    job: str
    place: str
    time: Number


class Order(msgspec.Struct):
    """So many rocks of a colour wanted at a factory from a time on.

    `filled` is the time when the last of them came, or None.
    """

    time: Number
    color: str
    rocks: int
    factory: str
    received: int = 0
    filled: Number | None = None


class Delivery(msgspec.Struct, frozen=True):
    """A rock was put down at a factory."""

    time: Number
    item: str
    color: str
    factory: str


class Encounter(msgspec.Struct):
    """Enemies and the truck were at one place, from a time on.

    `until` is when that was over, None while it lasts; `how`: `shot` if no unit was
    left, `left` if the truck set off, `captured`.
    """

    time: Number
    place: str
    units: int
    until: Number | None = None
    how: str | None = None


class TruckState(msgspec.Struct):
    """The whole state.

    Args:
        sighted: the items sensed since the truck arrived, with where they were.
        names: their sensor names, where those do not last.
        made: how many items of each kind there have ever been.
        gone: how many items factories took in, the depot removed, or enemies were.
        raining: the sectors in which it rains.
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
