"""What `:excludes` says of facts: which cannot stand beside which (docs/memory.md).

A property that has a value excludes the facts of a pattern; its own arguments are
the pattern's variables, every other variable is free. It works both ways. What goes
when one of two comes, or when a merge brings them together, is for others to say.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rapc.base.values import Atom, Fact
from rapc.ir import nodes
from rapc.library.signatures import Signatures
from rapc.runtime.memory.store import FactStore

Shape = tuple[str | nodes.Const, ...]
"""The arguments of one side: constants, and the names of variables."""


class _Side:
    """One of two kinds of fact that exclude each other."""

    __slots__ = ("args", "name")

    def __init__(self, name: str, args: Shape) -> None:
        self.name = name
        self.args = args

    def bound(self, fact: Fact) -> dict[str, Atom] | None:
        """Return what the variables stand for in a fact, or None for another fact."""
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

    def pattern(self, bound: dict[str, Atom]) -> tuple[Atom | None, ...]:
        """Return the facts of this side that go with what the other side has bound."""
        args = [
            arg.value if isinstance(arg, nodes.Const) else bound.get(arg)
            for arg in self.args
        ]
        return (self.name, *args)


class Exclusions:
    """The exclusions of a library, asked of facts in a store."""

    def __init__(
        self,
        properties: Iterable[nodes.DeclareProperty],
        signatures: Signatures,
        facts: FactStore,
    ) -> None:
        self._facts = facts
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
        """The facts in memory that cannot stand beside a fact, oldest first."""
        pairs = self._pairs.get(fact[0])
        return () if pairs is None else list(dict.fromkeys(self._of(fact, pairs)))

    def _of(self, fact: Fact, pairs: Iterable[tuple[_Side, _Side]]) -> Iterator[Fact]:
        for mine, other in pairs:
            bound = mine.bound(fact)
            if bound is not None:
                for found in self._facts.matching(other.pattern(bound)):
                    if found != fact and other.bound(found) is not None:
                        yield found


def _owner(declared: nodes.DeclareProperty, exclusion: nodes.Exclusion) -> _Side:
    """The side that declares; without a list it has the pattern's first variable."""
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
