"""The port between interpreter and world: all that authors of worlds import.

A `World` has a clock, takes requests, returns results and sensor data, may send more
unasked, and may end the run. Its `Kit` says what libraries find there: primitives and
data, options, and the Python code that belongs to the world, such as the handlers that
turn results and data into changes of memory through `HandlerMemory` [T 3.3]. What only
some worlds can do stands in protocols of its own, `OPTIONAL`. The interpreter cannot
see into a world, nor a world into the interpreter.
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
    Datum,
    Finished,
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
    "Mark",
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
    "Savable",
    "Signal",
    "SimpleWorld",
    "Skilled",
    "Spot",
    "Text",
    "Thing",
    "Time",
    "Timed",
    "Truthful",
    "World",
)


KINDS = ("number", "integer", "flag", "symbol", "text")
"""The kinds of options."""


class Option(msgspec.Struct, frozen=True):
    """One option of a world: what `rapc worlds NAME` lists and `--set` changes."""

    name: str
    #: One of `number`, `integer`, `flag`, `symbol`, `text`.
    kind: str
    #: The value if nobody sets another; of kind `text` a `str` or a `rapc.world.Text`.
    default: Atom | bool
    unit: str
    doc: str


Callables = Mapping[str, Callable[..., object]]
"""Python callables by the name under which libraries know them."""


class Kit(msgspec.Struct, frozen=True):
    """What a world brings along for libraries; nothing in it changes during a run."""

    #: The primitives, data, skills and signals of the world.
    offer: Offer = Offer()
    #: What turns results and data into changes of memory.
    handlers: Handlers = Handlers()
    #: The options with their defaults.
    options: tuple[Option, ...] = ()
    #: Functions `(memory, arg...)` and default functions `(memory, index)`, by name;
    #: an index is the tuple of the property's name and its arguments but the value.
    functions: Callables = {}
    #: Problem solvers `(goal, memory)` by the name of the RAP they help [T 7.4.1]; they
    #: return methods (see `rapc.methods`).
    solvers: Callables = {}
    #: Comparators `(one, other)` of descriptions, by name [T A.5]: each returns a
    #: number, 0 or less if the two cannot be the same item.
    comparators: Callables = {}

    def __post_init__(self) -> None:
        """See that the parts are what they should be; raises TypeError."""
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
    """A world as the interpreter sees it. One instance serves one run.

    A world that is opened by name is made with its own random stream, which comes from
    the seed of the run, and with a value for each option: `(rng, options)`. The value
    of an option of kind `symbol` or `text` is a `str`. It raises
    ValueError for values that make no sense together.
    """

    #: What the world is called: by `--set`, in traces and in messages.
    name: str
    #: What the world brings along for libraries. A world that is opened by name has one
    #: in its class; the constructor may put another in its place.
    kit: Kit
    #: The values of all options, if the world was opened by name: a saved run goes on
    #: only in a world that was opened with the same.
    made_with: Mapping[str, Atom | bool] = MappingProxyType({})

    def facts(self) -> Iterable[Fact]:
        """Return what the robot knows before it has sensed anything: a map, say."""
        return ()

    @abstractmethod
    def now(self) -> Time:
        """Return the time of the clock."""

    @abstractmethod
    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request (items by sensor name).

        An atomic primitive moves the clock on by what it takes and returns its
        reply; None means that the end comes later as a `Finished` with `ticket`.
        """

    def cancel(self, ticket: int) -> None:  # noqa: B027  # most worlds may leave it
        """Stop what was asked under `ticket` and has not ended: nobody wants it now.

        It may be answered once more, with what was done by then, or not at all; no
        time passes. A world that does nothing here goes on until it has ended. A
        ticket that was answered already means nothing.
        """

    @abstractmethod
    def next_time(self) -> Time | None:
        """Return when the world will next send something if nothing is asked of it.

        None: never. `NOT_KNOWN`: it cannot be said, as in a world whose time is
        continuous; `advance` then stops at the first thing there is to send.
        """

    @abstractmethod
    def advance(self, to: Time) -> None:
        """Move the clock on to `to`, never backwards; the world lives meanwhile.

        A world whose next time is `NOT_KNOWN` stops as soon as it has something to
        send; the rest of the way it is told again.
        """

    @abstractmethod
    def messages(self) -> Sequence[Message]:
        """Return what the world has sent since this was last asked, in order."""

    def ended(self) -> str | None:
        """Return the reason why the world has ended the run, or None.

        A world whose class does not define it never ends a run.
        """
        return None


