"""The next identification that a set allows: the best maximal match (T 2.3.2, 2.3.3).

Every ordered pair of views is looked at, local model first, then layers from latest
to earliest; the first pair with matches gives the one that scores highest. Whether
and how the two become one is for `recognizer` to say.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rapc.runtime.memory.recognition.descriptions import (
    Description,
    ExpectationSet,
    Key,
    View,
)
from rapc.runtime.memory.recognition.scoring import Score
from rapc.terms import Number

Members = tuple[Description, ...]


class Match(msgspec.Struct, frozen=True):
    """Two descriptions that are of one item.

    `score` is how well they match, `rival` the best score of `one` with another
    candidate group of the view that holds `other`; None where there is none.
    """

    one: Description
    other: Description
    score: Number
    rival: Number | None


class _Standing(msgspec.Struct, frozen=True):
    """How a description stands to the candidate groups of another view.

    `best` is its highest score, `group` the group that alone has it, `rival` the
    highest score but that, `only` whether every other group is ruled out.
    """

    best: Number
    group: Key | None
    rival: Number | None
    only: bool


def groups(members: Iterable[Description]) -> dict[Key, list[Description]]:
    """Candidate groups: descriptions that are identical, stamps aside."""
    found: dict[Key, list[Description]] = {}
    for member in members:
        found.setdefault(member.key, []).append(member)
    return found


def rank(member: Description) -> tuple[int, bool, int]:
    """The order in which a group's members are taken: the smallest first."""
    return (-member.mask.bit_count(), member.empty, member.number)


def best_match(of: ExpectationSet, score: Score) -> Match | None:
    """The identification to be made next, or None: then all wait."""
    views = [view for view in of.views() if view.members]
    for one in views:
        for other in views:
            if one is not other:
                complete = other is not of.local or len(other) == of.size
                found = _best_of_pair(one, other, score, complete)
                if found is not None:
                    return found
    return None


def _best_of_pair(one: View, other: View, score: Score, complete: bool) -> Match | None:
    seeking = [x for x in one.members if not x.mask & other.bit]
    offered = groups(y for y in other.members if not y.mask & one.bit)
    if not seeking or not offered:
        return None
    table = _Table(seeking, offered, score)
    best: tuple[Number, int] | None = None
    match = None
    for x in seeking:
        standing = table.standing(x)
        order = (-standing.best, x.number)
        if standing.group is None or (best is not None and order > best):
            continue
        if table.has_room(x, standing, complete):
            found = [y for y in offered[standing.group] if x.may_be(y)]
            y = min(found, key=rank)
            best = order
            match = Match(x, y, standing.best, standing.rival)
    return match


class _Table:
    """The scores of a view's descriptions with another view's candidate groups.

    Descriptions that are alike and stand in the same views stand alike to all.
    """

    def __init__(
        self,
        seeking: list[Description],
        offered: dict[Key, list[Description]],
        score: Score,
    ) -> None:
        self._seeking = seeking
        self._offered = offered
        self._score = score
        self._standings: dict[tuple[Key, int], _Standing] = {}

    def standing(self, x: Description) -> _Standing:
        """How x stands to the groups."""
        profile = (x.key, x.mask)
        found = self._standings.get(profile)
        if found is None:
            found = self._standings[profile] = self._compared(x)
        return found

    def _compared(self, x: Description) -> _Standing:
        best: Number = 0
        rival: Number | None = None
        group: Key | None = None
        possible = 0
        for key in self._offered:
            score = self._of(x, key)
            if score <= 0:
                continue
            possible += 1
            if score > best:
                best, rival, group = score, best or None, key
            else:
                rival = score if rival is None else max(rival, score)
                if score == best:
                    group = None
        return _Standing(best, group, rival, possible == 1)

    def _of(self, x: Description, group: Key) -> Number:
        """The score of x with the members of a group that it may be, else 0."""
        for y in self._offered[group]:
            if x.may_be(y):
                return self._score(x, y)
        return 0

    def has_room(self, x: Description, standing: _Standing, complete: bool) -> bool:
        """Whether the group takes x with all others that compete for it."""
        group = standing.group
        if group is None:
            return False
        room = sum(1 for y in self._offered[group] if x.may_be(y))
        rivals = sum(1 for o in self._seeking if self._of(o, group) >= standing.best)
        if rivals <= room:
            return True
        if not standing.only or not complete:
            return False
        bound = sum(1 for o in self._seeking if self._bound_to(o, group))
        return bound <= room

    def _bound_to(self, x: Description, group: Key) -> bool:
        standing = self.standing(x)
        return standing.only and standing.group == group
