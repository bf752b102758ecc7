"""The port between interpreter and world: all that authors of worlds import.

A `World` has a clock, takes requests, returns results and sensor data, may send more
unasked, and may end the run. Its `Kit` says what libraries find there: primitives and
data, options, and the Python code that belongs to the world, such as the handlers that
turn results and data into changes of memory through `HandlerMemory` [T 3.3]. What only
some worlds can do stands in protocols of its own: `Drawable`, `Savable`, `Skilled`,
`Timed`. The interpreter cannot see into a world, nor a world into the interpreter.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, Protocol, runtime_checkable

import msgspec

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
    "Skilled",
    "Spot",
    "Text",
    "Thing",
    "Time",
    "Timed",
    "World",
)

Time = Number
"""Simulated time units since the start of the run; never negative."""

OKAY = "okay"
"""The result symbol of a primitive that succeeded."""

NOT_KNOWN: Final[Time] = math.inf
"""What `World.next_time` returns where the world cannot say when it will send next."""


class Datum(msgspec.Struct, frozen=True):
    """One notification of the sensors: `(name arg...)`, items by sensor name."""

    content: Fact


class Signal(msgspec.Struct, frozen=True):
    """A signal `(:name arg...)`, items by sensor name [S 4]."""

    content: Fact
    #: The tickets of the activations, or of the request, under which it arose; none
    #: for a signal of the world by itself.
    tickets: tuple[int, ...] = ()


class Reply(msgspec.Struct, frozen=True):
    """The result of a primitive and the data that came with it, in order."""

    result: str
    data: tuple[Fact, ...] = ()


class Refused(msgspec.Struct, frozen=True):
    """The answer to a request, or an activation, that cannot be carried out now.

    `conflicts` are the tickets of those under way that it is in conflict with.
    The interpreter waits until they have ended, or has them cancelled, and asks again;
    where it can do neither the request has failed.
    """

    conflicts: tuple[int, ...] = ()
    #: Why, for people.
    reason: str = ""


class Finished(msgspec.Struct, frozen=True):
    """The end of a primitive that was not atomic, by the ticket of its request."""

    ticket: int
    reply: Reply


Message = Datum | Signal | Finished


class HandlerMemory(Protocol):
    """What a handler may do to memory (T A.3 to A.5).

    Facts are tuples of a declared name and atoms; symbols are `str`, strings of the
    language `rapc.base.values.Text`. All methods take memory names of items.
    """

    @property
    def now(self) -> Time:
        """The time of the clock."""

    @property
    def place(self) -> Atom | None:
        """The robot's own place: the one last given to `arrive`."""

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now; a property replaces its old value.

        Raises:
            ValueError: for an undeclared name, a wrong number of arguments, a
                built-in name, or an item's location and introducing class.
        """

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so. Raises ValueError as `assert_fact`."""

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """The facts that match, oldest first; None matches anything.

        Defaults are not consulted.
        """

    def value(self, *index: Atom) -> Atom | None:
        """The asserted value of a property for an index, or None."""

    def ask(
        self, formula: str, given: Mapping[str, Atom] | None = None
    ) -> list[dict[str, Any]]:
        """All answers to a formula of the language, in the order in which it has them.

        An answer holds the values of the variables by their names with question marks,
        those in `given` left out; a formula without variables that holds has one
        answer, an empty one. The formula is asked as a clause asks it, with defaults
        and named queries; a fault in it, an unbound variable say, is traced, and
        there is no answer. It is made ready once, when it is asked for the first time:
        what differs from one time to another belongs in `given`.

        Raises:
            ValueError: for a text that is no formula, or names what the library does
                not declare.
        """

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """An item is seen: returns its memory name; it is accessible from now.

        Asserts `(class item kind true)` and `(location item place)`. Seen again
        while accessible it is the same item; another place is a move. The name may
        become an alias of an older one when the batch ends.
        """

    def move(self, item: str, place: Atom) -> None:
        """An accessible item now is at `place`; it stays accessible."""

    def lose(self, item: str) -> None:
        """An item is not where it was: its place is `unknown`, it is out of reach."""

    def fix_cardinality(self, place: Atom) -> None:
        """All items accessible at `place` have been introduced: no others are there.

        This takes effect when the batch ends, so a result's handler may say it before
        the data are handled. Items believed there and not accessible get place
        `unknown`; of indistinct classes as many as are too many.
        """

    def expire(self) -> None:
        """All sensor names go: the robot has moved."""

    def arrive(self, place: Atom) -> None:
        """The robot now is at `place`, of which `external` speaks from now on."""


ResultHandler = Callable[[HandlerMemory, Fact, str], str | None]
"""Called with memory, the request (memory names) and the result symbol.

What it returns, unless None, is the result that the interpreter sees: another one of
those that are declared [T 3.3.2]."""

DatumHandler = Callable[[HandlerMemory, Fact], None]
"""Called with memory and the datum, known sensor names already replaced."""


class Handlers(msgspec.Struct, frozen=True):
    """The handlers of a world package, by primitive and by datum name.

    A primitive without a handler changes nothing; a datum without one is an error
    of the world package.
    """

    results: Mapping[str, ResultHandler] = {}
    data: Mapping[str, DatumHandler] = {}


KINDS = ("number", "integer", "flag", "symbol", "text")
"""The kinds of options."""


class Option(msgspec.Struct, frozen=True):
    """One option of a world: what `rapc worlds NAME` lists and `--set` changes."""

    name: str
    #: One of `number`, `integer`, `flag`, `symbol`, `text`.
    kind: str
    #: The value if nobody sets another; of kind `text` a `rapc.world.Text`.
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
            if not isinstance(option, Option) or option.kind not in KINDS:
                raise TypeError(f"`options` of a Kit has {option!a:.60}")


class World(ABC):
    """A world as the interpreter sees it. One instance serves one run.

    A world that is opened by name is made with its own random stream, which comes from
    the seed of the run, and with a value for each option: `(rng, options)`. It raises
    ValueError for values that make no sense together.
    """

    #: What the world is called: by `--set`, in traces and in messages.
    name: str
    #: What the world brings along for libraries. A world that is opened by name has one
    #: in its class; the constructor may put another in its place.
    kit: Kit

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
