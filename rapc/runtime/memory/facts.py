"""The facts of memory: stored once, by name; indexed by arguments in queries.

Every index keeps its facts in the order of their last assertion. Therefore the order of
solutions does not depend on the index [L 2.11, 2.13]. Whether a fact may be asserted is
decided in `rapc.runtime.memory.memory`.

`Mentions` finds the facts that mention an item.
`rapc.runtime.memory.recognition.merging` changes these facts when items merge or are
forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any, ClassVar

from rapc.base.values import Atom, Fact
from rapc.library.signature import Signature
from rapc.runtime.fields import LEFT_OUT, Fields, Stamp
from rapc.world import Time

NEVER: Time = float("-inf")
"""The stamp of a fact that was never asserted: older than any other stamp."""

PREFIX = "item-"
"""The prefix of the memory names of items of indistinct classes."""

Bucket = dict[Fact, None]
"""The facts that have one value in one position, oldest assertion first."""


class FactTable:
    """The facts of one name.

    `stamps` holds the time of each fact's last assertion, in the order of these
    assertions. For a property `values` holds the asserted fact by its index: the one
    argument before the value, or the tuple of arguments if there are more or none.
    `length` is the length of all facts, None if the declaration does not state it.
    These dicts stay the same objects for the life of the table.
    """

    FIELDS: ClassVar[Fields] = {
        "is_property": LEFT_OUT,
        "length": LEFT_OUT,
        "stamps": dict[Fact, Stamp],
        "values": LEFT_OUT,
        "spread": LEFT_OUT,
        "_indexes": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, relation: Signature | None) -> None:
        self.is_property = relation is not None and relation.is_property
        arity = None if relation is None else relation.most
        self.length = None if arity is None else arity + 1
        self.stamps: dict[Fact, Time] = {}
        self.values: dict[Any, Fact] = {}
        self.spread: tuple[tuple[int, dict[Atom, Bucket]], ...] = ()
        self._indexes: dict[int, dict[Atom, Bucket]] = {}

    def index(self, at: int) -> dict[Atom, Bucket]:
        """Return the facts by their argument in a position, counted from 1.

        The table builds an index on first use, and updates the index with the facts
        from then on.
        """
        found = self._indexes.get(at)
        if found is None:
            found = self._indexes[at] = {}
            for fact in self.stamps:
                if at < len(fact):
                    found.setdefault(fact[at], {})[fact] = None
            self.spread = tuple(self._indexes.items())
        return found

    def bucket(self, known: list[tuple[int, Atom]]) -> Iterable[Fact]:
        """Return the smallest indexed superset of the facts that match, oldest first.

        `known` has the arguments to match, each with its position. If none of the
        positions has an index, the table builds an index for the first one.
        """
        if not known:
            return self.stamps
        built = [(at, value) for at, value in known if at in self._indexes]
        found = [self.index(at).get(value, {}) for at, value in built or known[:1]]
        return min(found, key=len)

    def add(self, fact: Fact, time: Time) -> Fact | None:
        """Store or refresh a fact; remove and return the replaced fact."""
        stamps, replaced = self.stamps, None
        if fact in stamps:
            del stamps[fact]
            self._leave(fact)
        elif self.is_property:
            index = fact[1] if len(fact) == 3 else fact[1:-1]
            replaced = self.values.get(index)
            if replaced is not None:
                del stamps[replaced]
                self._leave(replaced)
            self.values[index] = fact
        stamps[fact] = time
        for at, buckets in self.spread:
            if at < len(fact):
                bucket = buckets.get(fact[at])
                if bucket is None:
                    buckets[fact[at]] = {fact: None}
                else:
                    bucket[fact] = None
        return replaced

    def remove(self, fact: Fact) -> None:
        """Remove a fact of the table."""
        del self.stamps[fact]
        if self.is_property:
            del self.values[fact[1] if len(fact) == 3 else fact[1:-1]]
        self._leave(fact)

    def _leave(self, fact: Fact) -> None:
        for at, buckets in self.spread:
            if at < len(fact):
                bucket = buckets[fact[at]]
                if len(bucket) == 1:
                    del buckets[fact[at]]
                else:
                    del bucket[fact]

    def take_up(self, stamps: Mapping[Fact, Time]) -> None:
        """Replace the facts, which are in the order of their assertion.

        The dicts stay the same objects: compiled queries have them in hand.
        """
        self.stamps.clear()
        self.stamps.update(stamps)
        self.values.clear()
        if self.is_property:
            for fact in stamps:
                self.values[fact[1] if len(fact) == 3 else fact[1:-1]] = fact
        for at, buckets in self.spread:
            buckets.clear()
            for fact in stamps:
                if at < len(fact):
                    buckets.setdefault(fact[at], {})[fact] = None


class Tables(dict[Atom, FactTable]):
    """The tables of a store by name; a look-up creates a missing table."""

    def __init__(self, relation: Callable[[str], Signature | None]) -> None:
        super().__init__()
        self._relation = relation

    def __missing__(self, name: Atom) -> FactTable:
        found = self[name] = FactTable(self._relation(str(name)))
        return found


class FactStore:
    """Ground facts with time stamps and indexes, a `FactTable` for each name.

    Args:
        relation: the declaration of a name, if there is one.
    """

    FIELDS: ClassVar[Fields] = {"tables": Tables}
    __slots__ = tuple(FIELDS)

    def __init__(self, relation: Callable[[str], Signature | None]) -> None:
        self.tables = Tables(relation)

    def __contains__(self, fact: object) -> bool:
        """Return whether a fact is stored."""
        table = self.tables.get(fact[0])  # type: ignore[index]
        return table is not None and fact in table.stamps

    def __iter__(self) -> Iterator[Fact]:
        """Yield all facts, name by name."""
        for table in self.tables.values():
            yield from table.stamps

    def take_up(self, other: FactStore) -> None:
        """Replace all facts by those of another store."""
        for name, table in self.tables.items():
            if name not in other.tables:
                table.take_up({})
        for name, table in other.tables.items():
            self.table(name).take_up(table.stamps)

    def table(self, name: Atom) -> FactTable:
        """Return the table of a name, which stays the same object."""
        return self.tables[name]

    def stamp(self, fact: Fact) -> Time | None:
        """Return the time of a fact's last assertion, or None."""
        table = self.tables.get(fact[0])
        return None if table is None else table.stamps.get(fact)

    def asserted(self, index: Fact) -> Fact | None:
        """Return the fact of a property with these leading arguments, or None."""
        table = self.tables.get(index[0])
        if table is None:
            return None
        return table.values.get(index[1] if len(index) == 2 else index[1:])

    def starting(self, prefix: Fact) -> list[Fact]:
        """Return the facts that start with a prefix, oldest first."""
        table = self.tables.get(prefix[0])
        if table is None:
            return []
        size = len(prefix)
        if size == table.length:
            return [prefix] if prefix in table.stamps else []
        if table.is_property and size + 1 == table.length:
            fact = table.values.get(prefix[1] if size == 2 else prefix[1:])
            return [] if fact is None else [fact]
        known = [(at, prefix[at]) for at in range(1, size)]
        return [fact for fact in table.bucket(known) if fact[:size] == prefix]

    def matching(self, pattern: tuple[Atom | None, ...]) -> list[Fact]:
        """Return the facts that match a pattern (None: anything), oldest first."""
        table = self.tables.get(pattern[0])  # type: ignore[arg-type]
        if table is None:
            return []
        size = len(pattern)
        known = [(at, v) for at, v in enumerate(pattern) if at and v is not None]
        if len(known) == size - 1:
            return [pattern] if pattern in table.stamps else []  # type: ignore[list-item]
        return [
            fact
            for fact in table.bucket(known)
            if len(fact) == size and all(fact[at] == v for at, v in known)
        ]


@lru_cache(maxsize=4096)
def _is_item(part: Atom) -> bool:
    """Return whether a value is the name of an item of an indistinct class."""
    return isinstance(part, str) and part.startswith(PREFIX)


class Mentions:
    """The facts in memory by the items in their arguments.

    Facts of all names are in one order, that of their last assertion.
    """

    FIELDS: ClassVar[Fields] = {"by_item": dict[str, dict[Fact, None]]}
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: The facts by item, each table in the order of the assertions.
        self.by_item: dict[Atom, dict[Fact, None]] = {}

    def added(self, fact: Fact) -> None:
        """Add an asserted fact as the youngest, also after a repeated assertion."""
        for part in filter(_is_item, fact[1:]):
            known = self.by_item.setdefault(part, {})
            known.pop(fact, None)
            known[fact] = None

    def removed(self, fact: Fact) -> None:
        """Remove a fact that is gone."""
        for part in filter(_is_item, fact[1:]):
            known = self.by_item.get(part, {})
            known.pop(fact, None)
            if not known:
                self.by_item.pop(part, None)

    def of(self, name: str) -> list[Fact]:
        """Return the facts that mention an item, oldest first, each once."""
        return list(self.by_item.get(name, ()))
