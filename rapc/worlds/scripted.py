"""A world that answers requests from a script: what tests of a library run against.

Every symbol is its own sensor name. What a script does to memory its handlers do,
with the result it belongs to. What a row may say is in `rapc.worlds.script`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence

import msgspec

from rapc.base.values import Fact, format_list, match, number
from rapc.errors import Error
from rapc.world import (
    Datum,
    DatumHandler,
    Finished,
    HandlerMemory,
    Handlers,
    Message,
    Offer,
    Option,
    Reply,
    Signal,
    Time,
    World,
)
from rapc.worlds.script import (
    At,
    Declarations,
    Row,
    check_script,
    fill,
    mentioned,
    offer_of,
)

AT = "at"
"""The datum by which an `At` reaches its handler; no library declares it."""


class UnansweredRequest(Error):
    """A request that no row of the script answers; `request` is it."""

    def __init__(self, request: Fact) -> None:
        super().__init__(f"no row of the script answers {format_list(request)}")
        self.request = request


class _Due(msgspec.Struct, frozen=True):
    """Something to come: an entry of `at`, or the end of the primitive of a row."""

    time: Time
    what: At | Row
    ticket: int = 0


class ScriptedWorld(World):
    """A world whose answers are written down beforehand.

    Args:
        rows: the script.
        at: what happens without a request; at one time, in this order.
        declared: the library that is to run; else all that is on offer is what the
            script itself mentions.
        data_handlers: handlers for the rows' data, those of another world, say.
        leaving: called whenever the clock is about to move on.

    Raises:
        ValueError: for a row with an unbound variable in its effects, an undeclared
            primitive, result or signal, or data without a handler.
    """

    name = "scripted"

    def __init__(
        self,
        rows: Sequence[Row],
        at: Sequence[At] = (),
        *,
        declared: Declarations | None = None,
        data_handlers: Mapping[str, DatumHandler] | None = None,
        leaving: Callable[[], None] | None = None,
    ) -> None:
        self._rows = tuple(rows)
        self._data_handlers = dict(data_handlers or {})
        self._leaving = leaving
        self._offer = offer_of(declared) if declared else mentioned(self._rows, at)
        check_script(self._rows, at, self._offer, self._data_handlers)
        self._used = [0] * len(self._rows)
        self._now: Time = 0
        self._coming = sorted((_Due(a.time, a) for a in at), key=_time)
        self._sent: list[Message] = []
        self._entries: deque[At] = deque()
        self._ends: list[Row] = []
        self._told: deque[Row] = deque()
        self._before: list[At] = []
        self._answered: Row | None = None

    @classmethod
    def options(cls) -> Sequence[Option]:
        """None: its script is given to the constructor."""
        return ()

    def offer(self) -> Offer:
        """What the library declares, or what the script mentions."""
        return self._offer

    def handlers(self) -> Handlers:
        """Handlers that carry out what this script does to memory."""
        results = dict.fromkeys(self._offer.primitives, self._handle_result)
        return Handlers(results, {**self._data_handlers, AT: self._handle_at})

    def now(self) -> Time:
        """The clock."""
        return self._now

    def perform(self, ticket: int, request: Fact) -> Reply | None:
        """What the first row that matches and is not used up says.

        Raises:
            UnansweredRequest: if there is none.
        """
        row = self._answer(request)
        end = number(self._now + row.takes)
        if row.after is not None:
            self._coming.append(_Due(number(end + row.after), row, ticket))
            self._coming.sort(key=_time)
            self.advance(end)
            return None
        self.advance(end)
        self._before, self._entries = list(self._entries), deque()
        self._sent = [m for m in self._sent if m != Datum((AT,))]
        self._sent += (Signal(content) for content in row.signals)
        self._answered = row
        return Reply(row.result, row.data)

    def usual_time(self, request: Fact) -> Time:
        """How long the row that would answer holds the robot; 0 if there is none."""
        rows = zip(self._rows, self._used, strict=True)
        answers = (
            row.takes
            for row, used in rows
            if used != row.times and match(row.pattern, request) is not None
        )
        return next(answers, 0)

    def next_time(self) -> Time | None:
        """When the next entry of `at` or the end of a primitive is due."""
        if self._sent:
            return self._now
        return max(self._coming[0].time, self._now) if self._coming else None

    def advance(self, to: Time) -> None:
        """Move the clock on, and send what falls due meanwhile."""
        if self._leaving is not None and to > self._now:
            self._leaving()
        while self._coming and self._coming[0].time <= to:
            due = self._coming.pop(0)
            if isinstance(due.what, At):
                self._entries.append(due.what)
                self._sent.append(Datum((AT,)))
            else:
                self._ends.append(due.what)
                reply = Reply(due.what.result, due.what.data)
                self._sent.append(Finished(due.ticket, reply))
            self._sent += (Signal(content) for content in due.what.signals)
        self._now = max(self._now, to)

    def messages(self) -> Sequence[Message]:
        """What fell due since this was last asked, in the order of time."""
        found, self._sent = tuple(self._sent), []
        self._told.extend(self._ends)
        self._ends.clear()
        return found

    def _answer(self, request: Fact) -> Row:
        for index, row in enumerate(self._rows):
            bound = match(row.pattern, request)
            if bound is None or self._used[index] == row.times:
                continue
            self._used[index] += 1
            return fill(row, bound)
        raise UnansweredRequest(request)

    def _handle_result(self, memory: HandlerMemory, _: Fact, __: str) -> None:
        """The answer just given, and what came before it; else the next end told.

        A result that this world has not given changes nothing.
        """
        for entry in self._before:
            _change(memory, entry)
        self._before = []
        row, self._answered = self._answered, None
        if row is None and self._told:
            row = self._told.popleft()
        if row is not None:
            _change(memory, row)

    def _handle_at(self, memory: HandlerMemory, _: Fact) -> None:
        _change(memory, self._entries.popleft())


def _change(memory: HandlerMemory, effects: Row | At) -> None:
    for prefix in effects.erases:
        memory.erase(*prefix)
    for fact in effects.asserts:
        memory.assert_fact(*fact)


def _time(due: _Due) -> Time:
    return due.time
