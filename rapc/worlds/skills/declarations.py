"""Declarations by the author of a skill: channels, parameters, skills, events.

    OBSTACLES = Channel("obstacles", Obstacles, "m", "what is near, by direction")

    class DetectObstacles(Skill):
        name = "detect-obstacles"
        inputs = (SONAR,)
        outputs = (OBSTACLES,)

        def step(self, now: float, ports: Ports) -> None:
            ports[OBSTACLES] = nearest(ports[SONAR])

Another skill that declares `OBSTACLES` among its inputs is wired to this one whenever
both are active. Not here: wiring (`network`) and checks of a whole set (`catalogue`).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import UnionType
from typing import Any, ClassVar, Generic, TypeVar, Union, get_args, get_origin

import msgspec

from rapc.base.values import Atom, Text, is_number

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)

KINDS = ("number", "symbol", "text")


class SkillError(Exception):
    """A skill that breaks its own declaration: a fault of the world's author."""


class Channel(Generic[T_co]):
    """A named stream of values between skills, sensors and actuators.

    A channel holds the value of the present tick, or no value.
    """

    __slots__ = ("_entries", "_types", "doc", "name", "own", "type", "unit")

    def __init__(
        self,
        name: str,
        type: type[T_co],
        unit: str = "",
        doc: str = "",
        *,
        own: bool = False,
    ) -> None:
        self.name = name
        #: The type of a value; a saved value is read back as this type.
        self.type = type
        self.unit = unit
        self.doc = doc
        #: Whether each skill that writes the channel has its own slot, which only the
        #: skill's own events read.
        self.own = own
        self._types = _classes(type)
        #: The classes of the entries, if a value is a tuple of any length or a list.
        self._entries = _classes_of_entries(type)

    def fits(self, value: object) -> bool:
        """Whether `value`, with its entries, is of the channel's type."""
        if not _is_of(type(value), self._types):
            return False
        return self._entries is None or all(
            _is_of(kind, self._entries)
            for kind in set(map(type, value))  # type: ignore[call-overload]  # a list
        )

    @property
    def kind(self) -> str:
        """Name of type and unit for messages: `float in m`."""
        plain = isinstance(self.type, type) and get_origin(self.type) is None
        kind = self.type.__name__ if plain else str(self.type)
        return f"{kind} in {self.unit}" if self.unit else kind

    def __repr__(self) -> str:
        return f"<channel {self.name}>"


def _classes(type_: Any) -> tuple[type, ...]:
    """Return the classes of a type's values; `object` if every class is possible."""
    origin = get_origin(type_)
    if origin in (Union, UnionType):
        return tuple(one for part in get_args(type_) for one in _classes(part))
    found = type(None) if type_ is None else origin or type_
    if found is Any or not isinstance(found, type):
        return (object,)
    try:
        isinstance(None, found)
    except TypeError:  # a protocol or a typed dict has no instance check
        return (object,)
    return (float, int) if found is float else (found,)


def _classes_of_entries(type_: Any) -> tuple[type, ...] | None:
    args = get_args(type_)
    if get_origin(type_) is list or (get_origin(type_) is tuple and ... in args):
        return _classes(args[0])
    return None


def _is_of(kind: type, classes: tuple[type, ...]) -> bool:
    """Whether values of a class are of one of `classes`; a boolean is no number."""
    if kind is bool and object not in classes:
        return bool in classes
    return issubclass(kind, classes)


class Input(msgspec.Struct, frozen=True, eq=False):
    """A channel that a skill reads."""

    channel: Channel[Any]
    #: Whether the skill also works without a value on the channel.
    optional: bool = False
    #: Whether the skill reads the value of the preceding tick. A circle of skills
    #: needs a delayed input in one place.
    delayed: bool = False


Reads = Channel[Any] | Input


class Parameter(msgspec.Struct, frozen=True):
    """A value that the RAP system passes to a skill, or an event to the RAP system."""

    name: str
    #: A kind of `KINDS`.
    kind: str
    unit: str = ""
    doc: str = ""
    #: Bounds of a number, inclusive.
    low: float | None = None
    high: float | None = None

    @property
    def measure(self) -> str:
        """Name of kind and unit for messages: `number in m`."""
        return f"{self.kind} in {self.unit}" if self.unit else self.kind

    def wrong_bounds(self) -> str | None:
        """Return the fault of the bounds, or None if they are valid."""
        bounds = [bound for bound in (self.low, self.high) if bound is not None]
        if any(map(math.isnan, bounds)):
            return f"a bound of `{self.name}` is not a number"
        if bounds != sorted(bounds):
            return f"`low` of `{self.name}` is above `high`"
        return None

    def fault(self, value: object) -> str | None:
        """Return the fault of `value`, or None if it is valid."""
        fits = {
            "number": is_number(value),
            "symbol": isinstance(value, str),
            "text": isinstance(value, Text),
        }[self.kind]
        if not fits:
            return f"`{self.name}` must be a {self.kind}"
        if isinstance(value, int | float):
            if self.low is not None and value < self.low:
                return f"`{self.name}` must not be below {self.low:g}"
            if self.high is not None and value > self.high:
                return f"`{self.name}` must not be above {self.high:g}"
        return None


