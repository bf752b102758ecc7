"""Changes of facts when two descriptions merge or become alike [T 2.3.2, 2.3.3].

Every fact that mentions the younger name gets the older name, with its stamp; where two
facts disagree, the newer fact stays. Views and names are for `recognizer`.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.values import Atom, Fact
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.memory import Memory
from rapc.runtime.memory.recognition.sets import UNKNOWN, Description
from rapc.world import Time


def merge_facts(memory: Memory, kept: str, lost: str, first: str, own: str) -> None:
    """Turn all facts about `lost` into facts about `kept`.

    Of two values the newer value stays; if their times are equal, the value of the name
    `first` stays. The values of the name `own` always stay, whatever the stamps ("" for
    no name).
    """
    assert memory.mentions is not None
    sources = dict.fromkeys(memory.mentions.of(kept), kept)
    shared: set[Fact] = set()
    for fact in memory.mentions.of(lost):
        renamed = _renamed(fact, lost, kept)
        rival = _rival(memory, renamed)
        if rival is None or rival == fact:
            memory.rename(fact, renamed, _stamp_of(memory, fact))
            sources[renamed] = lost
        elif rival == renamed:
            its, mine = _stamp_of(memory, fact), _stamp_of(memory, rival)
            memory.rename(fact, renamed, max(its, mine))
            sources[renamed] = own or (lost if its > mine else kept)
            shared.add(renamed)
        elif _wins(memory, (lost, fact), (kept, rival), first, own):
            stamp = _stamp_of(memory, fact)
            memory.remove(rival, "memory")
            memory.rename(fact, renamed, stamp)
            sources[renamed] = lost
        else:
            memory.remove(fact, "memory")
    if memory.exclusions is not None:
        _keep_newer(memory, sources, first, own)
        for fact in shared:
            del sources[fact]
        _drop_outdated(memory, sources, (kept, lost), own or first, own)


def _renamed(fact: Fact, old: str, new: str) -> Fact:
    return (fact[0], *[new if part == old else part for part in fact[1:]])


def _rival(memory: Memory, fact: Fact) -> Fact | None:
    """Return the fact in memory that is equal, or has another value of the property."""
    return fact if fact in memory.facts else memory.facts.asserted(fact[:-1])


def _stamp_of(memory: Memory, fact: Fact) -> Time:
    """Return the stamp of a stored fact."""
    return memory.facts.table(fact[0]).stamps[fact]


def _wins(
    memory: Memory, one: tuple[str, Fact], other: tuple[str, Fact], first: str, own: str
) -> bool:
    """Return whether the first of two disagreeing facts with sources stays."""
    mine, theirs = (_stamp_of(memory, fact) for _, fact in (one, other))
    if own and NEVER not in (mine, theirs) and own in (one[0], other[0]):
        return own == one[0]
    if mine != theirs:
        return mine > theirs
    return first == one[0]


def _keep_newer(memory: Memory, sources: dict[Fact, str], first: str, own: str) -> None:
    """Remove the older of two facts that a merge brings together in conflict."""
    assert memory.exclusions is not None
    for fact, source in sources.items():
        if fact not in memory.facts:
            continue
        for other in memory.exclusions.of(fact):
            one, two = (source, fact), (sources.get(other, ""), other)
            if _wins(memory, one, two, first, own):
                memory.remove(other, "memory")
            elif fact in memory.facts:
                memory.remove(fact, "memory")
                break


def _drop_outdated(
    memory: Memory,
    sources: dict[Fact, str],
    names: tuple[str, str],
    first: str,
    own: str,
) -> None:
    """Remove facts that a fact of the other name excluded later."""
    exclusions = memory.exclusions
    assert exclusions is not None
    kept, lost = names
    for name in names:
        for fact, time in exclusions.past(name):
            for other in exclusions.of(_renamed(fact, lost, kept)):
                stamp, source = _stamp_of(memory, other), sources.get(other, name)
                if source == name or (source == own and stamp != NEVER):
                    continue
                if time > stamp or (time == stamp and name == first):
                    memory.remove(other, "memory")
    for fact, time in exclusions.forget(lost):
        exclusions.asserted(_renamed(fact, lost, kept), time)


def make_alike(memory: Memory, members: Sequence[Description]) -> None:
    """Forget the properties that descriptions do not share, as if never asserted.

    Shared properties, with class and place, keep the oldest stamp.
    """
    if len(members) < 2:
        return
    indexes = dict.fromkeys(i for member in members for i in member.values)
    for index in indexes:
        values = {member.values.get(index) for member in members}
        shared = values.pop() if len(values) == 1 else None
        value: Atom = UNKNOWN if shared is None else shared
        facts = [_fact(m, index, value) for m in members if not m.empty]
        stamp = NEVER if shared is None else min(_stamp_of(memory, f) for f in facts)
        _stamp(memory, facts, stamp)
    _share_past(memory, members)
    named = [member for member in members if not member.empty]
    for of_all in ([_class(m) for m in named], [_place(m) for m in named]):
        stamps = [_stamp_of(memory, fact) for fact in of_all]
        _stamp(memory, of_all, min(stamps, default=NEVER))


def _share_past(memory: Memory, members: Sequence[Description]) -> None:
    """Keep the past assertions that all members share, each with its oldest time."""
    exclusions = memory.exclusions
    if exclusions is None:
        return
    pasts = [
        {
            exclusions.excluded(_renamed(p[0], m.name, "")): p
            for p in exclusions.forget(m.name)
        }
        for m in members
    ]
    for past in pasts:
        for excluded, (fact, _) in past.items():
            if all(excluded in each for each in pasts):
                oldest = min(each[excluded][1] for each in pasts)
                exclusions.asserted(fact, oldest)


def _stamp(memory: Memory, facts: Sequence[Fact], stamp: Time) -> None:
    for fact in facts:
        if memory.facts.stamp(fact) != stamp:
            memory.store(fact, "memory", stamp)


def _class(member: Description) -> Fact:
    return ("class", member.name, member.kind, "true")


def _place(member: Description) -> Fact:
    assert member.home is not None
    return ("location", member.name, member.home.place)


def _fact(member: Description, index: Fact, value: Atom) -> Fact:
    return (index[0], member.name, *index[1:], value)


def forget_facts(memory: Memory, name: str) -> None:
    """Erase all facts that mention a name."""
    assert memory.mentions is not None
    if memory.exclusions is not None:
        memory.exclusions.forget(name)
    for fact in memory.mentions.of(name):
        memory.remove(fact, "memory")
