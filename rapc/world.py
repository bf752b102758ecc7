"""The port between interpreter and world, with all names that authors of worlds import.

A `World` has a clock, takes requests, and returns results and sensor data. A world may
also send messages without a request, and end the run. Its `Kit` has the parts for
libraries: primitives, data, options and Python code. This code includes the handlers,
which turn results and data into changes of memory through `HandlerMemory` [T 3.3].
Features of some worlds only are separate protocols, `OPTIONAL`. Interpreter and world
have no access to each other's state.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from random import Random
from types import MappingProxyType, MethodType
from typing import Any, Protocol, runtime_checkable

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.base.handlers import DatumHandler, HandlerMemory, Handlers, ResultHandler
from rapc.base.messages import (
    NOT_KNOWN,
    OKAY,
    Change,
    Datum,
    Finished,
    Lost,
    Message,
    Refused,
    Reply,
    Signal,
    Time,
)
from rapc.base.offers import Offer
from rapc.base.pictures import (
    Area,
    Door,
    Gauge,
    Mark,
    Picture,
    Plan,
    Reckoning,
    Spot,
    Stand,
    Thing,
)
from rapc.base.values import Atom, Fact, Number, Text

__all__ = (
    "NOT_KNOWN",
    "OKAY",
    "Adjustable",
    "Area",
    "Atom",
    "Callables",
    "Change",
    "Datum",
    "DatumHandler",
    "Door",
    "Drawable",
    "Fact",
    "Finished",
    "Gauge",
    "HandlerMemory",
    "Handlers",
    "Kit",
    "Lost",
    "Mark",
    "Measured",
    "Message",
    "Number",
    "Offer",
    "Option",
    "Picture",
    "Plan",
    "Reckoning",
    "Refused",
    "Reply",
    "ResultHandler",
    "Resumable",
    "Savable",
    "Signal",
    "SimpleWorld",
    "Skilled",
    "Spot",
    "Stand",
    "Text",
    "Thing",
    "Time",
    "Timed",
    "Truth",
    "World",
)


KINDS = ("number", "integer", "flag", "symbol", "text")
"""The kinds of options."""


class Option(msgspec.Struct, frozen=True):
    """An option of a world, listed by `rapc worlds NAME` and set by `--set`."""

    name: str
    #: A kind: `number`, `integer`, `flag`, `symbol` or `text`.
    kind: str
    #: The default value; for the kind `text` a `str` or a `rapc.world.Text`.
    default: Atom | bool
    unit: str
    doc: str


Callables = Mapping[str, Callable[..., object]]
"""Python callables by their name in libraries."""


class Kit(msgspec.Struct, frozen=True):
    """The parts of a world for libraries; constant during a run."""

    #: The primitives, data, skills and signals of the world.
    offer: Offer = Offer()
    #: The handlers that turn results and data into changes of memory.
    handlers: Handlers = Handlers()
    #: The options with their defaults.
    options: tuple[Option, ...] = ()
    #: Functions `(memory, arg...)` and default functions `(memory, index)`, by name.
    #: An index is a tuple: the property's name and its arguments without the value.
    functions: Callables = {}
    #: Problem solvers `(goal, memory)` by the name of the RAP they solve [T 7.4.1];
    #: they return methods (see `rapc.methods`).
    solvers: Callables = {}
    #: Comparators `(one, other)` or `(one, other, memory)` of descriptions, by name
    #: [T A.5]: each returns a number, 0 or less if the two cannot be the same item.
    comparators: Callables = {}
    #: Called with the memory and the seconds for which no process ran the run, after a
    #: run in a world that cannot be saved was resumed (`rapc run --resume`).
    resumed: Callable[[HandlerMemory, Number], object] | None = None

    def __post_init__(self) -> None:
        """Validate the fields; raise TypeError."""
        if not isinstance(self.offer, Offer):
            raise TypeError(f"`offer` of a Kit is an Offer, not {self.offer!a:.60}")
        if not isinstance(self.handlers, Handlers):
            raise TypeError(
                f"`handlers` of a Kit is Handlers, not {self.handlers!a:.60}"
            )
        for option in self.options:
            if not isinstance(option, Option):
                raise TypeError(f"`options` of a Kit are Options, not {option!a:.60}")
            if option.kind not in KINDS:
                kinds = ", ".join(KINDS)
                said = f"the kind of the option `{option.name}` is {option.kind!a:.60}"
                raise TypeError(f"{said}, not one of {kinds}")


class World(ABC):
    """A world, as used by the interpreter. An instance serves a single run.

    A world opened by name is made with `(rng, options)`: its own random stream, which
    comes from the seed of the run, and a value for each option. The value of an option
    of kind `symbol` or `text` is a `str`. The constructor raises ValueError for
    inconsistent values.
    """

    #: The name of the world for `--set`, traces and messages.
    name: str
    #: The parts of the world for libraries. A world opened by name has a kit in its
    #: class; the constructor may replace it.
    kit: Kit
    #: The values of all options, if the world was opened by name. A saved run can only
    #: continue in a world opened with the same values.
    made_with: Mapping[str, Atom | bool] = MappingProxyType({})

    def facts(self) -> Iterable[Fact]:
        """Return the initial facts of the robot, for example a map."""
        return ()

    @abstractmethod
    def now(self) -> Time:
        """Return the time of the clock."""

    @abstractmethod
    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request (items by sensor name).

        An atomic primitive advances the clock by its duration and returns its reply.
        None means that the end comes later as a `Finished` with `ticket`.
        """

    def cancel(self, ticket: int) -> None:  # noqa: B027  # most worlds need no cancel
        """Stop the request under `ticket`, which is no longer needed.

        The world may answer the request once more, with the partial result, or not at
        all; no time passes. A world without this method carries the request to its end.
        A ticket that was already answered is ignored.
        """

    @abstractmethod
    def next_time(self) -> Time | None:
        """Return the time of the next message if no further request comes.

        None: never. `NOT_KNOWN`: the time is not known, as in a world with continuous
        time; `advance` then stops at the first message.
        """

    @abstractmethod
    def advance(self, to: Time) -> None:
        """Advance the clock to `to`, never backwards, with the events of the world.

        A world whose next time is `NOT_KNOWN` stops at its first message; the
        interpreter calls `advance` again for the rest.
        """

    @abstractmethod
    def messages(self) -> Sequence[Message]:
        """Return the messages sent since the preceding call, in order."""

    def ended(self) -> str | None:
        """Return the reason why the world has ended the run, or None.

        A world whose class does not define this method never ends a run.
        """
        return None