class Ports:
    """The channels of one active skill or event, read and written by channel.

    Undeclared channels cannot be used.

    Args:
        node: the name of the skill or event in messages.
        values: the values of the channels, by slot.
        reads: the slot of each channel that can be read.
        writes: the slot of each channel that can be written.
    """

    __slots__ = ("_node", "_reads", "_values", "_writes")

    def __init__(
        self,
        node: str,
        values: dict[str, Any],
        reads: Mapping[Channel[Any], str],
        writes: Mapping[Channel[Any], str],
    ) -> None:
        self._node = node
        self._values = values
        self._reads = reads
        self._writes = writes

    def __getitem__(self, channel: Channel[T]) -> T:
        """Return the value of `channel`. Raises SkillError if there is no value."""
        try:
            value: T = self._values[self._reads[channel]]
        except KeyError:
            if channel in self._reads:
                raise SkillError(
                    f"nothing was written to `{channel.name}` before "
                    f"{self._node} read it"
                ) from None
            raise self._undeclared("reads", channel) from None
        return value

    def get(self, channel: Channel[T]) -> T | None:
        """Return the value of `channel`, or None."""
        try:
            value: T | None = self._values.get(self._reads[channel])
        except KeyError:
            raise self._undeclared("reads", channel) from None
        return value

    def __setitem__(self, channel: Channel[T], value: T) -> None:
        """Write `value` to `channel` for the rest of the tick.

        Raises:
            SkillError: if `value` is not of the channel's type.
        """
        if not channel.fits(value):
            raise SkillError(
                f"{self._node} writes {value!a:.60} to `{channel.name}`, which is "
                f"{channel.kind}"
            )
        try:
            self._values[self._writes[channel]] = value
        except KeyError:
            raise self._undeclared("writes", channel) from None

    def _undeclared(self, does: str, channel: Channel[Any]) -> SkillError:
        return SkillError(
            f"{self._node} {does} `{channel.name}`, which it does not declare"
        )


class Stateless(msgspec.Struct):
    """The state of a skill without state."""


class NetworkNode:
    """The common part of skills and events: inputs, arguments, a state."""

    name: ClassVar[str]
    inputs: ClassVar[tuple[Reads, ...]] = ()
    #: The type of `state`: a msgspec struct; the runtime saves and restores it.
    State: ClassVar[type[msgspec.Struct]] = Stateless

    def __init__(self, arguments: Mapping[str, Any]) -> None:
        """Make the skill in its initial state.

        Args:
            arguments: the values of the parameters by name; an event has the arguments
                of its skill.
        """
        self.arguments = arguments
        #: The state that the skill keeps from tick to tick.
        self.state: Any = self.State()


def label_of(node: type[NetworkNode]) -> str:
    """Return the name of a class of skills or events for messages: name and class."""
    return f"`{node.name}` ({node.__name__})"


class Event(NetworkNode):
    """A test on channels, reported to the RAP system when the test passes [S 2].

    The runtime reports an event to an activation once, at the first passing test. It
    can report the event again after the test has failed once.
    """

    #: The arguments of the event.
    carries: ClassVar[tuple[Parameter, ...]] = ()
    #: Seconds after which a passing event is reported again; None: never.
    again: ClassVar[float | None] = None

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return the event's arguments if its test passes in this tick, else None.

        Args:
            now: the time in seconds.
            ports: the channels; the channels of the event's own skill come first.
        """
        raise NotImplementedError  # `Catalogue` refuses a class without this method


class Skill(NetworkNode):
    """A continuous process: each tick it reads its inputs and writes its outputs.

    The first line of the class's docstring is the description in `describe`.
    """

    outputs: ClassVar[tuple[Channel[Any], ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    #: The events that the skill may report.
    events: ClassVar[tuple[type[Event], ...]] = ()
    #: Things that only one skill at a time can use, for example `wheels`.
    uses: ClassVar[tuple[str, ...]] = ()
    #: Whether all activations share the skill: it runs once, with the arguments of the
    #: newest activation. So enabling it again changes its arguments [S 2].
    single: ClassVar[bool] = False

    def step(self, now: float, ports: Ports) -> None:
        """Do the work of one tick.

        Args:
            now: the time in seconds.
            ports: the channels of `inputs` and `outputs`.
        """
        raise NotImplementedError  # `Catalogue` refuses a class without this method


class Compound(msgspec.Struct, frozen=True):
    """A skill made of smaller skills that are switched on and off together [S 2.1].

    A part takes its arguments from the parameters of the same names.
    """

    name: str
    parts: tuple[type[Skill], ...]
    parameters: tuple[Parameter, ...] = ()
    doc: str = ""


class Arbiter(ABC):
    """The decision between several active skills that write one channel.

    Without a declared arbiter two writers are a conflict.
    """

    channel: ClassVar[Channel[Any]]

    @abstractmethod
    def decide(self, values: list[Any]) -> Any:
        """Return the value for the readers.

        Args:
            values: the values written in this tick, in the order in which the skills
                were switched on; never empty.
        """


def as_input(reads: Reads) -> Input:
    """Return a declared input in its long form."""
    return reads if isinstance(reads, Input) else Input(reads)


def first_line(doc: str | None) -> str:
    """Return the first line of a docstring, without the full stop."""
    return (doc or "").strip().partition("\n")[0].rstrip(".")
