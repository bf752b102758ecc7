"""Traces: events written as JSON Lines, or as text in the manner of T 6.2.1.

Both forms go to any text stream, one line at a time, so that a run that is cut off
leaves a readable trace. The keys of the JSON form are in docs/trace.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TextIO

import msgspec

from rapc.base.values import format_atom
from rapc.runtime.events import events


class JsonTrace:
    """Writes each event as one line of JSON; the same events give the same bytes."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._encode = msgspec.json.Encoder().encode

    def __call__(self, event: events.Event) -> None:
        """Write one event."""
        self._stream.write(self._encode(event).decode() + "\n")


class TextTrace:
    """Writes events as a person reads them, one line per step of the interpreter."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._time: object = None
        self._asked: events.PrimitiveRequested | None = None

    def __call__(self, event: events.Event) -> None:
        """Write what there is to say about one event, if anything.

        A request gets a line of its own only if its primitive does not end at once.
        """
        if isinstance(event, events.PrimitiveRequested):
            self._asked = event
            return
        line = _LINES.get(type(event))
        text = line(event) if line is not None else None
        if text is None:
            return
        asked, self._asked = self._asked, None
        if asked is not None and not isinstance(event, events.PrimitiveEnded):
            self._write(asked, f"    ... primitive operation {asked.request} begun")
        self._write(event, text)

    def _write(self, event: events.Event, text: str) -> None:
        stamp = "" if event.time == self._time else format_atom(event.time)
        self._time = event.time
        self._stream.write(f"{stamp:>7} {text}\n")


def _created(event: Any) -> str:
    priority = f" priority {event.priority}" if event.priority else ""
    return f"    ... creating task {event.goal} [{event.task}]{priority}"


def _chosen(event: Any) -> str:
    return f"    ... method {event.method} of {event.rap} [{event.task}]"


def _ended(event: Any) -> str | None:
    return f"    ... primitive operation {event.request} - {event.result}"


def _failed(event: Any) -> str:
    return (
        f"    ... goal failed ({event.reason}) - {event.result}: "
        f"{event.goal} [{event.task}]"
    )


def _run_started(event: Any) -> str:
    tasks = ", ".join(event.tasks) or "no task"
    return f"run of {event.library} in {event.world}, seed {event.seed}: {tasks}"


_LINES: Mapping[type, Callable[[Any], str | None]] = {
    events.RunStarted: _run_started,
    events.TaskCreated: _created,
    events.TaskSelected: lambda e: f"--> considering {e.goal} [{e.task}]",
    events.MethodChosen: _chosen,
    events.TaskBlocked: lambda e: f"    ... blocked until {e.on} [{e.task}]",
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
