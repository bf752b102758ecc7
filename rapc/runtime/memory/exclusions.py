"""Exclusions: pairs of facts that cannot be in memory together.

docs/explanation/memory.md describes them.

A property that has a value excludes the facts of a pattern; the arguments of the
property are the pattern's variables, every other variable is free. An exclusion works
in both directions.

A fact that excludes others may itself be gone when a merge brings up an older fact.
Therefore the exclusions keep the last assertion of each of these facts. Not here: the
choice between two facts that exclude each other (`memory`, `recognition.merging`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import ClassVar

from rapc.base.values import Atom, Fact
from rapc.ir import nodes
from rapc.library.signatures import Signatures
from rapc.runtime.fields import LEFT_OUT, Fields
from rapc.runtime.memory.facts import PREFIX, FactStore
from rapc.world import Time

Pattern = tuple[Atom | None, ...]
"""The facts of a name; None matches any argument."""

Excluded = tuple[Pattern, ...]
"""The patterns of all facts that a fact excludes."""

Past = tuple[Fact, Time]
"""A fact with the time of its assertion; the fact may be gone."""

Shape = tuple[str | nodes.Const, ...]
"""The arguments of one side: constants, and the names of variables."""


class _Side:
    """One of two kinds of fact that exclude each other."""

    __slots__ = ("args", "name")

    def __init__(self, name: str, args: Shape) -> None:
        self.name = name
        self.args = args

    def bound(self, fact: Fact) -> dict[str, Atom] | None:
        """Return the values of the variables in a fact, or None without a match."""
        if fact[0] != self.name or len(fact) != len(self.args) + 1:
            return None
        found: dict[str, Atom] = {}
        for arg, value in zip(self.args, fact[1:], strict=True):
            if isinstance(arg, nodes.Const):
                if arg.value != value:
                    return None
            elif arg and found.setdefault(arg, value) != value:
                return None
        return found

    def pattern(self, bound: dict[str, Atom]) -> Pattern:
        """Return the pattern of this side's facts with the other side's bindings."""
        args = [
            arg.value if isinstance(arg, nodes.Const) else bound.get(arg)
            for arg in self.args
        ]
        return (self.name, *args)


class Exclusions:
    """The exclusions of a library, evaluated over the facts of a store."""

    FIELDS: ClassVar[Fields] = {
        "by_item": dict[str, dict[Excluded, Past]],
        "_facts": LEFT_OUT,
        "_pairs": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self,
        properties: Iterable[nodes.DeclareProperty],
        signatures: Signatures,
        facts: FactStore,
    ) -> None:
        self._facts = facts
        #: The past assertions by item, then by the excluded patterns.
        self.by_item: dict[str, dict[Excluded, Past]] = {}
        self._pairs: dict[Atom, list[tuple[_Side, _Side]]] = {}
        for declared in properties:
            for exclusion in declared.excludes:
                one = _owner(declared, exclusion)
                other = _excluded(exclusion.pattern, signatures)
                self._pairs.setdefault(one.name, []).append((one, other))
                self._pairs.setdefault(other.name, []).append((other, one))

    def __bool__(self) -> bool:
        return bool(self._pairs)

    def of(self, fact: Fact) -> Sequence[Fact]:
        """Return the facts in memory that a fact excludes, oldest first."""
        return list(
            dict.fromkeys(
                found
                for other, pattern in self._patterns(fact)
                for found in self._facts.matching(pattern)
                if found != fact and other.bound(found) is not None
            )
        )

    def _patterns(self, fact: Fact) -> Iterator[tuple[_Side, Pattern]]:
        for mine, other in self._pairs.get(fact[0], ()):
            bound = mine.bound(fact)
            if bound is not None:
                yield other, other.pattern(bound)

    # --- past assertions ---------------------------------------------------------

    def excluded(self, fact: Fact) -> Excluded:
        """Return the patterns of all facts that a fact excludes."""
        return tuple([pattern for _, pattern in self._patterns(fact)])

    def asserted(self, fact: Fact, time: Time) -> None:
        """Record the time of an assertion, if the fact excludes facts of an item.

        Of several facts with the same exclusions only the last assertion is kept.
        """
        excluded = self.excluded(fact)
        for item in items_of(excluded):
            known = self.by_item.setdefault(item, {})
            before = known.get(excluded)
            if before is None or before[1] <= time:
                known[excluded] = (fact, time)

    def past(self, item: str) -> list[Past]:
        """Return the last assertions of facts that exclude facts of an item."""
        return list(self.by_item.get(item, {}).values())

    def forget(self, item: str) -> list[Past]:
        """Drop the past assertions of an item, and return them."""
        dropped = self.by_item.pop(item, {})
        for excluded in dropped:
            for other in items_of(excluded):
                known = self.by_item.get(other, {})
                known.pop(excluded, None)
                if not known:
                    self.by_item.pop(other, None)
        return list(dropped.values())


def items_of(excluded: Excluded) -> Iterable[str]:
    """Return the items of indistinct classes in patterns."""
    parts = dict.fromkeys(part for pattern in excluded for part in pattern[1:])
    return [p for p in parts if type(p) is str and p.startswith(PREFIX)]


def _owner(declared: nodes.DeclareProperty, exclusion: nodes.Exclusion) -> _Side:
    """Return the side that declares; by default with the pattern's first variable."""
    names: Sequence[str]
    if declared.args is not None:
        names = [arg.variable.name for arg in declared.args[:-1]]
    else:
        terms = exclusion.pattern.args
        names = [term.name for term in terms if isinstance(term, nodes.Var)][:1]
    return _Side(declared.name, (*names, nodes.Const(exclusion.value)))


def _excluded(pattern: nodes.Proposition, signatures: Signatures) -> _Side:
    relation = signatures.relations.get(pattern.name)
    args: list[str | nodes.Const] = []
    for term in pattern.args if relation is None else relation.full(pattern.args):
        if isinstance(term, nodes.Var) and not term.anonymous:
            args.append(term.name)
        else:
            args.append(term if isinstance(term, nodes.Const) else "")
    return _Side(pattern.name, tuple(args))
