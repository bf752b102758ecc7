"""A random driver that tests a world.

The driver makes random requests from the offer, about the facts that the world has
reported. It processes replies as the interpreter does: it validates replies and
messages against the port, runs handlers on a real memory, and checks the handlers
against their declarations.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Sequence

import msgspec

from rapc.base.values import Atom, Fact, Text, format_list, number
from rapc.compiler.program import Program
from rapc.host import find_plan
from rapc.ir import nodes
from rapc.library.kinds import Kinds
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import (
    NOT_KNOWN,
    Finished,
    Handlers,
    Lost,
    Message,
    Refused,
    Signal,
    World,
    Wrapper,
    innermost,
)
from rapc.worlds.skills.declarations import Parameter
from rapc.worlds.skills.world import SkillWorld

_STRANGER = "nobody"
"""The argument of requests while the world has sent no value."""

_MOST_WAITS = 1000
"""The highest number of other messages before a request ends."""

_UNFIT = 0.1
"""The share of arguments of skills that differ from the declaration."""

_CANCELLED = 0.25
"""The share of non-atomic requests that are cancelled."""

History = list[tuple[object, ...]]
"""The course of each request: the request, the replies and messages, the time."""


class Driver:
    """A driver that makes requests of one world and processes the replies.

    Args:
        world: the world, new.
        program: a library that declares the offer of the world.
        seed: the seed of the choice of requests.
        handled: whether the world's handlers run: the library declares their names.
        requests: the first requests.
    """

    def __init__(
        self,
        world: World,
        program: Program,
        seed: int,
        handled: bool,
        requests: Sequence[Fact] = (),
    ) -> None:
        spec = RunSpec(seed=seed, settings={"strict": True})
        driven = world if handled else _Unheard(world)
        self._run = run = Interpreter.prepared(program, driven, spec, planner=find_plan)
        #: The world, checked against the declarations of the library.
        self.world = run.port
        self.history: History = []
        #: Each primitive with each result that a request for it had.
        self.seen: set[tuple[str, str]] = set()
        self._rng = random.Random(f"{seed}:contract")
        self._library = program.library
        self._first = list(requests)
        self._told: dict[Atom, None] = {}
        self._note(HeldWorld(world).facts())
        run.start()

    def drive(self, requests: int) -> None:
        """Make a number of requests, or stop when the world ends the run.

        Raises:
            PortError: for a world that violates the port.
        """
        self._listen()
        for _ in range(requests):
            request = self.request()
            if request is None or self.world.ended() is not None:
                return
            self.ask(request)

    def ask(self, request: Fact) -> None:
        """Make one request; wait for its end or, now and then, cancel it.

        Raises:
            PortError: as `drive`.
        """
        ticket, answer = self._run.send(request)
        self._tell(request, answer)
        if isinstance(answer, Refused):
            self._check_refusal(request, answer)
            return
        if answer is not None:
            self.seen.add((str(request[0]), answer.result))
            self._note(answer.data)
        elif self._rng.random() < _CANCELLED:
            self.world.cancel(ticket)
        else:
            self._wait_for(ticket)
        self._listen()

    def _check_refusal(self, request: Fact, answer: Refused) -> None:
        """Validate that a refusal names requests under way. Raises PortError."""
        for ticket in answer.conflicts:
            if ticket not in self._run.requests():
                said = f"refuses {format_list(request)} because of request {ticket}"
                said += ", which is not under way"
                raise self.world.breach("perform", said)

    def _wait_for(self, ticket: int) -> None:
        """Advance time until a request has ended.

        Raises:
            PortError: if the request never ends.
        """
        run, world = self._run, self.world
        for _ in range(_MOST_WAITS):
            due = world.next_time()
            if ticket not in run.requests() or world.ended() is not None:
                return
            if due is None:
                break
            patience = run.settings.patience
            before = run.now
            world.advance(before + patience if due == NOT_KNOWN else due)
            if not self._listen() and run.now == before:
                break
        if ticket in run.requests() and world.ended() is None:
            asked = format_list(run.requests()[ticket][1])
            said = f"started {asked}, which never ends: no message announced"
            raise world.breach("next_time", said)

    def _listen(self) -> int:
        """Process the messages of the world; return their number."""
        under_way = self._run.requests()
        messages = self._run.receive()
        for message in messages:
            if isinstance(message, Finished):
                name = str(under_way[message.ticket][1][0])
                self.seen.add((name, message.reply.result))
                self._note(message.reply.data)
            elif not isinstance(message, Lost):
                self._note([message.content])
        self._tell(*messages)
        return len(messages)

    def _tell(self, *happened: object) -> None:
        self.history.append((*happened, self.world.now()))

    def _note(self, facts: Iterable[Fact]) -> None:
        """Remember the values that the world has sent, for use in later requests."""
        for fact in facts:
            self._told.update(dict.fromkeys(fact[1:]))

    # --- choice of requests ---------------------------------------------------------

    def request(self) -> Fact | None:
        """Return the next request; None if the offer is empty."""
        if self._first:
            return self._first.pop(0)
        offer = self.world.kit.offer.primitives
        if not offer:
            return None
        name = self._rng.choice(list(offer))
        form = self._library.primitives.get(name)
        args: Sequence[nodes.Argument | None] = [None] * offer[name][0]
        if form is not None:
            args = form.args
        return (name, *[self._value(arg) for arg in args])

    def activation(self) -> tuple[list[Fact], list[str]]:
        """Return one or two offered skills, and the events to report.

        For a world that declares all its skills, arguments are as declared, or now and
        then not, and events are those that the skills may report. For other worlds,
        both come from the offer.
        """
        offer, made = self.world.kit.offer, innermost(self.world)
        names = self._rng.sample(
            list(offer.skills), min(self._rng.randint(1, 2), len(offer.skills))
        )
        if not isinstance(made, SkillWorld):
            asked = [[self._value(None) for _ in range(offer.skills[n])] for n in names]
            return self._with(names, asked), list(offer.events)
        known = [made.runtime.catalogue.describe(n.removeprefix(":")) for n in names]
        asked = [[self._argument(one) for one in skill.parameters] for skill in known]
        told = dict.fromkeys(f":{event}" for skill in known for event in skill.events)
        return self._with(names, asked), list(told)

    def _with(self, names: list[str], asked: list[list[Atom]]) -> list[Fact]:
        return [(name, *args) for name, args in zip(names, asked, strict=True)]

    def _argument(self, parameter: Parameter) -> Atom:
        """Return a value for a parameter of a skill, mostly a matching one."""
        if self._rng.random() < _UNFIT:
            return self._value(None)
        if parameter.kind == "text":
            return Text(_STRANGER)
        if parameter.kind == "symbol":
            return str(self._value(None))
        low = 0.0 if parameter.low is None else parameter.low
        high = max(low, 10.0) if parameter.high is None else parameter.high
        return number(self._rng.choice([low, high, self._rng.uniform(low, high)]))

    def hold(self, sent: Iterable[Message], on: Collection[int]) -> None:
        """Validate that the signals sent belong to activations that are on.

        Raises:
            PortError: if not.
        """
        for message in sent:
            self.world.check_message(message)
            if isinstance(message, Signal) and not set(message.tickets) <= set(on):
                said = f"sent {format_list(message.content)} for an activation that is"
                raise self.world.breach("messages", f"{said} not on")

    def _value(self, arg: nodes.Argument | None) -> Atom:
        """Return a value for an argument, of its kind if the kind is known."""
        known: Sequence[Atom] = list(self._told) or [_STRANGER]
        if arg is not None and arg.kind is not None:
            kinds = Kinds(self._library.kinds)
            listed = kinds.values(arg.kind)
            fitting = [v for v in known if kinds.holds(arg.kind, v)]
            known = list(listed or fitting) or known
        return self._rng.choice(known)


class _Unheard(Wrapper):
    """A world whose first facts and handlers are left out.

    The library of the run then needs only the declarations of the offer.
    """

    def enclose(self, world: World) -> None:
        """Replace the wrapped world."""
        super().enclose(world)
        data = dict.fromkeys(world.kit.offer.data, _hear)
        self.kit = msgspec.structs.replace(world.kit, handlers=Handlers({}, data))

    def facts(self) -> tuple[()]:
        """Return no facts."""
        return ()


def _hear(memory: object, datum: Fact) -> None:
    """Accept a datum and ignore it."""
