"""The kinds of items there are, as data (T B.2): sizes, and what the senses tell.

Those of T are in `KINDS`; a map may declare more, containers and machines among them
(T 1.4.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

import msgspec

from rapc.base.values import Number

Color = Literal["red", "blue", "yellow"]
Word = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]
"""A name of the map's own: lower-case letters, digits and hyphens."""

Size = Annotated[int, msgspec.Meta(ge=0, le=1_000_000)]


class TruckMachine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What an item of a kind does by itself while it is switched on.

    Every `every` time units it uses up `uses` of the liquid in it and of the items in
    it those that it `needs`, and makes one item of a kind. Without them, or without
    room for what it makes, it switches itself off. If it wants `daylight` it rests in
    the dark. With the option `wear` it may break in a round, and does nothing more then
    until it is mended.
    """

    makes: str
    every: Number
    uses: Size = 0
    needs: Mapping[str, Annotated[int, msgspec.Meta(ge=1, le=1000)]] = {}
    daylight: bool = False


class Kind(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What all items of a class have in common.

    `size` takes up room in arms, bays and containers. `capacity` is in units of a
    liquid, of which a new item is full if `full`: `liquid` for a vessel, which may be
    refilled with another, or `rounds` for a weapon. `holds` is the size of the items
    that it can contain. `tool` is the class an arm must hold to grasp it. An item has
    one sensor name for life, one of an `indistinct` kind a new one at each visit. The
    shuffling demon leaves alone what is `fixed`. With what `mends` machines of some
    classes an arm that holds it makes a broken one whole.
    """

    size: Size
    capacity: Size = 0
    liquid: Word | None = None
    full: bool = True
    rounds: Word | None = None
    holds: Size = 0
    tool: str | None = None
    indistinct: bool = False
    fixed: bool = False
    machine: TruckMachine | None = None
    mends: tuple[str, ...] = ()


ENEMY = "enemy-unit"
"""The class of what can only be shot at."""

KINDS: Mapping[str, Kind] = {
    "rock": Kind(size=7, indistinct=True),
    "fuel-drum": Kind(size=5, capacity=5, liquid="fuel", indistinct=True),
    "ammo-box": Kind(size=7, capacity=15, liquid="ammo", indistinct=True),
    "gun": Kind(size=10, capacity=15, rounds="ammo", tool="gun-tool"),
    "gun-tool": Kind(size=4),
    ENEMY: Kind(size=1000, fixed=True),
}

COLORED = frozenset({"rock"})
"""Classes whose items have a colour."""
