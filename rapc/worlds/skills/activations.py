"""The skills and events of activations, and the check of a new activation.

An activation must be complete by itself: a sensor or a skill of the same activation
writes each required input. So the end of an activation never leaves another activation
with an input that nothing writes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import msgspec

from rapc.base.values import Atom, Text, number
from rapc.world import Refused
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import NetworkNode
from rapc.worlds.skills.network import Member, WiringError, wire


class ActiveSkills(msgspec.Struct, frozen=True):
    """Skills that were switched on together."""

    ticket: int
    skills: tuple[SkillRequest, ...]
    #: The events reported to the activation.
    events: tuple[str, ...]


def members_of(
    catalogue: Catalogue,
    activations: Iterable[ActiveSkills],
    old: Mapping[str, Member],
) -> dict[str, Member]:
    """Return the skills and events of activations by key, each once.

    Args:
        catalogue: the robot's skills.
        activations: the activations, oldest first.
        old: the active skills and events by key; their state is kept.
    """
    members: dict[str, Member] = {}
    for activation in activations:
        for key, node, arguments, host in _wanted(catalogue, activation):
            if key not in members:
                made = old[key].node if key in old else node(arguments)
                members[key] = Member(key, made, host)
            if members[key].node.arguments != arguments:  # of a single skill
                members[key].node.arguments = arguments
            if activation.ticket not in members[key].tickets:
                members[key].tickets.append(activation.ticket)
    return members


def _wanted(
    catalogue: Catalogue, activation: ActiveSkills
) -> Iterator[tuple[str, type[NetworkNode], Mapping[str, Atom], str | None]]:
    """Yield key, class, arguments and host of the parts of an activation."""
    for request in activation.skills:
        names = [one.name for one in catalogue.entries[request.skill].parameters]
        given = dict(zip(names, request.arguments, strict=True))
        for part in catalogue.parts(request.skill):
            arguments = {one.name: given[one.name] for one in part.parameters}
            values = () if part.single else arguments.values()
            key = " ".join([part.name, *map(written, values)])
            yield key, part, arguments, None
            for event in part.events:
                if event.name in activation.events:
                    yield f"{event.name} of {key}", event, arguments, key


def refusal(
    catalogue: Catalogue, under_way: Iterable[ActiveSkills], new: ActiveSkills
) -> Refused | None:
    """Return the reason why an activation is refused; None if it is valid.

    Args:
        catalogue: the robot's skills.
        under_way: the active activations, oldest first.
        new: the new activation.
    """
    may: set[str] = set()
    for request in new.skills:
        if wrong := catalogue.fault(request):
            return Refused(reason=wrong)
        may.update(catalogue.describe(request.skill).events)
    for event in new.events:
        if event not in may:
            return Refused(reason=f"no skill of the request emits `{event}`")
    for on in ([new], [*under_way, new]):
        members = members_of(catalogue, on, {})
        try:
            _check_things(members.values())
            wire(catalogue, list(members.values()))
        except WiringError as error:
            others = [members[key].tickets for key in error.skills if key in members]
            in_the_way = {t for ts in others if new.ticket not in ts for t in ts}
            tickets = [one.ticket for one in on if one.ticket in in_the_way]
            return Refused(tuple(tickets), str(error))
    return None


def written(value: Atom) -> str:
    """Return the text of an argument for keys and drawings."""
    if isinstance(value, Text):
        return f'"{value.value}"'
    return value if isinstance(value, str) else str(number(value))


def _check_things(members: Iterable[Member]) -> None:
    """Raise WiringError if two skills use one thing."""
    users: dict[str, str] = {}
    for member in members:
        for thing in getattr(member.node, "uses", ()):
            other = users.setdefault(thing, member.key)
            if other != member.key:
                raise WiringError(
                    f"`{other}` and `{member.key}` both use `{thing}`",
                    (other, member.key),
                )
