"""The rules of memory: the normal form of a fact, its stamp, and its consequences.

Inside the runtime memory has two verbs, `store` and `remove`. The callers validate a
fact before: `rapc.runtime.memory.access` for handlers and hosts, `Memory.checked` for
notations. Facts carry the time of their assertion [T 2.2, A.3].

Not here: queries (`rapc.compiler.query`), which facts exclude each other
(`exclusions`), who may change which facts (`access`), items (`items`, `recognition`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any, ClassVar, Final, Protocol

from rapc.base.values import Atom, Fact, format_list, number
from rapc.errors import FactError
from rapc.events import FactAsserted, FactErased
from rapc.ir import nodes
from rapc.language.atoms import is_atom
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.fields import LEFT_OUT, Fields
from rapc.runtime.memory.exclusions import Exclusions
from rapc.runtime.memory.facts import FactStore, Mentions
from rapc.runtime.memory.items import Items
from rapc.runtime.memory.notations import Notation, Notations
from rapc.world import Time

EXTERNAL = "external"
"""The place outside the robot."""

STORED: Final = "stored"
"""A fact was asserted, refreshed, or got another stamp."""

REPLACED: Final = "replaced"
"""A property's fact is removed because another value is being stored."""

REMOVED: Final = "removed"
"""A fact was removed."""


class Observer(Protocol):
    """An observer of all changes of memory; must not change facts itself."""

    def fact_changed(self, fact: Fact, how: str) -> None:
        """Receive the change of `fact`: STORED, REPLACED or REMOVED."""

    def other_changed(self, word: str) -> None:
        """Receive a change that queries see and that concerns no fact.

        `word` is `external`, `know-sensor-name`, or `location` for the size of an
        expectation set.
        """


class Sized(Protocol):
    """An expectation set, as memory sees it."""

    @property
    def size(self) -> int:
        """Return how many items are expected."""


