"""Traces: events written as JSON Lines, or as text in the manner of T 6.2.1.

Both forms go to any text stream, one line at a time, so that a run that is cut off
leaves a readable trace. The keys of the JSON form are in docs/trace.md. Events hold
values; the words for them are made here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple, Protocol, TextIO

import msgspec

from rapc.base.values import Fact, format_atom, format_list
from rapc.base.visible import visible
from rapc.runtime.events import events
from rapc.runtime.events.report import cause_in_a_line
from rapc.world import Time


def record(event: events.Event) -> dict[str, Any]:
    """Return an event as the object that a trace holds, its values as RAP text."""
    kind, shape = type(event), _shape(type(event))
    told = {name: getattr(event, name) for name in _COMMON}
    own = _in_words(_completed(kind, _keys(event)), shape.words, [None, None, None])
    keys = {"event": shape.tag, **told, **own}
    found: dict[str, Any] = msgspec.to_builtins(keys, enc_hook=_text)
    return found


_COMMON = events.Event.__struct_fields__
"""The keys that all events have; those of a kind follow."""

_Words = list[tuple[str, Callable[[Any], Any]]]


def _keys(event: events.Event) -> dict[str, Any]:
    names = type(event).__struct_fields__[len(_COMMON) :]
    return {name: getattr(event, name) for name in names}


class _Shape(NamedTuple):
    """How a kind of event is written."""

    tag: str
    #: The keys that are written in words, by their names in a trace.
    words: _Words
    #: How many keys an event has that can be written as they are; -1 if none can.
    size: int
    #: Its own fields, each with its name in a trace and its default.
    fields: tuple[tuple[str, str, object], ...]
    #: Whether what has its default is left out.
    omits: bool


@cache
def _shape(kind: type[events.Event]) -> _Shape:
    config = kind.__struct_config__
    own = msgspec.structs.fields(kind)[len(_COMMON) :]
    fields = tuple([(one.name, one.encode_name, one.default) for one in own])
    size = sum(one.required or not config.omit_defaults for one in own)
    if any(name != key for name, key, _ in fields):
        size = -1
    words = dict(_WORDS.get(kind, ()))
    in_words = [(key, words[key]) for _, key, _ in fields if key in words]
    return _Shape(str(config.tag), in_words, size, fields, config.omit_defaults)


def _completed(kind: type[events.Event], keys: dict[str, Any]) -> dict[str, Any]:
    """Return the keys of an event by their names in a trace, with those left out."""
    shape = _shape(kind)
    return {
        key: value
        for name, key, default in shape.fields
        if (value := keys.get(name, default)) is not default or not shape.omits
    }


def _in_words(keys: dict[str, Any], words: _Words, last: list[Any]) -> dict[str, Any]:
    """Return keys with text for values.

    `last` holds what was put into words last, by what, and these words: a request is
    told of three times, one after the other.
    """
    keys = keys.copy()
    for name, write in words:
        value = keys[name]
        if value or value == 0:  # what is empty is written as it is
            if value is not last[0] or write is not last[1]:
                last[:] = value, write, write(value)
            keys[name] = last[2]
    return keys


def _text(value: object) -> str:
    """Return what the encoder does not know as text: goals, mostly."""
    # by its attribute, as Python takes long to find the `__str__` of a class
    return (type(value) is events.Goal and value.text) or str(value)


def _facts(data: Iterable[Fact]) -> tuple[str, ...]:
    return tuple([format_list(fact) for fact in data])


def _bindings(bindings: Mapping[str, object]) -> dict[str, str]:
    return {name: format_atom(value) for name, value in bindings.items()}


def _result_or_signal(what: str | Fact) -> str:
    return what if isinstance(what, str) else format_list(what)


_WORDS: Mapping[type, Sequence[tuple[str, Callable[[Any], Any]]]] = {
    events.MethodChosen: [("bindings", _bindings)],
    events.TaskSucceeded: [("outputs", _bindings)],
    events.PrimitiveRequested: [("request", format_list), ("sent", format_list)],
    events.PrimitiveEnded: [("request", format_list), ("data", _facts)],
    events.PrimitiveCancelled: [("request", format_list)],
    events.RequestRefused: [("request", format_list), ("sent", format_list)],
    events.SkillEnabled: [("what", format_list)],
    events.SkillDisabled: [("what", format_list)],
    events.RuleRun: [("what", _result_or_signal)],
    events.DataReceived: [("data", format_list)],
    events.FactAsserted: [("fact", format_list)],
    events.FactErased: [("fact", format_list)],
    events.ResourceChanged: [("what", str)],
    events.SignalReceived: [("what", format_list)],
    events.ItemIntroduced: [("location", format_atom)],
    events.ItemMerged: [("location", format_atom)],
    events.ItemMoved: [("location", format_atom)],
    events.ItemLost: [("location", format_atom)],
}
"""The keys of each kind of event whose values a trace has as text, and their words.

