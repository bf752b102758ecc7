"""Doors that close now and then, and a lift that others use too."""

from __future__ import annotations

from collections.abc import Iterable
from random import Random

import msgspec

from rapc.worlds.hallway.map import Map, Opening, middle

SHUT_FOR = 25.0
"""How long a door stays closed on average, in seconds."""

CLEAR = 0.5
"""How near to the middle of a doorway somebody keeps its door open, in metres."""

A_FLOOR = 6.0
"""What the lift takes from one floor to the next, doors included, in seconds."""

DWELL = 20.0
"""How long the lift stays for the robot before somebody else can call it."""


class DoorState(msgspec.Struct):
    """A door in a doorway, open or closed."""

    doorway: str
    closed: bool = False
    #: When it is next opened or closed; None: never.
    changes: float | None = None


class Lift(msgspec.Struct):
    """The cabin of the lift."""

    #: Where it is, or was last.
    floor: int
    #: Where it is going, and when it will be there; None: it stands open.
    towards: int | None = None
    arrives: float = 0.0
    #: When it can be called by somebody else.
    free_from: float = 0.0
    #: When somebody else next wants it; None: never.
    wanted: float | None = None


Spot = tuple[int, float, float]
"""Where somebody is: floor, x, y."""


def doors(openings: Iterable[Opening], every: float, rng: Random) -> list[DoorState]:
    """Return the doors of a building, all open.

    Args:
        openings: all doorways.
        every: how long a door stays open on average, in seconds; 0: for ever.
        rng: the stream of doors.
    """
    return [
        DoorState(
            gap.doorway.name, changes=rng.expovariate(1 / every) if every > 0 else None
        )
        for gap in openings
        if gap.doorway.door
    ]


def swing(
    door: DoorState,
    opening: Opening,
    now: float,
    spots: Iterable[Spot],
    every: float,
    rng: Random,
) -> bool:
    """Open or close a door whose time has come; return whether it moved.

    A door that somebody stands in waits a second.
    """
    if door.changes is None or now < door.changes:
        return False
    if not door.closed and occupied(opening, spots):
        door.changes = now + 1
        return False
    door.closed = not door.closed
    door.changes = now + rng.expovariate(1 / (SHUT_FOR if door.closed else every))
    return True


def occupied(opening: Opening, spots: Iterable[Spot]) -> bool:
    """Return whether somebody is in a doorway, or about to be."""
    x, y = middle(opening.box)
    return any(
        floor == opening.floor and abs(px - x) < CLEAR and abs(py - y) < CLEAR
        for floor, px, py in spots
    )


def lift(map: Map, every: float, rng: Random) -> Lift | None:
    """Return the lift of a map at its lowest floor, or None.

    Args:
        map: the building.
        every: how often somebody else wants it, in seconds on average; 0: never.
        rng: the stream of the lift.
    """
    for space in map.space:
        if space.kind == "lift":
            wanted = rng.expovariate(1 / every) if every > 0 else None
            return Lift(min(space.floors), wanted=wanted)
    return None


def send(cabin: Lift, floor: int, now: float) -> None:
    """Let the cabin, which stands open, go to another floor."""
    cabin.towards = floor
    cabin.arrives = now + A_FLOOR * abs(floor - cabin.floor)


def arrive(cabin: Lift, now: float) -> bool:
    """Open the cabin at its goal if it has come there; return whether it has."""
    if cabin.towards is None or now < cabin.arrives - 1e-9:
        return False
    cabin.floor, cabin.towards = cabin.towards, None
    cabin.free_from = now + DWELL
    return True
