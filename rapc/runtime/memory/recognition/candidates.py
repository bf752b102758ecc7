"""Candidates: the descriptions of a view that may match, by kind and group.

Descriptions with equal known properties form a kind. The descriptions of a kind that
are out of reach are identical and form one group; each accessible description is a
group of its own. A description is compared with groups, not with all descriptions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

import msgspec

from rapc.base.values import Atom, Fact
from rapc.runtime.memory.recognition.sets import Description

Known = frozenset[tuple[Fact, Atom]]


def rank(member: Description) -> tuple[int, bool, int]:
    """Return the sort key of a group's members: the smallest is taken first."""
    return (-member.mask.bit_count(), member.empty, member.number)


class Group(msgspec.Struct, frozen=True, eq=False):
    """A candidate group: an accessible description, or identical ones out of reach.

    `number` is the number of the accessible description, 0 for a group out of reach.
    """

    kind: SameKnown
    number: int

    def same(self, other: Group) -> bool:
        """Return whether two groups are equal."""
        return self.kind is other.kind and self.number == other.number

    def room(self, mask: int) -> int:
        """Return how many members may match a description in the views of `mask`."""
        return len(self._members(mask))

    def member(self, mask: int) -> Description:
        """Return the member that matches a description in the views of `mask`."""
        return min(self._members(mask), key=rank)

    def _members(self, mask: int) -> list[Description]:
        wanted = self.number
        return [
            member
            for member in self.kind.members(mask)
            if (member.number if member.accessible else 0) == wanted
        ]


class SameKnown:
    """The descriptions of a view with equal known properties.

    The table is sorted by the views of the descriptions, because only these views
    decide which members may match another description.
    """

    __slots__ = ("_cells",)

    def __init__(self) -> None:
        self._cells: dict[int, tuple[list[Description], list[Description]]] = {}

    def add(self, member: Description) -> None:
        """Add a description of this kind."""
        cell = self._cells.setdefault(member.mask, ([], []))
        cell[0 if member.accessible else 1].append(member)

    def members(self, mask: int) -> Iterator[Description]:
        """Yield the members that may match a description in the views of `mask`."""
        for views, (near, far) in self._cells.items():
            if not views & mask:
                yield from near
                yield from far

    def first(self, mask: int) -> Description | None:
        """Return a candidate, an empty description only if all are empty."""
        found = None
        for views, (near, far) in self._cells.items():
            if not views & mask:
                for member in near or far:
                    if not member.empty:
                        return member
                    found = member
        return found

    def count(self, mask: int) -> int:
        """Return how many groups of this kind may match a description in `mask`."""
        near = far = 0
        for views, cell in self._cells.items():
            if not views & mask:
                near += len(cell[0])
                far |= bool(cell[1])
        return near + far

    def group(self, mask: int) -> Group:
        """Return the group of this kind; the caller ensures a single group."""
        member = self.first(mask)
        assert member is not None
        return Group(self, member.number if member.accessible else 0)


NONE: tuple[SameKnown, ...] = ()


class Candidates:
    """The kinds of descriptions of a view, by their known properties."""

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
        """Return all kinds, in the order in which they came."""
        return self._kinds.values()

    def sharing(self, x: Description) -> Collection[SameKnown]:
        """Return the kinds that have a known property in common with a description."""
        found: dict[SameKnown, None] | None = None
        for part in x.known:
            having = self._having.get(part)
            if having is not None:
                found = found or {}
                found.update(having)
        return found or NONE

    def count(self, mask: int) -> int:
        """Return how many groups may match a description in the views of `mask`."""
        found = self._counts.get(mask)
        if found is None:
            found = sum(kind.count(mask) for kind in self._kinds.values())
            self._counts[mask] = found
        return found
