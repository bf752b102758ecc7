"""The RAP memory: the facts that the robot believes, and observers of their changes.

Inside the house memory has two verbs, `store` and `remove`. Whether a fact may be
stored is asked before: by `rapc.runtime.memory.gate` for handlers and hosts, by
`Memory.checked` for notations. Facts carry the time of their assertion [T 2.2, A.3].

Not here: queries (`rapc.compiler.query`), which facts exclude each other
(`exclusions`), who may change what (`gate`), what items are (`items`, `recognition`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final, Protocol

from rapc.base.values import Atom, Fact
from rapc.events import FactAsserted, FactErased
from rapc.ir import nodes
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.checking import full_form
from rapc.runtime.memory.exclusions import Exclusions
from rapc.runtime.memory.items import Items
from rapc.runtime.memory.mentions import Mentions
from rapc.runtime.memory.notations import Notation, Notations
from rapc.runtime.memory.store import FactStore
from rapc.world import Time

EXTERNAL = "external"
"""The place outside the robot, wherever it is."""

STORED: Final = "stored"
"""A fact was asserted, refreshed, or got another stamp."""

REPLACED: Final = "replaced"
"""A property's fact went because another value of it is being stored."""

REMOVED: Final = "removed"
"""A fact went."""


class Observer(Protocol):
    """Whoever is told of each change of memory. An observer changes no fact itself."""

    def fact_changed(self, fact: Fact, how: str) -> None:
        """Take note that `fact` was STORED, REPLACED or REMOVED."""

    def other_changed(self, word: str) -> None:
        """Take note of a change that queries see and that is no fact's.

        `word` is `external`, `know-sensor-name`, or `location` for the size of an
        expectation set.
        """


_FactChanged = Callable[[Fact, str], None]


def _tell_each(told: Sequence[_FactChanged], fact: Fact, how: str) -> None:
    for changed in told:
        changed(fact, how)


class Sized(Protocol):
    """An expectation set, as far as memory knows of it."""

    @property
    def size(self) -> int:
        """Return how many items are expected."""


