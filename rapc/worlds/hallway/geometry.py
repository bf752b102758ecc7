"""Functions of the plane, for formulas: angles in radians, lengths in metres."""

from __future__ import annotations

import math

from rapc.base.values import Number, number


def turn_between(memory: object, one: Number, other: Number) -> Number:
    """Return the angle between two headings: from 0 to pi."""
    return number(round(abs(math.remainder(one - other, math.tau)), 3))


def far_from(
    memory: object,
    x: Number,
    y: Number,
    heading: Number,
    distance: Number,
    other_x: Number,
    other_y: Number,
) -> Number:
    """Return the distance between a point and the end of a way.

    Args:
        memory: unused.
        x: the start of the way.
        y: the start of the way.
        heading: the heading of the way.
        distance: the length of the way.
        other_x: the point.
        other_y: the point.
    """
    away_x = x + distance * math.cos(heading) - other_x
    away_y = y + distance * math.sin(heading) - other_y
    return number(round(math.hypot(away_x, away_y), 3))


def new_x(memory: object, x: Number, heading: Number, distance: Number) -> Number:
    """Return the x coordinate of the end of a way [S 4.2.1].

    Args:
        memory: unused.
        x: the x coordinate of the start.
        heading: the heading of the way.
        distance: the length of the way.
    """
    return number(round(x + distance * math.cos(heading), 3))


def new_y(memory: object, y: Number, heading: Number, distance: Number) -> Number:
    """Return the y coordinate of the end of a way [S 4.2.1].

    Args:
        memory: unused.
        y: the y coordinate of the start.
        heading: the heading of the way.
        distance: the length of the way.
    """
    return number(round(y + distance * math.sin(heading), 3))


def heading_to(
    memory: object, x: Number, y: Number, other_x: Number, other_y: Number
) -> Number:
    """Return the heading from one point to another.

    Args:
        memory: unused.
        x: the start.
        y: the start.
        other_x: the end.
        other_y: the end.
    """
    return number(round(math.atan2(other_y - y, other_x - x), 3))
