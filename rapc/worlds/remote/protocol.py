"""The messages between the interpreter and a world in another process, as types.

A message is a JSON-RPC 2.0 object in one line. The types define the fields; unknown
fields are ignored. `schema` returns their JSON Schema.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from rapc.base.chance import Stream
from rapc.base.messages import Change
from rapc.base.pictures import Picture
from rapc.base.values import Fact
from rapc.spec import Plain

PROTOCOL: Final = 1
"""The number of this version of the protocol."""

LINE_LIMIT = 16 * 2**20
"""The longest line, in bytes."""

TOKEN = "RAPC_TOKEN"  # noqa: S105  # a name
"""The environment variable with the token for TCP."""

Symbol = Annotated[str, Meta(pattern=r"^[^\x00-\x20\x7f()\";?]+$", max_length=200)]
Time = Annotated[int, Meta(ge=0, le=10**15)] | Annotated[float, Meta(ge=0, le=10**15)]
Count = Annotated[int, Meta(ge=0)]


class _Part(msgspec.Struct, frozen=True, rename="kebab", omit_defaults=True):
    """A part of a message."""


# --- describe -------------------------------------------------------------------------


class DescribeParams(_Part, frozen=True):
    """Parameters of `describe`, the first call of a connection."""

    protocol: int
    #: The token, for TCP.
    token: str | None = None


class Primitive(_Part, frozen=True):
    """A primitive of the offer."""

    #: The names of the arguments.
    arguments: tuple[Symbol, ...]
    results: tuple[Symbol, ...]
    #: Whether the reply comes with the answer to `perform`.
    atomic: bool = True
    #: Whether the primitive only senses and changes nothing.
    sensor: bool = False
    #: What to do with a request under way when the interpreter dies.
    after_crash: Literal["repeat", "fail", "ask"] | None = None


class WireOption(_Part, frozen=True):
    """An option of the world, as in `rapc.world.Option`."""

    name: Symbol
    kind: Literal["number", "integer", "flag", "symbol", "text"]
    default: Plain
    unit: str = ""
    doc: str = ""


OptionalMethod = Literal[
    "cancel",
    "activate",
    "deactivate",
    "usual-time",
    "picture",
    "figures",
    "truth",
    "save",
    "restore",
    "resume",
    "adjustable",
    "adjust",
]
"""The methods that a peer may leave out."""


class Description(_Part, frozen=True):
    """The result of `describe`: the offer of the world, constant for the peer."""

    protocol: int
    #: The name of the world for `--set`, traces and messages.
    name: Symbol
    doc: str = ""
    primitives: Mapping[Symbol, Primitive] = {}
    #: The names of the arguments of each datum, skill and signal; the names of skills
    #: and signals start with a colon.
    data: Mapping[Symbol, tuple[Symbol, ...]] = {}
    skills: Mapping[Symbol, tuple[Symbol, ...]] = {}
    events: Mapping[Symbol, tuple[Symbol, ...]] = {}
    options: tuple[WireOption, ...] = ()
    #: The other methods that the peer answers, besides `describe`, `open`, `perform`
    #: and `advance`.
    methods: tuple[OptionalMethod, ...] = ()
    #: The installed world whose handlers, functions and solvers are used; empty: none.
    code: str = ""
    #: The limit in seconds for the answer to a method [default: 10].
    timeouts: Mapping[str, Annotated[float, Meta(gt=0, le=86_400)]] = {}
    #: The seconds without a message after which the peer stops its body; the
    #: interpreter sends `heartbeat` four times as often while it waits.
    heartbeat: Annotated[float, Meta(ge=0.01, le=3600)] | None = None
    #: Whether `open` gets the random stream of the run.
    stream: bool = False


# --- answers --------------------------------------------------------------------------


class WireDatum(_Part, frozen=True, tag_field="type", tag="datum"):
    """A datum, as in `rapc.world.Datum`."""

    content: Fact
    memory: tuple[Change, ...] | None = None
    number: Count | None = None


class WireSignal(_Part, frozen=True, tag_field="type", tag="signal"):
    """A signal, as in `rapc.world.Signal`."""

    content: Fact
    tickets: tuple[int, ...] = ()
    number: Count | None = None


class WireFinished(_Part, frozen=True, tag_field="type", tag="finished"):
    """The end of a primitive that is not atomic, as in `rapc.world.Finished`."""

    ticket: int
    result: str
    data: tuple[Fact, ...] = ()
    memory: tuple[Change, ...] | None = None


class WireLost(_Part, frozen=True, tag_field="type", tag="lost"):
    """The loss of a request, as in `rapc.world.Lost`."""

    ticket: int
    reason: str = ""


WireMessage = WireDatum | WireSignal | WireFinished | WireLost

MOST_MESSAGES = 10_000
"""The highest number of messages in an answer."""


class Answer(_Part, frozen=True):
    """The fields of each result, except that of `describe`."""

    #: The time of the clock.
    now: Time
    #: The time of the next message if no further call comes: null for never,
    #: `unknown` if the time is not known.
    next: Time | Literal["unknown"] | None = None
    #: The messages since the last answer, in order.
    messages: Annotated[tuple[WireMessage, ...], Meta(max_length=MOST_MESSAGES)] = ()
    #: The number of messages since `open` or `restore`, including these; required
    #: with the method `resume`.
    sent: Count | None = None
    #: The reason why the world has ended the run.
    ended: str | None = None


class WireReply(_Part, frozen=True):
    """The reply to a request, as in `rapc.world.Reply`."""

    result: str
    data: tuple[Fact, ...] = ()
    memory: tuple[Change, ...] | None = None


class Refusal(_Part, frozen=True):
    """The refusal of a request or activation, as in `rapc.world.Refused`."""

    conflicts: tuple[int, ...] = ()
    reason: str = ""


class Opened(Answer, frozen=True):
    """The result of `open`."""

    #: The initial facts of the robot.
    facts: tuple[Fact, ...] = ()


class Performed(Answer, frozen=True):
    """The result of `perform`; without `reply` and `refused` the end comes later."""

    reply: WireReply | None = None
    refused: Refusal | None = None


class Activated(Answer, frozen=True):
    """The result of `activate`."""

    refused: Refusal | None = None


class Known(_Part, frozen=True):
    """A request that the world knows, in the result of `resume`.

    Without `reply` and `refused` the request is under way, or its end is among the
    messages.
    """

    ticket: int
    reply: WireReply | None = None
    refused: Refusal | None = None


class Resumed(Answer, frozen=True):
    """The result of `resume`."""

    requests: tuple[Known, ...] = ()
    #: The initial facts of the robot.
    facts: tuple[Fact, ...] = ()


class Saved(Answer, frozen=True, kw_only=True):
    """The result of `save`."""

    #: The complete state: any JSON value.
    state: msgspec.Raw


class UsualTime(Answer, frozen=True, kw_only=True):
    """The result of `usual-time`."""

    time: Time


class Pictured(Answer, frozen=True, kw_only=True):
    """The result of `picture`."""

    picture: Picture


class Measured(Answer, frozen=True, kw_only=True):
    """The result of `figures`."""

    figures: Mapping[str, int | float | str]


class ToldTruth(Answer, frozen=True, kw_only=True):
    """The result of `truth`."""

    facts: Mapping[str, tuple[Fact, ...]]


class Adjusted(Answer, frozen=True, kw_only=True):
    """The result of `adjustable`."""

    options: Mapping[str, Plain]


# --- parameters -----------------------------------------------------------------------


class Params(_Part, frozen=True, kw_only=True):
    """A field of the parameters of each method but `describe`."""

    #: The number of messages since the start of the run that a resumable world may
    #: forget.
    ack: int | None = None


class OpenParams(Params, frozen=True, kw_only=True):
    """Parameters of `open`, which starts a run."""

    #: A random number that depends on the seed of the run.
    seed: int
    #: The values of all options.
    options: Mapping[str, Plain] = {}
    #: The state of Python's `random.Random`, if the description has `stream`.
    stream: Stream | None = None


class PerformParams(Params, frozen=True, kw_only=True):
    """Parameters of `perform`."""

    ticket: int
    request: Fact


class TicketParams(Params, frozen=True, kw_only=True):
    """Parameters of `cancel` and `deactivate`."""

    ticket: int


class AdvanceParams(Params, frozen=True, kw_only=True):
    """Parameters of `advance`."""

    to: Time


class ActivateParams(Params, frozen=True, kw_only=True):
    """Parameters of `activate`."""

    ticket: int
    skills: tuple[Fact, ...]
    events: tuple[str, ...]


class ResumeParams(Params, frozen=True, kw_only=True):
    """Parameters of `resume`, which continues a run after a crash, without `open`."""

    tickets: tuple[int, ...]
    #: The number of messages that the interpreter has received in the run.
    received: int
    #: The parameters of `open`, for a new process of a peer whose machine goes on.
    opening: OpenParams | None = None


class RestoreParams(Params, frozen=True, kw_only=True):
    """Parameters of `restore`."""

    state: msgspec.Raw


class UsualTimeParams(Params, frozen=True, kw_only=True):
    """Parameters of `usual-time`."""

    request: Fact


class AdjustParams(Params, frozen=True, kw_only=True):
    """Parameters of `adjust`."""

    name: str
    value: Plain


METHODS: Mapping[str, tuple[type, type]] = {
    "describe": (DescribeParams, Description),
    "open": (OpenParams, Opened),
    "perform": (PerformParams, Performed),
    "advance": (AdvanceParams, Answer),
    "cancel": (TicketParams, Answer),
    "activate": (ActivateParams, Activated),
    "deactivate": (TicketParams, Answer),
    "usual-time": (UsualTimeParams, UsualTime),
    "picture": (Params, Pictured),
    "figures": (Params, Measured),
    "truth": (Params, ToldTruth),
    "save": (Params, Saved),
    "restore": (RestoreParams, Answer),
    "resume": (ResumeParams, Resumed),
    "adjustable": (Params, Adjusted),
    "adjust": (AdjustParams, Answer),
}
"""The types of parameters and result, by method."""


# --- envelopes ------------------------------------------------------------------------


class Call(msgspec.Struct, frozen=True, omit_defaults=True):
    """A call of a method, or a notification, which has no id."""

    method: str
    params: Any = None
    id: int | None = None
    jsonrpc: Literal["2.0"] | None = None


class Fault(msgspec.Struct, frozen=True):
    """The error of a call."""

    message: str
    code: int = -32000


class Response(msgspec.Struct, frozen=True, omit_defaults=True):
    """The answer to a call; or a notification, which has a method."""

    jsonrpc: Literal["2.0"]
    id: int | None = None
    result: msgspec.Raw = msgspec.Raw()
    error: Fault | None = None
    method: str | None = None


def schema() -> dict[str, Any]:
    """Return the JSON Schema of all parameters and results.

    The definition `perform.params` has the parameters of `perform`, `perform.result`
    the result.
    """
    types = [part for pair in METHODS.values() for part in pair]
    refs, definitions = msgspec.json.schema_components(types)
    found: dict[str, Any] = {}
    for at, method in enumerate(METHODS):
        found[f"{method}.params"], found[f"{method}.result"] = refs[2 * at : 2 * at + 2]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$defs": {**found, **definitions},
    }
