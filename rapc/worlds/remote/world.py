"""A world in another process, in any language: see `rapc.worlds.remote.protocol`.

The class of such a world is made from the description of its peer. An instance has a
connection of its own. `open` starts the run at the first use, so that a journal can
`resume` a run instead.
"""

from __future__ import annotations

import hashlib
import os
import random
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import msgspec

from rapc.base.chance import stream_state
from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.values import Atom, Fact, Text, format_atom, number
from rapc.errors import PortError, WorldError
from rapc.world import (
    NOT_KNOWN,
    Change,
    Datum,
    Finished,
    Kit,
    Lost,
    Message,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Signal,
    Time,
    World,
)
from rapc.worlds.remote import protocol
from rapc.worlds.remote.peer import Peer, RefusedCall, words_of
from rapc.worlds.remote.protocol import PROTOCOL, TOKEN, Description, WireMessage

_BEATS = 4
"""The number of heartbeats in the period of the peer's watchdog."""


class RemoteWorld(World):
    """A world behind a connection; `world_at` makes a class for each address."""

    #: The address of the peer.
    address: ClassVar[str]
    description: ClassVar[Description]
    #: A digest of the description, and of the files in the command of the peer.
    digest: ClassVar[str]

    def __init__(
        self,
        rng: random.Random,
        options: Mapping[str, Atom | bool] = MappingProxyType({}),
    ) -> None:
        stream = stream_state(rng) if self.description.stream else None
        self._opening = protocol.OpenParams(
            seed=rng.getrandbits(53),
            options={name: _plain(value) for name, value in options.items()},
            stream=stream,
        )
        self._clear()

    def _clear(self) -> None:
        self._peer: Peer | None = None
        self._open = False
        self._now: Time = 0
        self._next: Time | None = None
        self._ended: str | None = None
        #: The messages that the interpreter has not fetched.
        self._received: list[Message] = []
        #: The number of messages of the run that the peer has sent.
        self._sent = 0
        #: The number of messages that the peer may forget.
        self._acknowledged: int | None = None
        self._facts: list[Fact] = []
        #: The method that brought the last answer, for errors.
        self._method = "open"

    def __deepcopy__(self, memo: object) -> RemoteWorld:
        """Return a world of the same options and seed, at the start of a run."""
        made = type(self).__new__(type(self))
        made._opening = self._opening
        made.made_with = self.made_with
        made._clear()
        return made

    # --- calls ------------------------------------------------------------------------

    def _connected(self) -> Peer:
        peer = self._peer
        if peer is None:
            peer = _connect(type(self))
            weakref.finalize(self, peer.close)
            peer.late = _late(weakref.ref(self))
            self._peer = peer
        return peer

    def _ask(self, method: str, params: msgspec.Struct) -> Any:
        """Call a method of the peer in an open run; take in its clock and messages."""
        if not self._open:
            self._start()
        answer = self._connected().call(method, params)
        self._take(method, answer)
        return answer

    def _start(self) -> None:
        """Start the run of the peer."""
        try:
            answer = self._connected().call("open", self._opening)
        except RefusedCall as error:
            said = f"the world `{self.name}` refuses: {error.said}"
            raise WorldError(said) from error
        self._open = True
        self._take("open", answer)
        self._facts = [_fact(fact) for fact in answer.facts]

    def _take(self, method: str, answer: protocol.Answer) -> None:
        """Take in the clock and the messages of an answer."""
        self._method = method
        now = answer.now
        if type(now) is not int:
            now = number(now)
        if now < self._now:
            times = f"from {format_atom(self._now)} to {format_atom(now)}"
            self._breach(f"set its clock back in the answer to `{method}`, {times}")
        self._now, self._next, self._ended = now, None, answer.ended
        if answer.next == "unknown":
            self._next = NOT_KNOWN
        elif answer.next is not None:
            assert not isinstance(answer.next, str)
            self._next = number(answer.next)
            if self._next < now:
                said = f"announced a message for time {format_atom(self._next)} in the"
                self._breach(f"{said} answer to `{method}`, in the past")
        if answer.messages:
            self._received += map(_message, answer.messages)
            self._sent += len(answer.messages)
        if answer.sent is None:
            if "resume" in self.description.methods:
                self._breach(f"gave no `sent` in the answer to `{method}`")
        elif answer.sent != self._sent:
            said = f"counted {answer.sent} messages in the answer to `{method}`"
            self._breach(f"{said}, not {self._sent}")

    def _breach(self, said: str) -> None:
        """End the connection. Raises PortError."""
        if self._peer is not None:
            self._peer.close()
        raise PortError(f"the peer `{self.address}` {said}")

    def told_by(self, call: str) -> str:
        """Return the origin of what a method of this world returned, as text."""
        return f"the answer of the peer `{self.address}` to `{self._method}`"

    def _params(self) -> protocol.Params:
        return protocol.Params(ack=self._acknowledged)

    # --- the world --------------------------------------------------------------------

    def facts(self) -> Iterable[Fact]:
        """Return the initial facts of the robot."""
        if not self._open:
            self._start()
        return self._facts

    def now(self) -> Time:
        """Return the time of the clock, as in the last answer."""
        return self._now

    def ended(self) -> str | None:
        """Return the reason why the world has ended the run, as in the last answer."""
        return self._ended

    def next_time(self) -> Time | None:
        """Return the time of the next message, as in the last answer."""
        if not self._open:
            self._start()
        return self._now if self._received else self._next

    def messages(self) -> Sequence[Message]:
        """Return the messages of the last answers."""
        if not self._received:
            if self._open:
                return ()
            self._start()
        found, self._received = self._received, []
        return found

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request."""
        params = protocol.PerformParams(
            ticket=ticket, request=request, ack=self._acknowledged
        )
        return _outcome(self._ask("perform", params))

    def cancel(self, ticket: int) -> None:
        """Stop the request under `ticket`; drop its end if not fetched yet."""
        self._received = [
            message
            for message in self._received
            if not (isinstance(message, Finished) and message.ticket == ticket)
        ]
        if "cancel" in self.description.methods:
            self._end("cancel", ticket)

    def _end(self, method: str, ticket: int) -> None:
        """Call `cancel` or `deactivate`; a peer that has ended needs neither."""
        if self._open and not self._connected().broken:
            params = protocol.TicketParams(ticket=ticket, ack=self._acknowledged)
            self._ask(method, params)

    def advance(self, to: Time) -> None:
        """Advance the clock to `to`, or to the first message."""
        self._ask("advance", protocol.AdvanceParams(to=to, ack=self._acknowledged))


class _Optional(RemoteWorld):
    """The methods that a class has only if the peer offers them."""

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on, all at once."""
        params = protocol.ActivateParams(
            ticket=ticket,
            skills=tuple(skills),
            events=tuple(events),
            ack=self._acknowledged,
        )
        refused: protocol.Refusal | None = self._ask("activate", params).refused
        return None if refused is None else _refused(refused)

    def deactivate(self, ticket: int) -> None:
        """Switch skills off; drop their signals that are not fetched yet."""
        kept: list[Message] = []
        for message in self._received:
            if isinstance(message, Signal) and ticket in message.tickets:
                left = tuple(one for one in message.tickets if one != ticket)
                if left:
                    kept.append(msgspec.structs.replace(message, tickets=left))
            else:
                kept.append(message)
        self._received = kept
        self._end("deactivate", ticket)

    def usual_time(self, request: Fact) -> Time:
        """Return the usual time for which a request holds the robot."""
        params = protocol.UsualTimeParams(request=request, ack=self._acknowledged)
        return number(self._ask("usual-time", params).time)

    def picture(self) -> Picture:
        """Return the present truth as a picture."""
        picture: Picture = self._ask("picture", self._params()).picture
        return picture

    def figures(self) -> Mapping[str, Atom]:
        """Return ground-truth figures."""
        figures: Mapping[str, Atom] = self._ask("figures", self._params()).figures
        return figures

    def truth(self) -> Mapping[str, Iterable[Fact]]:
        """Return all true facts of some names."""
        told: Mapping[str, Sequence[Fact]] = self._ask("truth", self._params()).facts
        return {name: [_fact(fact) for fact in facts] for name, facts in told.items()}

    def save(self) -> bytes:
        """Return the state of the peer, and the messages that are not fetched yet."""
        saved: protocol.Saved = self._ask("save", self._params())
        return msgspec.json.encode(
            _State(
                self.name,
                dict(self._opening.options),
                saved.state,
                self._now,
                self._received,
            )
        )

    def restore(self, state: bytes) -> None:
        """Restore a saved state.

        Raises:
            ValueError: if another world, or one with other options, saved the state.
        """
        try:
            saved = msgspec.json.decode(state, type=_State)
        except UNREADABLE as error:
            raise ValueError(
                f"no state of the world `{self.name}`: {flaw(error)}"
            ) from error
        options = dict(self._opening.options)
        if (saved.world, saved.options) != (self.name, options):
            said = f"a world `{saved.world}` with other options saved the state"
            raise ValueError(said)
        if not self._open:
            self._start()
        params = protocol.RestoreParams(state=saved.state, ack=self._acknowledged)
        try:
            answer = self._connected().call("restore", params)
        except RefusedCall as error:
            raise ValueError(error.said) from error
        self._now, self._sent, self._received = saved.now, 0, saved.received
        self._take("restore", answer)

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        """Continue the run with a new process of the interpreter."""
        params = protocol.ResumeParams(
            tickets=tuple(tickets), received=received, opening=self._opening
        )
        try:
            answer = self._connected().call("resume", params)
        except RefusedCall as error:
            raise ValueError(error.said) from error
        self._open, self._sent, self._received = True, received, []
        self._take("resume", answer)
        self._facts = [_fact(fact) for fact in answer.facts]
        return {known.ticket: _outcome(known) for known in answer.requests}

    def acknowledge(self, received: int) -> None:
        """Let the peer forget the first messages of the run, with the next call."""
        self._acknowledged = received

    def adjustable(self) -> Mapping[str, Atom | bool]:
        """Return the options that can change during a run."""
        options: Mapping[str, Atom | bool]
        options = self._ask("adjustable", self._params()).options
        return options

    def adjust(self, name: str, value: Atom | bool) -> None:
        """Set an option to a new value. Raises ValueError if the peer refuses it."""
        params = protocol.AdjustParams(
            name=name, value=_plain(value), ack=self._acknowledged
        )
        try:
            self._ask("adjust", params)
        except RefusedCall as error:
            raise ValueError(error.said) from error