class Memory:
    """All beliefs of the robot.

    Args:
        signatures: the declarations; memory stores only declared facts.
        recorder: receives each change; its time is the stamp of new facts.
        properties: the declared properties, with their exclusions.
        indistinct: the classes whose items are recognised by comparison.
        expected: the expectation sets by class and place, which the recogniser updates.
    """

    FIELDS: ClassVar[Fields] = {
        "place": Atom | None,
        "facts": FactStore,
        "items": Items,
        "mentions": Mentions | None,
        "exclusions": Exclusions | None,
        "notations": LEFT_OUT,
        "signatures": LEFT_OUT,
        "_indistinct": LEFT_OUT,
        "_expected": LEFT_OUT,
        "_recorder": LEFT_OUT,
        "_observers": LEFT_OUT,
        "_fact_changed": LEFT_OUT,
        "_noted": LEFT_OUT,
        "_relations": LEFT_OUT,
        "_tables": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

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
        #: The place of the robot: the last argument of `arrive`.
        self.place: Atom | None = None
        exclusions = Exclusions(properties, signatures, self.facts)
        #: The pairs of facts that exclude each other; None if nothing excludes
        #: anything.
        self.exclusions: Exclusions | None = exclusions if exclusions else None
        #: The facts that mention items of indistinct classes; None without these
        #: classes.
        self.mentions: Mentions | None = Mentions() if indistinct else None
        self._indistinct = frozenset(indistinct)
        self._expected: Mapping[tuple[str, Atom], Sized] = (
            {} if expected is None else expected
        )
        self._recorder = recorder
        self._observers: tuple[Observer, ...] = ()
        self._fact_changed: tuple[Callable[[Fact, str], None], ...] = ()
        #: The notations in force: part of `notations`, and always the same object.
        self._noted = self.notations.by_fact
        self._relations = signatures.relations
        self._tables = self.facts.tables

    def observe(self, *observers: Observer) -> None:
        """Register observers of each change from now on, in this order."""
        self._observers = observers
        self._fact_changed = tuple([each.fact_changed for each in observers])

    def take_up(self, other: Memory) -> None:
        """Replace the beliefs by those of another memory of the same library.

        The observers receive no report: they have to look at all facts again.
        """
        self.place = other.place
        self.facts.take_up(other.facts)
        self.items.take_up(other.items)
        self.notations.take_up(other.notations)
        if self.mentions is not None and other.mentions is not None:
            self.mentions.by_item = other.mentions.by_item
        if self.exclusions is not None and other.exclusions is not None:
            self.exclusions.by_item = other.exclusions.by_item

    # --- the two verbs -----------------------------------------------------------

    def store(self, fact: Fact, by: str, stamp: Time | None = None) -> None:
        """Store a full, checked fact, or give a stored fact a new stamp.

        Memory removes the old value of a property. Without a `stamp` the fact is
        asserted now: memory removes the facts that it excludes, and ends its notation.
        With a `stamp` the fact has been asserted at another time, or never (`NEVER`).
        `by` is for the trace.
        """
        recorder = self._recorder
        if stamp is None:
            stamp = recorder.time
            if self._noted:
                self._noted.pop(fact, None)
            if self.exclusions is not None:
                for other in self.exclusions.of(fact):
                    self.remove(other, "memory")
                self.exclusions.asserted(fact, stamp)
        replaced = self._tables[fact[0]].add(fact, stamp)
        if replaced is not None:
            self._gone(replaced, by, REPLACED)
        if recorder.on:
            recorder.emit(FactAsserted, fact=fact, by=by)
        for changed in self._fact_changed:
            changed(fact, STORED)

    def remove(self, fact: Fact, by: str) -> None:
        """Remove a stored fact. `by` is for the trace."""
        self._tables[fact[0]].remove(fact)
        self._gone(fact, by, REMOVED)

    def _gone(self, fact: Fact, by: str, how: str) -> None:
        """End the notation of a removed fact, and report the removal."""
        if self._noted:
            self._noted.pop(fact, None)
        if self._recorder.on:
            self._recorder.emit(FactErased, fact=fact, by=by)
        for changed in self._fact_changed:
            changed(fact, how)

    def tell(self, word: str) -> None:
        """Report a change that concerns no fact to the observers: see `Observer`."""
        for observer in self._observers:
            observer.other_changed(word)

    # --- facts as memory stores them ----------------------------------------------

    def checked(self, fact: Fact) -> Fact:
        """Return `fact` in normal form, with current names of items.

        Raises:
            FactError: if the declarations do not allow it.
        """
        fact = self.full_form(fact)
        return self.canonical(fact) if self.items.aliases else fact

    def full_form(self, fact: Fact) -> Fact:
        """Return `fact` in normal form: its numbers normalised, and no value omitted.

        Raises:
            FactError: if the declarations do not allow it.
        """
        name = fact[0] if fact else ""
        relation = self._relations.get(name) if type(name) is str else None
        if relation is None:
            raise _undeclared(fact)
        fact = _in_one_form(fact)
        given, most = len(fact) - 1, relation.most
        if given != most:
            wrong = relation.miscount(given)
            if wrong is not None:
                raise FactError(f"{wrong}: {format_list(fact)}")
            if most is not None:
                fact = (*fact, "true")
        return fact

    def canonical(self, fact: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return a fact, prefix or pattern with current names of items."""
        aliases = self.items.aliases
        if not aliases or aliases.keys().isdisjoint(fact):
            return fact
        name_of = self.items.canonical
        return (fact[0], *[name_of(part) for part in fact[1:]])

    # --- notations ---------------------------------------------------------------

    def note(self, fact: Fact) -> Notation | None:
        """Store a checked fact for as long as a method lives.

        Returns:
            The notation for `release_notation`; None if the fact was asserted before:
            then only its stamp is new, and no release is necessary.
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
        """Replace `fact` by `renamed`, the same fact with new names of items.

        The fact `renamed` gets the `stamp`, and stays for the methods that noted
        `fact`.
        """
        by_fact = self.notations.by_fact
        notation, noted = by_fact.get(fact), by_fact.get(renamed)
        was_there = renamed in self.facts
        self.remove(fact, "memory")
        self.store(renamed, "memory", stamp)
        self.notations.rename(notation, renamed, noted, was_there)

    # --- where things are --------------------------------------------------------

    def arrive(self, place: Atom) -> None:
        """Set the robot's place, which `external` denotes from now on."""
        if self.place != place:
            self.place = place
            self.tell(EXTERNAL)

    def is_here(self, fact: Fact | None) -> bool:
        """Return whether a location fact puts an item at the place of the robot."""
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

        The place `external` also stands for the robot's place, for introduced items.
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


# --- the normal form of facts ------------------------------------------------------


def check_prefix(prefix: Fact, relations: Mapping[str, Signature]) -> None:
    """Validate a prefix of facts. Raises FactError."""
    if not prefix or type(prefix[0]) is not str or prefix[0] not in relations:
        raise _undeclared(prefix)
    _in_one_form(prefix)


def _undeclared(fact: Fact) -> FactError:
    return FactError(f"unknown predicate `{fact[0] if fact else ''}`")


def in_one_form(part: Atom) -> Atom:
    """Return a value in normal form: a whole float as an integer.

    Raises:
        FactError: for a value that is not a symbol, number or string of the language.
    """
    if is_atom(part):
        return number(part) if type(part) is float else part
    if type(part) is str:
        said = "is not a symbol; use `rapc.world.Text` for a string"
        raise FactError(f"`{part:.60}` {said}")
    raise FactError(f"`{part}` is not a symbol, number or string")


_known_form = lru_cache(maxsize=4096, typed=True)(in_one_form)
"""`in_one_form` with a cache: handlers assert the same values again and again."""


def _in_one_form(parts: Fact) -> Fact:
    """Return `parts` in normal form. Raises FactError as `in_one_form`."""
    try:
        return tuple(map(_known_form, parts))
    except TypeError:  # a part cannot be hashed
        return tuple(map(in_one_form, parts))
