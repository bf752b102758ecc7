"""Random walks through a small world of boxes, drums and guns.

A walk knows what is in reach and nothing more: things are seen anew, go and change
unseen, and containers are forgotten with what is in them. Every other walk stays in
one crowded place and looks at another property at each visit, so that layers gather.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

from rapc.base.values import Atom

from .pictures import Operation
from .plain_parts import Comparator, Declared, Known

MOST = 3
"""So many items of a class are in reach at one place."""

PLACES = ("dock", "depot", "bay")
VALUES: dict[str, tuple[Atom, ...]] = {
    "color": ("red", "blue", "unknown"),
    "size": (1, 2),
    "is-empty": ("true", "false"),
}


def _alike(one: Known, other: Known) -> float:
    """Score by the share of what is known of both; two unknown ones match best."""
    known = {*one.items(), *other.items()}
    shared = one.items() & other.items()
    return 4 + 10 * len(shared) / len(known) if known else 14


WORLD = Declared(
    properties=("class", "location", "color", "size", "is-empty", "contains"),
    indistinct=("drum", "box"),
    excludes=(("is-empty", "true", "contains", "true"),),
    comparators={
        ("drum", "depot"): Comparator(veto=("color",), weights={"size": 30}),
        ("drum", "bay"): Comparator(function=_alike),
        ("box", None): Comparator(veto=("size",), ignored=("is-empty",)),
    },
    max_layers=3,
)

Step = tuple[int, list[Operation]]


class Walk:
    """A walk: batches of operations with the time at which they happen.

    `reach` holds the items in reach as their labels with class and place. Whoever
    walks puts into `expected` the items that are in sets, so that some of those out of
    reach can be missed.
    """

    def __init__(self, seed: int) -> None:
        self._dice = random.Random(seed)
        self._crowded = {1: "dock", 3: "depot"}.get(seed % 4)
        self._focus = "color"
        self._time = 0
        self._seen = 0
        self.expected: list[str] = []
        self.reach: dict[str, tuple[str, Atom]] = {}
        self.known: list[str] = []
        self.boxes: list[str] = []

    def steps(self, count: int) -> Iterator[Step]:
        """So many batches of one to four operations."""
        for _ in range(count):
            self._time += self._dice.choice((0, 1, 1, 5))
            if self._crowded and self._dice.random() < 0.25:
                yield self._time, self._visit()
                continue
            if self.expected and self._dice.random() < 0.04:
                yield self._time, self._miss()
                continue
            size = self._dice.choice((1, 1, 1, 2, 3, 4))
            batch = [each for _ in range(size) for each in self._operation()]
            yield self._time, batch

    def _visit(self) -> list[Operation]:
        """Away and back again: some drums are seen at once, and looked at one way."""
        self._focus = self._dice.choice(("color", "size", "is-empty"))
        seen = [self._introduce() for _ in range(self._dice.randrange(1, MOST + 1))]
        looked = [self._assert() for _ in range(self._dice.randrange(MOST))]
        return [each for some in (self._expire(), *seen, *looked) for each in some]

    def _miss(self) -> list[Operation]:
        """An item, most likely out of reach, is not where it was."""
        item = self._dice.choice(self.expected)
        self.reach.clear()
        return [("lose", item), ("expire",)]

    def _operation(self) -> list[Operation]:
        dice = self._dice
        kinds: tuple[Callable[[], list[Operation]], ...]
        kinds = (self._introduce, self._assert, self._erase, self._move, self._lose)
        kinds = (*kinds, self._fix, self._expire, self._again)
        what = dice.choices(kinds, (8, 9, 1, 2, 1, 1, 2, 1))
        return what[0]()

    def _introduce(self) -> list[Operation]:
        dice = self._dice
        kind = dice.choice(("drum", "drum", "box", "gun"))
        kind = "drum" if self._crowded else kind
        place = self._somewhere(kind)
        if kind == "gun":
            sensor = f"g{dice.randrange(3)}"
            return [("introduce", sensor, kind, place)]
        if list(self.reach.values()).count((kind, place)) >= MOST:
            return []
        self._seen += 1
        label = f"@s{self._seen}"
        self.reach[label] = (kind, place)
        self.known.append(label)
        if kind == "box":
            self.boxes.append(label)
        return [("introduce", label[1:], kind, place)]

    def _again(self) -> list[Operation]:
        """An item in reach is seen again, at times in another place."""
        item = self._one_in_reach()
        if item is None:
            return []
        if self._dice.random() < 0.5:
            self._move_to(item)
        return [("introduce", item[1:], *self.reach[item])]

    def _somewhere(self, kind: str = "") -> Atom:
        """A place; for a drum, at times, in a box that was seen lately."""
        boxes = self.boxes[-3:] if kind == "drum" else []
        if self._crowded:
            return self._crowded if self._dice.random() < 0.85 else "bay"
        return self._dice.choice((*PLACES, *PLACES, *boxes))

    def _anything(self) -> str | None:
        """An item, in reach or not, or a gun or a plain symbol at times."""
        dice = self._dice
        if self.reach and dice.random() < 0.85:
            return dice.choice(list(self.reach))
        if self.known and dice.random() < 0.7:
            return dice.choice(self.known[-8:])
        return dice.choice(("tower", None))

    def _assert(self) -> list[Operation]:
        dice, item = self._dice, self._anything()
        if item is None:
            return []
        name = dice.choice(("color", "color", "size", "is-empty", "contains", "near"))
        name = self._focus if self._crowded and dice.random() < 0.9 else name
        if name == "contains":
            inside = dice.choice(("bars", "papers", self._anything() or "bars"))
            return [("assert", name, item, inside, dice.choice(("true", "false")))]
        if name == "near":
            return [("assert", name, "tower", item)]
        return [("assert", name, item, dice.choice(VALUES[name]))]

    def _erase(self) -> list[Operation]:
        item = self._anything()
        return (
            []
            if item is None
            else [("erase", self._dice.choice(("color", "size", "contains")), item)]
        )

    def _one_in_reach(self) -> str | None:
        return self._dice.choice(list(self.reach)) if self.reach else None

    def _move(self) -> list[Operation]:
        item = self._one_in_reach()
        if item is None:
            return []
        self._move_to(item)
        return [("move", item, self.reach[item][1])]

    def _move_to(self, item: str) -> None:
        """Choose where an item is moved to, if there still is room for it."""
        kind, _ = self.reach[item]
        there = (kind, self._somewhere(kind))
        if list(self.reach.values()).count(there) < MOST:
            self.reach[item] = there

    def _lose(self) -> list[Operation]:
        item = self._one_in_reach()
        if item is None:
            return []
        del self.reach[item]
        return [("lose", item)]

    def _fix(self) -> list[Operation]:
        return [("fix", self._somewhere("drum"))]

    def _expire(self) -> list[Operation]:
        self.reach.clear()
        return [("expire",)]
