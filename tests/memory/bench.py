"""A memory that recognises, without an interpreter or a world.

For tests and measurements:

    bench = MemoryBench(library, comparators={"by-eye": compare}, max_layers=8)
    bench.time = 5                       # stamps of what follows
    with bench.batch():                  # results and data of one primitive
        name = bench.introduce("s-1", "box", "bay")
        bench.assert_fact("color", name, "red")
        bench.fix_cardinality("bay")     # takes effect at the end of the batch
    bench.move(name, "dock")             # outside a batch: one of its own
    bench.sets()                         # tuple of SetView
    bench.events                         # list of events, item-merged among them
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import msgspec

from rapc.base.values import Atom, Fact
from rapc.events import Event
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.access import MemoryAccess, MemoryView
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.memory import Memory
from rapc.runtime.memory.recognition.recognizer import MAX_LAYERS
from rapc.runtime.memory.recognition.scoring import Comparator
from rapc.runtime.memory.recognition.sets import Description, ExpectationSet
from rapc.world import Time


class DescriptionView(msgspec.Struct, frozen=True):
    """One description as it stands in a view of a set.

    `name` is None for an empty description. `number` tells descriptions apart, empty
    ones too: one that stands in several views has one number; the older, the smaller.
    `sensor` is None out of reach. `properties` maps a property's index without the
    item (`("contains", "papers")`, `("color",)`) to its value and stamp, without
    location and introducing class; the stamp is None for what became unknown.
    """

    name: str | None
    number: int
    sensor: str | None
    properties: Mapping[Fact, tuple[Atom, Time | None]]


class SetView(msgspec.Struct, frozen=True):
    """An expectation set: the local model's part, and the layers, oldest first."""

    kind: str
    place: Atom
    size: int
    local: tuple[DescriptionView, ...]
    layers: tuple[tuple[DescriptionView, ...], ...]


class MemoryBench:
    """A memory to be driven by hand. What is done outside a batch is one of its own.

    Args:
        library: a linked library; only its declarations matter.
        comparators: comparators in Python by the names that the library uses.
        max_layers: how many layers a set keeps.
        record: whether `events` are kept.

    `time` is the stamp of what comes; `memory` is to be read, `parts` to be saved.
    """

    def __init__(
        self,
        library: Library,
        comparators: Mapping[str, Comparator] | None = None,
        max_layers: int = MAX_LAYERS,
        record: bool = True,
    ) -> None:
        self.events: list[Event] = []
        self.library = library
        self.recorder = Recorder()
        if record:
            self.recorder.listen(self.events.append)
        self.access = access = MemoryAccess(
            library,
            Signatures.of(library),
            self.recorder,
            comparators or {},
            max_layers,
        )
        access.observe()
        self._memory: Memory = access.memory
        self._recognizer = access.recognizer
        self.memory: MemoryView = access

    @property
    def time(self) -> Time:
        """The time now."""
        return self.recorder.time

    @time.setter
    def time(self, now: Time) -> None:
        """Move the clock on."""
        self.recorder.time = now

    @contextmanager
    def batch(self) -> Iterator[None]:
        """What belongs together; in a batch, another is a part of it."""
        with self.access.batch():
            yield

    def introduce(self, sensor: str, kind: str, place: Atom) -> str:
        """An item is seen: returns its memory name."""
        with self.batch():
            name = self.access.introduce(sensor, kind, place)
        return self.name(name)

    def move(self, item: str, place: Atom) -> None:
        """An item now is at a place."""
        with self.batch():
            self.access.move(item, place)

    def lose(self, item: str) -> None:
        """An item is not where it was."""
        with self.batch():
            self.access.lose(item)

    def fix_cardinality(self, place: Atom) -> None:
        """All accessible items at a place have been introduced."""
        with self.batch():
            self.access.fix_cardinality(place)

    def expire(self) -> None:
        """All sensor names go."""
        with self.batch():
            self.access.expire()

    def arrive(self, place: Atom) -> None:
        """The robot is at a place."""
        with self.batch():
            self.access.arrive(place)

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now."""
        with self.batch():
            self.access.assert_fact(*fact)

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so."""
        with self.batch():
            self.access.erase(*prefix)

    def name(self, name: str) -> str:
        """The name that now stands for a name."""
        return str(self._memory.items.canonical(name))

    def count(self, kind: str, place: Atom) -> int:
        """The size of the expectation set of an indistinct class at a place."""
        return self._memory.expected_at(kind, place) or 0

    def sets(self) -> tuple[SetView, ...]:
        """All expectation sets, by class and place as text."""
        found = [self._set(each) for each in self._recognizer.sets.values()]
        return tuple(sorted(found, key=lambda s: (s.kind, str(s.place))))

    def _set(self, of: ExpectationSet) -> SetView:
        return SetView(
            kind=of.kind,
            place=of.place,
            size=of.size,
            local=tuple(self._description(d) for d in of.local.members),
            layers=tuple(
                tuple(self._description(d) for d in layer.members)
                for layer in of.layers
            ),
        )

    def _description(self, of: Description) -> DescriptionView:
        properties: dict[Fact, tuple[Atom, Time | None]] = {}
        for index, value in of.values.items():
            stamp = self._memory.facts.stamp((index[0], of.name, *index[1:], value))
            properties[index] = (value, None if stamp == NEVER else stamp)
        return DescriptionView(
            name=of.name or None,
            number=of.number,
            sensor=of.sensor if of.accessible else None,
            properties=properties,
        )
