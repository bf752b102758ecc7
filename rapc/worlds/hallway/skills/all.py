"""The catalogue of the hallway robot's skills."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rapc.worlds.hallway import channels
from rapc.worlds.hallway.skills.avoiding import (
    DetectObstacles,
    FollowTrajectory,
    LimitSpeed,
    LowestLimit,
)
from rapc.worlds.hallway.skills.doorways import TrackDoorJambs
from rapc.worlds.hallway.skills.halls import TrackHallway
from rapc.worlds.hallway.skills.landmarks import (
    MARK,
    ApproachLandmark,
    TrackLandmark,
    WatchForLandmark,
)
from rapc.worlds.hallway.skills.lossy import (
    RememberCarefully,
    RememberObstacles,
    TrackDoorwayInSilence,
    TrackLandmarkInSilence,
)
from rapc.worlds.hallway.skills.moving import BackOff, FaceDirection, SteerInDirection
from rapc.worlds.hallway.skills.passages import DetectDoorway
from rapc.worlds.hallway.skills.reporting import ReportPosition, WatchBattery
from rapc.worlds.hallway.skills.services import CallLift, Charge, Speak
from rapc.worlds.hallway.skills.tags import SeeTags
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import Compound, Skill

MOVE_IN_DIRECTION = Compound(
    "move-in-direction",
    (DetectObstacles, SteerInDirection, FollowTrajectory),
    SteerInDirection.parameters,
    "Move a distance in a direction, around obstacles",
)

MOVE_TO_LANDMARK = Compound(
    "move-to-landmark",
    (DetectObstacles, TrackLandmark, ApproachLandmark, FollowTrajectory),
    (*MARK, *ApproachLandmark.parameters),
    "Move to a place in front of a visible landmark, around obstacles",
)

MOVE_THRU_DOORWAY = Compound(
    "move-thru-doorway",
    (DetectObstacles, TrackDoorJambs, FollowTrajectory),
    TrackDoorJambs.parameters,
    "Line up with a doorway and move through it",
)

TURN_TO = Compound(
    "turn-to",
    (DetectObstacles, FaceDirection, FollowTrajectory),
    FaceDirection.parameters,
    "Turn on the spot to a direction",
)

SENSORS = (
    channels.SONAR,
    channels.POSE,
    channels.TAGS,
    channels.BATTERY,
    channels.CURRENT,
    channels.LIFT,
)

LOSSY: Mapping[str, Sequence[type[Skill]]] = {
    "slant-50": (RememberObstacles, TrackDoorwayInSilence),
    "slant-30": (RememberCarefully, TrackLandmarkInSilence, TrackDoorwayInSilence),
}
"""The skills for models of sonars that lose echoes, in place of the usual ones."""

ACTUATORS = (channels.DRIVE, channels.CHARGE, channels.CALL, channels.VOICE)


def catalogue(sonar: str = "ideal") -> Catalogue:
    """Return the skills of the robot, checked.

    Args:
        sonar: the model of its sonars. With sonars that lose the echoes of slanted
            walls, `detect-obstacles` has a memory.
    """
    skills = (
        MOVE_IN_DIRECTION,
        MOVE_TO_LANDMARK,
        MOVE_THRU_DOORWAY,
        TURN_TO,
        WatchForLandmark,
        SeeTags,
        DetectObstacles,
        TrackHallway,
        FollowTrajectory,
        LimitSpeed,
        BackOff,
        DetectDoorway,
        ReportPosition,
        WatchBattery,
        Charge,
        CallLift,
        Speak,
    )
    made = Catalogue(skills, SENSORS, ACTUATORS, (LowestLimit(),))
    return made.extended(LOSSY[sonar]) if sonar in LOSSY else made
