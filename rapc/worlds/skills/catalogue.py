"""The skills of a world as a set, checked before any skill runs.

A catalogue finds the faults that occur in every network made of it: duplicate names, an
input that nothing writes, different types of one channel, a compound without a
parameter of its parts. Faults that depend on the active skills are left to `network`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from rapc.base.values import Atom
from rapc.worlds.skills.checks import (
    CatalogueError,
    check_entry,
    check_list,
)
from rapc.worlds.skills.declarations import (
    KINDS,
    Arbiter,
    Channel,
    Compound,
    Event,
    NetworkNode,
    Parameter,
    Skill,
    as_input,
    first_line,
    label_of,
)
from rapc.worlds.skills.network import Member, Periphery, WiringError, wire


class SkillRequest(msgspec.Struct, frozen=True):
    """A skill to run, with the values of its parameters in their order."""

    skill: str
    arguments: tuple[Atom, ...] = ()


class DescribedSkill(msgspec.Struct, frozen=True):
    """The declaration of a skill for libraries that enable the skill."""

    name: str
    parameters: tuple[Parameter, ...]
    #: Names of the events that the skill may report.
    events: tuple[str, ...]
    uses: tuple[str, ...]
    doc: str


class Catalogue(Periphery):
    """All skills of a world, by name.

    Args:
        skills: single skills and compounds, in the order of documentation.
        sensors: channels that the world writes.
        actuators: channels that the world reads.
        arbiters: arbiters of channels that several skills may write.

    Raises:
        CatalogueError: if the declarations contradict each other.
    """

    def __init__(
        self,
        skills: Iterable[type[Skill] | Compound],
        sensors: Sequence[Channel[Any]] = (),
        actuators: Sequence[Channel[Any]] = (),
        arbiters: Iterable[Arbiter] = (),
    ) -> None:
        self.sensors = check_list("sensors", sensors, Channel, "channels")
        self.actuators = check_list("actuators", actuators, Channel, "channels")
        self.arbiters: dict[Channel[Any], Arbiter] = {}
        for arbiter in check_list("arbiters", arbiters, Arbiter, "arbiters"):
            channel = getattr(arbiter, "channel", None)
            if not isinstance(channel, Channel):
                raise CatalogueError(
                    f"the class {type(arbiter).__name__} has no `channel`"
                )
            if channel in self.arbiters:
                raise CatalogueError(f"two arbiters for the channel `{channel.name}`")
            self.arbiters[channel] = arbiter
        #: The skills that a library may enable, by name.
        self.entries: dict[str, type[Skill] | Compound] = {}
        for entry in check_list("skills", skills, object, "skills"):
            check_entry(entry)
            if entry.name in self.entries:
                raise CatalogueError(f"two skills are named `{entry.name}`")
            self.entries[entry.name] = entry
        parts = [part for name in self.entries for part in self.parts(name)]
        #: Every single skill by name, including the parts of compounds.
        self._singles: dict[str, type[Skill]] = {}
        for skill in parts:
            other = self._singles.setdefault(skill.name, skill)
            if other is not skill:
                both = f"{label_of(other)} and {label_of(skill)}"
                raise CatalogueError(f"{both} have one name")
        #: Every event that a skill may report, by name.
        self.events: dict[str, type[Event]] = {}
        for skill in self._singles.values():
            self._check_parameters(label_of(skill), skill.parameters)
            for event in skill.events:
                self._check_parameters(label_of(event), event.carries)
                known = self.events.setdefault(event.name, event)
                if known.carries != event.carries:
                    raise CatalogueError(
                        f"duplicate event `{event.name}` with different values"
                    )
        self._check_channels()
        for entry in self.entries.values():
            if isinstance(entry, Compound):
                self._check_compound(entry)
            self._check_wiring(self.parts(entry.name))
        self._check_readers()

    def extended(self, skills: Sequence[type[Skill] | Compound]) -> Catalogue:
        """Return a catalogue with more skills.

        A skill replaces the skill of its name, also as a part of compounds.

        Raises:
            CatalogueError: if the declarations contradict each other.
        """
        for entry in check_list("skills", skills, object, "skills"):
            check_entry(entry)
        new = {skill.name: skill for skill in skills}
        singles = {n: one for n, one in new.items() if not isinstance(one, Compound)}
        entries = {**self.entries}
        for name, entry in self.entries.items():
            if isinstance(entry, Compound):
                parts = tuple([singles.get(part.name, part) for part in entry.parts])
                entries[name] = msgspec.structs.replace(entry, parts=parts)
        parts_only = self._singles.keys() - self.entries.keys()
        entries |= {n: one for n, one in new.items() if n not in parts_only}
        arbiters = self.arbiters.values()
        return Catalogue(entries.values(), self.sensors, self.actuators, arbiters)

    def parts(self, name: str) -> tuple[type[Skill], ...]:
        """Return the single skills of `name`.

        Raises:
            KeyError: for an unknown skill.
        """
        entry = self.entries[name]
        return entry.parts if isinstance(entry, Compound) else (entry,)

    def describe(self, name: str) -> DescribedSkill:
        """Return the declaration of a skill; for a compound, made of its parts."""
        entry = self.entries[name]
        parts = self.parts(name)
        doc = entry.doc if isinstance(entry, Compound) else first_line(entry.__doc__)
        events = dict.fromkeys(event.name for part in parts for event in part.events)
        uses = dict.fromkeys(thing for part in parts for thing in part.uses)
        return DescribedSkill(name, entry.parameters, tuple(events), tuple(uses), doc)

    def fault(self, request: SkillRequest) -> str | None:
        """Return the fault of a request by itself, or None."""
        entry = self.entries.get(request.skill)
        if entry is None:
            return f"unknown skill `{request.skill}`"
        wanted, given = len(entry.parameters), len(request.arguments)
        if wanted != given:
            return f"`{request.skill}` takes {wanted} arguments, not {given}"
        pairs = zip(entry.parameters, request.arguments, strict=True)
        for parameter, value in pairs:
            if wrong := parameter.fault(value):
                return f"`{request.skill}`: {wrong}"
        return None

    def _check_parameters(self, name: str, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.kind not in KINDS:
                raise CatalogueError(
                    f"{name}: unknown kind `{parameter.kind}` of `{parameter.name}`; "
                    "expected one of " + ", ".join(KINDS)
                )
            if wrong := parameter.wrong_bounds():
                raise CatalogueError(f"{name}: {wrong}")
        if len({parameter.name for parameter in parameters}) < len(parameters):
            raise CatalogueError(f"{name} has duplicate parameters")

    def _check_channels(self) -> None:
        """Check that each channel has a writer, a reader and a name of its own."""
        written = set(self.sensors)
        owners: dict[Channel[Any], str] = {}
        channels = {channel.name: channel for channel in self.sensors}
        reads: list[tuple[str, Channel[Any], set[Channel[Any]]]] = []
        for skill in self._singles.values():
            self._know(channels, skill, skill.outputs)
            own = {channel for channel in skill.outputs if channel.own}
            owners.update(dict.fromkeys(own, label_of(skill)))
            written |= set(skill.outputs) - own
            for channel in set(skill.outputs) & set(self.sensors):
                raise CatalogueError(
                    f"{label_of(skill)} writes the sensor `{channel.name}`, which only "
                    "the world writes"
                )
            nodes: tuple[type[NetworkNode], ...] = (skill, *skill.events)
            for node in nodes:
                inputs = [as_input(reads_).channel for reads_ in node.inputs]
                self._know(channels, node, inputs)
                mine = own if node is not skill else set()
                reads += ((label_of(node), channel, mine) for channel in inputs)
        for channel in self.actuators:
            if channel not in written:
                raise CatalogueError(f"no skill writes the actuator `{channel.name}`")
        for name, channel, mine in reads:
            if channel not in written and channel not in mine:
                told = "which nothing writes"
                if channel in owners:
                    told = (
                        "an `own` channel, which only the events of "
                        f"{owners[channel]} can read"
                    )
                raise CatalogueError(f"{name} reads `{channel.name}`, {told}")
        for channel in self.arbiters:
            if channel not in written:
                raise CatalogueError(
                    f"no skill writes `{channel.name}`, which has an arbiter"
                )

    def _know(
        self,
        channels: dict[str, Channel[Any]],
        node: type[NetworkNode],
        new: Iterable[Channel[Any]],
    ) -> None:
        for channel in new:
            known = channels.setdefault(channel.name, channel)
            if known is not channel:
                told = f"{channel.kind} instead of {known.kind}"
                if channel.kind == known.kind:
                    told = "use the same `Channel` object in all classes"
                raise CatalogueError(
                    f"{label_of(node)} has another channel `{channel.name}` than "
                    f"other classes: {told}"
                )

    def _check_readers(self) -> None:
        """Check that each output of a skill has a possible reader."""
        read = set(self.actuators)
        for skill in self._singles.values():
            for node in (skill, *skill.events):
                read |= {as_input(wanted).channel for wanted in node.inputs}
        for skill in self._singles.values():
            for channel in skill.outputs:
                if channel not in read:
                    raise CatalogueError(
                        f"{label_of(skill)} writes `{channel.name}`, which nothing "
                        "reads; a channel that the world reads is an actuator"
                    )

    def _check_compound(self, compound: Compound) -> None:
        self._check_parameters(f"`{compound.name}`", compound.parameters)
        by_name = {parameter.name: parameter for parameter in compound.parameters}
        twice = [one.name for one in compound.parts if compound.parts.count(one) > 1]
        if twice:
            raise CatalogueError(f"`{compound.name}` has the part `{twice[0]}` twice")
        taken = {one.name for part in compound.parts for one in part.parameters}
        for name in by_name:
            if name not in taken:
                raise CatalogueError(
                    f"no part of `{compound.name}` has a parameter `{name}`"
                )
        for part in compound.parts:
            for wanted in part.parameters:
                given = by_name.get(wanted.name)
                if given is None:
                    raise CatalogueError(
                        f"`{compound.name}` has no parameter `{wanted.name}` for "
                        f"its part `{part.name}`"
                    )
                if (given.kind, given.unit) != (wanted.kind, wanted.unit):
                    raise CatalogueError(
                        f"`{wanted.name}` of `{compound.name}` is a {given.measure}, "
                        f"but `{wanted.name}` of its part `{part.name}` is a "
                        f"{wanted.measure}"
                    )

    def _check_wiring(self, parts: Sequence[type[Skill]]) -> None:
        """Wire a skill, or a compound's parts, with the only writers of its inputs.

        Raises:
            CatalogueError: if the skills cannot be wired in any network.
        """
        on = dict.fromkeys(parts)
        queue = list(parts)
        for skill in queue:  # the loop extends the queue
            for read in map(as_input, skill.inputs):
                channel, needed = read.channel, not (read.optional or read.delayed)
                if needed and not channel.own and channel not in self.sensors:
                    singles = self._singles.values()
                    writers = [one for one in singles if channel in one.outputs]
                    if len(writers) == 1 and writers[0] not in on:
                        on[writers[0]] = None
                        queue.append(writers[0])
        try:
            wire(self, [Member(skill.name, skill) for skill in on], trial=True)
        except WiringError as error:
            raise CatalogueError(str(error)) from error
