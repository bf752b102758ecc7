"""Scores of pairs of descriptions [T 2.3.2, A.5].

Every comparator takes two descriptions of one set and returns a score; 0 or less rules
the pair out. Without a comparator, the class counts 10, and each property that both
descriptions have with the same known value counts 10. The same holds for properties
that a declared comparator does not mention.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isnan

import msgspec

from rapc.base.code_places import place_of
from rapc.base.values import Atom, Fact, Number
from rapc.errors import PortError
from rapc.ir import nodes
from rapc.runtime.authors import takes
from rapc.runtime.memory.recognition.sets import Description

SHARED = 10
"""The score of the class, and of each shared property."""


class DescribedItem(msgspec.Struct, frozen=True):
    """A description, as comparators in Python receive it (T A.5).

    `properties` maps a property's index without the item (`("color",)`,
    `("contains", "papers")`) to its known value. An empty description has no properties
    and the name "".
    """

    name: str
    kind: str
    place: Atom
    properties: Mapping[Fact, Atom]


Comparator = Callable[..., Number]
"""A comparator in Python, registered under a name, of two or three arguments.

The arguments are two `DescribedItem` and, if two are not enough, the memory with the
times of its facts. Descriptions with equal class, place and properties are
compared once for each recognition, so the score must not depend on their names.
"""


class Score:
    """A comparator of a set's descriptions.

    `of` returns the score of two descriptions. With `sparse`, two descriptions without
    a shared known property always score `SHARED`. Then only descriptions with a shared
    property need a comparison.
    """

    __slots__ = ("of", "sparse")

    def __init__(
        self, of: Callable[[Description, Description], Number], sparse: bool
    ) -> None:
        self.of = of
        self.sparse = sparse


def default_comparator() -> Score:
    """Return the default comparator."""

    def score(a: Description, b: Description) -> Number:
        return SHARED + SHARED * len(a.known & b.known)

    return Score(score, True)


def weighted(rows: Iterable[nodes.ComparatorRow]) -> Score:
    """Return a comparator declared in RAP: vetoing, weighted and ignored properties."""
    vetoing = {row.property for row in rows if row.treatment == "veto"}
    weights: dict[Atom, Number] = {
        row.property: row.weight if row.treatment == "score" else 0
        for row in rows
        if row.treatment != "veto"
    }

    def score(a: Description, b: Description) -> Number:
        total: Number = SHARED
        for index, value in a.known:
            other = b.values.get(index)
            if other == value:
                total += weights.get(index[0], SHARED)
            elif other is not None and other != "unknown" and index[0] in vetoing:
                return 0
        return total

    return Score(score, not vetoing)


def python_comparator(name: str, compare: Comparator, memory: object = None) -> Score:
    """Return a comparator in Python, which may read `memory`."""
    view = () if takes(compare, 2) else (memory,)

    def score(a: Description, b: Description) -> Number:
        home = a.home or b.home
        place: Atom = "unknown" if home is None else home.place
        found = compare(_described(a, place), _described(b, place), *view)
        if type(found) not in (int, float) or isnan(found):
            whose = f"the comparator `{name}`{place_of(compare)}"
            raise PortError(f"{whose} returned {found!a:.60}, not a number")
        return found

    return Score(score, False)


def _described(of: Description, place: Atom) -> DescribedItem:
    return DescribedItem(of.name, of.kind, place, dict(of.known))


def _found(name: str, registered: Mapping[str, Comparator], memory: object) -> Score:
    compare = registered.get(name)
    if compare is None:
        return default_comparator()
    return python_comparator(name, compare, memory)


class Scores:
    """The comparators of a library: by class, and by class and place.

    Args:
        classes: the indistinct classes, each with the name of a comparator or None.
        comparators: the comparators declared for them.
        registered: comparators in Python by name; a run with a missing comparator is
            refused.
        memory: the memory that comparators in Python may read.
    """

    def __init__(
        self,
        classes: Iterable[nodes.DeclareIndistinctClass],
        comparators: Sequence[nodes.DeclareComparator],
        registered: Mapping[str, Comparator],
        memory: object = None,
    ) -> None:
        self._plain = default_comparator()
        self._by_place: dict[tuple[str, Atom], Score] = {}
        self._by_class: dict[str, Score] = {}
        for declared in classes:
            if declared.comparator is not None:
                self._by_class[declared.name] = _found(
                    declared.comparator, registered, memory
                )
        for node in comparators:
            function = node.function
            score = (
                _found(function, registered, memory)
                if function
                else weighted(node.rows)
            )
            if node.place is None:
                self._by_class[node.class_name] = score
            else:
                self._by_place[node.class_name, node.place] = score

    def of(self, kind: str, place: Atom) -> Score:
        """Return the comparator of an expectation set, by its class and place."""
        found = self._by_place.get((kind, place))
        return found or self._by_class.get(kind) or self._plain