class _SavedSimple(msgspec.Struct):
    """What `SimpleWorld.save` writes."""

    made_with: Mapping[str, Any]
    time: Time
    outbox: list[tuple[Time, Message]]
    rng: Stream
    state: msgspec.Raw


class SimpleWorld(World):
    """A world of which only `perform` has to be written.

    `advance` moves its clock, `send` sends a message now or later. What changes in it
    is in `state`, and all chance comes from `rng`: both are saved.

    Args:
        rng: the random stream.
        options: the values of the options.
        perform: the method `perform`, if the class does not define it.
        kit: the kit, if the class has none.
    """

    name = "simple"
    #: The time of the clock.
    time: Time = 0
    #: What changes: a dict of plain data, a dataclass or a msgspec struct.
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
        #: What is still to be fetched, each message with its time, soonest first.
        self.outbox: list[tuple[Time, Message]] = []
        if kit is not None or not hasattr(self, "kit"):
            self.kit = kit or Kit()
        if perform is not None:
            vars(self)["perform"] = MethodType(perform, self)
        elif type(self).perform is SimpleWorld.perform:
            raise TypeError("a SimpleWorld requires `perform`")

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request; a class defines this, or the constructor is given it."""
        raise NotImplementedError

    def send(self, message: Message, after: Time = 0) -> None:
        """Send a datum, a signal or the end of a request, `after` so much time."""
        self.outbox.append((self.time + after, message))
        self.outbox.sort(key=lambda sent: sent[0])

    def now(self) -> Time:
        """Return the time of the clock."""
        return self.time

    def advance(self, to: Time) -> None:
        """Move the clock on."""
        self.time = max(self.time, to)

    def next_time(self) -> Time | None:
        """Return when the next message comes, or None."""
        return max(self.time, self.outbox[0][0]) if self.outbox else None

    def messages(self) -> Sequence[Message]:
        """Return the messages whose time has come."""
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
        """Return the complete state, as JSON. Raises TypeError for no plain data."""
        state, rng = msgspec.json.encode(self.state), stream_state(self.rng)
        if msgspec.json.decode(state, type=type(self.state)) != self.state:
            raise TypeError(f"`state` of the world `{self.name}` is no plain data")
        made = dict(self.made_with)
        return msgspec.json.encode(
            _SavedSimple(made, self.time, self.outbox, rng, msgspec.Raw(state))
        )

    def restore(self, state: bytes) -> None:
        """Take up a saved state.

        Raises:
            ValueError: if it is none of this world, or of one with other options.
        """
        saved = msgspec.json.decode(state, type=_SavedSimple)
        if saved.made_with != dict(self.made_with):
            raise ValueError(f"the state is that of a `{self.name}` otherwise made")
        mine = msgspec.json.decode(saved.state, type=type(self.state))
        self.rng = stream_in(saved.rng)
        self.time, self.outbox, self.state = saved.time, saved.outbox, mine


@runtime_checkable
class Skilled(Protocol):
    """A world with skills that are switched on and off [S 3].

    What an activation asks for is a set of skills that are to run together from now
    on, and the events that are to be told for it. A skill that several activations
    have with the same arguments runs once, until the last of them is switched off; a
    `Signal` carries the tickets of all those under which it arose.
    """

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on, all at once; no time passes.

        Args:
            ticket: the number of the activation from now on.
            skills: what is to run, `(:name argument...)`, items by sensor name.
            events: the names of the events to be told, with their colons.

        Returns:
            None, or why nothing was switched on.
        """

    def deactivate(self, ticket: int) -> None:
        """Switch off what only this activation has; no time passes.

        What it has not told by now it never tells.
        """