class _State(msgspec.Struct, frozen=True):
    """The data that `save` writes."""

    world: str
    options: Mapping[str, Any]
    state: msgspec.Raw
    now: Time
    received: list[Message]


_METHODS: Mapping[str, tuple[str, ...]] = {
    "resume": ("resume", "acknowledge"),
    "usual-time": ("usual_time",),
}
"""The methods of the class for a method of the peer, if not one of the same name."""

_PAIRS = (("activate", "deactivate"), ("save", "restore"), ("adjustable", "adjust"))
"""The methods that a peer offers only together."""


def world_at(
    address: str, find_world: Callable[[str], type[World]]
) -> type[RemoteWorld]:
    """Return a class for the world of a peer, from its description.

    Args:
        address: `exec:COMMAND`, `unix:/path` or `tcp:127.0.0.1:PORT`.
        find_world: finds an installed world, for its handlers.

    Raises:
        WorldError: if the peer cannot be reached or described.
    """
    try:
        told = _description(address, _files(address))
        kit = _kit(told, find_world)
    except PortError as error:
        raise WorldError(error.message) from error
    except (TypeError, ValueError, WorldError) as error:
        said = f"the peer `{address}` described an invalid world in `describe`"
        raise WorldError(f"{said}: {error}") from error
    names = [one for name in told.methods for one in _METHODS.get(name, (name,))]
    methods = {name: vars(_Optional)[name] for name in names if name != "cancel"}
    return type(
        "RemoteWorld",
        (RemoteWorld,),
        {
            **methods,
            "__doc__": told.doc or f"The world of the peer `{address}`.",
            "__module__": __name__,
            "name": told.name,
            "kit": kit,
            "address": address,
            "description": told,
            "digest": _digest(address, told),
        },
    )


