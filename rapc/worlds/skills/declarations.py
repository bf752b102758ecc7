"""What the author of a skill declares: channels, parameters, skills, events.

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

    A channel holds the value of the present tick, or nothing.
    """

    __slots__ = ("doc", "name", "own", "type", "types", "unit")

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
        #: What a value is; also what a saved value is read back as.
        self.type = type
        self.unit = unit
        self.doc = doc
        #: Whether each skill that writes the channel has one for itself, which only
        #: its own events read.
        self.own = own
        #: The classes of which a value is, as far as that is quickly seen.
        self.types = _classes(type)

    @property
    def kind(self) -> str:
        """Return how messages name type and unit: `float in m`."""
        plain = isinstance(self.type, type) and get_origin(self.type) is None
        kind = self.type.__name__ if plain else str(self.type)
        return f"{kind} in {self.unit}" if self.unit else kind

    def __repr__(self) -> str:
        return f"<channel {self.name}>"


def _classes(type_: Any) -> tuple[type, ...]:
    """Return the classes that values of a type have; `object` where any may do."""
    origin = get_origin(type_)
    if origin in (Union, UnionType):
        return tuple(one for part in get_args(type_) for one in _classes(part))
    found = type(None) if type_ is None else origin or type_
    if found is Any or not isinstance(found, type):
        return (object,)
    try:
        isinstance(None, found)
    except TypeError:  # a protocol, a typed dict: it cannot be asked
        return (object,)
    return (float, int) if found is float else (found,)


class Input(msgspec.Struct, frozen=True, eq=False):
    """A channel that a skill reads."""

    channel: Channel[Any]
    #: Whether the skill also works while nothing is written to the channel.
    optional: bool = False
    #: Whether the skill reads the value of the tick before: what a circle of skills
    #: needs in one place.
    delayed: bool = False


Reads = Channel[Any] | Input


class Parameter(msgspec.Struct, frozen=True):
    """A value that the RAP system hands to a skill, or an event hands to it."""

    name: str
    #: One of `KINDS`.
    kind: str
    unit: str = ""
    doc: str = ""
    #: Bounds of a number, both allowed themselves.
    low: float | None = None
    high: float | None = None

    def fault(self, value: object) -> str | None:
        """Return what is wrong with `value`, or None if it fits."""
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

    What was not declared cannot be reached.

    Args:
        node: how messages name the skill or event.
        values: what the channels hold, by slot.
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
        """Return what `channel` holds. Raises SkillError if it holds nothing."""
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
        """Return what `channel` holds, or None."""
        try:
            value: T | None = self._values.get(self._reads[channel])
        except KeyError:
            raise self._undeclared("reads", channel) from None
        return value

    def __setitem__(self, channel: Channel[T], value: T) -> None:
        """Write `value` to `channel` for the rest of the tick.

        Raises:
            SkillError: if it is not of the channel's type.
        """
        if not isinstance(value, channel.types):
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
    """The state of a skill that has none."""


class NetworkNode:
    """What skills and events have in common: inputs, arguments, a state."""

    name: ClassVar[str]
    inputs: ClassVar[tuple[Reads, ...]] = ()
    #: The type of `state`: a msgspec struct, which is saved and restored.
    State: ClassVar[type[msgspec.Struct]] = Stateless

    def __init__(self, arguments: Mapping[str, Any]) -> None:
        """Make the skill as it is when it comes on.

        Args:
            arguments: the values of the parameters by name; an event has those of
                its skill.
        """
        self.arguments = arguments
        #: All that the skill remembers from one tick to the next.
        self.state: Any = self.State()


def label_of(node: type[NetworkNode]) -> str:
    """Return how messages name a class of skills or events: by name and class."""
    return f"`{node.name}` ({node.__name__})"


class Event(NetworkNode):
    """A test on channels that tells the RAP system when it comes out true [S 2].

    An event is told to an activation once, at the edge; it can be told again after
    the test has failed once.
    """

    #: What the event says besides its name.
    carries: ClassVar[tuple[Parameter, ...]] = ()
    #: Seconds after which an event whose test still holds is told again; None: never.
    again: ClassVar[float | None] = None

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return what the event carries if its test holds in this tick, else None.

        Args:
            now: the time in seconds.
            ports: the channels; those of the event's own skill come first.
        """
        raise NotImplementedError


class Skill(NetworkNode):
    """A continuous process: every tick it reads its inputs and writes its outputs.

    The docstring's first line of a skill's class is what `describe` says of it.
    """

    outputs: ClassVar[tuple[Channel[Any], ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    #: The events that the skill may tell.
    events: ClassVar[tuple[type[Event], ...]] = ()
    #: Things that only one skill at a time can use, `wheels` for example.
    uses: ClassVar[tuple[str, ...]] = ()

    def step(self, now: float, ports: Ports) -> None:
        """Do the work of one tick.

        Args:
            now: the time in seconds.
            ports: the channels of `inputs` and `outputs`.
        """
        raise NotImplementedError


class Compound(msgspec.Struct, frozen=True):
    """A skill made of smaller ones that are switched on and off together [S 2.1].

    A part takes its arguments from the parameters of the same names.
    """

    name: str
    parts: tuple[type[Skill], ...]
    parameters: tuple[Parameter, ...] = ()
    doc: str = ""


class Arbiter:
    """What decides when several active skills write one channel.

    Without a declared arbiter two writers are a conflict.
    """

    channel: ClassVar[Channel[Any]]

    def decide(self, values: list[Any]) -> Any:
        """Return the one value that the readers get.

        Args:
            values: what was written in this tick, in the order in which the skills
                came on; never empty.
        """
        raise NotImplementedError


def as_input(reads: Reads) -> Input:
    """Return a declared input in its long form."""
    return reads if isinstance(reads, Input) else Input(reads)


def first_line(doc: str | None) -> str:
    """Return the first line of a docstring, without the full stop."""
    return (doc or "").strip().partition("\n")[0].rstrip(".")
