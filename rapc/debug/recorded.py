"""Recorded runs: write a trace, run it again and compare."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from rapc import events
from rapc.base.decoding import UNREADABLE
from rapc.debug.history import History, Moment
from rapc.debug.log import ToldEvent
from rapc.debug.recording import Recording
from rapc.errors import LoadError, TextError, reason
from rapc.host import methods
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.planner import BUILT_IN, PLAN, Planned

_BROKEN_OFF = ("until", "cycles", "cancelled")
"""The end reasons of a run that could go on; a replay does not repeat such an end."""

_FOLDER = re.compile(r"(^| at ).*[/\\:](?=[^/\\:]+\.rap:[0-9]+)")
"""The folder in a position `FILE:LINE`, alone or after ` at `."""


def write_trace(history: History, path: Path) -> int:
    """Write the trace of the run up to now; return the number of events.

    Raises:
        LoadError: if the file cannot be written.
        StateError: if the log has dropped events and the run cannot go back.
    """
    count = 0
    try:
        with path.open("w", encoding="utf-8") as stream:
            trace = JsonTrace(stream)
            for one in history.scan():
                trace.raw(*one)
                count += 1
    except OSError as error:
        raise LoadError(f"cannot write `{path}`: {reason(error)}") from error
    return count


class Replay:
    """A comparison of a run with its recording.

    At first the history is before its first cycle; `goto(history.seen)` goes to the end
    of the recording. An act before that end begins another branch; events of that
    branch are not compared.

    Args:
        history: the run, begun with `recording.begun`.
        recording: the recording.
    """

    def __init__(self, history: History, recording: Recording) -> None:
        self._history, self._recording = history, recording
        self._lines = recording.lines()
        self._written = _Lines()
        self._trace = JsonTrace(self._written)
        #: The serial number of the next event to compare; None after the comparison.
        self._next: int | None = 0
        #: The first cycle that differs; None if no cycle differs.
        self.parted: int | None = None
        self._to_tell = ""
        #: Whether the run could go on; its last cycle may then be incomplete.
        self._cut = recording.reason in ("", *_BROKEN_OFF)
        self._last = Moment(max(recording.last_cycle - self._cut, 0))
        if any(one.plan for one in history.run.library.library.raps.values()):
            history.answers.coming.extend(_plans_of_engines(recording))
        self._main = history.branch
        self._main.end, self._main.over = self._last, not self._cut
        for told in history.log.scan(0):
            self._compare(told)
        history.follow(self._compare)
        history.checks["recording"] = self._stops
        history.notes.append(self.note)

    def note(self) -> str:
        """Return the text of the first difference, once; empty afterwards."""
        text, self._to_tell = self._to_tell, ""
        return text

    def _stops(self) -> str | None:
        """Return the reason to stop after a cycle, or None."""
        if self._to_tell:
            return self.note()
        at_end = self._history.moment == self._last
        if self._cut and self._is_recorded and at_end:
            return f"end of the recording ({self._recording.reason or 'cut off'})"
        return None

    @property
    def _is_recorded(self) -> bool:
        """Whether the run is free of acts that the recording lacks."""
        return self._history.branch is self._main and not self._main.acts

    def _compare(self, told: ToldEvent) -> None:
        """Compare an event with its line, unless a preceding event differs."""
        if told.serial != self._next or not self._is_recorded:
            return
        self._next += 1
        line = next(self._lines, b"")
        self._trace.raw(*told)
        if not line.endswith(b"\n"):  # the recording was cut off
            self._next = None
        elif told.kind is not events.RunStarted and line != self._written.text.encode():
            self._differs(told, line)

    def _differs(self, told: ToldEvent, line: bytes) -> None:
        """Note a line that differs in more than the folders of files."""
        if self._cut and told.cycle >= self._recording.last_cycle:
            self._next = None
            return
        try:
            there = msgspec.json.decode(line)
        except UNREADABLE:
            there = None
        if _anywhere(msgspec.json.decode(self._written.text)) != _anywhere(there):
            self._next = None
            self.parted = told.cycle
            self._to_tell = (
                f"the run differs from the recording from cycle {told.cycle} on (line "
                f"{told.serial + 1}): different library, world or user acts"
            )


def _plans_of_engines(recording: Recording) -> Iterator[tuple[int, str, Planned]]:
    """Yield the answers of planners that a replay cannot ask, each with its cycle.

    Raises:
        LoadError: for a plan that is not a method.
    """
    for told in recording.scan(0, recording.rows, [events.PlanMade]):
        keys = told.keys
        if keys["engine"] == BUILT_IN and not keys["refused"]:
            continue
        try:
            method = methods(keys["text"])[0] if keys["text"] else None
        except TextError as error:
            said = f"line {told.serial + 1} is not an event: {error.message}"
            raise LoadError(f"`{recording.path}` is not a trace: {said}") from None
        achieved = [
            tuple([link.fact for link in step.links if link.step is None])
            for step in keys["steps"]
        ]
        taken = ("outcome", "expanded", "left_out", "unreachable", "engine", "refused")
        rest = {name: keys[name] for name in taken}
        planned = Planned(method=method, achieved=tuple(achieved), **rest)
        yield told.cycle, PLAN, planned


class _Lines:
    """A stream that keeps the last text written."""

    text = ""

    def write(self, text: str) -> None:
        """Keep a line."""
        self.text = text


def _anywhere(told: Any) -> Any:
    """Return an event with the folders of file positions removed.

    The folders of the library and of rapc may differ between two machines.
    """
    if isinstance(told, dict):
        return {key: _anywhere(value) for key, value in told.items()}
    if isinstance(told, list):
        return [_anywhere(value) for value in told]
    return _FOLDER.sub(r"\1", told) if isinstance(told, str) else told
