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
            self._write(asked, f"    ... primitive operation {asked.request} begun")
        for held, text in self._held:
            self._write(held, text)
        self._asked = None
        self._held.clear()

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
