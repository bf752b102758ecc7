"""The next identification that a set allows: the best maximal match [T 2.3.2, 2.3.3].

The search compares every ordered pair of views, local model first, then layers from
latest to earliest. The first pair with matches gives the match with the highest score.
Not here: the merge of the two descriptions (`recognizer`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable

import msgspec

from rapc.base.values import Atom, Fact, Number
from rapc.runtime.memory.recognition.candidates import Candidates, Group, SameKnown
from rapc.runtime.memory.recognition.scoring import SHARED, Score
from rapc.runtime.memory.recognition.sets import (
    Description,
    ExpectationSet,
    View,
)

Profile = tuple[frozenset[tuple[Fact, Atom]], int]
"""The common part of descriptions of a view with equal scores for all others."""


Seekers = dict[Profile, tuple[Description, int]]
"""The descriptions that seek a match: by profile, the oldest one and their number."""


class Match(msgspec.Struct, frozen=True):
    """Two descriptions of the same item.

    `score` is the score of the match, `rival` the best score of `one` with another
    candidate group of the view that holds `other`; None without another group.
    """

    one: Description
    other: Description
    score: Number
    rival: Number | None


class _Standing(msgspec.Struct, frozen=True):
    """The scores of a description with the candidate groups of another view.

    `best` is the highest score, `group` the only group with this score, `rival` the
    next lower score, `only` whether every other group is ruled out.
    """

    best: Number
    group: Group | None
    rival: Number | None
    only: bool


def best_match(of: ExpectationSet, score: Score) -> Match | None:
    """Return the next identification to make, or None without a match.

    The search skips pairs of views in which nothing has changed since the last search.
    """
    views = [view for view in of.views() if view.members]
    for one in views:
        for other in views:
            if one is other:
                continue
            complete = other is not of.local or len(other) == of.size
            now = (one.version, other.version, complete)
            if of.settled.get((one.bit, other.bit)) == now:
                continue
            found = _best_of_pair(_Table(of, one, other, score), complete)
            if found is not None:
                return found
            of.settled[one.bit, other.bit] = now
    return None


def _best_of_pair(table: _Table, complete: bool) -> Match | None:
    best: tuple[Number, int] | None = None
    match = None
    for profile, (x, _) in table.seekers.items():
        standing = table.standing(profile, x)
        order = (-standing.best, x.number)
        if standing.group is None or (best is not None and order > best):
            continue
        if table.has_room(profile, standing, complete):
            best = order
            y = standing.group.member(x.mask)
            match = Match(x, y, standing.best, standing.rival)
    return match


def _candidates(of: ExpectationSet, view: View, one: View) -> Candidates:
    """Return the candidates of a view for another view, from a cache if valid."""
    shared = _shared(view, one)
    known = of.candidates.get((view.bit, shared))
    if known is not None and known[0] == view.version:
        found: Candidates = known[1]
        return found
    offer = Candidates(y for y in view.members if not y.mask & shared)
    of.candidates[view.bit, shared] = (view.version, offer)
    return offer


def _seekers(of: ExpectationSet, view: View, other: View) -> Seekers:
    """Return the descriptions of a view that seek a match, from a cache."""
    shared = _shared(view, other)
    known = of.seekers.get((view.bit, shared))
    if known is not None and known[0] == view.version:
        found: Seekers = known[1]
        return found
    seekers: Seekers = {}
    for x in view.members:
        if not x.mask & shared:
            profile = (x.known, x.mask)
            oldest, count = seekers.get(profile, (x, 0))
            oldest = oldest if oldest.number < x.number else x
            seekers[profile] = (oldest, count + 1)
    of.seekers[view.bit, shared] = (view.version, seekers)
    return seekers


def _shared(view: View, other: View) -> int:
    """Return the bit of the other view if it has a member of this view, else 0."""
    bit = other.bit
    return bit if any(d.mask & bit for d in view.members) else 0


class _Table:
    """The scores of a view's descriptions with another view's candidate groups.

    Descriptions with equal known properties in the same views have equal scores with
    all groups. Therefore only the oldest description of each profile is compared.
    """

    def __init__(
        self, of: ExpectationSet, one: View, other: View, score: Score
    ) -> None:
        self.seekers = _seekers(of, one, other)
        self._candidates = _candidates(of, other, one)
        self._score = score
        self._standings: dict[Profile, _Standing] = {}
        self._strange: dict[int, _Standing] = {}
        self._on: dict[tuple[SameKnown, int], list[Number]] = {}

    def standing(self, profile: Profile, x: Description) -> _Standing:
        """Return the scores of the descriptions of a profile, x among them."""
        found = self._standings.get(profile)
        if found is None:
            found = self._standings[profile] = self._compared(x)
        return found

    def _compared(self, x: Description) -> _Standing:
        """Compare x with all kinds, or with the kinds that share a property with x."""
        if not self._score.sparse:
            return self._scored(x, self._candidates.kinds())
        sharing = self._candidates.sharing(x)
        if sharing:
            return self._scored(x, sharing)
        found = self._strange.get(x.mask)
        if found is None:
            found = self._strange[x.mask] = self._scored(x, ())
        return found

    def _scored(self, x: Description, kinds: Iterable[SameKnown]) -> _Standing:
        """Compare x with kinds; with a sparse comparator other kinds score `SHARED`."""
        scored: list[tuple[Number, int, SameKnown | None]] = []
        plain = self._candidates.count(x.mask)
        for kind in kinds:
            y = kind.first(x.mask)
            if y is not None:
                number = kind.count(x.mask)
                plain -= number
                scored.append((self._score.of(x, y), number, kind))
        if self._score.sparse and plain:
            scored.append((SHARED, plain, None))
        return self._standing([s for s in scored if s[0] > 0], x)

    def _standing(
        self, scored: list[tuple[Number, int, SameKnown | None]], x: Description
    ) -> _Standing:
        if not scored:
            return _Standing(0, None, None, False)
        best = max(score for score, _, _ in scored)
        top = [(number, kind) for score, number, kind in scored if score == best]
        others = [score for score, _, _ in scored if score != best]
        if len(top) > 1 or top[0][0] > 1:
            return _Standing(best, None, best, False)
        kind = top[0][1]
        if kind is None:
            shared = self._candidates.sharing(x)
            kind = next(
                k
                for k in self._candidates.kinds()
                if k not in shared and k.first(x.mask)
            )
        rival = max(others, default=None)
        return _Standing(best, kind.group(x.mask), rival, rival is None)

    def has_room(self, profile: Profile, standing: _Standing, complete: bool) -> bool:
        """Return whether the group has room for x and all its competitors."""
        group = standing.group
        assert group is not None
        room = group.room(profile[1])
        if self._competing(group, standing.best) <= room:
            return True
        if not standing.only or not complete:
            return False
        bound = 0
        for other, (x, count) in self.seekers.items():
            rival = self.standing(other, x)
            if rival.only and rival.group is not None and rival.group.same(group):
                bound += count
        return bound <= room

    def _competing(self, group: Group, least: Number) -> int:
        """Return how many descriptions score at least `least` on a group."""
        key = (group.kind, group.number)
        scores = self._on.get(key)
        if scores is None:
            scores = []
            for (_, mask), (x, count) in self.seekers.items():
                if group.room(mask):
                    score = self._score.of(x, group.member(mask))
                    scores.extend([score] * count)
            scores.sort()
            self._on[key] = scores
        return len(scores) - bisect_left(scores, least)
