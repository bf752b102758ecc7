"""The facts of memory: stored once, indexed by name and by each argument.

Every index keeps its facts in the order of their last assertion, so whichever index
a query takes, answers come in one order (semantics 2). Whether a fact may be
asserted is for `rapc.runtime.memory.memory` to say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rapc.runtime.world import Time
from rapc.terms import Atom, Fact

NEVER: Time = float("-inf")
"""The stamp of what was never asserted: older than any (semantics 7, moving)."""

Key = tuple[Atom, ...]
"""`(name,)` for all facts of a name, `(name, position, value)` for an argument."""


def keys_of(fact: Fact) -> list[Key]:
    """The keys of all indexes in which a fact stands."""
    name = fact[0]
    keys: list[Key] = [(name,)]
    keys.extend((name, at, fact[at]) for at in range(1, len(fact)))
    return keys


class FactStore:
    """Ground facts with time stamps and indexes.

    `values` holds, for each property with its index (all but the value), the fact
    that is asserted; `buckets` the facts by `Key`; `stamps` the time of each fact's
    last assertion; `serials` a number that grows with each assertion; `places` every
    name and argument position that ever was in use.
    """

    def __init__(self, is_property: Callable[[str], bool]) -> None:
        self.values: dict[Fact, Fact] = {}
        self.buckets: dict[Key, dict[Fact, None]] = {}
        self.stamps: dict[Fact, Time] = {}
        self.serials: dict[Fact, int] = {}
        self.places: dict[tuple[str, int], None] = {}
        self._is_property = is_property
        self._serial = 0

    def add(self, fact: Fact, time: Time) -> Fact | None:
        """Store or refresh a fact; the fact it replaces is removed and returned."""
        replaced = None
        if self._is_property(str(fact[0])):
            old = self.values.get(fact[:-1])
            if old is not None and old != fact:
                self.remove(old)
                replaced = old
            self.values[fact[:-1]] = fact
        self._serial += 1
        buckets = self.buckets
        if fact in self.stamps:
            for key in keys_of(fact):
                bucket = buckets[key]
                del bucket[fact]
                bucket[fact] = None
        else:
            for key in keys_of(fact):
                bucket = buckets.setdefault(key, {})
                bucket[fact] = None
            for at in range(1, len(fact)):
                self.places[str(fact[0]), at] = None
        self.stamps[fact] = time
        self.serials[fact] = self._serial
        return replaced

    def remove(self, fact: Fact) -> None:
        """Remove a fact that is there."""
        for key in keys_of(fact):
            bucket = self.buckets[key]
            del bucket[fact]
            if not bucket:
                del self.buckets[key]
        del self.stamps[fact]
        del self.serials[fact]
        if self.values.get(fact[:-1]) == fact:
            del self.values[fact[:-1]]

    def starting(self, prefix: Fact) -> list[Fact]:
        """The facts that start with a prefix, oldest first."""
        sets = [self.buckets.get(key, {}) for key in keys_of(prefix)]
        size = len(prefix)
        return [fact for fact in min(sets, key=len) if fact[:size] == prefix]

    def mentioning(self, value: Atom) -> list[Fact]:
        """The facts with a value in any argument, oldest first, each once."""
        buckets = self.buckets
        found: dict[Fact, None] = {}
        for name, at in self.places:
            found.update(buckets.get((name, at, value), {}))
        return sorted(found, key=self.serials.__getitem__)

    def matching(self, pattern: tuple[Atom | None, ...]) -> Iterator[Fact]:
        """The facts that match a pattern (None: anything), oldest first."""
        name = str(pattern[0])
        known = [(at, v) for at, v in enumerate(pattern) if at and v is not None]
        sets = [self.buckets.get((name, at, v), {}) for at, v in known]
        smallest = min(sets, key=len) if sets else self.buckets.get((name,), {})
        for fact in list(smallest):
            if len(fact) == len(pattern) and all(fact[at] == v for at, v in known):
                yield fact
