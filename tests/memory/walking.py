"""A random walk through what handlers can say of items, checked at each step.

Run as a program it walks by a fixed seed and prints all that came of it.
"""

from __future__ import annotations

import random
from typing import Any

from rapc.base.values import Atom
from tests.memory.bench import MemoryBench

from .sightings import WORDS, bench

TEXT = WORDS + (
    "(declare-indistinct-class drum)(declare-indistinct-class box)"
    "(declare-class-comparator box (veto color) (score size 25))"
)
KINDS = ("drum", "box")
PLACES = ("depot", "bay", "dock")
PROPERTIES = {"color": ("red", "blue"), "size": ("big", "small"), "lid": ("on",)}
Step = tuple[int, int, int]


class Walk:
    """A random walk through what handlers can say, checked after each step."""

    def __init__(self, text: str = TEXT, **how: Any) -> None:
        self.memory: MemoryBench = bench(text, **{"max_layers": 4, **how})
        self.sensors = 0

    def accessible(self) -> list[str]:
        """The items within reach, in a fixed order."""
        return [d.name or "" for s in self.memory.sets() for d in s.local]

    def step(self, step: Step) -> None:
        """Do one thing, chosen by three numbers."""
        what, which, how = step
        memory, near = self.memory, self.accessible()
        memory.time += 1
        if what < 30 or not near:
            kind, place = KINDS[which % 2], PLACES[how % 3]
            self.sensors += 1
            memory.introduce(f"s{self.sensors}", kind, place)
        elif what < 65:
            name = list(PROPERTIES)[which % 3]
            values: tuple[str, ...] = (*PROPERTIES[name], "unknown")
            memory.assert_fact(name, near[how % len(near)], values[which % len(values)])
        elif what < 70:
            memory.erase("color", near[how % len(near)])
        elif what < 80:
            memory.move(near[which % len(near)], PLACES[how % 3])
        elif what < 84:
            memory.lose(near[how % len(near)])
        elif what < 90:
            memory.fix_cardinality(PLACES[how % 3])
        else:
            memory.expire()

    def check(self) -> None:
        """All that must hold now."""
        for each in self.memory.sets():
            sizes = {len(layer) for layer in each.layers}
            assert sizes <= {each.size}
            assert len(each.local) <= each.size
            for view in (each.local, *each.layers):
                numbers = [d.number for d in view]
                assert len(set(numbers)) == len(numbers), "merged within a view"
        self._check_facts()

    def _check_facts(self) -> None:
        """Every description has its facts, and no other item has any."""
        memory = self.memory.memory
        placed: dict[str, tuple[str, Atom]] = {}
        for each in self.memory.sets():
            for view in (each.local, *each.layers):
                for d in view:
                    if d.name is not None:
                        placed[d.name] = (each.kind, each.place)
        for name, (kind, place) in placed.items():
            assert memory.value("location", name) == place
            assert memory.value("class", name, kind) == "true"
        for _, item, where in memory.query("location", None, None):
            assert where == "unknown" or str(item) in placed


def main() -> None:
    """Print the events and sets of a walk of 400 steps."""
    rng = random.Random(7)
    walk = Walk()
    for _ in range(400):
        walk.step((rng.randrange(100), rng.randrange(100), rng.randrange(100)))
    print(walk.memory.events)
    print(walk.memory.sets())


if __name__ == "__main__":
    main()
