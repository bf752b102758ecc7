"""Memory as a plain list of facts, oldest first [L 2, 6].

What formulas ask of it is in `queries`.
"""

from __future__ import annotations

from collections.abc import Callable

from rapc.base.values import Atom, Fact, format_list
from rapc.library.library import Library
from rapc.world import Time

Tell = Callable[[str, str, str], None]
"""Told of each change: the kind of event, the fact as text, who did it."""


class Entry:
    """A fact in memory, when it was last asserted, and who holds it there.

    `asserted`: somebody other than a notation has asserted it. `notes`: the methods
    that note it.
    """

    def __init__(self, fact: Fact, stamp: Time) -> None:
        self.fact = fact
        self.stamp = stamp
        self.asserted = False
        self.notes: list[object] = []


def is_short(library: Library, name: str, count: int) -> bool:
    """Whether so many arguments are one less than a property is declared with.

    One without arguments besides its value has no short form.
    """
    declared = library.properties.get(name)
    if declared is None or declared.args is None or count == 0:
        return False
    return count == len(declared.args) - 1


class Memory:
    """The facts, by last assertion, and the changes that [L 2] allows."""

    def __init__(self, library: Library, clock: Callable[[], Time], tell: Tell) -> None:
        self.library = library
        self.clock = clock
        self.tell = tell
        self.entries: list[Entry] = []

    # --- what handlers and functions see ------------------------------------------

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self.clock()

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """The facts that match, oldest first; None matches anything."""
        return [
            entry.fact
            for entry in self.entries
            if len(entry.fact) == len(pattern)
            and all(
                p is None or p == v for p, v in zip(pattern, entry.fact, strict=True)
            )
        ]

    def value(self, *index: Atom) -> Atom | None:
        """The asserted value of a property for an index, or None."""
        found = self.query(*index, None)
        return found[0][-1] if found else None

    # --- changes ------------------------------------------------------------------

    def whole(self, fact: Fact) -> Fact:
        """A property one argument short of its declaration means value `true`."""
        short = is_short(self.library, str(fact[0]), len(fact) - 1)
        return (*fact, "true") if short else fact

    def assert_fact(self, fact: Fact, by: str) -> None:
        """Assert a fact, on behalf of anyone but a notation."""
        self._put(self.whole(fact), by).asserted = True

    def note(self, fact: Fact, method: object) -> None:
        """Assert a fact for as long as a method runs."""
        entry = self._put(self.whole(fact), "notation")
        if not entry.asserted:
            entry.notes.append(method)

    def unnote(self, fact: Fact, method: object) -> None:
        """A method has ended: a fact that nobody else holds in memory goes."""
        fact = self.whole(fact)
        for entry in list(self.entries):
            if entry.fact == fact and method in entry.notes:
                entry.notes = [m for m in entry.notes if m is not method]
                if not entry.asserted and not entry.notes:
                    self._drop(entry, "notation")

    def erase(self, prefix: Fact, by: str) -> None:
        """Erase every fact that starts so."""
        for entry in list(self.entries):
            if entry.fact[: len(prefix)] == prefix:
                self._drop(entry, by)

    def _put(self, fact: Fact, by: str) -> Entry:
        entry = None
        for other in list(self.entries):
            if other.fact == fact:
                entry = other
                self.entries.remove(other)
            elif fact[0] in self.library.properties and other.fact[:-1] == fact[:-1]:
                self._drop(other, by)
        if entry is None:
            entry = Entry(fact, self.now)
        entry.stamp = self.now
        self.entries.append(entry)
        self.tell("FactAsserted", format_list(fact), by)
        return entry

    def _drop(self, entry: Entry, by: str) -> None:
        self.entries.remove(entry)
        self.tell("FactErased", format_list(entry.fact), by)
