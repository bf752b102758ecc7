"""The facts of the plain memory: one dict, searched from end to end."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.values import Atom, Fact

from .plain_parts import Declared, Thing

NEVER = float("-inf")
"""The stamp of what became unknown and was never asserted."""

Properties = dict[Fact, tuple[Atom, float]]
"""Value and stamp by index without the item."""


class Facts:
    """Facts with their stamps, and the names that stand for others."""

    def __init__(self, declared: Declared) -> None:
        self.now: float = 0
        self.stamps: dict[Fact, float] = {}
        #: When facts of a name and last part were last excluded for an item.
        self.denied: dict[Fact, float] = {}
        self.aliases: dict[Atom, Atom] = {}
        self.declared = declared

    def name(self, name: Atom) -> Atom:
        """The name that now stands for a name."""
        while name in self.aliases:
            name = self.aliases[name]
        return name

    def put(self, *fact: Atom) -> None:
        """Assert a fact now; what it contradicts goes."""
        fact = (fact[0], *map(self.name, fact[1:]))
        for other in list(self.stamps):
            if self.contradict(fact, other):
                del self.stamps[other]
        self.stamps.pop(fact, None)
        self.stamps[fact] = self.now
        for owner, value, barred, forbidden in self.declared.excludes:
            if (fact[0], fact[-1]) == (owner, value):
                self.denied[barred, fact[1], forbidden] = self.now
            if (fact[0], fact[-1]) == (barred, forbidden):
                self.denied[owner, fact[1], value] = self.now

    def erase(self, prefix: Fact) -> None:
        """Every fact that starts so goes."""
        prefix = (prefix[0], *map(self.name, prefix[1:]))
        for fact in list(self.stamps):
            if fact[: len(prefix)] == prefix:
                del self.stamps[fact]

    def value(self, *index: Atom) -> Atom | None:
        """The value of a property for an index."""
        for fact in self.stamps:
            if fact[:-1] == index:
                return fact[-1]
        return None

    def forget(self, name: Atom) -> None:
        """Every fact that mentions a name goes."""
        for fact in list(self.stamps):
            if name in fact[1:]:
                del self.stamps[fact]
        self._drop_denied(name)

    def _drop_denied(self, name: Atom) -> dict[tuple[Atom, Atom], float]:
        """Drop when facts of an item were denied; by what they are without the item."""
        mine = [(what, of, value) for what, of, value in self.denied if of == name]
        return {
            (what, value): self.denied.pop((what, name, value))
            for what, _, value in mine
        }

    def share_denied(self, names: Sequence[Atom | None]) -> None:
        """What was not denied of all of these items was denied of none."""
        dropped = [self._drop_denied(name) if name else {} for name in names]
        for what, value in dropped[0]:
            if all((what, value) in each for each in dropped):
                for name in names:
                    oldest = min(each[what, value] for each in dropped)
                    self.denied[what, str(name), value] = oldest

    def contradict(self, one: Fact, other: Fact) -> bool:
        """Whether two facts cannot stand beside each other."""
        if one != other and one[:-1] == other[:-1]:
            return one[0] in self.declared.properties
        return self._excludes(one, other) or self._excludes(other, one)

    def _excludes(self, one: Fact, other: Fact) -> bool:
        if one[1] != other[1]:
            return False
        ends = (one[0], one[-1], other[0], other[-1])
        return ends in self.declared.excludes

    def of(self, thing: Thing) -> Properties:
        """The further properties of a thing: not its place and introducing class."""
        found: Properties = {}
        for fact, stamp in self.stamps.items():
            index = (fact[0], *fact[2:-1])
            if fact[0] not in self.declared.properties or fact[1] != thing.name:
                continue
            if index not in (("location",), ("class", thing.kind)):
                found[index] = (fact[-1], stamp)
        return found

    def set(self, thing: Thing, index: Fact, value: Atom, stamp: float) -> None:
        """A property of a thing has a value since then."""
        mine = (index[0], str(thing.name), *index[1:])
        for fact in list(self.stamps):
            if fact[:-1] == mine:
                del self.stamps[fact]
        self.stamps[*mine, value] = stamp

    def stamp(self, thing: Thing, *index: Atom) -> float:
        """When a property of a thing was last asserted."""
        mine = (index[0], str(thing.name), *index[1:])
        return next(s for fact, s in self.stamps.items() if fact[:-1] == mine)

    def merge(self, keep: str, gone: str, gone_is_stronger: bool, wins: bool) -> None:
        """One name stands for two; at one time the stronger one's facts stay.

        If `wins`, those facts stay at any time, except what was never asserted.
        """
        its_denied, my_denied = self._drop_denied(gone), self._drop_denied(keep)
        its = {f: s for f, s in self.stamps.items() if gone in f[1:]}
        for fact in its:
            del self.stamps[fact]
        mine = {f: s for f, s in self.stamps.items() if keep in f[1:]}
        self.aliases[gone] = keep
        renamed = {tuple(map(self.name, f)): s for f, s in its.items()}
        strong, weak = (renamed, mine) if gone_is_stronger else (mine, renamed)
        hard, soft = my_denied, its_denied
        if gone_is_stronger:
            hard, soft = soft, hard
        kept: dict[Fact, float] = {}
        sides = (strong, weak, soft, True), (weak, strong, hard, False)
        for facts, others, denied, better in sides:
            for fact, stamp in facts.items():
                rivals = [s for f, s in others.items() if self.contradict(fact, f)]
                stays = [_stays(stamp, rival, better, wins) for rival in rivals]
                if fact[1] == keep and (fact[0], fact[-1]) in denied:
                    rival = denied[fact[0], fact[-1]]
                    stays.append(_stays(stamp, rival, better, wins and better))
                if all(stays):
                    kept[fact] = max(stamp, kept.get(fact, NEVER))
        for what, value in {**my_denied, **its_denied}:
            stamps = [
                d[what, value] for d in (my_denied, its_denied) if (what, value) in d
            ]
            self.denied[what, keep, value] = max(stamps)
        for fact in mine:
            self.stamps.pop(fact, None)
        self.stamps.update(kept)


def _stays(stamp: float, rival: float, stronger: bool, wins: bool) -> bool:
    """Whether a fact stays against one that contradicts it."""
    if wins and stronger and stamp != NEVER:
        return True
    if wins and not stronger and rival != NEVER:
        return False
    return stamp >= rival if stronger else stamp > rival
