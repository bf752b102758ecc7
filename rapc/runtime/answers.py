"""The answers of a world and of solvers, kept so that a run can be repeated.

A run is a function of its specification, the acts of the host, and these answers. A
simulator that can be saved answers again in the same way; the answers of every other
world are kept. The answers of solvers are always kept.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Any, NamedTuple, NoReturn, Protocol

import msgspec

from rapc.base.messages import Resumed
from rapc.base.resources import Value
from rapc.base.values import Atom, Fact
from rapc.errors import StateError
from rapc.runtime.held_world import MOST_FACTS
from rapc.world import (
    Datum,
    Finished,
    Lost,
    Message,
    Picture,
    Refused,
    Reply,
    Signal,
    Time,
    World,
    Wrapper,
)

Goal = tuple[Value, ...]
"""The name of a RAP and its inputs, as a solver gets them."""

_READINGS = ("now", "messages", "ended")
"""The questions whose answers often say nothing new."""

REQUESTS = ("perform", "activate")
"""The questions with which the world begins to act, each with a ticket."""


class UnknownAnswerError(StateError):
    """A question beyond the kept answers, in a run that may not ask the world."""


class Failed(msgspec.Struct, frozen=True):
    """The exception of a world in place of an answer."""

    error: Exception


class Answer(msgspec.Struct, frozen=True):
    """A kept answer."""

    #: The number of readings before the question that said nothing new: the same time,
    #: no messages, no end.
    readings: int
    #: The method of the world and its arguments.
    call: str
    asked: tuple[Any, ...]
    told: Any


class Store(Protocol):
    """A store outside of this process, which receives each answer before its use."""

    def asking(self, readings: int, call: str, asked: tuple[Any, ...]) -> None:
        """Keep a request, before the world receives the request."""

    def keep(self, answer: Answer) -> None:
        """Keep an answer of the world."""

    def solved(self, cycle: int, goal: Goal, methods: Any) -> None:
        """Keep the methods of a solver."""


class Position(NamedTuple):
    """A position among the answers: the next answer, and the readings before it."""

    at: int = 0
    readings: int = 0
    #: The last reading of the clock.
    time: Time | None = None


class Answers:
    """The answers of a run's solvers and world; those of the world in their order.

    A question at the end is new: the world is asked, and its answer is kept before it
    is used. At another position the kept answer is returned, if the question is the
    same; a world that cannot be saved has only one past.
    """

    def __init__(self) -> None:
        self.kept: list[Answer] = []
        #: The number of answers before those in `kept`, which are no longer known.
        self.first = 0
        #: The readings after the last kept answer.
        self.readings = 0
        self.position = Position()
        #: The methods from solvers, by the cycle and the goal.
        self.solutions: dict[tuple[int, Goal], Any] = {}
        #: The methods from solvers that the run has not asked for yet, each with its
        #: cycle and RAP.
        self.coming: deque[tuple[int, str, Any]] = deque()
        #: Whether no new answer may be kept, because the run is soon restored.
        self.closed = False
        #: Receives each new answer; `kept` then ends at the present position.
        self.store: Store | None = None
        #: Called with a question at the end of the kept answers, before the world is
        #: asked; returns whether further answers have been kept.
        self.at_end: Callable[[str, tuple[Any, ...]], bool] | None = None

    @property
    def end(self) -> int:
        """The number of all answers so far."""
        return self.first + len(self.kept)

    def solve(self, cycle: int, goal: Goal, solver: Callable[[], Any]) -> Any:
        """Return the methods of a solver for a goal in a cycle, kept or new."""
        key = cycle, goal
        if key in self.solutions:
            return self.solutions[key]
        if self.coming and self.coming[0][:2] == (cycle, goal[0]):
            found = self.solutions[key] = self.coming.popleft()[2]
            return found
        found = solver()
        if not self.closed:
            if self.store is not None:
                self.store.solved(cycle, goal, found)
            self.solutions[key] = found
        return found

    def ask(self, call: str, asked: tuple[Any, ...], answer: Callable[..., Any]) -> Any:
        """Return the answer to a question, kept or new.

        Args:
            call: the method of the world.
            asked: its arguments.
            answer: called with these arguments if the question is new.

        Raises:
            UnknownAnswerError: for a new question while the answers are closed, and for
                a question that differs from the kept one.
        """
        at, used, time = self.position
        is_last = at == self.end
        if is_last and used == self.readings:
            if self.at_end is not None and self.at_end(call, asked):
                return self.ask(call, asked, answer)
            return self._new(call, asked, answer)
        if used < (self.readings if is_last else self.kept[at - self.first].readings):
            if call not in _READINGS:
                self._refuse(call)
            self.position = Position(at, used + 1, time)
            return {"now": time, "messages": (), "ended": None}[call]
        kept = self.kept[at - self.first]
        if (kept.call, kept.asked) != (call, asked):
            self._refuse(call, kept.call)
        told = kept.told
        if isinstance(told, Failed):
            self.position = Position(at + 1, 0, time)
            raise told.error
        self.position = Position(at + 1, 0, told if call == "now" else time)
        return told

    def _new(
        self, call: str, asked: tuple[Any, ...], answer: Callable[..., Any]
    ) -> Any:
        if self.closed:
            self._refuse(call)
        at, used, time = self.position
        if self.store is not None and call in REQUESTS:
            self.store.asking(used, call, asked)
        try:
            told = answer(*asked)
        except Exception as error:
            # an act that fails is not repeated; a stored run can go on after a repair
            if call != "adjust" and self.store is None:
                self._keep(Answer(self.readings, call, asked, Failed(error)), time)
            raise
        empty = isinstance(told, tuple | list) and not told
        old = {"now": time is not None and told == time, "messages": empty}
        if old.get(call, call == "ended" and told is None):
            self.readings = used + 1
            self.position = Position(at, used + 1, time)
            return told
        if isinstance(told, list):
            told = tuple(told)
        later = told if call == "now" else time
        self._keep(Answer(self.readings, call, asked, told), later)
        return told

    def _keep(self, answer: Answer, time: Time | None) -> None:
        self.readings = 0
        if self.store is None:
            self.kept.append(answer)
        else:
            self.store.keep(answer)
            self.first = self.end + 1
            self.kept.clear()
        self.position = Position(self.end, 0, time)

    def _refuse(self, call: str, before: str = "") -> NoReturn:
        """Raise the error for an answer that is not known."""
        asked = f"was asked `{before}`" if before else "was not asked this"
        raise UnknownAnswerError(
            f"the answer of the world to `{call}` is unknown: the world cannot be "
            f"saved, and {asked} at this point"
        )


class _Saved(msgspec.Struct, frozen=True):
    """The saved state of a recorded world."""

    position: Position
    requests: dict[int, Fact]
    skills: dict[int, tuple[tuple[Fact, ...], tuple[str, ...]]]
    received: int
    numbers: dict[str, int] = {}


class RecordedWorld(Wrapper):
    """A wrapper of a world that keeps its answers, so that the run can be saved.

    The saved state is the position among the answers. Pictures, figures and options are
    those of the present, because the interpreter never asks for them.

    Args:
        world: a world that cannot be saved.
        answers: the store.
    """

    def __init__(self, world: World, answers: Answers) -> None:
        self.answers = answers
        #: The requests and the activations whose end the run has not received, by
        #: ticket.
        self.requests: dict[int, Fact] = {}
        self.skills: dict[int, tuple[tuple[Fact, ...], tuple[str, ...]]] = {}
        #: The number of messages of the world that the run has received.
        self.received = 0
        #: The highest number among the data or signals of each name.
        self.numbers: dict[str, int] = {}
        #: The time to return once: a restored run reads the clock to check it.
        self._restored: Time | None = None
        super().__init__(world)
        #: The time before the first reading of the clock.
        self._begun = world.now()
        answers.position = answers.position._replace(time=self._begun)

    def enclose(self, world: World) -> None:
        """Replace the wrapped world."""
        super().enclose(world)
        self.save, self.restore = self._save, self._restore

    def __deepcopy__(self, memo: object) -> NoReturn:
        """Refuse a copy: the world exists once."""
        raise StateError(f"the world `{self.name}` cannot be copied")

    def facts(self) -> Iterable[Fact]:
        """Return the initial facts of the robot."""

        def listed() -> object:
            facts = self.behind.facts()
            if not isinstance(facts, Iterable):
                return facts  # the interpreter reports the error
            return tuple(islice(facts, MOST_FACTS + 1))

        told: Iterable[Fact] = self.answers.ask("facts", (), listed)
        return told

    def now(self) -> Time:
        """Return the time of the clock."""
        restored, self._restored = self._restored, None
        if restored is not None:
            return restored
        time: Time = self.answers.ask("now", (), self.behind.now)
        return time

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request."""
        asked = ticket, request
        told: Reply | Refused | None
        told = self.answers.ask("perform", asked, self.behind.perform)
        if told is None:
            self.requests[ticket] = request
        return told

    def cancel(self, ticket: int) -> None:
        """Stop the request under `ticket`."""
        self.answers.ask("cancel", (ticket,), self.behind.cancel)
        self.requests.pop(ticket, None)

    def next_time(self) -> Time | None:
        """Return the time of the next message."""
        told: Time | None = self.answers.ask("next_time", (), self.behind.next_time)
        return told

    def advance(self, to: Time) -> None:
        """Advance the clock to `to`."""
        self.answers.ask("advance", (to,), self.behind.advance)

    def messages(self) -> Sequence[Message]:
        """Return the messages sent since the preceding call.

        A machine may send a message again that is in the journal already: its number
        is not above those before, and the run does not take in the message.
        """
        told: Sequence[Message] = self.answers.ask("messages", (), self.behind.messages)
        if not told or not isinstance(told, tuple):
            return told
        if not isinstance(told[0], Resumed):  # these are not of the world
            self.received += len(told)
        return list(filter(self._takes, told))

    def _takes(self, message: Message) -> bool:
        """Note a message; return whether the run takes it in."""
        if isinstance(message, Finished | Lost):
            self.requests.pop(message.ticket, None)
            self.skills.pop(message.ticket, None)
        elif isinstance(message, Datum | Signal) and type(message.number) is int:
            name = str(message.content[0])
            if message.number <= self.numbers.get(name, -1):
                return False
            self.numbers[name] = message.number
        return True

    def ended(self) -> str | None:
        """Return the reason why the world has ended the run, or None."""
        told: str | None = self.answers.ask("ended", (), self.behind.ended)
        return told

    def _activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        asked = ticket, tuple(skills), tuple(events)
        told: Refused | None
        told = self.answers.ask("activate", asked, self.behind.activate)
        if told is None:
            self.skills[ticket] = asked[1:]
        return told

    def _deactivate(self, ticket: int) -> None:
        self.answers.ask("deactivate", (ticket,), self.behind.deactivate)
        self.skills.pop(ticket, None)

    def _usual_time(self, request: Fact) -> Time:
        told: Time
        told = self.answers.ask("usual_time", (request,), self.behind.usual_time)
        return told

    def _adjust(self, name: str, value: Atom | bool) -> None:
        self.answers.ask("adjust", (name, value), self.behind.adjust)

    def _picture(self) -> Picture:
        self._check_present("picture")
        picture: Picture = self.behind.picture()
        return picture

    def _figures(self) -> Any:
        self._check_present("figures")
        return self.behind.figures()

    def _truth(self) -> Any:
        self._check_present("truth")
        return self.behind.truth()

    def _check_present(self, what: str) -> None:
        answers = self.answers
        end = answers.end, answers.readings
        if answers.position[:2] != end:
            raise StateError(
                f"the {what} of the world `{self.name}` is known only at the present: "
                "the world cannot be made again"
            )

    def _save(self) -> bytes:
        position, requests, skills = self.answers.position, self.requests, self.skills
        return msgspec.json.encode(
            _Saved(position, requests, skills, self.received, self.numbers)
        )

    def _restore(self, state: bytes) -> None:
        saved = msgspec.json.decode(state, type=_Saved)
        if not self.answers.first <= saved.position.at <= self.answers.end:
            raise ValueError("the saved position is not among the kept answers")
        self.answers.position = saved.position
        if saved.position.at == self.answers.end:  # readings are not always stored
            self.answers.readings = max(self.answers.readings, saved.position.readings)
        self.requests, self.skills = saved.requests, saved.skills
        self.received, self.numbers = saved.received, saved.numbers
        time = saved.position.time
        self._restored = self._begun if time is None else time
