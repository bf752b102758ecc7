"""A world that answers requests from a script: what tests of a library run against.

Every symbol is its own sensor name. What a script does to memory its handlers do,
with the result it belongs to. What a row may say is in `rapc.worlds.script`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import msgspec

from rapc.base.values import Bindings, Fact, format_list, match_pattern, number
from rapc.errors import Error
from rapc.world import (
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
    change,
    check_script,
    fill,
    fillers,
    mentioned,
    offer_of,
)
from rapc.worlds.script_state import AT, ENTRY, Due, ScriptState, SentMessage, SkillOn

_NO_KIT = Kit()


class UnansweredRequest(Error):
    """A request that no row of the script answers; `request` is it."""

    def __init__(self, request: Fact) -> None:
        super().__init__(f"no row of the script answers {format_list(request)}")
        self.request = request


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
        self._fillers = [fillers(row) for row in self._rows]
        self._leaving = leaving
        offer = offer_of(declared) if declared else mentioned(self._rows, at)
        handled = kit.handlers.data
        check_script(self._rows, at, offer, handled)
        results = dict.fromkeys(offer.primitives, self._handle_result)
        offer = msgspec.structs.replace(offer, data={**offer.data, AT: 0})
        handlers = Handlers(results, {**handled, AT: self._handle_at})
        self.kit = msgspec.structs.replace(kit, offer=offer, handlers=handlers)
        coming = sorted((Due(entry.time, entry) for entry in at), key=_time)
        self._state = ScriptState([0] * len(self._rows), coming=coming)

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
            return Refused(self._under_way())
        end = number(state.now + row.takes)
        if row.after is not None:
            due = Due(number(end + row.after), row=row, ticket=ticket)
            state.coming.append(due)
            state.coming.sort(key=_time)
            self.advance(end)
            return None
        self.advance(end)
        state.before, state.entries = state.entries, []
        if state.sent:
            state.sent = [m for m in state.sent if m != ENTRY]
        if row.signals:
            self._send(row.signals)
        state.answered = row
        return Reply(row.result, row.data)

    def cancel(self, ticket: int) -> None:
        """Let what a row has not done for a request never be done."""
        state = self._state
        state.coming = [
            due
            for due in state.coming
            if due.row is None or due.skill is not None or due.ticket != ticket
        ]

    # --- skills -------------------------------------------------------------------

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on; each does what the first row for it says that matches.

        One that is on already goes on as it is. No row is needed.
        """
        state = self._state
        coming = [skill for skill in skills if self._found(skill) is None]
        found = {skill: self._row_for("enable", skill) for skill in coming}
        for row in found.values():
            if row is not None and self._rows[row[0]].refused:
                self._use(row)
                return Refused(self._under_way())
        for skill in dict.fromkeys(skills):
            on = self._found(skill)
            if on is None:
                on = SkillOn(skill, [])
                state.on.append(on)
                self._start(skill, found[skill])
            on.tickets.append(ticket)
        return None

    def _under_way(self) -> tuple[int, ...]:
        """Return the tickets of all requests and activations under way."""
        state = self._state
        requests = [due.ticket for due in state.coming if due.row and not due.skill]
        return (*requests, *sorted({t for on in state.on for t in on.tickets}))

    def _found(self, skill: Fact) -> SkillOn | None:
        return next((on for on in self._state.on if on.skill == skill), None)

    def _start(self, skill: Fact, found: tuple[int, Bindings] | None) -> None:
        """Let a skill have to tell, from now on, what its row says."""
        if found is None:
            return
        row = self._use(found)
        self._tell_later(Due(0, row=row, skill=skill), row.after or 0)

    def _tell_later(self, due: Due, wait: Time) -> None:
        """Let a skill tell a signal of its row after a wait, and its pause."""
        state, row = self._state, due.row
        assert row is not None
        pause = row.pause(due.signal) if row.signals else 0
        time = number(state.now + wait + pause)
        state.coming.append(msgspec.structs.replace(due, time=time))
        state.coming.sort(key=_time)

    def deactivate(self, ticket: int) -> None:
        """Switch off the skills that only this activation has."""
        state = self._state
        for on in [on for on in state.on if ticket in on.tickets]:
            on.tickets.remove(ticket)
            if on.tickets:
                continue
            state.on.remove(on)
            state.coming = [due for due in state.coming if due.skill != on.skill]
            found = self._row_for("disable", on.skill)
            if found is not None:
                row = self._use(found)
                self._change_memory(row)
                self._send(row.signals, (ticket,))

    def _tell(self, due: Due) -> None:
        """Send the signal of a skill that is due, and plan the next one."""
        row, on = due.row, self._found(due.skill or ())
        if row is None or on is None:
            return
        if due.signal == 0:
            self._change_memory(row)
        self._send(row.signals[due.signal : due.signal + 1], tuple(on.tickets))
        if due.signal + 1 < len(row.signals):
            self._tell_later(msgspec.structs.replace(due, signal=due.signal + 1), 0)
        elif row.every is not None:
            self._tell_later(msgspec.structs.replace(due, signal=0), row.every)

    def _change_memory(self, row: Row) -> None:
        """Have the handler of entries do what a row does to memory."""
        state = self._state
        changes = (row.asserts, row.erases, row.moves, row.loses)
        if any(changes):
            state.entries.append(At(state.now, *changes))
            state.sent.append(ENTRY)

    def _send(self, signals: Iterable[Fact], tickets: tuple[int, ...] = ()) -> None:
        sent = self._state.sent
        sent += (SentMessage(signal=Signal(content, tickets)) for content in signals)

    # --- time ---------------------------------------------------------------------

    def usual_time(self, request: Fact) -> Time:
        """Return how long the row that would answer holds the robot; 0 without one."""
        rows = zip(self._rows, self._state.used, strict=True)
        answers = (
            row.takes
            for row, used in rows
            if row.kind == "request"
            and used != row.times
            and match_pattern(row.pattern, request) is not None
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
            if due.skill is not None:
                state.now = max(state.now, due.time)
                self._tell(due)
                continue
            if due.entry is not None:
                signals = due.entry.signals
                state.entries.append(due.entry)
                state.sent.append(ENTRY)
            if due.row is not None:
                signals = due.row.signals
                state.ends.append(due.row)
                reply = Reply(due.row.result, due.row.data)
                state.sent.append(SentMessage(finished=Finished(due.ticket, reply)))
            self._send(signals, (due.ticket,) if due.row is not None else ())
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
            saved = msgspec.json.decode(state, type=ScriptState)
        except ValueError as error:
            raise ValueError(f"no state of a scripted world: {error}") from error
        if len(saved.used) != len(self._rows):
            raise ValueError("the state is that of a world with another script")
        self._state = saved

    def _answer(self, request: Fact) -> Row:
        found = self._row_for("request", request)
        if found is None:
            raise UnansweredRequest(request)
        return self._use(found, request)

    def _row_for(self, kind: str, asked: Fact) -> tuple[int, Bindings] | None:
        """Return the first row of a kind that matches and is not used up."""
        used = self._state.used
        for index, row in enumerate(self._rows):
            if row.kind != kind or used[index] == row.times:
                continue
            bound = match_pattern(row.pattern, asked)
            if bound is not None:
                return index, bound
        return None

    def _use(self, found: tuple[int, Bindings], asked: Fact | None = None) -> Row:
        """Use a row that was found, with what it binds; return it filled in.

        With `asked`, the request that it answers, that is its pattern.
        """
        (index, bound), row = found, self._rows[found[0]]
        self._state.used[index] += 1
        return fill(row, self._fillers[index], bound, asked or row.pattern)

    def _handle_result(self, memory: HandlerMemory, request: Fact, _: str) -> None:
        """Handle the answer just given and what came before it, else the next end told.

        What the row says of items by the sensor names in the request that it answered
        is done to them by the names in `request`, which are memory's. A result that
        this world has not given changes nothing.
        """
        state = self._state
        for entry in state.before:
            change(memory, entry)
        state.before = []
        row, state.answered = state.answered, None
        if row is None and state.told:
            row = state.told.pop(0)
        if row is not None:
            if row.pattern == request:
                change(memory, row)
            else:
                names = dict(zip(row.pattern[1:], request[1:], strict=True))
                change(memory, row, names)

    def _handle_at(self, memory: HandlerMemory, _: Fact) -> None:
        change(memory, self._state.entries.pop(0))


def _time(due: Due) -> Time:
    return due.time
