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
