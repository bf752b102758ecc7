"""What flows between sensors, skills and motors of the hallway robot.

Angles are in radians, counter-clockwise; a *bearing* is one from where the robot
points, a *heading* one in the frame of dead reckoning, which is that of the building at
the start of a run and drifts away from it.
"""

from __future__ import annotations

import math

import msgspec

from rapc.worlds.skills.declarations import Channel

SONARS = 24
"""Sonars in the ring; number 0 looks ahead, the others follow counter-clockwise."""

SONAR_RANGE = 4.0
"""What a sonar says when it hears no echo, in metres."""

BEARINGS = tuple(
    math.remainder(2 * math.pi * number / SONARS, 2 * math.pi)
    for number in range(SONARS)
)
"""The bearing of each sonar."""

DIRECTIONS = tuple((math.cos(b), math.sin(b)) for b in BEARINGS)

LASER_RANGE = 6.0
"""How far the laser can read a tag, in metres."""

RADIUS = 0.25
"""Of the robot, which is round, in metres."""

TOP_SPEED = 0.6
"""In metres a second."""

TOP_TURN = 1.5
"""In radians a second."""


class Pose(msgspec.Struct, frozen=True):
    """Where the robot takes itself to be by dead reckoning, in metres."""

    x: float
    y: float
    heading: float


class Tag(msgspec.Struct, frozen=True):
    """A bar code that the laser sees, and its bearing: it tells nothing else."""

    code: int
    bearing: float


class Trajectory(msgspec.Struct, frozen=True):
    """Where the robot is to go next."""

    bearing: float
    speed: float
    #: Metres left to go; None if there is no end in sight.
    distance: float | None = None
    #: Whether the robot is only to turn.
    turn: bool = False
    #: Whether it goes through a gap that leaves no room to swerve.
    narrow: bool = False


class Drive(msgspec.Struct, frozen=True):
    """What the motors are to do, in metres and radians a second."""

    speed: float
    turn: float


class Hall(msgspec.Struct, frozen=True):
    """A hallway as the robot sees it."""

    #: Of the hallway.
    bearing: float
    width: float
    #: From the middle of the hallway to the robot, positive to the left.
    offset: float
    #: Whether a wall closes the hallway right ahead.
    ends: bool
    #: Seconds for which the robot has been beside the hallway, as in a room.
    outside: float = 0.0


class Sighting(msgspec.Struct, frozen=True):
    """A landmark that the laser sees, with what two angles tell of it."""

    distance: float
    bearing: float


class PositionFix(msgspec.Struct, frozen=True):
    """A landmark that is being tracked, in the frame of dead reckoning."""

    x: float
    y: float
    #: The direction in which its tags face.
    normal: float
    #: Seconds since it was last seen, or since it has been looked for.
    age: float
    #: Whether it has been seen at all.
    known: bool = True
    #: Whether both tags are in view, at the bearings that follow from the fix.
    in_view: bool = False


SONAR = Channel("sonar", tuple[float, ...], "m", "what each sonar of the ring measures")
POSE = Channel("pose", Pose, "m, rad", "dead reckoning")
TAGS = Channel("tags", tuple[Tag, ...], "rad", "the bar codes in the laser's view")
BATTERY = Channel("battery", float, "%", "how full the battery is")
CURRENT = Channel("current", bool, "", "whether the battery is being charged")
LIFT = Channel("lift", int, "", "the floor at which the lift stands open, or -1")

OBSTACLES = Channel(
    "obstacles", tuple[float, ...], "m", "the nearest thing in each sonar's direction"
)
HALL = Channel("hall", Hall, "m, rad", "the hallway around the robot")
TRAJECTORY = Channel("trajectory", Trajectory, "m, rad", "where to go next")
PROGRESS = Channel("progress", float, "s", "for how long it has come no nearer")
SPEED_LIMIT = Channel("speed-limit", float, "m/s", "the most that is allowed")
FIX = Channel("fix", PositionFix, "m, rad", "the landmark that is being approached")

GAP = Channel("gap", str, "", "the stage of a passage of a doorway", own=True)
"""One of `looking`, `going`, `between`, `closed`, `through`."""

TRAVEL = Channel("travel", bool, "", "whether a movement is at its end", own=True)
SIGHTING = Channel("sighting", Sighting, "m, rad", "a landmark in view", own=True)
SEEN = Channel("seen", tuple[Tag, ...], "rad", "pairs of tags in view", own=True)
PASSED = Channel("passed", Pose, "m, rad", "a doorway that was passed", own=True)
DONE = Channel("done", bool, "", "whether the work is done", own=True)

DRIVE = Channel("drive", Drive, "m/s, rad/s", "to the motors")
CHARGE = Channel("charge", bool, "", "to the charging contacts")
CALL = Channel("call", int, "", "the floor to which the lift is called by radio")
VOICE = Channel("voice", str, "", "words to be spoken")
