"""What a view offers for a match: its candidate groups, found without comparing all.

Descriptions that are known by the same are a kind. Of a kind, those out of reach are
identical and one group; each accessible one is a group of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

import msgspec

from rapc.base.values import Atom, Fact
from rapc.runtime.memory.recognition.sets import Description

Known = frozenset[tuple[Fact, Atom]]


def rank(member: Description) -> tuple[int, bool, int]:
    """The order in which a group's members are taken: the smallest first."""
    return (-member.mask.bit_count(), member.empty, member.number)


class Group(msgspec.Struct, frozen=True, eq=False):
    """A candidate group: an accessible description, or identical ones out of reach.

    `number` is that of the accessible one, 0 for the others.
    """

    kind: SameKnown
    number: int

    def same(self, other: Group) -> bool:
        """Whether two are one group."""
        return self.kind is other.kind and self.number == other.number

    def room(self, mask: int) -> int:
        """Return how many members a description that stands in these views may be."""
        return len(self._members(mask))

    def member(self, mask: int) -> Description:
        """The member to be taken by such a description."""
        return min(self._members(mask), key=rank)

    def _members(self, mask: int) -> list[Description]:
        wanted = self.number
        return [
            member
            for member in self.kind.members(mask)
            if (member.number if member.accessible else 0) == wanted
        ]


class SameKnown:
    """The descriptions of a view that are known by the same.

    They are kept by the views in which they stand: which of them another one may be
    depends on that alone.
    """

    __slots__ = ("_cells",)

    def __init__(self) -> None:
        self._cells: dict[int, tuple[list[Description], list[Description]]] = {}

    def add(self, member: Description) -> None:
        """A further description of this kind."""
        cell = self._cells.setdefault(member.mask, ([], []))
        cell[0 if member.accessible else 1].append(member)

    def members(self, mask: int) -> Iterator[Description]:
        """Those that a description which stands in the given views may be."""
        for views, (near, far) in self._cells.items():
            if not views & mask:
                yield from near
                yield from far

    def first(self, mask: int) -> Description | None:
        """Return one of the candidates, an empty description only if all are empty."""
        found = None
        for views, (near, far) in self._cells.items():
            if not views & mask:
                for member in near or far:
                    if not member.empty:
                        return member
                    found = member
        return found

    def count(self, mask: int) -> int:
        """Return how many groups such a description finds in this kind."""
        near = far = 0
        for views, cell in self._cells.items():
            if not views & mask:
                near += len(cell[0])
                far |= bool(cell[1])
        return near + far

    def group(self, mask: int) -> Group:
        """The one group of this kind, where there is only one."""
        member = self.first(mask)
        assert member is not None
        return Group(self, member.number if member.accessible else 0)


NONE: tuple[SameKnown, ...] = ()


class Candidates:
    """The kinds of descriptions that a view offers, by what they are known by."""

    def __init__(self, members: Iterable[Description]) -> None:
        self._kinds: dict[Known, SameKnown] = {}
        self._having: dict[tuple[Fact, Atom], dict[SameKnown, None]] = {}
        self._counts: dict[int, int] = {}
        for member in members:
            known = member.known
            kind = self._kinds.get(known)
            if kind is None:
                kind = self._kinds[known] = SameKnown()
                for part in known:
                    self._having.setdefault(part, {})[kind] = None
            kind.add(member)

    def kinds(self) -> Iterable[SameKnown]:
        """All kinds, in the order in which they came."""
        return self._kinds.values()

    def sharing(self, x: Description) -> Collection[SameKnown]:
        """The kinds that have a known property in common with a description."""
        found: dict[SameKnown, None] | None = None
        for part in x.known:
            having = self._having.get(part)
            if having is not None:
                found = found or {}
                found.update(having)
        return found or NONE

    def count(self, mask: int) -> int:
        """Return how many groups a description that stands in the given views finds."""
        found = self._counts.get(mask)
        if found is None:
            found = sum(kind.count(mask) for kind in self._kinds.values())
            self._counts[mask] = found
        return found
