"""Departure of an item from a set, in all layers at once [T 2.3.3].

The collection has a member of every candidate group in every layer to be served. Memory
makes the properties unknown that tell these members apart. Some of the members leave,
and each layer loses exactly one of them. The search for the smallest collection is
exact for few groups, and greedy for more groups.
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
"""The highest number of candidate groups for an exact search."""

STEPS = 100_000
"""The highest number of steps in the search for ways to leave."""

Members = tuple[Description, ...]


class Collection(msgspec.Struct, frozen=True):
    """The descriptions that may be a leaving item.

    `members` become alike; `leaving` are those members that are exactly once in each
    layer to be served. `score` is the item's best score with a candidate group from
    which a member leaves, `rival` its best score with a group from which none leaves;
    None without such a group.
    """

    members: Members
    leaving: Members
    score: Number | None
    rival: Number | None


class _Candidate(msgspec.Struct, frozen=True):
    """A description with bits for its groups and its layers to serve."""

    description: Description
    groups: int
    layers: int

    @property
    def order(self) -> tuple[bool, int]:
        """Return the sort key: empty descriptions first, then the oldest."""
        return (not self.description.empty, self.description.number)


def candidate_groups(
    layer: View, item: Description, outside: int, score: Score
) -> tuple[Number, list[list[Description]]]:
    """Return the groups of a layer that an item may be of, with the highest score.

    `outside` has the bits of all views whose members are known to be other items. If
    all groups are ruled out, the groups without such a member remain.
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
    """Return the layers that must lose a description, with candidate groups.

    The result leaves out a layer that contains the item itself, and a layer whose
    members are all known to be other items: there the item was never expected.
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
    """Return the smallest collection, or None if no choice serves each layer once.

    If the candidates are not sufficient, other descriptions that may be the item
    complete the choice.
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
    """Return descriptions with their candidate groups, one description of each kind."""
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
    """Remove a possible description from each layer; return all removed ones.

    For layers that contradict each other: no way to leave serves each layer once. A
    removed description leaves all layers. Otherwise, a layer that still contained the
    description could match it with a description beside which it stood. Therefore a
    layer can lose more than one description.
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
    """Return the best candidate of each kind: no choice needs two of a kind."""
    kept: dict[tuple[int, int], _Candidate] = {}
    for candidate in sorted(candidates, key=lambda c: c.order):
        kept.setdefault((candidate.groups, candidate.layers), candidate)
    return list(kept.values())


def _choose(
    candidates: Sequence[_Candidate], count: int, layers: int
) -> tuple[list[_Candidate], list[_Candidate]] | None:
    """Return the members of the smallest collection, and the leaving ones of them."""
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
    """Yield the ways to serve each layer exactly once, short ones early."""
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
    """The fewest candidates that hit given groups, preferring empty and old ones."""

    def __init__(self, candidates: Sequence[_Candidate]) -> None:
        self._candidates = sorted(candidates, key=lambda c: c.order)
        self._known: dict[int, tuple[_Candidate, ...]] = {0: ()}

    def of(self, wanted: int) -> tuple[_Candidate, ...]:
        """Return the candidates; the search solves smaller sets of groups first."""
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
    """Return the cost: fewest first, then most empty ones, then oldest."""
    real = sum(not c.description.empty for c in chosen)
    return (len(chosen), real, sorted(c.order for c in chosen))


class _Greedy:
    """A greedy choice of candidates: the next hits most of the remaining groups.

    The number of groups that a candidate still hits only shrinks. Therefore a heap
    finds the best candidate without looking at all candidates again.
    """

    def __init__(self, candidates: Sequence[_Candidate]) -> None:
        self._candidates = candidates

    def of(self, wanted: int) -> tuple[_Candidate, ...]:
        """Return the candidates, at most as many as there are groups."""
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
