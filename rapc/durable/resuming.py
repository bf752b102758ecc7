"""Resumption of a run in a world that cannot be saved: what became of its requests.

The answers in the journal are repeated. Before the first further question, the world is
asked for the outcome of each request under way. If the world cannot know the outcome,
the treatment of the primitive decides (`Offer.after_crash`). The outcomes are the first
messages that the run then receives.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rapc.base.messages import Resumed
from rapc.base.offers import Offer
from rapc.base.values import Fact, number
from rapc.errors import StateError
from rapc.runtime.answers import RecordedWorld
from rapc.runtime.interpreter import Interpreter
from rapc.world import (
    NOT_KNOWN,
    Finished,
    Lost,
    Message,
    Refused,
    Reply,
    Resumable,
    Time,
    World,
    Wrapper,
)

ALL = "*"
"""Every primitive, in a table of treatments."""

LOST = "the process of the interpreter ended before the outcome was known"
"""The reason for the end of a request with an unknown outcome."""

Skills = tuple[tuple[Fact, ...], tuple[str, ...]]
"""The skills of an activation, and the events to report."""

Decide = Callable[[Fact], str]
"""Returns `repeat` or `fail` for a request whose treatment is `ask`."""


class Sent(NamedTuple):
    """The last request of the journal, if its answer is missing."""

    call: str
    asked: tuple[object, ...]

    @property
    def ticket(self) -> int:
        """Return the ticket."""
        ticket = self.asked[0]
        assert isinstance(ticket, int)
        return ticket


class ResumedWorld(Wrapper):
    """A wrapper of a world that cannot be saved, for a run from a journal.

    The clock of a world that has begun anew goes on from the last time of the run.

    Args:
        world: the world, newly made.
        begun: the time of the clock of the first world when the run was made.
    """

    def __init__(self, world: World, begun: Time) -> None:
        super().__init__(world)
        #: The time before the resumption; None afterwards.
        self._begun: Time | None = begun
        self._offset: Time = 0
        #: The last time of the clock.
        self._time = begun
        #: The last time to come to, and the last result of `next_time`, each with this
        #: time of the wrapped world: a sum of times is not exact.
        self._target: tuple[Time, Time] = begun, 0
        self._due: tuple[Time, Time] = begun, 0
        #: The messages to return before those of the world.
        self.first: list[Message | Resumed] = []
        #: The answers to requests that the first process may have sent, by ticket.
        self.settled: dict[int, Reply | Refused | None] = {}

    def ask_from(self, last: Time) -> None:
        """Ask the world from now on, whose clock goes on from the time `last`."""
        self._begun = None
        behind = super().now()
        self._offset = number(last - behind) if behind < last else 0
        self._time = last

    def facts(self) -> Iterable[Fact]:
        """Return the initial facts; none before the resumption, which are known."""
        return () if self._begun is not None else super().facts()

    def now(self) -> Time:
        """Return the time of the clock."""
        if self._begun is not None:
            return self._begun
        behind = super().now()
        if not self._offset:
            return behind
        to, target = self._target
        now = number(behind + self._offset)
        self._time = max(self._time, now, to if behind >= target else now)
        return self._time

    def next_time(self) -> Time | None:
        """Return the time of the next message."""
        due = super().next_time()
        if due is None or due == NOT_KNOWN or not self._offset:
            return due
        self._due = number(due + self._offset), due
        return self._due[0]

    def advance(self, to: Time) -> None:
        """Advance the clock, unless messages are to be received."""
        if self.first:
            return
        time, due = self._due
        target = due if self._offset and to == time else number(to - self._offset)
        self._target = to, target
        super().advance(target)

    def messages(self) -> Sequence[Message]:
        """Return the outcomes of requests, or else the messages of the world."""
        if self.first:
            found, self.first = tuple(self.first), []
            return found  # type: ignore[return-value]  # with `Resumed`
        return super().messages()

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request, unless its answer is settled."""
        if ticket in self.settled:
            return self.settled.pop(ticket)
        return super().perform(ticket, request)

    def _activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        if ticket in self.settled:
            answer = self.settled.pop(ticket)
            return answer if isinstance(answer, Refused) else None
        found: Refused | None = self.behind.activate(ticket, skills, events)
        return found


