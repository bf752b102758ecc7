"""Functions of the plane, for formulas: angles in radians, lengths in metres."""

from __future__ import annotations

import math

from rapc.base.values import Number, number


def turn_between(memory: object, one: Number, other: Number) -> Number:
    """Return how far it is to turn from one heading to another: from 0 to pi."""
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
    """Return how far a point is from the one that lies ahead of a third.

    Args:
        memory: what is known; it is not asked.
        x: where the way begins.
        y: where the way begins.
        heading: where the way leads.
        distance: how far it leads.
        other_x: where the point is.
        other_y: where the point is.
    """
    away_x = x + distance * math.cos(heading) - other_x
    away_y = y + distance * math.sin(heading) - other_y
    return number(round(math.hypot(away_x, away_y), 3))


def new_x(memory: object, x: Number, heading: Number, distance: Number) -> Number:
    """Return how far to the right a point is that lies ahead of another [S 4.2.1].

    Args:
        memory: what is known; it is not asked.
        x: how far to the right the way begins.
        heading: where the way leads.
        distance: how far it leads.
    """
    return number(round(x + distance * math.cos(heading), 3))


def new_y(memory: object, y: Number, heading: Number, distance: Number) -> Number:
    """Return how far up a point is that lies ahead of another [S 4.2.1].

    Args:
        memory: what is known; it is not asked.
        y: how far up the way begins.
        heading: where the way leads.
        distance: how far it leads.
    """
    return number(round(y + distance * math.sin(heading), 3))


def heading_to(
    memory: object, x: Number, y: Number, other_x: Number, other_y: Number
) -> Number:
    """Return the heading from one point to another.

    Args:
        memory: what is known; it is not asked.
        x: where the way begins.
        y: where the way begins.
        other_x: where it ends.
        other_y: where it ends.
    """
    return number(round(math.atan2(other_y - y, other_x - x), 3))
