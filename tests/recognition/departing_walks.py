"""Walks in which items leave sets of marked items that nobody can tell apart.

A mark rules out all other marks, so a description stands in as many layers as visits
have seen its mark; the layers need not agree. Then items without a mark come and leave.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

from rapc.base.values import Atom

from .pictures import Operation
from .plain_parts import Comparator, Declared

MARKS = range(7)

MARKED = Declared(
    properties=("class", "location", "mark", "color", "size"),
    indistinct=("drum",),
    comparators={("drum", None): Comparator(veto=("mark",))},
    max_layers=3,
)


class Visits:
    """Two or three visits, then items that leave; `batches` are those of a seed."""

    def __init__(self, seed: int) -> None:
        self._dice = random.Random(seed)
        self._looks: dict[int, list[tuple[str, Atom]]] = {}
        for mark in MARKS:
            color = self._dice.choice(("red", "blue", None))
            size = self._dice.choice((1, 2, None))
            looks = ("color", color), ("size", size)
            self._looks[mark] = [(name, v) for name, v in looks if v is not None]
        self._seen = 0

    def batches(self) -> Iterator[list[Operation]]:
        """The batches of one walk."""
        for _ in range(self._dice.choice((2, 3, 3))):
            yield self._marked(self._dice.choice((2, 3, 3, 4)))
            yield [("expire",)]
        yield self._marked(self._dice.choice((0, 1, 1, 2)))
        known = self._seen
        yield [each for _ in range(self._dice.choice((1, 2))) for each in self._see()]
        for number in range(known + 1, self._seen + 1):
            yield [("move", f"@s{number}", "bay")]
        yield [("fix", "dock")]
        yield [("expire",)]
        yield self._marked(3)

    def _marked(self, count: int) -> list[Operation]:
        marks = self._dice.sample(MARKS, count)
        return [each for mark in marks for each in self._see(mark)]

    def _see(self, mark: int | None = None) -> list[Operation]:
        """An item comes into reach; without a mark it may be any."""
        self._seen += 1
        label = f"@s{self._seen}"
        batch: list[Operation] = [("introduce", label[1:], "drum", "dock")]
        if mark is None:
            mark = self._dice.choice(MARKS)
        else:
            batch.append(("assert", "mark", label, mark))
        for name, value in self._looks[mark]:
            if self._dice.random() < 0.7:
                batch.append(("assert", name, label, value))
        return batch