class _SavedSimple(msgspec.Struct):
    """The data that `SimpleWorld.save` writes."""

    made_with: Mapping[str, Any]
    time: Time
    outbox: list[tuple[Time, Message]]
    rng: Stream
    state: msgspec.Raw


class SimpleWorld(World):
    """A world that requires only the method `perform`.

    `advance` advances the clock, `send` sends a message at once or later. `state` has
    the changing state, and `rng` is the source of all chance: both are saved.

    Args:
        rng: the random stream.
        options: the values of the options.
        perform: the method `perform`, if the class does not define it.
        kit: the kit, if the class has none.
    """

    name = "simple"
    #: The time of the clock.
    time: Time = 0
    #: The changing state: a dict of plain data, a dataclass or a msgspec struct.
    state: Any

    def __init__(
        self,
        rng: Random | None = None,
        options: Mapping[str, Atom | bool] = MappingProxyType({}),
        *,
        perform: Callable[[Any, int, Fact], Reply | Refused | None] | None = None,
        kit: Kit | None = None,
    ) -> None:
        self.rng = rng or Random(0)
        self.options = options
        self.state = {}
        #: The messages still to be fetched, each with its time, soonest first.
        self.outbox: list[tuple[Time, Message]] = []
        if kit is not None or not hasattr(self, "kit"):
            self.kit = kit or Kit()
        if perform is not None:
            vars(self)["perform"] = MethodType(perform, self)
        elif type(self).perform is SimpleWorld.perform:
            raise TypeError("a SimpleWorld requires `perform`")

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request; defined by a subclass or passed to the constructor."""
        raise NotImplementedError  # the constructor requires either of them

    def send(self, message: Message, after: Time = 0) -> None:
        """Send a datum, a signal or the end of a request, after the time `after`."""
        self.outbox.append((self.time + after, message))
        self.outbox.sort(key=lambda sent: sent[0])

    def now(self) -> Time:
        """Return the time of the clock."""
        return self.time

    def advance(self, to: Time) -> None:
        """Advance the clock."""
        self.time = max(self.time, to)

    def next_time(self) -> Time | None:
        """Return the time of the next message, or None."""
        return max(self.time, self.outbox[0][0]) if self.outbox else None

    def messages(self) -> Sequence[Message]:
        """Return the messages that are due."""
        due = [message for time, message in self.outbox if time <= self.time]
        del self.outbox[: len(due)]
        return due

    def cancel(self, ticket: int) -> None:
        """Drop the end of a request that is still to be sent."""
        self.outbox = [
            sent
            for sent in self.outbox
            if not (isinstance(sent[1], Finished) and sent[1].ticket == ticket)
        ]

    def save(self) -> bytes:
        """Return the complete state, as JSON. Raises TypeError if not plain data."""
        state, rng = msgspec.json.encode(self.state), stream_state(self.rng)
        if msgspec.json.decode(state, type=type(self.state)) != self.state:
            raise TypeError(f"`state` of the world `{self.name}` is not plain data")
        made = dict(self.made_with)
        return msgspec.json.encode(
            _SavedSimple(made, self.time, self.outbox, rng, msgspec.Raw(state))
        )

    def restore(self, state: bytes) -> None:
        """Restore a saved state.

        Raises:
            ValueError: if `state` was saved by another world or with other options.
        """
        saved = msgspec.json.decode(state, type=_SavedSimple)
        if saved.made_with != dict(self.made_with):
            raise ValueError(
                f"a world `{self.name}` with other options saved the state"
            )
        mine = msgspec.json.decode(saved.state, type=type(self.state))
        self.rng = stream_in(saved.rng)
        self.time, self.outbox, self.state = saved.time, saved.outbox, mine


@runtime_checkable
class Skilled(Protocol):
    """A world with skills that are switched on and off [S 3].

    An activation is a set of skills that run together, and the events to report to the
    activation. A skill with equal arguments in several activations runs once, until the
    last of them is switched off. A `Signal` carries the tickets of all its activations.
    """

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on, all at once; no time passes.

        Args:
            ticket: the number of the activation.
            skills: the skills to run, `(:name argument...)`, items by sensor name.
            events: the names of the events to report, with their colons.

        Returns:
            None, or the reason for a refusal.
        """

    def deactivate(self, ticket: int) -> None:
        """Switch off the skills that only this activation has; no time passes.

        Events that are not reported yet are dropped.
        """


