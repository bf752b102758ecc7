"""What becomes of facts when two descriptions are one, or alike (T 2.3.2, 2.3.3).

Every fact that mentions the younger name gets the older one, with its stamp; where
two of them disagree the newer stays. Views and names are for `recognizer`.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.memory import Memory
from rapc.runtime.memory.recognition.descriptions import UNKNOWN, Description
from rapc.runtime.world import Time
from rapc.terms import Atom, Fact


def merge_facts(memory: Memory, kept: str, lost: str, first: str, own: str) -> None:
    """All facts about `lost` become facts about `kept`.

    Of two values the newer stays, at one time that of the name `first`; but of those
    that the name `own` has, whatever the stamps, none is lost ("" for no name).
    """
    stamps = memory.facts.stamps
    sources = dict.fromkeys(memory.facts.mentioning(kept), kept)
    for fact in memory.facts.mentioning(lost):
        renamed = tuple([kept if part == lost else part for part in fact])
        renamed = (fact[0], *renamed[1:])
        rival = _rival(memory, renamed)
        if rival is None or rival == fact:
            memory.rename(fact, renamed, stamps[fact])
            sources[renamed] = lost
        elif rival == renamed:
            memory.rename(fact, renamed, max(stamps[fact], stamps[rival]))
        elif _wins(memory, (lost, fact), (kept, rival), first, own):
            stamp = stamps[fact]
            memory.take(rival)
            memory.rename(fact, renamed, stamp)
            sources[renamed] = lost
        else:
            memory.take(fact)
    if memory.excluded is not None:
        _keep_newer(memory, sources, first, own)


def _rival(memory: Memory, fact: Fact) -> Fact | None:
    """The fact in memory that is this one, or has another value of its property."""
    if fact in memory.facts.stamps:
        return fact
    return memory.facts.values.get(fact[:-1])


def _wins(
    memory: Memory, one: tuple[str, Fact], other: tuple[str, Fact], first: str, own: str
) -> bool:
    """Whether the first of two facts that disagree, each with its source, stays."""
    stamps = memory.facts.stamps
    mine, theirs = stamps[one[1]], stamps[other[1]]
    if own and NEVER not in (mine, theirs) and own in (one[0], other[0]):
        return own == one[0]
    if mine != theirs:
        return mine > theirs
    return first == one[0]


def _keep_newer(memory: Memory, sources: dict[Fact, str], first: str, own: str) -> None:
    """Of facts that a merge has brought together and exclude each other, one goes."""
    assert memory.excluded is not None
    for fact, source in sources.items():
        if fact not in memory.facts.stamps:
            continue
        for other in memory.excluded(fact):
            one, two = (source, fact), (sources.get(other, ""), other)
            if _wins(memory, one, two, first, own):
                memory.take(other)
            elif fact in memory.facts.stamps:
                memory.take(fact)
                break


def make_alike(memory: Memory, members: Sequence[Description]) -> None:
    """What descriptions do not share becomes unknown, as if never asserted.

    What they share, class and place among it, keeps the oldest stamp.
    """
    if len(members) < 2:
        return
    indexes = dict.fromkeys(i for member in members for i in member.values)
    stamps = memory.facts.stamps
    for index in indexes:
        values = {member.values.get(index) for member in members}
        shared = values.pop() if len(values) == 1 else None
        value: Atom = UNKNOWN if shared is None else shared
        facts = [_fact(m, index, value) for m in members if not m.empty]
        stamp = NEVER if shared is None else min(stamps[fact] for fact in facts)
        _stamp(memory, facts, stamp)
    named = [member for member in members if not member.empty]
    for of_all in ([_class(m) for m in named], [_place(m) for m in named]):
        _stamp(memory, of_all, min((stamps[fact] for fact in of_all), default=NEVER))


def _stamp(memory: Memory, facts: Sequence[Fact], stamp: Time) -> None:
    for fact in facts:
        if memory.facts.stamps.get(fact) != stamp:
            memory.put(fact, stamp)


def _class(member: Description) -> Fact:
    return ("class", member.name, member.kind, "true")


def _place(member: Description) -> Fact:
    assert member.home is not None
    return ("location", member.name, member.home.place)


def _fact(member: Description, index: Fact, value: Atom) -> Fact:
    return (index[0], member.name, *index[1:], value)


def forget_facts(memory: Memory, name: str) -> None:
    """All facts that mention a name go."""
    for fact in memory.facts.mentioning(name):
        memory.take(fact)
