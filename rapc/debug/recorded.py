"""Recorded runs: traces that are written, followed by replay, and compared."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec

from rapc import events
from rapc.debug.log import ToldEvent
from rapc.debug.session import Session
from rapc.debug.stepped import Stepped
from rapc.errors import LoadError
from rapc.runtime.events.trace import JsonTrace, record

_DECISIONS = ("task-selected", "method-chosen")
"""The events in which a run decides something."""

_BROKEN_OFF = ("until", "cycles", "cancelled")
"""Why a run ends that could have gone on: what it did then is not done again."""

_FOLDER = re.compile(r"(^| at ).*[/\\:](?=[^/\\:]+\.rap:[0-9]+)")
"""The folder of a file whose row is told: alone, or behind words."""

_Event = dict[str, Any]


def write_trace(session: Stepped, path: Path) -> int:
    """Write the trace of the run up to now; return how many events it has.

    Raises:
        LoadError: if the file cannot be written.
        StateError: if events are gone and the run cannot be taken back in time.
    """
    told = session.scan()
    try:
        with path.open("w", encoding="utf-8") as stream:
            trace = JsonTrace(stream)
            for one in told:
                trace(one.event())
    except OSError as error:
        raise LoadError(f"cannot write `{path}`: {error.strerror}") from error
    return len(told)


def read_events(path: Path) -> Iterator[_Event]:
    """Iterate over the events of a trace in the form jsonl.

    Raises:
        LoadError: for what cannot be read, and for what is no trace.
    """
    try:
        with path.open("rb") as stream:
            for row, line in enumerate(stream, 1):
                event = msgspec.json.decode(line)
                if not isinstance(event, dict) or "event" not in event:
                    raise LoadError(f"`{path}` is no trace: line {row} is no event")
                yield event
    except OSError as error:
        raise LoadError(f"cannot read `{path}`: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise LoadError(f"`{path}` is no trace: {error}") from error


class Beginnings(msgspec.Struct, frozen=True):
    """The library, world, seed and tasks with which a recorded run began."""

    library: str
    world: str
    options: dict[str, str | int | float | bool]
    settings: dict[str, int | float | bool]
    seed: int
    tasks: tuple[str, ...]
    faults: tuple[str, ...]
    #: A trace that an earlier rapc wrote does not have them.
    facts: tuple[str, ...] = ()
    #: Tells the texts of the library from others; nor does it have that.
    digest: str = ""


def beginnings(path: Path) -> Beginnings:
    """Return what a recorded run was begun with: its first event says it.

    Raises:
        LoadError: for what is no trace, or one that lacks its beginning.
    """
    for event in read_events(path):
        if event["event"] == "run-started":
            try:
                return msgspec.convert(event, Beginnings)
            except msgspec.ValidationError as error:
                raise LoadError(f"`{path}` is no trace: {error}") from error
        break
    raise LoadError(f"`{path}` is no trace of a run from its beginning")


class Parting(msgspec.Struct, frozen=True):
    """Where two runs part: what each did then; None where one is over."""

    cycle: int
    here: _Event | None
    there: _Event | None


def follow(session: Session, path: Path) -> Parting | None:
    """Run on as a recorded run went; return where it parts from it, None if nowhere.

    The session then stands at the end of the last cycle in which they agree.

    Raises:
        LoadError: for what is no trace.
        StateError: if the run cannot be taken back in time and has to be.
    """
    last = 0
    for event in read_events(path):
        last = max(last, event.get("cycle", 0))
    session.goto(last)
    ends = [event for event in read_events(path) if event["event"] == "run-ended"]
    broken_off = bool(ends) and ends[0]["reason"] in _BROKEN_OFF
    if ends and not broken_off:
        session.step()
    found = parting(session, path)
    if found is not None and not session.no_way_back:
        session.goto(max(found.cycle - 1, 0))
    # a run that is broken off may have done less in its last cycle, or more behind it
    return None if broken_off and found and found.cycle >= last else found


def parting(session: Stepped, path: Path, *, decisions: bool = False) -> Parting | None:
    """Return the first event in which the run differs from a recorded one.

    Args:
        session: the run, as far as it has gone.
        path: the trace of the other.
        decisions: whether only choices of tasks and methods are compared.

    Raises:
        LoadError: for what is no trace.
    """
    mine = _mine(session, decisions)
    others = (e for e in read_events(path) if not decisions or e["event"] in _DECISIONS)
    for here, there in zip_longest(mine, others):
        one, other = _bare(here, decisions), _bare(there, decisions)
        if one != other and _anywhere(one) != _anywhere(other):
            either = here or there or {}
            return Parting(either.get("cycle", 0), here, there)
    return None


def _mine(session: Stepped, decisions: bool) -> Iterator[_Event]:
    kinds = (events.TaskSelected, events.MethodChosen) if decisions else ()
    told: list[ToldEvent] = session.scan(*kinds)
    return (_as_read(record(one.event())) for one in told)


def _as_read(event: _Event) -> _Event:
    """Return an event as it is read from a file."""
    found: _Event = msgspec.json.decode(msgspec.json.encode(event, enc_hook=str))
    return found


def _bare(event: _Event | None, decisions: bool) -> _Event | None:
    """Return an event without what says only where it stands, for decisions.

    How a run was begun is no part of how it went.
    """
    if event is not None and event["event"] == "run-started":
        return {"event": "run-started"}
    if event is None or not decisions:
        return event
    return {key: value for key, value in event.items() if key != "n"}


def _anywhere(told: Any) -> Any:
    """Return an event without the folders of the files that it names.

    The same library may lie elsewhere, and rapc be installed elsewhere.
    """
    if isinstance(told, dict):
        return {key: _anywhere(value) for key, value in told.items()}
    if isinstance(told, list):
        return [_anywhere(value) for value in told]
    return _FOLDER.sub(r"\1", told) if isinstance(told, str) else told