@runtime_checkable
class Timed(Protocol):
    """A world that can predict the duration of requests."""

    def usual_time(self, request: Fact) -> Time:
        """Return the usual time for which a request holds the robot, in time units.

        A request that is made to fail (`--fault`) takes this time; in a world that is
        not `Timed` it takes no time.
        """


@runtime_checkable
class Drawable(Protocol):
    """A world that `rapc run --show` can draw."""

    def picture(self) -> Picture:
        """Return the present truth as a picture, without side effects."""


@runtime_checkable
class Measured(Protocol):
    """A world with ground-truth figures, for experiments and tests.

    The figures are hidden from the robot.
    """

    def figures(self) -> Mapping[str, Atom] | msgspec.Struct:
        """Return ground-truth figures; experiments report the numbers.

        The names of the figures are constant. The call has no side effects.
        """


@runtime_checkable
class Truth(Protocol):
    """A simulator that tells which facts are true, in the names of memory.

    The debugger, tests and experiments compare the beliefs of the robot with the truth.
    The facts are hidden from the robot.
    """

    def truth(self) -> Mapping[str, Iterable[Fact]]:
        """Return all true facts of some names: `{"docked": [("docked",)]}`.

        A believed fact of one of these names is wrong if it is not among the facts. So
        a name without true facts has an empty list, and a state that may be described
        in two ways has a fact for each. Items stand by their sensor names. The call has
        no side effects.
        """


