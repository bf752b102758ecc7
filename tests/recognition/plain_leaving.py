"""Which things go when an item leaves a set: every collection is tried.

So it is for small sets only; the bound of 14 groups, above which section 7 is content
with less than the smallest collection, is not kept here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from rapc.base.values import Atom

from .plain_facts import NEVER, Facts
from .plain_matching import Look
from .plain_parts import Expected, Thing

Merge = Callable[[Thing, Thing, Thing | None], tuple[Thing, Thing]]
"""Makes two things one, of which the third keeps its values; who is kept and gone."""

Groups = list[list[Thing]]


@dataclass
class Left:
    """Who has left; the other name the item has now; how sure that was.

    `dropped` went for the item without being it, and stand nowhere now.
    """

    who: list[Thing]
    other: str | None = None
    score: float | None = None
    rival: float | None = None
    dropped: list[Thing] = field(default_factory=list)

    @property
    def told(self) -> tuple[str | None, float | None, float | None]:
        """What an event says of it."""
        return self.other, self.score, self.rival


def leave(thing: Thing, expected: Expected, facts: Facts, merge: Merge) -> Left:
    """A thing leaves a set: it goes from every view, or another one for it."""
    look = Look(expected, facts)
    may = [d for d in expected.things() if not _known_other(expected, thing, d)]
    served = [
        layer.members
        for layer in expected.layers
        if thing not in layer.members and any(d in may for d in layer.members)
    ]
    choices = [_choices(look, thing, members) for members in served]
    candidates = [d for groups in choices for group in groups for d in group]
    found = _collection(served, choices, candidates)
    found = found or _collection(served, choices, may)
    scored = _scored(look, thing, choices, found[1] if found else [])
    for view in expected.views():
        if thing in view:
            view.remove(thing)
    if found is None:
        return Left([thing], dropped=_drop(expected, served, choices))
    collection, leavers = found
    make_alike([each for each in collection if each.name], collection, facts)
    for view in expected.views():
        view[:] = [each for each in view if each not in leavers]
    return _absorb(thing, leavers, merge, scored)


def _absorb(
    thing: Thing,
    leavers: Sequence[Thing],
    merge: Merge,
    scored: tuple[float | None, float | None],
) -> Left:
    left = Left([thing], None, *scored)
    for leaver in leavers:
        mover = left.who[0]
        keep, gone = merge(mover, leaver, mover if thing.name else None)
        left.who = [keep]
        left.other = left.other or gone.name
    if thing.name and left.who[0] is not thing:
        left.other = thing.name
    return left


def _choices(look: Look, thing: Thing, members: list[Thing]) -> Groups:
    """The groups of a layer to which the thing may belong."""
    expected = look.expected
    strangers = [d for d in members if not _known_other(expected, thing, d)]
    groups = look.groups(strangers)
    best = max((look.score(thing, g[0]) for g in groups), default=0)
    if best <= 0:
        whole = look.groups(members)
        return [g for g in whole if all(d in strangers for d in g)] or groups
    return [group for group in groups if look.score(thing, group[0]) == best]


def _known_other(expected: Expected, thing: Thing, other: Thing) -> bool:
    """Whether they stand in one view, or one of them alone is in reach there."""
    return expected.apart(thing, other) or other in expected.local


def _collection(
    served: list[list[Thing]], choices: list[Groups], among: Sequence[Thing]
) -> tuple[Sequence[Thing], Sequence[Thing]] | None:
    """The smallest collection with members that serve each layer once, and these."""
    groups = [group for layer in choices for group in layer]
    pool = sorted(set(among), key=lambda d: d.number)
    for size in range(len(pool) + 1):
        found = [
            (collection, leavers)
            for collection in combinations(pool, size)
            if all(any(d in collection for d in group) for group in groups)
            for leavers in _subsets(collection)
            if _serve(leavers, served)
        ]
        if found:
            return min(found, key=lambda pair: (_rank(pair[1]), _rank(pair[0])))
    return None


def _rank(things: Sequence[Thing]) -> tuple[int, int, list[tuple[bool, int]]]:
    """The fewest come first, of those the most empty ones, of those the oldest."""
    ages = sorted((thing.name is not None, thing.number) for thing in things)
    return len(things), sum(real for real, _ in ages), ages


def _subsets(things: Sequence[Thing]) -> Iterable[Sequence[Thing]]:
    for size in range(len(things) + 1):
        yield from combinations(things, size)


def _serve(leavers: Sequence[Thing], served: list[list[Thing]]) -> bool:
    """Whether of each layer exactly one leaves."""
    return all(sum(each in members for each in leavers) == 1 for members in served)


def _drop(
    expected: Expected, served: list[list[Thing]], choices: list[Groups]
) -> list[Thing]:
    """Where layers cannot be served together, what may be the item goes for good."""
    gone: list[Thing] = []
    for members, groups in zip(served, choices, strict=True):
        if not any(each in members for each in gone):
            fit = [d for group in groups for d in group]
            gone.append(min(fit, key=lambda d: (d.name is not None, d.number)))
    for view in expected.views():
        view[:] = [each for each in view if each not in gone]
    return gone


def _scored(
    look: Look, thing: Thing, choices: list[Groups], leavers: Sequence[Thing]
) -> tuple[float | None, float | None]:
    """The best score of what leaves, and of what might have left as well."""
    taken: list[float] = []
    rivals: list[float] = []
    for group in (group for layer in choices for group in layer):
        to = taken if any(each in group for each in leavers) else rivals
        to.append(look.score(thing, group[0]))
    return max(taken, default=None), max(rivals, default=None) or None


def make_alike(
    named: Sequence[Thing], collection: Sequence[Thing], facts: Facts
) -> None:
    """What a collection does not share becomes unknown; the rest is as old as any."""
    if len(collection) < 2:
        return
    facts.share_denied([thing.name for thing in collection])
    every = [facts.of(thing) for thing in named]
    empty = len(named) < len(collection)
    for index in {index: None for each in every for index in each}:
        values: list[Atom | None] = [
            each[index][0] if index in each else None for each in every
        ]
        alike = not empty and len(set(values)) == 1
        stamps = [each[index][1] for each in every if index in each]
        value = values[0] if alike and values[0] is not None else "unknown"
        for thing in named:
            facts.set(thing, index, value, min(stamps) if alike else NEVER)
    for index in (("class", named[0].kind), ("location",)) if named else ():
        oldest = min(facts.stamp(each, *index) for each in named)
        for thing in named:
            at = facts.value(index[0], str(thing.name), *index[1:])
            facts.set(thing, index, at or "unknown", oldest)
