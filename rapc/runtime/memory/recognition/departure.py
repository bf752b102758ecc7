"""Which descriptions go when an item leaves a set, in all layers at once [T 2.3.3].

The collection has a member of every candidate group in every layer to be served, so
that what tells them apart can be made unknown; some of its members leave, so that
each layer loses exactly one. The smallest collection is found exactly where there
are few groups; above that, groups are hit greedily.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

import msgspec

from rapc.base.values import Number
from rapc.runtime.memory.recognition.scoring import Score
from rapc.runtime.memory.recognition.sets import (
    Description,
    ExpectationSet,
    Key,
    View,
)

EXACT = 14
"""Up to so many candidate groups the smallest collection is searched exactly."""

STEPS = 100_000
"""So many steps are made at most in looking for ways to leave."""

Members = tuple[Description, ...]


class Collection(msgspec.Struct, frozen=True):
    """Which descriptions an item that leaves may be.

    `members` become alike; `leaving` are those of them that stand exactly once in
    each layer to be served. `score` is the item's best with a candidate group of which
    one leaves, `rival` its best with one none of which leaves; None where there is no
    such group.
    """

    members: Members
    leaving: Members
    score: Number | None
    rival: Number | None


class _Candidate(msgspec.Struct, frozen=True):
    """A description with the groups it is in and the layers it would serve, as bits."""

    description: Description
    groups: int
    layers: int

    @property
    def order(self) -> tuple[bool, int]:
        """Empty ones first, then the oldest."""
        return (not self.description.empty, self.description.number)


def candidate_groups(
    layer: View, item: Description, outside: int, score: Score
) -> tuple[Number, list[list[Description]]]:
    """The groups of a layer that an item may be of: those with its highest score.

    `outside` has the bits of all views whose members are known to be other items. If
    all groups are ruled out, those that hold no such member are taken.
    """
    free = {d for d in layer.members if not d.mask & outside}
    by_key: dict[Key, list[Description]] = {}
    for member in layer.members:
        by_key.setdefault(member.key, []).append(member)
    grouped = list(by_key.values())
    scored = []
    for group in grouped:
        found = [d for d in group if d in free]
        if found:
            scored.append((score.of(item, found[0]), found))
    best = max((s for s, _ in scored), default=0)
    if best > 0:
        return best, [group for s, group in scored if s == best]
    unmixed = [group for group in grouped if free.issuperset(group)]
    return 0, unmixed or [group for _, group in scored]


def collect(
    of: ExpectationSet, item: Description, score: Score
) -> tuple[list[View], list[tuple[Number, list[list[Description]]]]]:
    """The layers that must lose a description for an item, with candidate groups.

    A layer in which the item stands itself is none of them, nor is one whose members
    are all known to be other items: there the item was never expected.
    """
    outside = item.mask | of.local.bit
    served = [
        layer
        for layer in of.layers
        if not item.mask & layer.bit
        and any(not d.mask & outside for d in layer.members)
    ]
    return served, [candidate_groups(v, item, outside, score) for v in served]


def smallest(
    served: Sequence[View], found: Sequence[tuple[Number, list[list[Description]]]]
) -> Collection | None:
    """The collection, or None if no descriptions stand once in each layer.

    If the candidates alone do not, others that may be the item complete them.
    """
    hits: dict[Description, int] = {}
    count = 0
    for _, grouped in found:
        for group in grouped:
            for description in group:
                hits[description] = hits.get(description, 0) | 1 << count
            count += 1
    chosen = _choose(_candidates(served, hits), count, len(served))
    if chosen is None:
        own = sum(layer.bit for layer in served)
        others = [d for v in served for d in v.members if not d.mask & ~own]
        hits = {**dict.fromkeys(others, 0), **hits}
        chosen = _choose(_candidates(served, hits), count, len(served))
    if chosen is None:
        return None
    members, leaving = chosen
    going = {c.description for c in leaving}
    groups = [(s, going.isdisjoint(g)) for s, grouped in found for g in grouped]
    return Collection(
        _descriptions(members),
        _descriptions(leaving),
        max((s for s, stays in groups if not stays), default=None),
        max((s for s, stays in groups if stays), default=None),
    )


def _candidates(
    served: Sequence[View], hits: Mapping[Description, int]
) -> list[_Candidate]:
    """Descriptions with the candidate groups that each is in, one of each kind."""
    found = []
    for description, groups in hits.items():
        stands = [description.mask & layer.bit > 0 for layer in served]
        layers = sum(1 << at for at, there in enumerate(stands) if there)
        found.append(_Candidate(description, groups, layers))
    return _thinned(found)


def drop_each(
    of: ExpectationSet,
    served: Sequence[View],
    found: Sequence[tuple[Number, list[list[Description]]]],
) -> list[Description]:
    """Let each layer lose one that may be the item; return what then is in no view.

    For layers that contradict each other: no way to leave serves each of them once. A
    description that goes leaves all layers, for in one that it does not leave it could
    be taken for a description that it stood beside. So a layer can lose more than one.
    """
    gone: list[Description] = []
    for layer, (_, groups) in zip(served, found, strict=True):
        if not any(member.mask & layer.bit for member in gone):
            free = [d for group in groups for d in group]
            gone.append(min(free, key=lambda d: (not d.empty, d.number)))
    for member in gone:
        for layer in of.layers:
            of.discard(layer, member)
    return gone


def _descriptions(chosen: Sequence[_Candidate]) -> Members:
    return tuple(sorted((c.description for c in chosen), key=lambda d: d.number))


def _thinned(candidates: Sequence[_Candidate]) -> list[_Candidate]:
    """The best candidate of each kind: two of a kind are never both needed."""
    kept: dict[tuple[int, int], _Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: c.order):
        kept.setdefault((candidate.groups, candidate.layers), candidate)
    return list(kept.values())


def _choose(
    candidates: Sequence[_Candidate], count: int, layers: int
) -> tuple[list[_Candidate], list[_Candidate]] | None:
    """The members of the smallest collection, and those of them that leave."""
    everything = (1 << count) - 1
    exact = count <= EXACT
    cover = _Exact(candidates) if exact else _Greedy(candidates)
    best: tuple[object, list[_Candidate], list[_Candidate]] | None = None
    for leaving in islice(_covers(candidates, layers), None if exact else 1):
        rest = everything
        for candidate in leaving:
            rest &= ~candidate.groups
        others = cover.of(rest)
        cost = (
            len(leaving) + len(others),
            _cost(leaving),
            _cost(others),
        )
        if best is None or cost < best[0]:  # type: ignore[operator]
            best = (cost, [*leaving, *others], list(leaving))
    return None if best is None else (best[1], best[2])


def _covers(
    candidates: Sequence[_Candidate], layers: int
) -> Iterator[tuple[_Candidate, ...]]:
    """All ways to serve each layer exactly once; those of few members come early."""
    by_layer: dict[int, list[_Candidate]] = {}
    youngest_first = sorted(candidates, key=lambda c: c.order, reverse=True)
    for candidate in sorted(youngest_first, key=lambda c: c.layers.bit_count()):
        if candidate.layers:
            lowest = candidate.layers & -candidate.layers
            by_layer.setdefault(lowest, []).append(candidate)
    stack: list[tuple[int, tuple[_Candidate, ...]]] = [((1 << layers) - 1, ())]
    for _ in range(STEPS):
        if not stack:
            return
        left, chosen = stack.pop()
        if not left:
            yield chosen
            continue
        for candidate in by_layer.get(left & -left, ()):
            if not candidate.layers & ~left:
                stack.append((left & ~candidate.layers, (*chosen, candidate)))


class _Exact:
    """The fewest candidates that hit given groups, empty and old ones before others."""

    def __init__(self, candidates: Sequence[_Candidate]) -> None:
        self._candidates = sorted(candidates, key=lambda c: c.order)
        self._known: dict[int, tuple[_Candidate, ...]] = {0: ()}

    def of(self, wanted: int) -> tuple[_Candidate, ...]:
        """The candidates; the groups left are worked off from the smallest set up."""
        stack = [wanted]
        while stack:
            top = stack[-1]
            options = self._options(top)
            missing = [rest for rest, _ in options if rest not in self._known]
            if top in self._known:
                stack.pop()
            elif missing:
                stack.extend(missing)
            else:
                found = [(*self._known[rest], c) for rest, c in options]
                self._known[top] = min(found, key=_cost)
                stack.pop()
        return self._known[wanted]

    def _options(self, wanted: int) -> list[tuple[int, _Candidate]]:
        lowest = wanted & -wanted
        return [(wanted & ~c.groups, c) for c in self._candidates if c.groups & lowest]


def _cost(chosen: tuple[_Candidate, ...]) -> tuple[int, int, list[tuple[bool, int]]]:
    """The fewest, of those the most empty ones, of those the oldest come first."""
    real = sum(not c.description.empty for c in chosen)
    return (len(chosen), real, sorted(c.order for c in chosen))


class _Greedy:
    """Candidates that hit given groups: each time the one that hits most of the rest.

    What a candidate would still hit only shrinks, so the best is found without
    looking at all of them again each time.
    """

    def __init__(self, candidates: Sequence[_Candidate]) -> None:
        self._candidates = candidates

    def of(self, wanted: int) -> tuple[_Candidate, ...]:
        """The candidates, never more than there are groups."""
        waiting = [
            (-(c.groups & wanted).bit_count(), c.order, at)
            for at, c in enumerate(self._candidates)
        ]
        heapq.heapify(waiting)
        chosen: list[_Candidate] = []
        while wanted:
            _, order, at = heapq.heappop(waiting)
            candidate = self._candidates[at]
            entry = (-(candidate.groups & wanted).bit_count(), order, at)
            if waiting and entry > waiting[0]:
                heapq.heappush(waiting, entry)
                continue
            chosen.append(candidate)
            wanted &= ~candidate.groups
        return tuple(chosen)
