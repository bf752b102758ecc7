"""The options of a run in the hallway, and its complete changing state."""

from __future__ import annotations

import msgspec

from rapc.worlds.hallway.people import Walker
from rapc.worlds.hallway.robot import Robot, Wear

ODOMETRIES = ("body", "wheels")
"""What dead reckoning can measure.

The `wheels` go on when the body is blocked, and do not turn when it is pushed aside.
"""


class HallwaySettings(msgspec.Struct, frozen=True):
    """The options of a run; times in seconds."""

    #: The average time that a door stays open; 0: for ever.
    doors: float = 120.0
    #: The number of the map's people in the run.
    people: int = 99
    #: The average time between lift calls by other users; 0: no calls.
    lift: float = 90.0
    #: The drift of dead reckoning; 1 is usual.
    drift: float = 1.0
    #: The use of the battery; 1 is usual, 0 none.
    usage: float = 1.0
    #: The model of the sonars, a name in `SONAR_MODELS`.
    sonar: str = "ideal"
    #: What dead reckoning measures, one of `ODOMETRIES`.
    odometry: str = "body"
    #: The part of their ways on which people do not look out for the robot.
    careless: float = 0.0


class DoorState(msgspec.Struct):
    """A door in a doorway, open or closed."""

    doorway: str
    closed: bool = False
    #: The time of the next change; None: never.
    changes: float | None = None


class Lift(msgspec.Struct):
    """The cabin of the lift."""

    #: The present or last floor.
    floor: int
    #: The destination and the time of arrival; None: the cabin stands open.
    towards: int | None = None
    arrives: float = 0.0
    #: The time from which other users can call the lift.
    free_from: float = 0.0
    #: The time of the next call by another user; None: never.
    wanted: float | None = None


class Collision(msgspec.Struct, frozen=True):
    """A contact of the robot with an obstacle."""

    time: float
    #: The relative speed at the contact, in metres a second.
    speed: float
    #: The robot's position at the contact.
    x: float
    y: float
    #: A `wall`, a `person`, or a `push` for a contact that the robot could not avoid.
    what: str


class Push(msgspec.Struct):
    """A push of the robot, in metres a second."""

    x: float
    y: float
    until: float


class HallwayState(msgspec.Struct):
    """The complete changing state, except skills and random streams."""

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
    #: Spoken words, each with its time.
    said: list[tuple[float, str]] = []
