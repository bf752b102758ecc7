"""The skills and events that activations are made of, and which of them can come on.

An activation must be complete by itself: each input that is not optional is written by
a sensor or by a skill of the same activation. So one that ends never leaves another
with an input that nothing writes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import msgspec

from rapc.base.values import Atom, Text, number
from rapc.world import Refused
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import Skill
from rapc.worlds.skills.network import Member, WiringError, wire


class ActiveSkills(msgspec.Struct, frozen=True):
    """Skills that came on together."""

    ticket: int
    skills: tuple[SkillRequest, ...]
    #: The events that are told for it.
    events: tuple[str, ...]


def members_of(
    catalogue: Catalogue,
    activations: Iterable[ActiveSkills],
    old: Mapping[str, Member],
) -> dict[str, Member]:
    """Return the skills and events of activations by key, each once.

    Args:
        catalogue: what the robot can do.
        activations: what came on, in this order.
        old: those that are on already, by key; they go on with their state.
    """
    members: dict[str, Member] = {}
    for activation in activations:
        for request in activation.skills:
            entry = catalogue.entries[request.skill]
            names = [parameter.name for parameter in entry.parameters]
            given = dict(zip(names, request.arguments, strict=True))
            for part in catalogue.parts(request.skill):
                _make(part, given, activation.events, old, members)
    return members


def refusal(
    catalogue: Catalogue, under_way: Iterable[ActiveSkills], new: ActiveSkills
) -> Refused | None:
    """Return why an activation cannot come on; None if it can.

    Args:
        catalogue: what the robot can do.
        under_way: the activations that are on, in the order they came on.
        new: the one that is to come on.
    """
    return _fault(catalogue, new) or _conflict(catalogue, list(under_way), new)


def written(value: Atom) -> str:
    """Return an argument of a skill as it stands in keys and drawings."""
    if isinstance(value, Text):
        return f'"{value.value}"'
    return value if isinstance(value, str) else str(number(value))


def _fault(catalogue: Catalogue, new: ActiveSkills) -> Refused | None:
    """Return why an activation could never come on, whatever is under way."""
    may: set[str] = set()
    for request in new.skills:
        if wrong := catalogue.fault(request):
            return Refused(reason=wrong)
        may.update(catalogue.describe(request.skill).events)
    for event in new.events:
        if event not in may:
            return Refused(reason=f"none of these skills tells `{event}`")
    try:
        _check(catalogue, [new])
    except WiringError as error:
        return Refused(reason=str(error))
    return None


def _conflict(
    catalogue: Catalogue, under_way: Sequence[ActiveSkills], new: ActiveSkills
) -> Refused | None:
    """Return in whose way an activation would be, if in anybody's."""
    try:
        _check(catalogue, [*under_way, new])
    except WiringError as error:
        others = set(error.skills) - set(members_of(catalogue, [new], {}))
        tickets = tuple(
            activation.ticket
            for activation in under_way
            if others & set(members_of(catalogue, [activation], {}))
        )
        return Refused(tickets, str(error))
    return None


def _check(catalogue: Catalogue, activations: Iterable[ActiveSkills]) -> None:
    """Raise WiringError if skills use one thing or cannot be wired."""
    members = members_of(catalogue, activations, {})
    users: dict[str, str] = {}
    for member in members.values():
        if isinstance(member.node, Skill):
            for thing in member.node.uses:
                other = users.setdefault(thing, member.key)
                if other != member.key:
                    raise WiringError(
                        f"`{other}` and `{member.key}` both use `{thing}`",
                        (other, member.key),
                    )
    wire(catalogue, list(members.values()))


def _make(
    part: type[Skill],
    given: Mapping[str, Atom],
    events: Sequence[str],
    old: Mapping[str, Member],
    members: dict[str, Member],
) -> None:
    """Put a single skill and its events among the members, unless it is there."""
    arguments = {p.name: given[p.name] for p in part.parameters}
    key = " ".join([part.name, *map(written, arguments.values())])
    if key not in members:
        members[key] = old.get(key) or Member(key, part(arguments))
    for event in part.events:
        told = f"{event.name} of {key}"
        if event.name in events and told not in members:
            members[told] = old.get(told) or Member(told, event(arguments), key)
