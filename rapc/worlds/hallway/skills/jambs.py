"""Telling by one ring of sonars that the robot stands between the jambs of a doorway.

A doorway is a gap in a wall, so a robot in it has something near on both sides, and
only there: beams that cross the line of a jamb a little before it or behind it go on
into one of the two spaces.

      .      |wall|      .       beams beside the jamb end deep in a space
       `.    +----+    .'
    ahead <-   (robot)           the jambs lie across the way, nothing on it
       .'    +----+    `.
      '      |wall|      `

Who stands farther from the wall finds its face by other means (`doorways`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.worlds.hallway.skills.sonar import Point

WIDTH = (0.55, 1.35)
"""How wide a doorway can be, in metres."""

REACH = 0.5
"""A jamb has an echo no farther ahead of the robot's middle or behind it, in metres."""

SHORT = 1.1
"""From that echo a jamb ends within this, both ahead and behind, in metres."""

DEEP = 0.3
"""A beam that ends so far behind the line of a jamb has not met it, in metres."""

FREE = 1.3
"""Nothing is on the way for so long, in metres,"""

BROAD = 0.2
"""so far to both sides of the robot's middle."""


def between_jambs(echoes: Sequence[Point]) -> tuple[float, float, float] | None:
    """Return the middle between the two jambs beside the robot.

    Args:
        echoes: what the sonars heard, the robot's middle at (0, 0), x along the way
            through the doorway.

    Returns:
        How far ahead and how far to the left it is, and how far apart the jambs are, in
        metres; None if the robot stands in no doorway, or something is on the way.
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
    """Return the echo of a jamb on the left: what is nearest there, if it is short."""
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
