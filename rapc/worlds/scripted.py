"""A world that answers requests from a script: what tests of a library run against.

Every symbol is its own sensor name. What a script does to memory its handlers do,
with the result it belongs to. What a row may say is in `rapc.worlds.script`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from rapc.base.values import Fact, format_list, match, number
from rapc.errors import Error
from rapc.world import (
    Datum,
    Finished,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Refused,
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


_NO_KIT = Kit()


class UnansweredRequest(Error):
    """A request that no row of the script answers; `request` is it."""

    def __init__(self, request: Fact) -> None:
        super().__init__(f"no row of the script answers {format_list(request)}")
        self.request = request


class _Due(msgspec.Struct, frozen=True):
    """Something to come: an entry of `at`, or the end of the primitive of a row."""

    time: Time
    entry: At | None = None
    row: Row | None = None
    ticket: int = 0


class _Sent(msgspec.Struct, frozen=True):
    """A message not yet fetched, as it is saved: one of the three."""

    datum: Datum | None = None
    signal: Signal | None = None
    finished: Finished | None = None

    def message(self) -> Message:
        """Return the message itself."""
        found = self.datum or self.signal or self.finished
        if found is None:
            raise ValueError("a message is empty")
        return found


_ENTRY = _Sent(datum=Datum((AT,)))


class _State(msgspec.Struct):
    """All that changes in a scripted world."""

    #: How often each row has been used.
    used: list[int]
    now: Time = 0
    #: What is to come, soonest first.
    coming: list[_Due] = []
    #: The messages not yet fetched.
    sent: list[_Sent] = []
    #: The entries of `at` whose handler has not run.
    entries: list[At] = []
    #: Rows whose end is among `sent`.
    ends: list[Row] = []
    #: Rows whose end was fetched and whose handler has not run.
    told: list[Row] = []
    #: The entries of `at` that fell into the primitive that `answered` answers.
    before: list[At] = []
    #: The row that has just answered, its handler not yet run.
    answered: Row | None = None


class ScriptedWorld(World):
    """A world whose answers are written down beforehand.

    Args:
        rows: the script.
        at: what happens without a request; at one time, in this order.
        declared: the library that is to run; else all that is on offer is what the
            script itself mentions.
        kit: what the library finds besides the script: handlers of the rows' data,
            functions, solvers and comparators, those of another world, say.
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
        kit: Kit = _NO_KIT,
        leaving: Callable[[], None] | None = None,
    ) -> None:
        self._rows = tuple(rows)
        self._leaving = leaving
        offer = offer_of(declared) if declared else mentioned(self._rows, at)
        handled = kit.handlers.data
        check_script(self._rows, at, offer, handled)
        results = dict.fromkeys(offer.primitives, self._handle_result)
        offer = msgspec.structs.replace(offer, data={**offer.data, AT: 0})
        handlers = Handlers(results, {**handled, AT: self._handle_at})
        self.kit = msgspec.structs.replace(kit, offer=offer, handlers=handlers)
        coming = sorted((_Due(entry.time, entry) for entry in at), key=_time)
        self._state = _State([0] * len(self._rows), coming=coming)

    def now(self) -> Time:
        """Return the time of the clock."""
        return self._state.now

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Do what the first row says that matches and is not used up.

        Raises:
            UnansweredRequest: if there is none.
        """
        state, row = self._state, self._answer(request)
        if row.refused:
            return Refused(tuple([due.ticket for due in state.coming if due.row]))
        end = number(state.now + row.takes)
        if row.after is not None:
            due = _Due(number(end + row.after), row=row, ticket=ticket)
            state.coming.append(due)
            state.coming.sort(key=_time)
            self.advance(end)
            return None
        self.advance(end)
        state.before, state.entries = state.entries, []
        state.sent = [m for m in state.sent if m != _ENTRY]
        state.sent += (_Sent(signal=Signal(content)) for content in row.signals)
        state.answered = row
        return Reply(row.result, row.data)

    def cancel(self, ticket: int) -> None:
        """Let what a row has not done for a request never be done."""
        state = self._state
        state.coming = [
            due for due in state.coming if due.row is None or due.ticket != ticket
        ]

    def usual_time(self, request: Fact) -> Time:
        """Return how long the row that would answer holds the robot; 0 without one."""
        rows = zip(self._rows, self._state.used, strict=True)
        answers = (
            row.takes
            for row, used in rows
            if used != row.times and match(row.pattern, request) is not None
        )
        return next(answers, 0)

    def next_time(self) -> Time | None:
        """Return when the next entry of `at` or the end of a primitive is due."""
        state = self._state
        if state.sent:
            return state.now
        return max(state.coming[0].time, state.now) if state.coming else None

    def advance(self, to: Time) -> None:
        """Move the clock on, and send what falls due meanwhile."""
        state = self._state
        if self._leaving is not None and to > state.now:
            self._leaving()
        while state.coming and state.coming[0].time <= to:
            due = state.coming.pop(0)
            signals: tuple[Fact, ...] = ()
            if due.entry is not None:
                signals = due.entry.signals
                state.entries.append(due.entry)
                state.sent.append(_ENTRY)
            if due.row is not None:
                signals = due.row.signals
                state.ends.append(due.row)
                reply = Reply(due.row.result, due.row.data)
                state.sent.append(_Sent(finished=Finished(due.ticket, reply)))
            state.sent += (_Sent(signal=Signal(content)) for content in signals)
        state.now = max(state.now, to)

    def messages(self) -> Sequence[Message]:
        """Return what fell due since this was last asked, in the order of time."""
        state = self._state
        if not state.sent and not state.ends:
            return ()
        found, state.sent = tuple([sent.message() for sent in state.sent]), []
        state.told.extend(state.ends)
        state.ends.clear()
        return found

    def save(self) -> bytes:
        """Return how far the script has come, as JSON."""
        return msgspec.json.encode(self._state)

    def restore(self, state: bytes) -> None:
        """Go back to a saved state of a world with the same script.

        Raises:
            ValueError: if `state` is none.
        """
        try:
            saved = msgspec.json.decode(state, type=_State)
        except ValueError as error:
            raise ValueError(f"no state of a scripted world: {error}") from error
        if len(saved.used) != len(self._rows):
            raise ValueError("the state is that of a world with another script")
        self._state = saved

    def _answer(self, request: Fact) -> Row:
        used = self._state.used
        for index, row in enumerate(self._rows):
            bound = match(row.pattern, request)
            if bound is None or used[index] == row.times:
                continue
            used[index] += 1
            return fill(row, bound)
        raise UnansweredRequest(request)

    def _handle_result(self, memory: HandlerMemory, _: Fact, __: str) -> None:
        """Handle the answer just given and what came before it, else the next end told.

        A result that this world has not given changes nothing.
        """
        state = self._state
        for entry in state.before:
            _change(memory, entry)
        state.before = []
        row, state.answered = state.answered, None
        if row is None and state.told:
            row = state.told.pop(0)
        if row is not None:
            _change(memory, row)

    def _handle_at(self, memory: HandlerMemory, _: Fact) -> None:
        _change(memory, self._state.entries.pop(0))


def _change(memory: HandlerMemory, effects: Row | At) -> None:
    for prefix in effects.erases:
        memory.erase(*prefix)
    for fact in effects.asserts:
        memory.assert_fact(*fact)


def _time(due: _Due) -> Time:
    return due.time
