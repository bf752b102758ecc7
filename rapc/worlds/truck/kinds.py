"""The kinds of items there are, as data (T B.2): sizes, and what the senses tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import msgspec

Color = Literal["red", "blue", "yellow"]


class Kind(msgspec.Struct, frozen=True):
    """What all items of a class have in common.

    `size` takes up room in arms and bays. `capacity` is in units of a liquid, of
    which a new item is full: `liquid` for a vessel, which may be refilled with
    another, or `rounds` for a weapon. `tool` is the class an arm must hold to
    grasp it. An item of a kind that is `distinct` has one sensor name for life.
    """

    size: int
    capacity: int = 0
    liquid: str | None = None
    rounds: str | None = None
    tool: str | None = None
    distinct: bool = False


ENEMY = "enemy-unit"
"""The class of what cannot be handled, only shot at."""

KINDS: Mapping[str, Kind] = {
    "rock": Kind(size=7),
    "fuel-drum": Kind(size=5, capacity=5, liquid="fuel"),
    "ammo-box": Kind(size=7, capacity=15, liquid="ammo"),
    "gun": Kind(size=10, capacity=15, rounds="ammo", tool="gun-tool", distinct=True),
    "gun-tool": Kind(size=4, distinct=True),
    ENEMY: Kind(size=1000, distinct=True),
}

COLORED = frozenset({"rock"})
"""Classes whose items have a colour."""