Goals need no row: the encoder writes as text what it does not know.
"""


class JsonTrace:
    """Writes each event as one line of JSON; the same events give the same bytes."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._encode = msgspec.json.Encoder(enc_hook=_text).encode
        #: How lines of each kind of event begin, how many keys can be written as they
        #: are, and which in words.
        self._shapes: dict[type[events.Event], tuple[str, int, _Words]] = {}
        self._last: list[Any] = [None, None, None]
        #: The time of the event before, and how it is written.
        self._time: Time | None = None
        self._stamp = ""

    def __call__(self, event: events.Event) -> None:
        """Write one event."""
        self.raw(type(event), event.n, event.cycle, event.time, _keys(event))

    def raw(
        self,
        kind: type[events.Event],
        serial: int,
        cycle: int,
        time: Time,
        keys: dict[str, Any],
    ) -> None:
        """Write one event that has not been made: see `Recorder.listen`.

        The keys are in the order of its fields; what is left out has its default.
        """
        head, size, words = self._shapes.get(kind) or self._learn(kind)
        if len(keys) != size:
            keys = _completed(kind, keys)
        if words:
            keys = _in_words(keys, words, self._last)
        if time is not self._time:
            self._time, self._stamp = time, self._encode(time).decode()
        told = self._encode(keys).decode()
        self._stream.write(
            f'{head}{serial},"cycle":{cycle},"time":{self._stamp},{told[1:]}\n'
        )

    def _learn(self, kind: type[events.Event]) -> tuple[str, int, _Words]:
        shape = _shape(kind)
        found = f'{{"event":"{shape.tag}","n":', shape.size, shape.words
        self._shapes[kind] = found
        return found


class Writable(Protocol):
    """Whatever text can be written to."""

    def write(self, text: str, /) -> object:
        """Write text."""


class TextTrace:
    """Writes events as a person reads them, one line per step of the interpreter."""

    def __init__(self, stream: Writable) -> None:
        self._stream = stream
        self._time: object = None
        self._asked: events.PrimitiveRequested | None = None
        self._held: list[tuple[events.Event, str]] = []

    def __call__(self, event: events.Event) -> None:
        """Write what there is to say about one event, if anything.

        A request gets a line of its own only if its primitive does not end at once.
        Until that is known, what the host does meanwhile is held back.
        """
        if isinstance(event, events.PrimitiveRequested):
            self._asked = event
            return
        line = _LINES.get(type(event))
        text = line(event) if line is not None else None
        if text is None:
            return
        if self._asked is not None:
            if isinstance(event, events.TaskCreated | events.TaskRemoved):
                self._held.append((event, text))
                return
            self._tell_asked(event, self._asked)
        self._write(event, text)

    def _tell_asked(
        self, event: events.Event, asked: events.PrimitiveRequested
    ) -> None:
        """Write what was held back; `event` tells whether the primitive has ended."""
        ended = isinstance(event, events.PrimitiveEnded) and (
            event.task == asked.task or event.request == asked.request
        )
        if not ended:
            self._write(
                asked, f"    ... primitive operation {format_list(asked.request)} begun"
            )
        for held, text in self._held:
            self._write(held, text)
        self._asked = None
        self._held.clear()

    def _write(self, event: events.Event, text: str) -> None:
        stamp = "" if event.time == self._time else format_atom(event.time)
        self._time = event.time
        self._stream.write(f"{stamp:>7} {text}\n")


