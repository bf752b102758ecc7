"""A world that answers requests from a script, for tests of a library.

Every symbol is its own sensor name. The handlers of the world apply a script's changes
of memory, each with its result. Active skills report the signals of their rows. The
fields of a row are described in `rapc.worlds.script`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import msgspec

from rapc.base.values import Bindings, Fact, format_list, match_pattern, number
from rapc.errors import Error
from rapc.library.effects import complete_data
from rapc.library.library import Library
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
    Row,
    change,
    check_script,
    fill,
    fillers,
    mentioned,
    offer_of,
)
from rapc.worlds.states import reading_state

AT = "at"
"""The datum that passes an `At` to its handler; no library declares it."""

_ENTRY = Datum((AT,))
_NO_KIT = Kit()

_FoundRow = tuple[int, Bindings]
"""The number of a matching row, and its bindings."""


class UnansweredRequest(Error):
    """An error for a request without a matching row; `request` is the request."""

    def __init__(self, request: Fact) -> None:
        super().__init__(f"no row of the script answers {format_list(request)}")
        self.request = request


class Due(msgspec.Struct, frozen=True):
    """A future event: an entry of `at`, the end of a primitive, or a skill's signal."""

    time: Time
    entry: At | None = None
    #: The row of a primitive that ends, or of an active skill.
    row: Row | None = None
    ticket: int = 0
    #: The skill with a signal to report, and the number of the signal.
    skill: Fact | None = None
    signal: int = 0


class SkillOn(msgspec.Struct):
    """An active skill with its activations, oldest first."""

    skill: Fact
    tickets: list[int]


class ScriptState(msgspec.Struct):
    """The complete changing state of a scripted world."""

    #: The number of uses of each row.
    used: list[int]
    now: Time = 0
    #: Future events, soonest first.
    coming: list[Due] = []
    #: The messages not yet fetched.
    sent: list[Message] = []
    #: The entries of `at` whose handler has not run.
    entries: list[At] = []
    #: Rows whose end is among `sent`.
    ends: list[Row] = []
    #: Rows with a fetched end whose handler has not run.
    told: list[Row] = []
    #: The entries of `at` during the primitive that `answered` answers.
    before: list[At] = []
    #: The row of the last answer, before its handler has run.
    answered: Row | None = None
    #: The active skills, in the order of activation.
    on: list[SkillOn] = []

    def found(self, skill: Fact | None) -> SkillOn | None:
        """Return the skill if it is active, else None."""
        return next((on for on in self.on if on.skill == skill), None)

    def expect(self, due: Due) -> None:
        """Add a future event."""
        self.coming.append(due)
        self.coming.sort(key=lambda due: due.time)

    def change_memory(self, entry: At) -> None:
        """Pass an entry to the handler of entries, which changes memory."""
        self.entries.append(entry)
        self.sent.append(_ENTRY)

    def send(self, signals: Iterable[Fact], tickets: tuple[int, ...] = ()) -> None:
        """Send signals with the tickets of their activations or request."""
        self.sent += (Signal(content, tickets) for content in signals)