def settle_requests(
    run: Interpreter,
    question: tuple[str, tuple[Any, ...]],
    sent: Sent | None,
    treatments: Mapping[str, str],
    decide: Decide,
    seconds: float,
) -> None:
    """Settle the requests under way; from now on the run asks the world itself.

    Args:
        run: a run from a journal, at the end of the journal.
        question: the first question whose answer is not in the journal.
        sent: the last request, if its answer is missing.
        treatments: the treatments by primitive, which replace those of the offer.
        decide: decides on requests whose treatment is `ask`.
        seconds: the time for which no process ran the run.

    Raises:
        StateError: if the world no longer has all messages.
        PortError: if the world breaks.
    """
    recorded = run.port.behind
    world = recorded.behind
    assert isinstance(recorded, RecordedWorld)
    assert isinstance(world, ResumedWorld)
    under_way: dict[int, Fact | Skills] = {**recorded.requests, **recorded.skills}
    call, asked = question
    if call in ("cancel", "deactivate"):  # the ticket is no longer needed
        under_way.pop(asked[0], None)
    first: list[Message | Resumed] = [Resumed(round(seconds, 3))]
    if isinstance(world, Resumable):
        tickets = sorted({*under_way, *([sent.ticket] if sent else ())})
        try:
            known = run.port.resume(tickets, recorded.received)  # type: ignore[attr-defined]
        except ValueError as error:
            raise StateError(
                f"cannot resume: the world `{world.name}` refuses: {error}"
            ) from error
        world.ask_from(run.now)
        if sent is not None and sent.ticket in known:
            world.settled[sent.ticket] = known[sent.ticket]
        for ticket, asked in under_way.items():
            if ticket in known:
                first += _ended(ticket, known[ticket])
            else:
                first += _sent_again(world, ticket, asked)
    else:
        world.ask_from(run.now)
        chosen = _Treatments(world.kit.offer, treatments, decide)
        if sent is not None and not chosen.repeats(sent.asked[1]):
            world.settled[sent.ticket] = Refused(reason=LOST)
        for ticket, asked in under_way.items():
            if ticket in recorded.skills or chosen.repeats(asked):
                first += _sent_again(world, ticket, asked)
            else:
                first.append(Lost(ticket, LOST))
    world.first = first


class _Treatments(NamedTuple):
    """The treatments of requests whose outcome the world cannot know."""

    offer: Offer
    treatments: Mapping[str, str]
    decide: Decide

    def repeats(self, request: object) -> bool:
        """Return whether a request is sent again; skills always are."""
        assert isinstance(request, tuple)
        name = request[0]
        if not isinstance(name, str):
            return True
        usual = "repeat" if name in self.offer.sensors else "fail"
        chosen = self.offer.after_crash.get(name, usual)
        chosen = self.treatments.get(name, self.treatments.get(ALL, chosen))
        if chosen == "ask":
            chosen = self.decide(request)
        return chosen == "repeat"


def _ended(ticket: int, answer: Reply | Refused | None) -> list[Message]:
    """Return the message for an answer that the world has kept, if any."""
    if answer is None:
        return []
    if isinstance(answer, Refused):
        return [Lost(ticket, answer.reason)]
    return [Finished(ticket, answer)]


def _sent_again(
    world: ResumedWorld, ticket: int, asked: Fact | Skills
) -> list[Message]:
    """Send a request or an activation again under the same ticket."""
    behind = world.behind
    if isinstance(asked[0], tuple):
        return _ended(ticket, behind.activate(ticket, *asked))
    return _ended(ticket, behind.perform(ticket, asked))
