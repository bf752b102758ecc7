"""The RAP memory: what may be asserted and erased, by whom, and who is told.

Memory checks a fact against the declarations, stores it with its time (T 2.2, A.3),
keeps notations as long as their methods (T 4.9), and knows where the robot is, so
that `external` can be computed (semantics 7). Queries are in `rapc.compiler`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rapc.base.values import Atom, Fact, format_list
from rapc.compiler.vocabulary import Vocabulary
from rapc.errors import FactError
from rapc.runtime.events.events import FactAsserted, FactErased
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.checking import check_prefix, full_form
from rapc.runtime.memory.items import Items
from rapc.runtime.memory.mentions import Mentions
from rapc.runtime.memory.store import FactStore
from rapc.world import Time

_BY_HANDLERS = ("class", "location")
"""What an introduced item has from `introduce`, `move` and `lose`."""

EXTERNAL = "external"
"""The place outside the robot, wherever it is."""


class Notation:
    """How many methods note a fact that nobody else has asserted."""

    __slots__ = ("count", "fact", "same")

    def __init__(self, fact: Fact) -> None:
        self.fact = fact
        self.count = 0
        self.same: Notation | None = None


class Memory:
    """All that the robot believes.

    Args:
        vocabulary: the declarations; nothing undeclared gets in.
        recorder: is told of each change; new facts are stamped with its time.

    `changed` is called with every fact that came, was refreshed or went; `moved` with
    a word when something else that queries see has changed: `external`,
    `know-sensor-name` or `location` (for the size of a set). Where items of indistinct
    classes may come, `described` is called with every fact that came or was refreshed
    (True) or went (False), but with none whose value another one replaces, and
    `mentions` finds the facts that speak of such items. `excluded` returns the
    facts in memory that one cannot stand beside. `set_size` is the size of the
    expectation set of a class and a place, None for a distinct class.
    """

    def __init__(self, vocabulary: Vocabulary, recorder: Recorder) -> None:
        self.vocabulary = vocabulary
        self.facts = FactStore(vocabulary.relations.get)
        self.items = Items()
        self.place: Atom | None = None
        self.changed: Callable[[Fact], None] = lambda fact: None
        self.moved: Callable[[str], None] = lambda word: None
        self.described: Callable[[Fact, bool], None] | None = None
        self.mentions: Mentions | None = None
        self.excluded: Callable[[Fact], Sequence[Fact]] | None = None
        self.set_size: Callable[[object, object], int | None] = lambda kind, at: None
        self._recorder = recorder
        self._notations: dict[Fact, Notation] = {}

    # --- changes -------------------------------------------------------------

    def checked(self, fact: Fact) -> Fact:
        """A fact in its full form, after looking at name, number and kinds.

        Raises:
            FactError: if the declarations do not allow it.
        """
        fact = full_form(fact, self.vocabulary.relations)
        return self.canonical(fact) if self.items.aliases else fact

    def canonical(self, fact: tuple[Any, ...]) -> tuple[Any, ...]:
        """A fact, prefix or pattern with the names that stand for others now."""
        aliases = self.items.aliases
        if not aliases:
            return fact
        for part in fact[1:]:
            if type(part) is str and part in aliases:
                name_of = self.items.canonical
                return (fact[0], *[name_of(part) for part in fact[1:]])
        return fact

    def refuse_by_hand(self, fact: Fact) -> None:
        """Only introduce, move and lose set an item's place and introducing class.

        Raises:
            FactError: for such a fact, or a prefix of one.
        """
        if not fact or fact[0] not in _BY_HANDLERS or not self.items.known:
            return
        known = self.items.known
        if len(fact) == 1:
            items = [known.get(str(f[1])) for f in self.facts.starting(fact)]
        else:
            items = [known.get(str(fact[1]))]
        for item in items:
            other = fact[0] == "class" and len(fact) > 2 and item is not None
            if item is not None and not (other and fact[2] != item.kind):
                raise FactError(
                    f"{format_list(fact)}: an introduced item's location and class "
                    "are set by `introduce`, `move` and `lose`"
                )

    def assert_by_hand(self, fact: Fact, by: str) -> None:
        """Assert a fact that a host or a handler has made: checked, then asserted.

        Raises:
            FactError: as `checked`, and as `refuse_by_hand`.
        """
        fact = self.checked(fact)
        if fact[0] in _BY_HANDLERS:
            self.refuse_by_hand(fact)
        if self._notations:
            self._notations.pop(fact, None)
        self._store(fact, by)

    def erase_by_hand(self, prefix: Fact, by: str) -> None:
        """Erase every fact that starts so, on behalf of a host or a handler.

        Raises:
            FactError: as `erase`, and as `refuse_by_hand`.
        """
        if prefix and prefix[0] in _BY_HANDLERS:
            self.refuse_by_hand(self.canonical(prefix))
        self.erase(prefix, by)

    def assert_fact(self, fact: Fact, by: str) -> None:
        """Assert a full, checked fact now; a property's old value is erased."""
        if self._notations:
            self._notations.pop(fact, None)
        self._store(fact, by)

    def put(self, fact: Fact, stamp: Time) -> None:
        """Store a fact as it was asserted at another time, or never (`NEVER`)."""
        self._store(fact, "memory", stamp)

    def take(self, fact: Fact) -> None:
        """Remove a fact that is there: a merge, or an item that is forgotten."""
        self._remove(fact, "memory")

    def _store(self, fact: Fact, by: str, stamp: Time | None = None) -> None:
        recorder = self._recorder
        if self.excluded is not None and stamp is None:
            for other in self.excluded(fact):
                self._remove(other, "memory")
        replaced = self.facts.add(fact, recorder.time if stamp is None else stamp)
        if replaced is not None:
            if self._notations:
                self._notations.pop(replaced, None)
            if self.mentions is not None:
                self.mentions.went(replaced)
            if recorder.on:
                recorder.emit(FactErased, fact=replaced, by=by)
            self.changed(replaced)
        if recorder.on:
            recorder.emit(FactAsserted, fact=fact, by=by)
        self.changed(fact)
        if self.mentions is not None:
            self.mentions.came(fact)
        if self.described is not None:
            self.described(fact, True)

    def erase(self, prefix: Fact, by: str) -> None:
        """Erase every fact that starts so.

        Raises:
            FactError: if the prefix names nothing declared.
        """
        check_prefix(prefix, self.vocabulary.relations)
        if self.items.aliases:
            prefix = self.canonical(prefix)
        for fact in self.facts.starting(prefix):
            self._remove(fact, by)

    def _remove(self, fact: Fact, by: str) -> None:
        if self._notations:
            self._notations.pop(fact, None)
        self.facts.remove(fact)
        if self._recorder.on:
            self._recorder.emit(FactErased, fact=fact, by=by)
        self.changed(fact)
        if self.mentions is not None:
            self.mentions.went(fact)
        if self.described is not None:
            self.described(fact, False)

    # --- notations -------------------------------------------------------------

    def note(self, fact: Fact) -> Notation | None:
        """Assert a checked fact for as long as a method lives.

        Returns what `forget` wants back, or None where the fact was there anyway:
        then only its stamp is new and nothing is to be taken away.
        """
        notation = self._notations.get(fact)
        if notation is None and fact in self.facts:
            self._store(fact, "notation")
            return None
        if notation is None:
            notation = Notation(fact)
        self._store(fact, "notation")
        self._notations[fact] = notation
        notation.count += 1
        return notation

    def forget(self, notation: Notation) -> None:
        """A method that noted a fact has ended; the last one takes the fact along."""
        while notation.same is not None:
            notation = notation.same
        if self._notations.get(notation.fact) is not notation:
            return
        notation.count -= 1
        if notation.count == 0:
            self._remove(notation.fact, "notation")

    def rename(self, fact: Fact, renamed: Fact, stamp: Time) -> None:
        """A fact gets other names and keeps its stamp and whoever notes it."""
        notation = self._notations.get(fact)
        was_there = renamed in self.facts
        noted = self._notations.get(renamed)
        self.take(fact)
        self.put(renamed, stamp)
        if notation is None:
            self._notations.pop(renamed, None)
        elif noted is not None:
            notation.same = noted
            noted.count += notation.count
        elif not was_there:
            notation.fact = renamed
            self._notations[renamed] = notation

    # --- where things are --------------------------------------------------------

    def arrive(self, place: Atom) -> None:
        """The robot is at a place, of which `external` speaks from now on."""
        if self.place != place:
            self.place = place
            self.moved(EXTERNAL)

    def is_here(self, fact: Fact | None) -> bool:
        """Whether a location fact says that an item is where the robot is."""
        if fact is None or self.place is None or fact[2] != self.place:
            return False
        return fact[1] in self.items.known

    def facts_at(self, place: object) -> Iterator[Fact]:
        """Location facts of a place, `external` computed, oldest assertion first."""
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