class Memory:
    """All that the robot believes.

    Args:
        signatures: the declarations; nothing undeclared gets in.
        recorder: is told of each change; its time is the stamp of new facts.
        properties: the declared properties, for what they exclude.
        indistinct: the classes whose items are recognised by comparison.
        expected: the expectation sets by class and place, kept up by the recogniser.
    """

    def __init__(
        self,
        signatures: Signatures,
        recorder: Recorder,
        properties: Iterable[nodes.DeclareProperty] = (),
        indistinct: Collection[str] = (),
        expected: Mapping[tuple[str, Atom], Sized] | None = None,
    ) -> None:
        self.signatures = signatures
        self.facts = FactStore(signatures.relations.get)
        self.items = Items()
        self.notations = Notations()
        #: Where the robot is: the place last given to `arrive`.
        self.place: Atom | None = None
        exclusions = Exclusions(properties, signatures, self.facts)
        #: Which facts cannot stand beside which; None if nothing excludes anything.
        self.exclusions: Exclusions | None = exclusions if exclusions else None
        #: The facts that speak of items of indistinct classes; None without such.
        self.mentions: Mentions | None = Mentions() if indistinct else None
        self._indistinct = frozenset(indistinct)
        self._expected: Mapping[tuple[str, Atom], Sized] = (
            {} if expected is None else expected
        )
        self._recorder = recorder
        self._observers: tuple[Observer, ...] = ()
        #: Tells all observers of a fact: the only one's own method in most runs.
        self._fact_changed: _FactChanged = partial(_tell_each, ())
        #: The notations in force: part of `notations`, and the same object for good.
        self._noted = self.notations.by_fact
        self._relations = signatures.relations

    def observe(self, *observers: Observer) -> None:
        """Tell these observers of each change from now on, in this order."""
        self._observers = observers
        told = [each.fact_changed for each in observers]
        self._fact_changed = told[0] if len(told) == 1 else partial(_tell_each, told)

    # --- the two verbs -----------------------------------------------------------

    def store(self, fact: Fact, by: str, stamp: Time | None = None) -> None:
        """Store a full, checked fact, or give the one that is there a new stamp.

        A property's old value goes. Without a `stamp` the fact is asserted now: facts
        that it excludes go, and it is no notation any more. With one it is stored as
        it was asserted at another time, or never (`NEVER`). `by` is for the trace.
        """
        recorder, noted = self._recorder, self._noted
        if stamp is None:
            stamp = recorder.time
            if noted:
                noted.pop(fact, None)
            if self.exclusions is not None:
                for other in self.exclusions.of(fact):
                    self.remove(other, "memory")
                self.exclusions.asserted(fact, stamp)
        replaced = self.facts.add(fact, stamp)
        if replaced is not None:
            if noted:
                noted.pop(replaced, None)
            if recorder.on:
                recorder.emit(FactErased, fact=replaced, by=by)
            self._fact_changed(replaced, REPLACED)
        if recorder.on:
            recorder.emit(FactAsserted, fact=fact, by=by)
        self._fact_changed(fact, STORED)

    def remove(self, fact: Fact, by: str) -> None:
        """Remove a fact that is there. `by` is for the trace."""
        if self._noted:
            self._noted.pop(fact, None)
        self.facts.remove(fact)
        if self._recorder.on:
            self._recorder.emit(FactErased, fact=fact, by=by)
        self._fact_changed(fact, REMOVED)

    def tell(self, word: str) -> None:
        """Tell the observers of a change that is no fact's: see `Observer`."""
        for observer in self._observers:
            observer.other_changed(word)

    # --- facts as they are kept --------------------------------------------------

    def checked(self, fact: Fact) -> Fact:
        """Return `fact` in the form in which it is kept, under the names of today.

        Raises:
            FactError: if the declarations do not allow it.
        """
        fact = full_form(fact, self._relations)
        return self.canonical(fact) if self.items.aliases else fact

    def canonical(self, fact: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return a fact, prefix or pattern with the names that stand for others now."""
        aliases = self.items.aliases
        if not aliases:
            return fact
        for part in fact[1:]:
            if type(part) is str and part in aliases:
                name_of = self.items.canonical
                return (fact[0], *[name_of(part) for part in fact[1:]])
        return fact

    # --- notations ---------------------------------------------------------------

    def note(self, fact: Fact) -> Notation | None:
        """Store a checked fact for as long as a method lives.

        Returns:
            What `release_notation` wants back; None if the fact was asserted before:
            then only its stamp is new, and nothing is to be taken away.
        """
        notation = self.notations.by_fact.get(fact)
        if notation is None and fact in self.facts:
            self.store(fact, "notation")
            return None
        self.store(fact, "notation")
        return self.notations.hold(fact, notation)

    def release_notation(self, notation: Notation) -> None:
        """Release a notation; remove its fact if no other method notes it."""
        fact = self.notations.release(notation)
        if fact is not None:
            self.remove(fact, "notation")

    def rename(self, fact: Fact, renamed: Fact, stamp: Time) -> None:
        """Replace `fact` by `renamed`, which speaks of the same items by new names.

        `renamed` gets the `stamp`, and stays for the methods that noted `fact`.
        """
        by_fact = self.notations.by_fact
        notation, noted = by_fact.get(fact), by_fact.get(renamed)
        was_there = renamed in self.facts
        self.remove(fact, "memory")
        self.store(renamed, "memory", stamp)
        self.notations.rename(notation, renamed, noted, was_there)

    # --- where things are --------------------------------------------------------

    def arrive(self, place: Atom) -> None:
        """Set the robot's place, of which `external` speaks from now on."""
        if self.place != place:
            self.place = place
            self.tell(EXTERNAL)

    def is_here(self, fact: Fact | None) -> bool:
        """Whether a location fact says that an item is where the robot is."""
        if fact is None or self.place is None or fact[2] != self.place:
            return False
        return fact[1] in self.items.known

    def expected_at(self, kind: str, place: Atom) -> int | None:
        """Return the size of the expectation set of a class at a place.

        Returns:
            None for a class whose items are not recognised by comparison.
        """
        if kind not in self._indistinct:
            return None
        found = self._expected.get((kind, place))
        return 0 if found is None else found.size

    def facts_at(self, place: object) -> Iterator[Fact]:
        """Iterate over the location facts of a place, oldest assertion first.

        `external` means the robot's place too, for items that handlers introduced.
        """
        located = self.facts.table("location")
        index = located.index(2)
        there = index.get(place, {})  # type: ignore[call-overload]
        if place != EXTERNAL or self.place is None:
            return iter(there)
        items = self.items.known
        near = [fact for fact in index.get(self.place, ()) if fact[1] in items]
        if not near or not there:
            return iter(near or there)
        either = {*near, *there}
        return iter([fact for fact in located.stamps if fact in either])
