"""Traces: events written as JSON Lines, or as text in the manner of T 6.2.1.

Both forms go to any text stream, one line at a time: an aborted run leaves a readable
trace. docs/reference/trace.md lists the keys of the JSON form; `rapc.events` defines
the written fields of an event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from io import StringIO
from typing import Any, NamedTuple, Protocol

import msgspec

from rapc import events
from rapc.base.values import format_list, readable
from rapc.world import Time


def record(event: events.Event) -> dict[str, Any]:
    """Return an event as an object of a trace, with values as RAP text."""
    kind, shape = type(event), _shape(type(event))
    told = {name: getattr(event, name) for name in _COMMON}
    own = _in_words(_completed(kind, _keys(event)), shape.words, [None, None, None])
    keys = {"event": shape.tag, **told, **own}
    found: dict[str, Any] = msgspec.to_builtins(keys, enc_hook=_text)
    return found


_COMMON = events.Event.__struct_fields__
"""The keys of all events; the keys of a kind follow."""

_Words = list[tuple[str, Callable[[Any], Any]]]


def _keys(event: events.Event) -> dict[str, Any]:
    names = type(event).__struct_fields__[len(_COMMON) :]
    return {name: getattr(event, name) for name in names}


class _Shape(NamedTuple):
    """The written form of a kind of event."""

    tag: str
    #: The keys that are written as text, by their names in a trace.
    words: _Words
    #: How many keys of an event can be written unchanged; -1 if none can.
    size: int
    #: The kind's own fields, each with its name in a trace and its default.
    fields: tuple[tuple[str, str, object], ...]
    #: Whether fields with their default are omitted.
    omits: bool


@cache
def _shape(kind: type[events.Event]) -> _Shape:
    config = kind.__struct_config__
    own = msgspec.structs.fields(kind)[len(_COMMON) :]
    fields = tuple([(one.name, one.encode_name, one.default) for one in own])
    size = sum(one.required or not config.omit_defaults for one in own)
    if any(name != key for name, key, _ in fields):
        size = -1
    return _Shape(
        str(config.tag), events.words(kind), size, fields, config.omit_defaults
    )


def _completed(kind: type[events.Event], keys: dict[str, Any]) -> dict[str, Any]:
    """Return the keys of an event by their names in a trace, with omitted ones."""
    shape = _shape(kind)
    return {
        key: value
        for name, key, default in shape.fields
        if (value := keys.get(name, default)) is not default or not shape.omits
    }


def _in_words(keys: dict[str, Any], words: _Words, last: list[Any]) -> dict[str, Any]:
    """Return keys with text for values.

    `last` holds the last converted value, its conversion and its text: three events in
    a row report the same request.
    """
    keys = keys.copy()
    for name, write in words:
        value = keys[name]
        if value or value == 0:  # empty values are written unchanged
            if value is not last[0] or write is not last[1]:
                last[:] = value, write, write(value)
            keys[name] = last[2]
    return keys


def _text(value: object) -> str:
    """Return text for a value unknown to the encoder: a goal, mostly."""
    # by its attribute, as Python takes long to find the `__str__` of a class
    return (type(value) is events.Goal and value.text) or str(value)


class JsonTrace:
    """A listener that writes each event as one line of JSON, repeatably."""

    def __init__(self, stream: Writable) -> None:
        self._stream = stream
        self._encode = msgspec.json.Encoder(enc_hook=_text).encode
        #: For each kind of event the beginning of its lines, the number of keys that
        #: can be written unchanged, and the keys to write as text.
        self._shapes: dict[type[events.Event], tuple[str, int, _Words]] = {}
        self._last: list[Any] = [None, None, None]
        #: The time of the last event, and its text.
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

        The keys are in the order of the event's fields; missing keys have their
        defaults.
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
    """A stream that text can be written to."""

    def write(self, text: str, /) -> object:
        """Write text."""


class TextTrace:
    """A listener that writes events for people, a line per step of the interpreter."""

    def __init__(self, stream: Writable) -> None:
        self._stream = stream
        self._time: object = None
        self._asked: events.PrimitiveRequested | None = None
        self._held: list[tuple[events.Event, str]] = []

    def __call__(self, event: events.Event) -> None:
        """Write the lines of one event, if any.

        A request gets a line of its own only if its primitive does not end at once.
        Until that is known, the listener holds back the host's events.
        """
        if isinstance(event, events.PrimitiveRequested):
            self._asked = event
            return
        text = event.line()
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
        """Write the events held back; `event` shows whether the primitive has ended."""
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
        """Write the line of an event."""
        stamp = "" if event.time == self._time else readable(event.time)
        self._time = event.time
        self._stream.write(f"{stamp:>7} {text}\n")


def text_lines(told: Iterable[events.Event]) -> list[str]:
    """Return the lines of a text trace of some events."""
    stream = StringIO()
    trace = TextTrace(stream)
    for event in told:
        trace(event)
    return stream.getvalue().splitlines()