@lru_cache(maxsize=16)
def _description(address: str, files: tuple[tuple[str, int, int], ...]) -> Description:
    """Return the description of the world at an address.

    The answer of a process is kept as long as the files in its command do not change.
    """
    peer = Peer(address)
    try:
        return _described(peer)
    finally:
        peer.close()


def _files(address: str) -> tuple[tuple[str, int, int], ...]:
    """Return the files in the command of a peer, each with its size and time."""
    found = [(path, path.stat()) for path in _paths(address)]
    return tuple((str(path), stat.st_size, stat.st_mtime_ns) for path, stat in found)


def _paths(address: str) -> list[Path]:
    return [path for path in map(Path, words_of(address)) if path.is_file()]


def _late(world: weakref.ref[RemoteWorld]) -> Callable[[str, Any], None]:
    """Return the function that takes in a late answer, while the world exists."""

    def take(method: str, answer: Any) -> None:
        if (known := world()) is not None:
            known._take(method, answer)

    return take


def _connect(world: type[RemoteWorld]) -> Peer:
    """Return a new connection of a world, with the same description."""
    peer = Peer(world.address)
    if _described(peer) != world.description:
        peer.close()
        raise PortError(
            f"the peer `{world.address}` gave another answer to `describe` than before"
        )
    return peer


