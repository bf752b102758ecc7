"""The channels between sensors, skills and motors of the hallway robot.

Angles are in radians, counter-clockwise. A *bearing* is an angle from the robot's
heading. A *heading* is an angle in the frame of dead reckoning, which agrees with the
building at the start of a run and drifts later.
"""

from __future__ import annotations

import math

import msgspec

from rapc.worlds.skills.declarations import Channel

SONARS = 24
"""The number of sonars; number 0 looks ahead, the others follow counter-clockwise."""

SONAR_RANGE = 4.0
"""The reading of a sonar without an echo, in metres."""

BEARINGS = tuple(
    math.remainder(2 * math.pi * number / SONARS, 2 * math.pi)
    for number in range(SONARS)
)
"""The bearing of each sonar."""

DIRECTIONS = tuple((math.cos(b), math.sin(b)) for b in BEARINGS)

LASER_RANGE = 6.0
"""The maximum distance at which the laser reads a tag, in metres."""

RADIUS = 0.25
"""The radius of the round robot, in metres."""

TOP_SPEED = 0.6
"""The maximum speed, in metres a second."""

TOP_TURN = 1.5
"""The maximum turning speed, in radians a second."""


class Pose(msgspec.Struct, frozen=True):
    """The robot's pose by dead reckoning, in metres."""

    x: float
    y: float
    heading: float


class Tag(msgspec.Struct, frozen=True):
    """A bar code seen by the laser, with its bearing; a tag carries no other data."""

    code: int
    bearing: float


class Trajectory(msgspec.Struct, frozen=True):
    """The next movement of the robot."""

    bearing: float
    speed: float
    #: The remaining metres; None if no end is in sight.
    distance: float | None = None
    #: Whether the robot only turns.
    turn: bool = False
    #: Whether the gap ahead leaves no room to swerve.
    narrow: bool = False


class Drive(msgspec.Struct, frozen=True):
    """Speeds for the motors, in metres and radians a second."""

    speed: float
    turn: float


class Hall(msgspec.Struct, frozen=True):
    """A hallway as seen by the robot."""

    #: The bearing of the hallway.
    bearing: float
    width: float
    #: The robot's offset from the middle of the hallway, positive to the left.
    offset: float
    #: Whether a wall closes the hallway right ahead.
    ends: bool
    #: The seconds that the robot has spent beside the hallway, for example in a room.
    outside: float = 0.0


class Sighting(msgspec.Struct, frozen=True):
    """A landmark seen by the laser, with its estimated distance and its bearing."""

    distance: float
    bearing: float


class PositionFix(msgspec.Struct, frozen=True):
    """A tracked landmark, in the frame of dead reckoning."""

    x: float
    y: float
    #: The direction that its tags face.
    normal: float
    #: Seconds since the last sighting, or since the start of the search.
    age: float
    #: Whether the landmark has been seen.
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
"""The stages: `looking`, `going`, `between`, `closed`, `through`."""

TRAVEL = Channel("travel", bool, "", "whether a movement is at its end", own=True)
SIGHTING = Channel("sighting", Sighting, "m, rad", "a landmark in view", own=True)
SEEN = Channel("seen", tuple[Tag, ...], "rad", "pairs of tags in view", own=True)
PASSED = Channel("passed", Pose, "m, rad", "a doorway that was passed", own=True)
DONE = Channel("done", bool, "", "whether the work is done", own=True)

DRIVE = Channel("drive", Drive, "m/s, rad/s", "to the motors")
CHARGE = Channel("charge", bool, "", "to the charging contacts")
CALL = Channel("call", int, "", "the floor to which the lift is called by radio")
VOICE = Channel("voice", str, "", "words to be spoken")
