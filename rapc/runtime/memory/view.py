"""Memory to be read by hosts, functions and solvers."""

from __future__ import annotations

from rapc.base.values import Atom, Fact
from rapc.runtime.arguments import need_atoms
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.memory import EXTERNAL, Memory
from rapc.runtime.memory.store import NEVER
from rapc.world import Time


class MemoryView:
    """Memory to be read: what functions, default functions and solvers are given."""

    def __init__(self, memory: Memory, recorder: Recorder) -> None:
        self._memory = memory
        self._recorder = recorder

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self._recorder.time

    @property
    def place(self) -> Atom | None:
        """The robot's own place: the one last given to `arrive`."""
        return self._memory.place

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """The facts that match, oldest first; None matches anything.

        Defaults are not consulted, and `external` is what is stored as such.
        """
        try:
            return self._memory.facts.matching(self._memory.canonical(pattern))
        except (IndexError, TypeError):
            need_atoms(pattern, "the pattern")
            raise

    def value(self, *index: Atom) -> Atom | None:
        """The asserted value of a property for an index, or None."""
        try:
            fact = self._memory.facts.asserted(self._memory.canonical(index))
        except (IndexError, TypeError):
            need_atoms(index, "the property")
            raise
        return None if fact is None else fact[-1]

    def count(self, kind: str, place: Atom) -> int:
        """Return how many items of a class memory expects at a place [T 2.3.3].

        Of an indistinct class it is the size of its expectation set.
        """
        memory = self._memory
        try:
            here = memory.place if place == EXTERNAL else None
            size = memory.expected_at(
                kind, memory.items.canonical(place if here is None else here)
            )
            if size is not None:
                return size
            known = memory.items.known
            found = [known.get(str(fact[1])) for fact in memory.facts_at(place)]
        except TypeError:
            need_atoms((kind, place), "the count")
            raise
        return sum(1 for item in found if item is not None and item.kind == kind)

    def kind(self, item: Atom) -> str | None:
        """The class under which an item was introduced; None for a plain symbol."""
        found = self._memory.items.known.get(str(self._memory.items.canonical(item)))
        return None if found is None else found.kind

    def spread(self, name: str, *places: int) -> float:
        """Return how many facts of a name share arguments in some places, on average.

        Places count from 1; without any, how many facts of that name there are.
        """
        need_atoms((name, *places), "the facts")
        facts = self._memory.facts.table(name).stamps
        kinds = {tuple([fact[at : at + 1] for at in places]) for fact in facts}
        return len(facts) / len(kinds) if kinds else 0

    def age(self, *fact: Atom) -> Time | None:
        """Time units since a fact was last asserted, or None."""
        try:
            stamp = self._memory.facts.stamp(self._memory.canonical(fact))
        except (IndexError, TypeError):
            need_atoms(fact, "the fact")
            raise
        return None if stamp is None or stamp == NEVER else self.now - stamp
