"""What a use of a named query needs and surely binds, by which terms have values.

A named query stands for its formula with terms put in for its arguments. Which
arguments need a value, and which the formula surely binds, depends on those that have
one where the name stands: so queries are walked once for each such set that comes up.
What a query asks through others is worked out first, without recursion, however long
the chain is. In a circle, which is reported elsewhere, a query is taken for a fact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set

import msgspec

from rapc.ir import nodes

Key = tuple[str, frozenset[str]]
"""A query by its name, with those of its arguments that have a value."""


class QueryBindings(msgspec.Struct, frozen=True):
    """What a query comes to where some of its arguments have a value."""

    #: The arguments that need a value and do not surely have one.
    needs: Set[str]
    #: The arguments that have a value wherever the query holds.
    binds: Set[str]
    #: Whether it can hold at all.
    possible: bool


class _UnknownError(Exception):
    """A summary is asked for that has to be worked out first."""

    def __init__(self, key: Key) -> None:
        super().__init__(key)
        self.key = key


Summarize = Callable[[nodes.DefineQuery, frozenset[str]], QueryBindings]
"""Walks the formula of a query once, asking `Summaries.known` for others in it."""


class Summaries:
    """The summaries of the queries of a library, worked out when asked for.

    Args:
        queries: the queries by name.
        summarize: what walks one of them.
    """

    def __init__(
        self, queries: Mapping[str, nodes.DefineQuery], summarize: Summarize
    ) -> None:
        self.queries = queries
        self._summarize = summarize
        self._known: dict[Key, QueryBindings] = {}
        #: What is being worked out, each for the sake of the one before it.
        self._asking: dict[Key, None] = {}

    def known(self, name: str, given: frozenset[str]) -> QueryBindings:
        """Return what a query comes to where the arguments in `given` have a value."""
        key = (name, given)
        found = self._known.get(key)
        if found is not None:
            return found
        if self._asking:
            raise _UnknownError(key)
        self._work_out(key)
        return self._known[key]

    def _work_out(self, key: Key) -> None:
        """Walk a query, after all others that its formula asks."""
        self._asking[key] = None
        while self._asking:
            name, given = here = next(reversed(self._asking))
            try:
                self._known[here] = self._summarize(self.queries[name], given)
                del self._asking[here]
            except _UnknownError as wanted:
                if wanted.key in self._asking:
                    query = self.queries[wanted.key[0]]
                    every = frozenset(query_arguments(query))
                    self._known[wanted.key] = QueryBindings(frozenset(), every, True)
                else:
                    self._asking[wanted.key] = None


def query_arguments(query: nodes.DefineQuery) -> Iterator[str]:
    """The names of the arguments of a query."""
    return (arg.variable.name for arg in query.args)