_CAUSE = " " * 16
"""Where the cause of a failure stands, below the failure."""


def _created(event: Any) -> str:
    priority = f" priority {event.priority}" if event.priority else ""
    return f"    ... creating task {event.goal} [{event.task}]{priority}"


def _chosen(event: Any) -> str:
    return f"    ... method {event.method} of {event.rap} [{event.task}]"


def _ended(event: Any) -> str | None:
    return f"    ... primitive operation {format_list(event.request)} - {event.result}"


def _blocked(event: Any) -> str:
    if event.holder is None:
        return f"    ... blocked until {event.on} [{event.task}]"
    return f"    ... waits for {event.on}, held by [{event.holder}] [{event.task}]"


def _failed(event: Any) -> str:
    told = f"    ... goal failed ({event.reason}) - {event.result}: "
    told += f"{event.goal} [{event.task}]"
    if event.because is None:
        return told
    lines = [told, f"{_CAUSE}because of {_short(event.because)}"]
    lines += [f"{_CAUSE}  {_short(ruled_out)}" for ruled_out in event.because.methods]
    return "\n".join(lines)


def _short(cause: events.Cause) -> str:
    """Return a cause on one line, with its file but not with the folders of that."""
    file = cause.place.replace("\\", "/").rpartition("/")[2]
    return cause_in_a_line(msgspec.structs.replace(cause, place=file))


def _run_started(event: Any) -> str:
    tasks = ", ".join(event.tasks) or "no task"
    return (
        f"run of {visible(event.library)} in {event.world}, seed {event.seed}: {tasks}"
    )


_LINES: Mapping[type, Callable[[Any], str | None]] = {
    events.RunStarted: _run_started,
    events.TaskCreated: _created,
    events.TaskSelected: lambda e: f"--> considering {e.goal} [{e.task}]",
    events.MethodChosen: _chosen,
    events.TaskBlocked: _blocked,
    events.Deadlock: lambda e: f"    ... deadlock: {'; '.join(e.waiting)}",
    events.MethodSuspended: lambda e: (
        f"    ... method {e.method} suspended for {e.for_} of [{e.by}] [{e.task}]"
    ),
    events.PrimitiveCancelled: lambda e: (
        f"    ... primitive operation {format_list(e.request)} - cancelled"
    ),
    events.RequestRefused: lambda e: (
        f"    ... primitive operation {format_list(e.request)} - refused"
        + (f": {e.because}" if e.because else "")
    ),
    events.SkillEnabled: lambda e: (
        f"    ... skill {format_list(e.what)} enabled [{e.task}]"
    ),
    events.SkillDisabled: lambda e: (
        f"    ... skill {format_list(e.what)} disabled [{e.task}]"
    ),
    events.SignalReceived: lambda e: f"    ... signal {format_list(e.what)}",
    events.TaskWoken: lambda e: f"    ... woken by {e.on} [{e.task}]",
    events.TaskSucceeded: lambda e: f"    ... task accomplished {e.goal} [{e.task}]",
    events.TaskFailed: _failed,
    events.TaskRemoved: lambda e: f"    ... removing task [{e.task}] ({e.cause})",
    events.PrimitiveEnded: _ended,
    events.ResourceChanged: lambda e: f"    ... {e.what} [{e.task}]",
    events.QueryFaulted: lambda e: f"    ... query fault: {e.what}",
    events.FamilySwitched: lambda e: (
        f"--> switching family from [{e.from_}] to [{e.to}]"
    ),
    events.DeadlineMissed: lambda e: (
        f"    ... deadline {format_atom(e.deadline)} missed [{e.task}]"
    ),
    events.SolverCalled: lambda e: (
        f"    ... problem solver for {e.goal}: {e.methods} methods"
    ),
    events.RunEnded: lambda e: f"run over: {e.reason}",
}