@runtime_checkable
class Timed(Protocol):
    """A world that can say beforehand how long requests take."""

    def usual_time(self, request: Fact) -> Time:
        """Return how long a request usually holds the robot, in time units.

        A request that is made to fail (`--fault`) takes as long, and no time at all in
        a world that is not `Timed`.
        """


@runtime_checkable
class Drawable(Protocol):
    """A world that `rapc run --show` can draw."""

    def picture(self) -> Picture:
        """Return the truth as it is now; nothing changes by that."""


@runtime_checkable
class Truthful(Protocol):
    """A world that can say what was true, for experiments and tests.

    The robot never hears of it.
    """

    def figures(self) -> Mapping[str, Atom] | msgspec.Struct:
        """Return what was true so far; of what is numbers experiments tell.

        Which figures there are never changes. Nothing changes by asking.
        """


@runtime_checkable
class Savable(Protocol):
    """A simulator whose state can be saved."""

    def save(self) -> bytes:
        """Return the world's complete state, its random streams included.

        Nothing in the world changes.
        """

    def restore(self, state: bytes) -> None:
        """Go back to a state that `save` returned, in place.

        Raises:
            ValueError: if `state` is none of this world, or of one otherwise made.
        """


@runtime_checkable
class Adjustable(Protocol):
    """A simulator some of whose options can be changed while a run goes on.

    Their values are part of the state that `save` returns and `restore` goes back to.
    """

    def adjustable(self) -> Mapping[str, Atom | bool]:
        """Return the options that can be changed, with the values they have now."""

    def adjust(self, name: str, value: Atom | bool) -> None:
        """Give an option another value from now on.

        Raises:
            ValueError: for a value that it cannot have.
        """


OPTIONAL: tuple[type, ...] = (
    Skilled,
    Timed,
    Drawable,
    Truthful,
    Savable,
    Adjustable,
)
"""The protocols that a world may have or not."""


def methods_of(protocol: type) -> list[str]:
    """Return the names of the methods of `World`, or of an optional protocol."""
    return [
        name
        for name, value in vars(protocol).items()
        if callable(value) and not name.startswith("_")
    ]


class Wrapper(World):
    """A world round another one; every call goes on to the world behind.

    The optional protocols are there if the world behind has them. A subclass changes a
    method of `World` by a method of the same name. It changes a method of an optional
    protocol, such as `save`, by a method with an underscore before the name: `_save`.

    Args:
        world: the world behind.
    """

    def __init__(self, world: World) -> None:
        self.enclose(world)

    def enclose(self, world: World) -> None:
        """Put another world behind this one."""
        self.name = world.name
        self.kit, self.made_with = world.kit, world.made_with
        #: The world behind; in `behind` of any type, for it has what it has.
        self.__wrapped__ = world
        self.behind: Any = world
        for protocol in OPTIONAL:
            for name in methods_of(protocol) if isinstance(world, protocol) else ():
                passed_on = getattr(self, f"_{name}", None) or getattr(world, name)
                setattr(self, name, passed_on)

    def facts(self) -> Iterable[Fact]:
        """Return what the robot knows at first."""
        return self.__wrapped__.facts()

    def now(self) -> Time:
        """Return the time of the clock."""
        return self.__wrapped__.now()

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request."""
        return self.__wrapped__.perform(ticket, request)

    def cancel(self, ticket: int) -> None:
        """Stop what was asked under `ticket`."""
        self.__wrapped__.cancel(ticket)

    def next_time(self) -> Time | None:
        """Return when the world will next send something."""
        return self.__wrapped__.next_time()

    def advance(self, to: Time) -> None:
        """Move the clock on."""
        self.__wrapped__.advance(to)

    def messages(self) -> Sequence[Message]:
        """Return what the world has sent."""
        return self.__wrapped__.messages()

    def ended(self) -> str | None:
        """Return why the world has ended the run, or None."""
        return self.__wrapped__.ended()


def innermost(world: World) -> World:
    """Return the world behind all those that wrap it."""
    while (behind := getattr(world, "__wrapped__", None)) is not None:
        world = behind
    return world