def _described(peer: Peer) -> Description:
    """Return the description of a peer; set the times of the connection."""
    token = os.environ.get(TOKEN) if peer.address.startswith("tcp:") else None
    told: Description = peer.call(
        "describe", protocol.DescribeParams(PROTOCOL, token=token)
    )
    if told.protocol != PROTOCOL:
        peer.close()
        versions = f"version {told.protocol} of the protocol, not {PROTOCOL}"
        raise PortError(
            f"the peer `{peer.address}` answered `describe` with {versions}"
        )
    peer.timeouts = told.timeouts
    peer.beat = told.heartbeat / _BEATS if told.heartbeat is not None else None
    return told


def _kit(told: Description, find_world: Callable[[str], type[World]]) -> Kit:
    """Return the kit of a described world. Raises TypeError, ValueError, WorldError."""
    for one, other in _PAIRS:
        if (one in told.methods) != (other in told.methods):
            raise ValueError(f"`methods` has only one of `{one}` and `{other}`")
    names = [*told.primitives, *told.data, *told.skills, *told.events]
    arguments = {
        **{name: one.arguments for name, one in told.primitives.items()},
        **told.data,
        **told.skills,
        **told.events,
    }
    if len(arguments) < len(names):
        raise ValueError("two parts of the offer have the same name")
    offer = Offer(
        primitives={
            name: (len(one.arguments), one.results)
            for name, one in told.primitives.items()
        },
        data={name: len(names) for name, names in told.data.items()},
        skills={name: len(names) for name, names in told.skills.items()},
        events={name: len(names) for name, names in told.events.items()},
        sensors=tuple(n for n, one in told.primitives.items() if one.sensor),
        not_atomic=tuple(n for n, one in told.primitives.items() if not one.atomic),
        arguments=arguments,
        after_crash={
            name: one.after_crash
            for name, one in told.primitives.items()
            if one.after_crash is not None
        },
    )
    options = tuple(
        Option(one.name, one.kind, one.default, one.unit, one.doc)
        for one in told.options
    )
    if not told.code:
        return Kit(offer, options=options)
    if ":" in told.code:
        raise ValueError(f"`code` names `{told.code}`, not an installed world")
    kit = find_world(told.code).kit
    return msgspec.structs.replace(kit, offer=offer, options=options)


def _digest(address: str, told: Description) -> str:
    """Return a digest of a world: results of experiments are kept by the digest."""
    digest = hashlib.sha256(msgspec.json.encode(told))
    for path in _paths(address):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


# --- values of the wire ---------------------------------------------------------------


def _plain(value: Atom | bool) -> Any:
    return value.value if isinstance(value, Text) else value


def _fact(fact: Fact) -> Fact:
    """Return a fact with whole numbers as integers, as in memory."""
    if any(type(part) is float for part in fact):
        return tuple(number(p) if type(p) is float else p for p in fact)
    return fact


def _changes(memory: tuple[Change, ...] | None) -> tuple[Change, ...] | None:
    return None if memory is None else tuple(map(_fact, memory))


def _reply(told: protocol.WireReply | protocol.WireFinished) -> Reply:
    return Reply(told.result, tuple(map(_fact, told.data)), _changes(told.memory))


def _refused(told: protocol.Refusal) -> Refused:
    return Refused(told.conflicts, told.reason)


def _outcome(told: protocol.Performed | protocol.Known) -> Reply | Refused | None:
    if told.reply is not None:
        return _reply(told.reply)
    return None if told.refused is None else _refused(told.refused)


def _message(told: WireMessage) -> Message:
    if isinstance(told, protocol.WireDatum):
        return Datum(_fact(told.content), _changes(told.memory), told.number)
    if isinstance(told, protocol.WireSignal):
        return Signal(_fact(told.content), told.tickets, told.number)
    if isinstance(told, protocol.WireFinished):
        return Finished(told.ticket, _reply(told))
    return Lost(told.ticket, told.reason)
