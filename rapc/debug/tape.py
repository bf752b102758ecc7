"""Recorded runs without what they ran: only to look at, forth and back.

A trace has words where a run has values. Goals, facts and requests are read again, as
far as searching and telling needs them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from rapc import events
from rapc.base.values import Fact, number
from rapc.debug.log import EventLog, ToldEvent, Wanted
from rapc.debug.recorded import read_events
from rapc.debug.stepped import Stepped
from rapc.errors import LoadError, TextError
from rapc.events import Cause, Goal, TaskResult, kinds
from rapc.parser.parse import parse_fact
from rapc.world import Time


class Tape(Stepped):
    """A recorded run that is only looked at; it stands before its first cycle.

    Args:
        told: all its events, in order.
    """

    def __init__(self, told: Iterable[ToldEvent]) -> None:
        self._all = list(told)
        super().__init__(EventLog(most=max(len(self._all), 1)))
        self._end = _beginning_of_end(self._all)
        self._at = 0
        self._number = 0
        self._feed(0)

    @classmethod
    def open(cls, path: Path) -> Tape:
        """Read a recorded run from a file.

        Raises:
            LoadError: for what cannot be read, and for what is no trace.
        """
        known = kinds()
        return cls(
            _told(path, row, one, known) for row, one in enumerate(read_events(path))
        )

    @property
    def cycle(self) -> int:
        """The number of the cycle that was looked at last."""
        return self._number

    @property
    def now(self) -> Time:
        """The time of the last event up to here."""
        return self._all[self._at - 1].time if self._at else 0

    @property
    def reason(self) -> str:
        """The reason why the run was over, at its end; empty before."""
        if self._at < len(self._all):
            return ""
        last = self._all[-1] if self._all else None
        ended = last is not None and last.kind is events.RunEnded
        return str(last.keys["reason"]) if ended and last else "no more is recorded"

    @property
    def serial(self) -> int:
        """The place of the next event."""
        return self._at

    @property
    def seen(self) -> int:
        """The last cycle that was recorded."""
        return self._all[-1].cycle if self._all else 0

    def scan(
        self,
        *kinds: type[Any],
        first: int = 0,
        want: Callable[[ToldEvent], bool] | None = None,
    ) -> list[ToldEvent]:
        """Return events up to here: see `Stepped.scan`."""
        wanted = Wanted(kinds, first, want)
        return [told for told in self._all[: self._at] if wanted.fits(told)]

    def _cycle(self) -> bool:
        if self._at < self._end:
            self._number += 1
            self._feed(self._number)
            return True
        self._hand_over(len(self._all))
        return False

    def _feed(self, cycle: int) -> None:
        """Hand over all events up to the end of a cycle, but for those of the end."""
        until = self._at
        while until < self._end and self._all[until].cycle <= cycle:
            until += 1
        self._hand_over(until)

    def _hand_over(self, until: int) -> None:
        for told in self._all[self._at : until]:
            self.log.raw(*told)
        self._at = until

    def _go_back(self, cycle: int) -> None:
        self._number = cycle
        self._at = 0
        self.log.forget_from(0)
        watcher, self.log.watcher = self.log.watcher, None
        self._feed(cycle)
        self.log.watcher = watcher


def _beginning_of_end(told: list[ToldEvent]) -> int:
    """Return the place of the first event of the end of a run, where it is removed."""
    at = len(told)
    while at and (
        told[at - 1].kind is events.RunEnded
        or (
            told[at - 1].kind is events.TaskRemoved
            and told[at - 1].keys["cause"] == "run-over"
        )
    ):
        at -= 1
    return at


# --- words into values ----------------------------------------------------------------


def _told(
    path: Path, row: int, event: Mapping[str, Any], known: Mapping[str, type[Any]]
) -> ToldEvent:
    """Return an event of a trace as a run would have told it. Raises LoadError."""
    kind = known.get(str(event["event"]))
    if kind is None:
        said = f"line {row + 1} is an event `{event['event']}`, which is not known"
        raise LoadError(f"`{path}` is no trace: {said}")
    keys = {}
    try:
        for field in msgspec.structs.fields(kind):
            if field.encode_name in event:
                value = event[field.encode_name]
            elif not field.required:
                value = field.default
            else:
                raise LoadError(
                    f"`{path}` is no trace: line {row + 1} has no `{field.encode_name}`"
                )
            read_it = _READ.get(field.name)
            keys[field.name] = value if read_it is None else read_it(value)
        serial, cycle, time = (keys.pop(name) for name in ("n", "cycle", "time"))
        return (
            ToldEvent(kind, row, int(cycle), number(time), keys)
            if serial == row
            else (_out_of_order(path, row))
        )
    except (TypeError, ValueError, msgspec.ValidationError) as error:
        raise LoadError(f"`{path}` is no trace: line {row + 1}: {error}") from error


def _out_of_order(path: Path, row: int) -> ToldEvent:
    raise LoadError(f"`{path}` is no trace: line {row + 1} is out of order")


_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[^\s()"]*\([^()]*\)|[^\s()"]+')


def _words(text: object) -> tuple[Any, ...]:
    """Return the words of a list; what it was made of cannot be told any more."""
    return tuple(_WORD.findall(str(text)[1:-1]))


def _fact(text: object) -> Fact:
    """Return a fact, request or signal; one that is none is left as its words."""
    try:
        return parse_fact(str(text))
    except TextError:
        return _words(text)


def _facts(texts: object) -> object:
    """Return the data of a result, or the one datum that came by itself."""
    if isinstance(texts, str):
        return _fact(texts)
    return tuple(map(_fact, texts)) if isinstance(texts, list) else texts


def _goal(text: object) -> Goal:
    words = _words(text)
    at = words.index("=>") if "=>" in words else len(words)
    return Goal(str(words[0]), words[1:at], words[at + 1 :])


def _because(value: object) -> object:
    return msgspec.convert(value, Cause) if isinstance(value, dict) else value


def _results(value: object) -> tuple[TaskResult, ...]:
    return msgspec.convert(
        value, tuple[TaskResult, ...], dec_hook=lambda _, text: _goal(text)
    )


def _what(value: object) -> object:
    """Return a signal or skill; what became of a resource stays words."""
    return _fact(value) if str(value).startswith("(") else value


_READ: Mapping[str, Callable[[Any], Any]] = {
    "goal": _goal,
    "fact": _fact,
    "request": _fact,
    "sent": _fact,
    "data": _facts,
    "what": _what,
    "because": _because,
    "results": _results,
}
"""How the values of a key are read; those of any other stay as they are."""
