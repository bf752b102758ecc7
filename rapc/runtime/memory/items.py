"""The items that handlers have introduced, with their sensor names.

Items of distinct classes keep one name and one sensor name for life [T 2.3.2].
`rapc.runtime.memory.recognition` sets and removes the names of the other items. A name
that no handler introduced is a plain symbol: it is its own sensor name.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from rapc.base.values import Atom, Fact
from rapc.runtime.fields import LEFT_OUT, Fields


class Item:
    """One introduced item: its sensor name, introducing class, and reach."""

    FIELDS: ClassVar[Fields] = {
        "name": str,
        "sensor": str,
        "kind": str,
        "accessible": bool,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, name: str, sensor: str, kind: str) -> None:
        self.name = name
        self.sensor = sensor
        self.kind = kind
        self.accessible = True


ItemsByName = Annotated[dict[str, Item], "saved as names"]
"""Items that are known, by name or sensor name."""


class Items:
    """All introduced items by memory name, in the order of introduction.

    `aliases` maps every name that a merge has removed to the older name that was kept;
    `gone` holds the names of items that memory has forgotten.
    """

    FIELDS: ClassVar[Fields] = {
        "known": dict[str, Item],
        "aliases": dict[str, str],
        "renamings": LEFT_OUT,
        "gone": set[str],
        "by_sensor": ItemsByName,
        "reach": ItemsByName,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        self.known: dict[str, Item] = {}
        self.aliases: dict[str, str] = {}
        #: How often names have been replaced by others, or were loaded.
        self.renamings = 0
        self.gone: set[str] = set()
        self.by_sensor: dict[str, Item] = {}
        #: The accessible items, in the order in which they came into reach.
        self.reach: dict[str, Item] = {}

    def take_up(self, other: Items) -> None:
        """Replace all items and names by those of another table."""
        self.known, self.gone = other.known, other.gone
        self.by_sensor, self.reach = other.by_sensor, other.reach
        self.renamings += 1
        self.aliases.clear()
        self.aliases.update(other.aliases)

    def introduce(self, sensor: str, kind: str) -> tuple[Item, bool]:
        """Return the distinct item of a sensor name, and whether its access is new.

        The item is accessible from now on.
        """
        item = self.by_sensor.get(sensor)
        if item is None:
            item = Item(sensor, sensor, kind)
            self.enter(item)
            return item, True
        news = not item.accessible
        if news:
            item.accessible = True
            self.reach[item.name] = item
        return item, news

    def enter(self, item: Item) -> None:
        """Add a new item, within reach if accessible."""
        self.known[item.name] = item
        if item.accessible:
            self.by_sensor[item.sensor] = item
            self.reach[item.name] = item

    def put_out_of_reach(self, item: Item, keep_sensor: bool = True) -> None:
        """Remove an item from reach; its sensor name may go for good."""
        item.accessible = False
        self.reach.pop(item.name, None)
        if not keep_sensor:
            self.by_sensor.pop(item.sensor, None)
            item.sensor = ""

    def expire(self) -> list[Item]:
        """Remove all items from reach; return those that were within reach."""
        found = list(self.reach.values())
        for item in found:
            item.accessible = False
        self.reach.clear()
        return found

    def drop_sensor(self, item: Item) -> None:
        """Drop a sensor name that will refer to another item from now on."""
        self.by_sensor.pop(item.sensor, None)
        item.sensor = ""

    def merge(self, kept: Item, lost: Item) -> None:
        """Merge `lost` into `kept`, which is within reach if either was."""
        del self.known[lost.name]
        self.aliases[lost.name] = kept.name
        self.renamings += 1
        if lost.accessible:
            kept.sensor, kept.accessible = lost.sensor, True
            self.by_sensor[kept.sensor] = kept
            reach = self.reach.items()
            self.reach = {
                kept.name if name == lost.name else name: kept if item is lost else item
                for name, item in reach
            }

    def forget(self, item: Item) -> None:
        """Remove an item with all of its names."""
        self.put_out_of_reach(item, keep_sensor=False)
        del self.known[item.name]
        self.gone.add(item.name)

    def canonical(self, name: Atom) -> Atom:
        """Return the current name of an item, following merges; else `name` itself."""
        aliases = self.aliases
        if type(name) is not str or name not in aliases:
            return name
        passed = []
        while name in aliases:
            passed.append(name)
            name = aliases[name]
        for alias in passed:
            aliases[alias] = name
        return name

    def accessible(self) -> list[str]:
        """Return the items within reach, in the order in which they came into reach."""
        return list(self.reach)

    def is_accessible(self, name: object) -> bool:
        """Return whether a name has a sensor name now."""
        if not isinstance(name, str):
            return True
        item = self.known.get(name)
        return name not in self.gone if item is None else item.accessible

    def sensor_of(self, name: str) -> str | None:
        """Return an item's sensor name, or None out of reach; a symbol is its own."""
        item = self.known.get(name)
        if item is None:
            return None if name in self.gone else name
        return item.sensor if item.accessible else None

    def sensed(self, request: Fact) -> Fact | None:
        """Return a request, or a skill, with sensor names; None if an item has none."""
        sensor_of = self.sensor_of
        names = [sensor_of(p) if isinstance(p, str) else p for p in request[1:]]
        return None if None in names else (request[0], *names)  # type: ignore[arg-type]

    def named(self, content: Fact) -> Fact:
        """Return a datum, or a signal, with memory names for known sensor names."""
        name_of = self.name_of
        name, *parts = content
        return (name, *[name_of(p) if isinstance(p, str) else p for p in parts])

    def name_of(self, sensor: str) -> str:
        """Return the memory name of `sensor`, or `sensor` itself if unknown."""
        item = self.by_sensor.get(sensor)
        return item.name if item is not None else sensor
