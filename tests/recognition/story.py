"""A few words in which the examples of T 2.3 can be told to either memory."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from rapc.base.values import Atom

from .pictures import Described, Operation, Pictured, Side
from .plain_parts import Comparator, Declared

DEPOT = Declared(
    properties=(
        "class",
        "location",
        "color",
        "size",
        "mark",
        "content",
        "is-empty",
        "contains",
    ),
    indistinct=("drum", "box"),
    excludes=(("is-empty", "true", "contains", "true"),),
    comparators={
        ("box", "warehouse"): Comparator(ignored=("is-empty",)),
        ("drum", "paint-shop"): Comparator(veto=("color",)),
    },
)

Looked = Mapping[str, Atom]
"""Properties of an item that are looked at."""

Seen = Mapping[str, Looked]
"""What is seen: sensor names, each with what is looked at."""

Match = tuple[str, str | None, float | None, float | None]
"""A merge: the item, the name that went, the score and that of the best rival."""


class Story:
    """One memory, the class most items are of, and a clock that each step moves."""

    def __init__(self, side: Side, kind: str) -> None:
        self.side = side
        self._kind = kind
        self._time = 0

    def see(self, place: Atom, seen: Seen, kind: str | None = None) -> list[Match]:
        """Items come into view, and are looked at; what that merges."""
        batch: list[Operation] = []
        for sensor, properties in seen.items():
            batch.append(("introduce", sensor, kind or self._kind, place))
            for name, value in properties.items():
                batch.append(("assert", name, f"@{sensor}", value))
        return self.do(*batch)

    def look(self, sensor: str, *fact: Atom) -> list[Match]:
        """One property of an item is looked at; what that merges."""
        return self.do(("assert", fact[0], f"@{sensor}", *fact[1:]))

    def leave(self) -> list[Match]:
        """The robot goes away; what that merges."""
        return self.do(("expire",))

    def do(self, *batch: Operation) -> list[Match]:
        """Any batch; what it merges."""
        self._time += 1
        self.side.run(self._time, batch)
        return [
            (each.item, each.other, each.score, each.rival)
            for each in self.side.told()
            if each.what == "merged"
        ]

    def set(self, place: Atom) -> Pictured:
        """The expectation set at a place."""
        return self.side.picture().sets[self._kind, place]

    def values(self, item: str) -> dict[str, Atom]:
        """What memory holds of an item, without class and place."""
        picture = self.side.picture()
        return {
            " ".join(map(str, (fact[0], *fact[2:-1]))): fact[-1]
            for fact in picture.facts
            if fact[1] == picture.names[item] and fact[0] not in ("class", "location")
        }

    def name(self, item: str) -> str:
        """Who an item has turned out to be."""
        return self.side.picture().names[item]


def items(view: tuple[Described, ...]) -> set[str | None]:
    """Who stands in a view."""
    return {each.item for each in view}


def tally(view: tuple[Described, ...], *properties: str) -> Counter[tuple[Atom, ...]]:
    """How many of a view have which values, `?` for none."""
    return Counter(
        tuple(each.value(name) or "?" for name in properties) for each in view
    )