@runtime_checkable
class Savable(Protocol):
    """A simulator whose state can be saved."""

    def save(self) -> bytes:
        """Return the complete state with its random streams, without side effects."""

    def restore(self, state: bytes) -> None:
        """Restore a state that `save` returned.

        Raises:
            ValueError: if `state` was saved by another world or with other options.
        """


@runtime_checkable
class Resumable(Protocol):
    """A world that goes on when the process of the interpreter dies.

    A second process can continue the run, and the world still does each request once:
    the ticket is the key of a request. The world keeps each message until the
    interpreter acknowledges the message, and the answer to the last call of `perform`
    or `activate`. Its clock goes on, and is never set back.
    """

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        """Continue the run with a new process of the interpreter.

        The world cancels and forgets requests and activations with other tickets.

        Args:
            tickets: the requests and activations that the interpreter may have sent and
                whose end it has not received.
            received: the number of messages that the interpreter has received since the
                start of the run. `messages` then returns each later message again.

        Returns:
            an item for each of the tickets that the world knows: its answer if
            `perform` or `activate` answered the request at once and finally; None if
            the request or activation is under way, or its `Finished` is still to be
            received.

        Raises:
            ValueError: if the world no longer has all later messages.
        """

    def acknowledge(self, received: int) -> None:
        """Let the world forget the first `received` messages of the run."""


@runtime_checkable
class Adjustable(Protocol):
    """A simulator with options that can change during a run.

    The values of these options are part of the state that `save` returns.
    """

    def adjustable(self) -> Mapping[str, Atom | bool]:
        """Return the options that can change during a run, with present values."""

    def adjust(self, name: str, value: Atom | bool) -> None:
        """Set an option to a new value.

        Raises:
            ValueError: for an invalid value.
        """


OPTIONAL: tuple[type, ...] = (
    Skilled,
    Timed,
    Drawable,
    Measured,
    Truth,
    Savable,
    Resumable,
    Adjustable,
)
"""The optional protocols of worlds."""


def methods_of(protocol: type) -> list[str]:
    """Return the names of the methods of `World`, or of an optional protocol."""
    return [
        name
        for name, value in vars(protocol).items()
        if callable(value) and not name.startswith("_")
    ]


class Wrapper(World):
    """A wrapper of a world; every call is passed to the wrapped world.

    The wrapper has the optional protocols of the wrapped world. A subclass changes a
    method of `World` by a method of the same name. It changes a method of an optional
    protocol, such as `save`, by a method with an underscore before the name: `_save`.

    Args:
        world: the wrapped world.
    """

    def __init__(self, world: World) -> None:
        self.enclose(world)

    def enclose(self, world: World) -> None:
        """Replace the wrapped world."""
        self.name = world.name
        self.kit, self.made_with = world.kit, world.made_with
        #: The wrapped world; `behind` has the type `Any`, because its methods vary.
        self.__wrapped__ = world
        self.behind: Any = world
        for protocol in OPTIONAL:
            for name in methods_of(protocol) if isinstance(world, protocol) else ():
                passed_on = getattr(self, f"_{name}", None) or getattr(world, name)
                setattr(self, name, passed_on)

    def facts(self) -> Iterable[Fact]:
        """Return the initial facts of the robot."""
        return self.__wrapped__.facts()

    def now(self) -> Time:
        """Return the time of the clock."""
        return self.__wrapped__.now()

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request."""
        return self.__wrapped__.perform(ticket, request)

    def cancel(self, ticket: int) -> None:
        """Stop the request under `ticket`."""
        self.__wrapped__.cancel(ticket)

    def next_time(self) -> Time | None:
        """Return the time of the next message."""
        return self.__wrapped__.next_time()

    def advance(self, to: Time) -> None:
        """Advance the clock."""
        self.__wrapped__.advance(to)

    def messages(self) -> Sequence[Message]:
        """Return the messages sent since the preceding call."""
        return self.__wrapped__.messages()

    def ended(self) -> str | None:
        """Return the reason why the world has ended the run, or None."""
        return self.__wrapped__.ended()


def innermost(world: World) -> World:
    """Return the innermost wrapped world."""
    while (behind := getattr(world, "__wrapped__", None)) is not None:
        world = behind
    return world
