"""Which facts speak of items of indistinct classes, found without a search.

What becomes of these facts when items turn out to be one, or are forgotten, is for
`rapc.runtime.memory.recognition.merging` to say.
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.base.values import Fact

PREFIX = "item-"
"""How the memory names of such items begin."""


class Mentions:
    """The facts in memory by the items that stand in their arguments.

    Facts of all names stand in one order, that of their last assertion.
    """

    __slots__ = ("_facts",)

    def __init__(self) -> None:
        self._facts: dict[str, dict[Fact, None]] = {}

    def added(self, fact: Fact) -> None:
        """Enter a fact that was asserted, perhaps again: now it is the youngest."""
        for part in fact[1:]:
            if type(part) is str and part[:5] == PREFIX:
                known = self._facts.get(part)
                if known is None:
                    self._facts[part] = {fact: None}
                else:
                    known.pop(fact, None)
                    known[fact] = None

    def removed(self, fact: Fact) -> None:
        """Strike a fact out that is no longer there."""
        for part in fact[1:]:
            if type(part) is str and part[:5] == PREFIX:
                known = self._facts.get(part)
                if known is not None:
                    known.pop(fact, None)
                    if not known:
                        del self._facts[part]

    def state(self) -> tuple[tuple[str, tuple[Fact, ...]], ...]:
        """Return the facts by item, as `load` takes them."""
        return tuple((name, tuple(facts)) for name, facts in self._facts.items())

    def load(self, state: Iterable[tuple[str, Iterable[Fact]]]) -> None:
        """Hold the facts that `state` returned, and no others."""
        self._facts = {name: dict.fromkeys(facts) for name, facts in state}

    def of(self, name: str) -> list[Fact]:
        """Return the facts that mention an item, oldest first, each once."""
        return list(self._facts.get(name, ()))
