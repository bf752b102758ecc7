"""Recognising by sonar a position between the jambs of a doorway.

A doorway is a gap in a wall. So a robot in a doorway has a near echo on both sides, and
only there: beams that cross the line of a jamb a little before or behind the jamb go on
into one of the two spaces.

      .      |wall|      .       beams beside the jamb end deep in a space
       `.    +----+    .'
    ahead <-   (robot)           the jambs lie across the way, nothing on it
       .'    +----+    `.
      '      |wall|      `

Not here: a robot farther from the wall, see `doorways`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.worlds.hallway.skills.sonar import Point

WIDTH = (0.55, 1.35)
"""The minimum and maximum width of a doorway, in metres."""

REACH = 0.5
"""The maximum distance of a jamb's echo ahead of or behind the middle, in metres."""

SHORT = 1.1
"""The maximum length of a jamb from that echo, ahead and behind, in metres."""

DEEP = 0.3
"""The distance behind the line of a jamb at which a beam missed the jamb, in metres."""

FREE = 1.3
"""The length of the way that must be free, in metres."""

BROAD = 0.2
"""The width of the free way to each side of the robot's middle, in metres."""


def between_jambs(echoes: Sequence[Point]) -> tuple[float, float, float] | None:
    """Return the middle between the two jambs beside the robot.

    Args:
        echoes: the echoes of the sonars, the robot's middle at (0, 0), x along the way
            through the doorway.

    Returns:
        The position of the middle, ahead and to the left, and the distance between the
        jambs, in metres; None if the robot is in no doorway, or the way is not free.
    """
    if any(0 < x < FREE and abs(y) < BROAD for x, y in echoes):
        return None
    left = _jamb(echoes)
    right = _jamb([(x, -y) for x, y in echoes])
    if left is None or right is None:
        return None
    wide = left[1] + right[1]
    if not WIDTH[0] <= wide <= WIDTH[1]:
        return None
    return (left[0] + right[0]) / 2, (left[1] - right[1]) / 2, wide


def _jamb(echoes: Iterable[Point]) -> Point | None:
    """Return the echo of a jamb on the left: the nearest echo, if the jamb is short."""
    aside = [(x, y) for x, y in echoes if y > 0]
    beside = [echo for echo in aside if abs(echo[0]) < REACH]
    if not beside:
        return None
    jamb = min(beside, key=lambda echo: echo[1])
    place, line = jamb
    crossed = [x * line / y - place for x, y in aside if y > line + DEEP]
    ends_ahead = any(0 < far < SHORT for far in crossed)
    ends_behind = any(-SHORT < far < 0 for far in crossed)
    return jamb if ends_ahead and ends_behind else None
