"""The items that handlers have introduced, and which of them can be sensed now.

Items of distinct classes keep one name and one sensor name for life (semantics 7);
recognising the others is not done here. A name that no handler introduced is a plain
symbol: it is its own sensor name.
"""

from __future__ import annotations


class Item:
    """One introduced item: its sensor name, introducing class, and reach."""

    __slots__ = ("accessible", "kind", "name", "sensor")

    def __init__(self, name: str, sensor: str, kind: str) -> None:
        self.name = name
        self.sensor = sensor
        self.kind = kind
        self.accessible = True


class Items:
    """All introduced items by memory name, in the order of introduction."""

    def __init__(self) -> None:
        self.known: dict[str, Item] = {}
        self._by_sensor: dict[str, Item] = {}

    def introduce(self, sensor: str, kind: str) -> tuple[Item, bool]:
        """The item seen under a sensor name, and whether it is seen anew.

        It is accessible from now; it is news if it was not accessible before.
        """
        item = self._by_sensor.get(sensor)
        if item is None:
            item = Item(sensor, sensor, kind)
            self.known[item.name] = item
            self._by_sensor[sensor] = item
            return item, True
        news = not item.accessible
        if news:
            item.accessible = True
            self.known[item.name] = self.known.pop(item.name)
        return item, news

    def expire(self) -> bool:
        """Put all items out of reach; whether any was within it."""
        changed = False
        for item in self.known.values():
            changed = changed or item.accessible
            item.accessible = False
        return changed

    def accessible(self) -> list[str]:
        """The items within reach, in the order in which they came into it."""
        return [item.name for item in self.known.values() if item.accessible]

    def is_accessible(self, name: object) -> bool:
        """Whether a name has a sensor name now."""
        item = self.known.get(name) if isinstance(name, str) else None
        return item is None or item.accessible

    def sensor_of(self, name: str) -> str | None:
        """The sensor name of an item, or None out of reach; of a symbol, itself."""
        item = self.known.get(name)
        if item is None:
            return name
        return item.sensor if item.accessible else None

    def name_of(self, sensor: str) -> str:
        """The memory name of a sensor name; an unknown one is returned as it is."""
        item = self._by_sensor.get(sensor)
        return item.name if item is not None else sensor
