"""A world that answers requests from a script: what tests of a library run against.

Every symbol is its own sensor name. What a script does to memory its handlers do,
with the result it belongs to. What a row may say is in `rapc.worlds.script`, what
skills tell while they are on in `rapc.worlds.script_skills`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from rapc.base.values import Fact, format_list, number
from rapc.errors import Error
from rapc.world import (
    Finished,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Refused,
    Reply,
    Time,
    World,
)
from rapc.worlds.script import (
    At,
    Declarations,
    Row,
    Script,
    change,
    check_script,
    mentioned,
    offer_of,
)
from rapc.worlds.script_skills import ScriptedSkills
from rapc.worlds.script_state import (
    AT,
    ENTRY,
    Due,
    ScriptState,
    SentMessage,
    time_of,
)

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
        self._script = Script(rows)
        self._skills = ScriptedSkills(self._script)
        self._leaving = leaving
        offer = offer_of(declared) if declared else mentioned(rows, at)
        handled = kit.handlers.data
        check_script(rows, at, offer, handled)
        results = dict.fromkeys(offer.primitives, self._handle_result)
        offer = msgspec.structs.replace(offer, data={**offer.data, AT: 0})
        handlers = Handlers(results, {**handled, AT: self._handle_at})
        self.kit = msgspec.structs.replace(kit, offer=offer, handlers=handlers)
        coming = sorted((Due(entry.time, entry) for entry in at), key=time_of)
        self._state = ScriptState([0] * len(rows), coming=coming)

    def now(self) -> Time:
        """Return the time of the clock."""
        return self._state.now

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Do what the first row says that matches and is not used up.

        Raises:
            UnansweredRequest: if there is none.
        """
        state = self._state
        found = self._script.find("request", request, state.used)
        if found is None:
            raise UnansweredRequest(request)
        row = self._script.use(found, state.used, request)
        if row.refused:
            return Refused(state.under_way())
        end = number(state.now + row.takes)
        if row.after is not None:
            due = Due(number(end + row.after), row=row, ticket=ticket)
            state.expect(due)
            self.advance(end)
            return None
        self.advance(end)
        state.before, state.entries = state.entries, []
        if state.sent:
            state.sent = [m for m in state.sent if m != ENTRY]
        if row.signals:
            state.send(row.signals)
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
        return self._skills.switch_on(self._state, ticket, skills)

    def deactivate(self, ticket: int) -> None:
        """Switch off the skills that only this activation has."""
        self._skills.switch_off(self._state, ticket)

    # --- time ---------------------------------------------------------------------

    def usual_time(self, request: Fact) -> Time:
        """Return how long the row that would answer holds the robot; 0 without one."""
        found = self._script.find("request", request, self._state.used)
        return 0 if found is None else self._script.rows[found[0]].takes

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
                self._skills.tell(state, due)
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
            state.send(signals, (due.ticket,) if due.row is not None else ())
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
        if len(saved.used) != len(self._script.rows):
            raise ValueError("the state is that of a world with another script")
        self._state = saved

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
