"""Both memories driven by the same steps, and read as the same pictures.

In a step an item is called `@` and the sensor name under which it first was seen; so
are the names in a picture, whatever a memory calls its items.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from rapc.base.values import Atom, Fact
from tests.memory.bench import MemoryBench

from .plain import Plain
from .plain_parts import Declared

Operation = tuple[Atom, ...]
"""`introduce sensor class place`, `move item place`, `lose item`, `fix place`,
`expire`, `assert fact...` or `erase prefix...`."""

Values = tuple[tuple[Fact, tuple[Atom, float | None]], ...]
"""Index without the item, value and stamp; no stamp for what became unknown."""

Read = tuple[int, str | None, str | None, Values]
"""A description as a memory shows it: number, name, sensor name, properties."""


@dataclass(frozen=True)
class Described:
    """A description: its item, its sensor name, what is known, and where it stands.

    `stands` numbers the layers of the set from the oldest, and the local model as -1:
    so an empty description that stands in two layers is told from two of them.
    """

    item: str | None
    sensor: str | None
    values: Values
    stands: tuple[int, ...]

    def value(self, *index: Atom) -> Atom | None:
        """The value of one of its properties."""
        return dict(self.values).get(index, (None, None))[0]


@dataclass(frozen=True)
class Pictured:
    """An expectation set: each view as a multiset, put in order; layers as pushed."""

    local: tuple[Described, ...]
    layers: tuple[tuple[Described, ...], ...]
    size: int


@dataclass(frozen=True)
class Picture:
    """All that can be seen of a memory."""

    sets: dict[tuple[str, Atom], Pictured]
    names: dict[str, str]
    facts: dict[Fact, float | None]

    @property
    def sensors(self) -> list[str]:
        """The sensor names within reach, of the items in sets."""
        local = [each.sensor for of in self.sets.values() for each in of.local]
        return sorted(each for each in local if each)


@dataclass
class Told:
    """An event about an item, in the labels of the steps."""

    what: str
    item: str
    sensor: str | None
    kind: str
    place: str
    other: str | None
    score: float | None
    rival: float | None


def sensor_named(step_name: str) -> str:
    """The sensor name of an item: figures of the thesis have numbers, no symbols."""
    return f"n{step_name}" if step_name.isdecimal() else step_name


def step_named(sensor_name: str | None) -> str | None:
    """What steps call the item of a sensor name."""
    if sensor_name and sensor_name[1:].isdecimal() and sensor_name.startswith("n"):
        return sensor_name[1:]
    return sensor_name


@dataclass
class Side(ABC):
    """One of the two memories."""

    declared: Declared
    labels: dict[str, str] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)

    def run(self, time: float, operations: Iterable[Operation]) -> None:
        """Carry out the operations of one batch at a time."""
        self.at(time)
        with self.memory().batch():
            for what, *args in operations:
                self._do(str(what), [self._called(arg) for arg in args])

    def _do(self, what: str, args: Sequence[Atom]) -> None:
        memory = self.memory()
        if what == "introduce":
            sensor, kind, place = args
            sensor_name = sensor_named(str(sensor))
            name = memory.introduce(sensor_name, str(kind), place)
            if name not in self.labels and name != sensor_name:
                self.labels[name] = f"@{sensor}"
                self.names[f"@{sensor}"] = name
        elif what == "move":
            memory.move(str(args[0]), args[1])
        elif what == "lose":
            memory.lose(str(args[0]))
        elif what == "fix":
            memory.fix_cardinality(args[0])
        elif what == "expire":
            memory.expire()
        elif what == "assert":
            memory.assert_fact(*args)
        else:
            memory.erase(*args)

    def _called(self, name: Atom) -> Atom:
        return self.names.get(name, name) if isinstance(name, str) else name

    def label(self, atom: Atom) -> Atom:
        """What a name is called in steps and pictures."""
        return self.labels.get(atom, atom) if isinstance(atom, str) else atom

    def labelled(self, fact: Fact) -> Fact:
        """A fact with labels in place of names."""
        return tuple(self.label(part) for part in fact)

    def picture(self) -> Picture:
        """The memory as it is now."""
        names = {
            label: str(self.label(self.now_called(name)))
            for label, name in self.names.items()
        }
        return Picture(self.sets(), names, self.facts())

    def pictured(self, views: Sequence[Sequence[Read]], size: int) -> Pictured:
        """A set from its views: the local model's part, then layers from the oldest."""
        stands: dict[int, tuple[int, ...]] = {}
        for at, view in enumerate(views, -1):
            for number, *_ in view:
                stands[number] = (*stands.get(number, ()), at)
        seen = [
            tuple(sorted((self._described(each, stands) for each in view), key=repr))
            for view in views
        ]
        return Pictured(seen[0], tuple(seen[1:]), size)

    def _described(self, read: Read, stands: dict[int, tuple[int, ...]]) -> Described:
        number, name, sensor, values = read
        shown = [(self.labelled(i), (self.label(v), at)) for i, (v, at) in values]
        return Described(
            item=None if name is None else str(self.label(name)),
            sensor=step_named(sensor),
            values=tuple(sorted(shown, key=repr)),
            stands=stands[number],
        )

    @abstractmethod
    def memory(self) -> MemoryBench | Plain:
        """The memory itself."""

    @abstractmethod
    def at(self, time: float) -> None:
        """Set the clock."""

    @abstractmethod
    def now_called(self, name: str) -> Atom:
        """The name that now stands for a name."""

    @abstractmethod
    def sets(self) -> dict[tuple[str, Atom], Pictured]:
        """The expectation sets."""

    @abstractmethod
    def facts(self) -> dict[Fact, float | None]:
        """All facts with their stamps."""

    @abstractmethod
    def told(self) -> list[Told]:
        """What was told of items since this was last asked."""
