"""What can be chosen about a run in the hallway, and all that changes in one."""

from __future__ import annotations

import msgspec

from rapc.worlds.hallway.people import Walker
from rapc.worlds.hallway.robot import Robot, Wear


class HallwaySettings(msgspec.Struct, frozen=True):
    """What can be chosen about a run; times in seconds."""

    #: How long a door stays open on average; 0: for ever.
    doors: float = 120.0
    #: How many of the map's people there are.
    people: int = 99
    #: How often somebody else calls the lift; 0: never.
    lift: float = 90.0
    #: How much dead reckoning drifts; 1 is usual.
    drift: float = 1.0
    #: How fast the battery is used up; 1 is usual, 0 never.
    usage: float = 1.0


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


class Collision(msgspec.Struct, frozen=True):
    """The robot touched something."""

    time: float
    #: How fast they came together, in metres a second.
    speed: float
    #: Where the robot was.
    x: float
    y: float
    #: A `wall`, a `person`, or a `push` for what the robot could not help.
    what: str


class Push(msgspec.Struct):
    """Somebody is pushing the robot, in metres a second."""

    x: float
    y: float
    until: float


class HallwayState(msgspec.Struct):
    """All that changes, apart from skills and streams of chance."""

    robot: Robot
    wear: Wear
    walkers: list[Walker]
    doors: list[DoorState]
    lift: Lift | None
    #: The space whose floor is under the robot's middle.
    space: str
    ticks: int = 0
    push: Push | None = None
    #: The floor to which the robot called the lift in the last tick.
    called: int | None = None
    collisions: list[Collision] = []
    #: When something was said, and what.
    said: list[tuple[float, str]] = []
