"""Which identification a set allows: every pair of views, every thing, every group."""

from __future__ import annotations

from dataclasses import dataclass

from .plain_facts import Facts, Properties
from .plain_parts import Comparator, Expected, Known, Thing


@dataclass(frozen=True)
class Match:
    """Two things that are one, how well they match, and the best rival's score."""

    one: Thing
    other: Thing
    score: float
    rival: float | None


class Look:
    """The things of one set as they are now: what they score, and who is alike."""

    def __init__(self, expected: Expected, facts: Facts) -> None:
        self.expected = expected
        self._comparator = facts.declared.comparator(expected.kind, expected.place)
        self._known: dict[Thing, Known] = {}
        for view in expected.views():
            for thing in view:
                self._known[thing] = (
                    {} if thing.name is None else known(facts.of(thing))
                )

    def score(self, one: Thing, other: Thing) -> float:
        """How well two things match; 0 or less rules them out."""
        return score(self._known[one], self._known[other], self._comparator)

    def groups(self, things: list[Thing]) -> list[list[Thing]]:
        """Those that cannot be told apart together; one in reach is by itself."""
        groups: list[list[Thing]] = []
        for thing in sorted(things, key=lambda each: each.number):
            for group in groups:
                if self._identical(thing, group[0]):
                    group.append(thing)
                    break
            else:
                groups.append([thing])
        return groups

    def _identical(self, one: Thing, other: Thing) -> bool:
        return one.sensor == other.sensor and self._known[one] == self._known[other]


def known(properties: Properties) -> Known:
    """What is known: `unknown` is the same as no assertion."""
    return {
        index: value for index, (value, _) in properties.items() if value != "unknown"
    }


def score(one: Known, other: Known, comparator: Comparator) -> float:
    """10 for the class and, unless declared otherwise, for each property shared."""
    if comparator.function is not None:
        return comparator.function(one, other)
    total: float = 10
    for index in one:
        name = str(index[0])
        if index not in other:
            continue
        if one[index] == other[index]:
            if name not in comparator.ignored:
                total += comparator.weights.get(name, 10)
        elif name in comparator.veto:
            return 0
    return total


def first_match(expected: Expected, facts: Facts) -> Match | None:
    """The best match of the first ordered pair of views that has any."""
    look = Look(expected, facts)
    for view in expected.views():
        for other in expected.views():
            if view is not other:
                found = _matches(look, view, other)
                if found:
                    return min(found, key=lambda m: (-m.score, m.one.number))
    return None


def _matches(look: Look, view: list[Thing], other: list[Thing]) -> list[Match]:
    waiting = [thing for thing in view if thing not in other]
    offered = [thing for thing in other if thing not in view]
    incomplete = other is look.expected.local and len(other) < look.expected.size
    found = []
    for thing in waiting:
        match = _match(look, thing, waiting, look.groups(offered), incomplete)
        if match is not None:
            found.append(match)
    return found


def _match(
    look: Look,
    thing: Thing,
    waiting: list[Thing],
    groups: list[list[Thing]],
    incomplete: bool,
) -> Match | None:
    scores = [_best(look, thing, group) for group in groups]
    ranked = sorted(range(len(groups)), key=lambda at: -(scores[at] or 0))
    if not ranked or (scores[ranked[0]] or 0) <= 0:
        return None
    at = ranked[0]
    best, rivals = scores[at] or 0, [scores[i] for i in ranked[1:]]
    rival = max((each for each in rivals if each is not None), default=None)
    if rival is not None and rival == best:
        return None
    group = [d for d in groups[at] if not look.expected.apart(thing, d)]
    as_high = [x for x in waiting if (_best(look, x, groups[at]) or 0) >= best]
    fits = len(as_high) <= len(group)
    if not fits and not incomplete and (rival or 0) <= 0:
        alone = [x for x in waiting if _only(look, x, groups, at)]
        fits = len(alone) <= len(group)
    if not fits:
        return None
    standing = look.expected.standing
    taken = min(group, key=lambda d: (-standing(d), d.name is None, d.number))
    return Match(thing, taken, best, rival if (rival or 0) > 0 else None)


def _best(look: Look, thing: Thing, group: list[Thing]) -> float | None:
    """What a thing scores on a group; None if none of it may be compared with it."""
    apart = look.expected.apart
    return max(
        (look.score(thing, d) for d in group if not apart(thing, d)), default=None
    )


def _only(look: Look, thing: Thing, groups: list[list[Thing]], at: int) -> bool:
    """Whether every group but one is ruled out for a thing."""
    scores = [_best(look, thing, group) or 0 for group in groups]
    return [i for i, each in enumerate(scores) if each > 0] == [at]
