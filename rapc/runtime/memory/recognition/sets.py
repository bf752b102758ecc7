"""Descriptions of items, and the expectation sets and views that contain them.

Structure only [T 2.3.1, 2.3.3]. Not here: comparison (`scoring`, `matching`), departure
(`departure`), and changes of facts (`merging`).
"""

from __future__ import annotations

from typing import Any, ClassVar

from rapc.base.values import Atom, Fact
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.memory.items import Item

UNKNOWN = "unknown"

Key = tuple[frozenset[tuple[Fact, Atom]], str | None]
"""The common part of identical descriptions: known properties and the sensor name."""


class Description(Item):
    """A description of an item of an indistinct class.

    `number` orders descriptions by age. `values` maps the index of a property without
    the item (`("color",)`, `("contains", "papers")`) to its value, without location and
    introducing class. An empty description has the name "". `mask` has a bit for each
    view of the set `home` that contains the description.
    """

    FIELDS: ClassVar[Fields] = {
        **Item.FIELDS,
        "number": Natural,
        "values": dict[Fact, Atom],
        "mask": LEFT_OUT,
        "home": LEFT_OUT,
        "_known": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS.keys() - Item.FIELDS.keys())

    def __init__(self, number: int, name: str, sensor: str, kind: str) -> None:
        super().__init__(name, sensor, kind)
        self.number = number
        self.accessible = bool(sensor)
        self.values: dict[Fact, Atom] = {}
        self.mask = 0
        self.home: ExpectationSet | None = None
        self._known: frozenset[tuple[Fact, Atom]] | None = None

    @property
    def empty(self) -> bool:
        """Return whether the description is empty: without properties and a name."""
        return not self.name

    def learn(self, index: Fact, value: Atom | None) -> None:
        """Set or remove the value of a property."""
        if value is None:
            self.values.pop(index, None)
        else:
            self.values[index] = value
        self._known = None

    @property
    def known(self) -> frozenset[tuple[Fact, Atom]]:
        """Return the properties with known values."""
        if self._known is None:
            self._known = frozenset(
                (index, v) for index, v in self.values.items() if v != UNKNOWN
            )
        return self._known

    @property
    def key(self) -> Key:
        """Return the part that identical descriptions share."""
        return (self.known, self.sensor if self.accessible else None)


class View:
    """A layer of an expectation set, or its part of the local model."""

    FIELDS: ClassVar[Fields] = {
        "bit": LEFT_OUT,
        "serial": Natural,
        "members": dict[Description, None],
        "version": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, bit: int, serial: int = 0) -> None:
        #: The bit of this view among the views of its set.
        self.bit = bit
        #: For a layer, its number among all layers of all sets; older layers are lower.
        self.serial = serial
        #: The descriptions of the view, in the order in which they came.
        self.members: dict[Description, None] = {}
        #: A version that increases when a member comes, goes, or changes in its known
        #: properties or in its other views.
        self.version = 0

    def __len__(self) -> int:
        return len(self.members)


class ExpectationSet:
    """The expected items of a class at a place.

    All layers hold equally many descriptions, and the local model at most as many.
    """

    FIELDS: ClassVar[Fields] = {
        "kind": str,
        "place": Atom,
        "local": View,
        "layers": list[View],
        "settled": LEFT_OUT,
        "candidates": LEFT_OUT,
        "seekers": LEFT_OUT,
        "_changes": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, kind: str, place: Atom) -> None:
        self.kind = kind
        self.place = place
        #: The accessible descriptions.
        self.local = View(1)
        #: The layers, oldest first.
        self.layers: list[View] = []
        #: The pairs of views that were found without a match, with their versions.
        self.settled: dict[tuple[int, int], tuple[int, int, bool]] = {}
        #: The candidates of views at the last search, with a version.
        self.candidates: dict[tuple[int, int], tuple[int, Any]] = {}
        #: The descriptions of views that sought a match at that search, with a version.
        self.seekers: dict[tuple[int, int], tuple[int, Any]] = {}
        self._changes = 0

    def settle(self) -> None:
        """Compute the bits of the views, and the views of each description."""
        for at, view in enumerate((self.local, *self.layers)):
            view.bit = 1 << at
            for member in view.members:
                member.mask |= view.bit
                member.home = self

    def changed(self, mask: int) -> None:
        """Raise the version of each view whose bit is in `mask`."""
        self._changes += 1
        for view in (self.local, *self.layers):
            if view.bit & mask:
                view.version = self._changes

    @property
    def size(self) -> int:
        """Return how many items are expected."""
        return len(self.layers[0]) if self.layers else len(self.local)

    def views(self) -> list[View]:
        """Return the views in matching order: local model, then latest to earliest."""
        return [self.local, *reversed(self.layers)]

    def members(self) -> list[Description]:
        """Return every description of a view once, oldest first."""
        found = dict.fromkeys(d for view in self.views() for d in view.members)
        return sorted(found, key=lambda d: d.number)

    def new_layer(self, serial: int) -> View:
        """Add and return a layer, in the order of the `serial` numbers."""
        taken = sum(layer.bit for layer in self.layers) | 1
        bit = (taken + 1) & ~taken
        layer = View(bit, serial)
        self.layers.append(layer)
        self.layers.sort(key=lambda layer: layer.serial)
        self._changes += 1
        layer.version = self._changes
        return layer

    def add(self, view: View, member: Description) -> None:
        """Add a description to a view."""
        view.members[member] = None
        member.mask |= view.bit
        member.home = self
        self.changed(member.mask)

    def discard(self, view: View, member: Description) -> None:
        """Remove a description from a view."""
        if member not in view.members:
            return
        del view.members[member]
        self.changed(member.mask)
        member.mask &= ~view.bit
        if not member.mask:
            member.home = None

    def replace(self, old: Description, new: Description) -> None:
        """Replace a description by another one in all of its views."""
        for view in self.views():
            if old.mask & view.bit:
                view.members = {
                    (new if member is old else member): None for member in view.members
                }
        new.mask |= old.mask
        new.home = self
        self.changed(new.mask)
        old.mask = 0
        old.home = None

    def drop_layer(self, layer: View) -> list[Description]:
        """Remove a layer; return the descriptions left in no view, oldest first."""
        members = sorted(layer.members, key=lambda d: d.number)
        for member in members:
            self.discard(layer, member)
        self.layers.remove(layer)
        return [member for member in members if not member.mask]