class ScriptedWorld(World):
    """A world with prepared answers.

    Args:
        rows: the script.
        at: entries without a request; equal times keep this order.
        declared: the library to run; if omitted, the offer consists of the names that
            the script mentions.
        kit: further parts for the library: handlers of the rows' data, functions,
            solvers and comparators, for example of another world.
        leaving: called before each move of the clock.

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
        declared: Library | None = None,
        kit: Kit = _NO_KIT,
        leaving: Callable[[], None] | None = None,
    ) -> None:
        self._rows = tuple(rows)
        self._fillers = [fillers(row) for row in rows]
        self._leaving = leaving
        offer = offer_of(declared) if declared else mentioned(rows, at)
        handled = kit.handlers.data
        complete = complete_data(declared) if declared else frozenset()
        check_script(rows, at, offer, {*handled, *complete})
        results = dict.fromkeys(offer.primitives, self._handle_result)
        offer = msgspec.structs.replace(offer, data={**offer.data, AT: 0})
        handlers = Handlers(results, {**handled, AT: self._handle_at})
        self.kit = msgspec.structs.replace(kit, offer=offer, handlers=handlers)
        self._state = ScriptState([0] * len(rows))
        for entry in at:
            self._state.expect(Due(entry.time, entry))

    def now(self) -> Time:
        """Return the time of the clock."""
        return self._state.now

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Apply the first matching row that is not used up.

        Raises:
            UnansweredRequest: if no row matches.
        """
        state = self._state
        found = self._find("request", request)
        if found is None:
            raise UnansweredRequest(request)
        row = self._use(found, request)
        if row.refused:
            return self._refusal()
        end = number(state.now + row.takes)
        if row.after is not None:
            due = Due(number(end + row.after), row=row, ticket=ticket)
            state.expect(due)
            self.advance(end)
            return None
        self.advance(end)
        state.before, state.entries = state.entries, []
        if state.sent:
            state.sent = [message for message in state.sent if message != _ENTRY]
        if row.signals:
            state.send(row.signals)
        state.answered = row
        return Reply(row.result, row.data)

    def cancel(self, ticket: int) -> None:
        """Drop the effects of a row that are still to come for a request."""
        state = self._state
        state.coming = [
            due
            for due in state.coming
            if due.row is None or due.skill is not None or due.ticket != ticket
        ]

    # --- rows ---------------------------------------------------------------------

    def _find(self, kind: str, asked: Fact) -> _FoundRow | None:
        """Return the first matching row of a kind that is not used up."""
        used = self._state.used
        for index, row in enumerate(self._rows):
            if row.kind != kind or used[index] == row.times:
                continue
            bound = match_pattern(row.pattern, asked)
            if bound is not None:
                return index, bound
        return None

    def _use(self, found: _FoundRow, asked: Fact | None = None) -> Row:
        """Use a found row; return it with its variables replaced.

        The pattern of the returned row is the request, if there is one.
        """
        index, bound = found
        self._state.used[index] += 1
        row = self._rows[index]
        return fill(row, self._fillers[index], bound, asked or row.pattern)

    def _refusal(self) -> Refused:
        """Return a conflict with all requests and activations under way."""
        state = self._state
        requests = [due.ticket for due in state.coming if due.row and not due.skill]
        return Refused((*requests, *sorted({t for on in state.on for t in on.tickets})))

    # --- skills -------------------------------------------------------------------

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on; each skill applies its first matching row.

        A skill that is already active continues unchanged. A skill needs no row.
        """
        state = self._state
        coming = [skill for skill in skills if state.found(skill) is None]
        found = {skill: self._find("enable", skill) for skill in coming}
        for row in found.values():
            if row is not None and self._rows[row[0]].refused:
                self._use(row)
                return self._refusal()
        for skill in dict.fromkeys(skills):
            on = state.found(skill)
            if on is None:
                on = SkillOn(skill, [])
                state.on.append(on)
                if (row := found[skill]) is not None:
                    used = self._use(row)
                    self._tell_later(used, skill, 0, used.after or 0)
            on.tickets.append(ticket)
        return None

    def deactivate(self, ticket: int) -> None:
        """Switch off the skills that only this activation has."""
        state = self._state
        for on in [on for on in state.on if ticket in on.tickets]:
            on.tickets.remove(ticket)
            if on.tickets:
                continue
            state.on.remove(on)
            state.coming = [due for due in state.coming if due.skill != on.skill]
            found = self._find("disable", on.skill)
            if found is not None:
                row = self._use(found)
                self._change_memory(row)
                state.send(row.signals, (ticket,))

    def _tell(self, row: Row, on: SkillOn, signal: int) -> None:
        """Send a signal of a skill, and plan the next signal."""
        if signal == 0:
            self._change_memory(row)
        self._state.send(row.signals[signal : signal + 1], tuple(on.tickets))
        if signal + 1 < len(row.signals):
            self._tell_later(row, on.skill, signal + 1, 0)
        elif row.every is not None:
            self._tell_later(row, on.skill, 0, row.every)

    def _tell_later(self, row: Row, skill: Fact, signal: int, wait: Time) -> None:
        """Plan a signal of a skill's row after a wait and its pause."""
        pause = row.pause(signal) if row.signals else 0
        time = number(self._state.now + wait + pause)
        self._state.expect(Due(time, row=row, skill=skill, signal=signal))

    def _change_memory(self, row: Row) -> None:
        """Pass the changes of a skill's row to the handler of entries."""
        changes = (row.asserts, row.erases, row.moves, row.loses)
        if any(changes):
            self._state.change_memory(At(self._state.now, *changes))

    # --- time ---------------------------------------------------------------------

    def usual_time(self, request: Fact) -> Time:
        """Return the duration of the row that would answer; 0 without a row."""
        found = self._find("request", request)
        return 0 if found is None else self._rows[found[0]].takes

    def next_time(self) -> Time | None:
        """Return the time of the next future event, or None."""
        state = self._state
        if state.sent:
            return state.now
        return max(state.coming[0].time, state.now) if state.coming else None

    def advance(self, to: Time) -> None:
        """Advance the clock, and send the messages that become due."""
        state = self._state
        if self._leaving is not None and to > state.now:
            self._leaving()
        while state.coming and state.coming[0].time <= to:
            due = state.coming.pop(0)
            row = due.row
            if due.entry is not None:
                state.change_memory(due.entry)
                state.send(due.entry.signals)
            elif row is not None and due.skill is None:
                state.ends.append(row)
                state.sent.append(Finished(due.ticket, Reply(row.result, row.data)))
                state.send(row.signals, (due.ticket,))
            elif row is not None and (on := state.found(due.skill)) is not None:
                state.now = max(state.now, due.time)
                self._tell(row, on, due.signal)
        state.now = max(state.now, to)

    def messages(self) -> Sequence[Message]:
        """Return the due messages since the preceding call, in order of time."""
        state = self._state
        if not state.sent and not state.ends:
            return ()
        found, state.sent = tuple(state.sent), []
        state.told.extend(state.ends)
        state.ends.clear()
        return found

    def save(self) -> bytes:
        """Return the state of the script, as JSON."""
        return msgspec.json.encode(self._state)

    def restore(self, state: bytes) -> None:
        """Restore a saved state of a world with the same script.

        Raises:
            ValueError: if `state` is invalid.
        """
        with reading_state("a scripted world"):
            saved = msgspec.json.decode(state, type=ScriptState)
        if len(saved.used) != len(self._rows):
            raise ValueError("the state is that of a world with another script")
        self._state = saved

    # --- handlers -----------------------------------------------------------------

    def _handle_result(self, memory: HandlerMemory, request: Fact, _: str) -> None:
        """Handle the last answer and earlier entries, else the next reported end.

        The row refers to items by the sensor names in its request. The changes apply to
        the items by memory's names in `request`. A result that this world did not send
        changes nothing.
        """
        state = self._state
        for entry in state.before:
            change(memory, entry)
        state.before = []
        row, state.answered = state.answered, None
        if row is None and state.told:
            row = state.told.pop(0)
        if row is not None:
            names = None
            if row.pattern != request:
                names = dict(zip(row.pattern[1:], request[1:], strict=True))
            change(memory, row, names)

    def _handle_at(self, memory: HandlerMemory, _: Fact) -> None:
        change(memory, self._state.entries.pop(0))
