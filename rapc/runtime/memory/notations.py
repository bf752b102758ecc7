"""Notations: facts that stay in memory as long as a method that noted them [T 4.9].

Bookkeeping only: `rapc.runtime.memory.memory` stores and removes the facts. A saved run
has the noted facts of each method under way; the notations in force follow from them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from rapc.base.values import Fact
from rapc.runtime.fields import LEFT_OUT, Fields


class Notation:
    """A fact that methods note and that was not asserted otherwise."""

    FIELDS: ClassVar[Fields] = {"fact": LEFT_OUT, "count": LEFT_OUT, "joined": LEFT_OUT}
    __slots__ = tuple(FIELDS)

    def __init__(self, fact: Fact) -> None:
        #: The fact, with the current names of its items.
        self.fact = fact
        #: How many methods that have not ended note the fact.
        self.count = 0
        #: The notation that includes this one, once a merge has made their facts equal;
        #: else None.
        self.joined: Notation | None = None


class Notations:
    """The notations that are in force, by fact."""

    FIELDS: ClassVar[Fields] = {"by_fact": LEFT_OUT}
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: The notations in force. Empty in most runs: callers test that first.
        self.by_fact: dict[Fact, Notation] = {}

    def drop(self, fact: Fact) -> None:
        """End the notation of `fact`, if any: the fact is asserted or gone."""
        self.by_fact.pop(fact, None)

    def hold(self, fact: Fact, notation: Notation | None) -> Notation:
        """Return the notation of `fact` with one more noting method.

        `notation` is the one in force before `fact` was stored again, if any.
        """
        if notation is None:
            notation = Notation(fact)
        self.by_fact[fact] = notation
        notation.count += 1
        return notation

    def in_force(self, notation: Notation) -> Notation | None:
        """Return the notation that replaces `notation` now; None after its end."""
        while notation.joined is not None:
            notation = notation.joined
        return notation if self.by_fact.get(notation.fact) is notation else None

    def facts(self, notations: Iterable[Notation]) -> list[Fact]:
        """Return the facts of the notations that are still in force."""
        found = [self.in_force(notation) for notation in notations]
        return [notation.fact for notation in found if notation is not None]

    def note(self, facts: Iterable[Fact]) -> tuple[Notation, ...]:
        """Return the notations of some facts, each with one more noting method."""
        return tuple([self.hold(fact, self.by_fact.get(fact)) for fact in facts])

    def release(self, notation: Notation) -> Fact | None:
        """Subtract one noting method; return the fact if no noting method is left."""
        current = self.in_force(notation)
        if current is None:
            return None
        current.count -= 1
        return current.fact if current.count == 0 else None

    def take_up(self, other: Notations) -> None:
        """Replace the notations in force by those of another table."""
        self.by_fact.clear()
        self.by_fact.update(other.by_fact)

    def rename(
        self,
        notation: Notation | None,
        renamed: Fact,
        noted: Notation | None,
        was_there: bool,
    ) -> None:
        """Transfer `notation` to the fact `renamed`, which is stored by now.

        `noted` is the notation that `renamed` had before, if any; `was_there` is
        whether `renamed` was in memory before. A fact that was asserted under either
        name is no notation any more.
        """
        if notation is None:
            self.drop(renamed)
        elif noted is not None:
            notation.joined = noted
            noted.count += notation.count
        elif not was_there:
            notation.fact = renamed
            self.by_fact[renamed] = notation
