"""The kinds of items, as data (T B.2): sizes, and properties that the robot senses.

The kinds of T are in `KINDS`; a map may declare further kinds, containers and machines
included (T 1.4.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

import msgspec

from rapc.base.values import Number

Color = Literal["red", "blue", "yellow"]
Word = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]
"""A name defined by the map: lower-case letters, digits and hyphens."""

Size = Annotated[int, msgspec.Meta(ge=0, le=1_000_000)]


class TruckMachine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The automatic work of an item while the item is switched on.

    Every `every` time units the machine consumes `uses` units of its liquid and the
    items that it `needs`, and makes one item of a kind. If liquid, items or room are
    missing, the machine switches itself off. With `daylight` the machine rests in the
    dark. With the option `wear` the machine may break in a round; a broken machine does
    not work until an arm mends it.
    """

    makes: str
    every: Number
    uses: Size = 0
    needs: Mapping[str, Annotated[int, msgspec.Meta(ge=1, le=1000)]] = {}
    daylight: bool = False


class Kind(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Properties shared by all items of a class.

    `size` is the room that an item takes in arms, bays and containers. `capacity` is in
    units of a liquid; a new item is full if `full`. `liquid` is the content of a new
    vessel, which may be refilled with a different liquid; `rounds` is that of a weapon.
    `holds` is the total size of the items that a container can hold. `tool` is the
    class of tool that an arm must hold to grasp the item. An item keeps its sensor name
    for life; an `indistinct` item gets a new name at each visit. The shuffling demon
    does not move `fixed` items. `mends` names classes of machines: an arm that holds
    the item mends a broken machine of these classes.
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
"""The class of items that can only be shot at."""

KINDS: Mapping[str, Kind] = {
    "rock": Kind(size=7, indistinct=True),
    "fuel-drum": Kind(size=5, capacity=5, liquid="fuel", indistinct=True),
    "ammo-box": Kind(size=7, capacity=15, liquid="ammo", indistinct=True),
    "gun": Kind(size=10, capacity=15, rounds="ammo", tool="gun-tool"),
    "gun-tool": Kind(size=4),
    ENEMY: Kind(size=1000, fixed=True),
}

COLORED = frozenset({"rock"})
"""Classes of items with a colour."""
