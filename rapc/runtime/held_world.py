"""Checks of a world: its replies and messages must match its offer and declarations.

The interpreter calls the world through a `HeldWorld` and checks nothing itself. If the
world violates the port, a `PortError` names the world, the call and the place in the
author's code at once; the run does not go on.

A world's methods, its handlers, and functions, solvers and comparators are code of
their authors. An exception in such code also becomes a `PortError`, with file and line.
An exception in a listener belongs to the host and is not changed; any other exception
is a fault of rapc.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn, TypeGuard

import msgspec

from rapc.base.code_places import code_of, frames, place_of, place_of_error, said_by
from rapc.base.messages import CHANGES, Change
from rapc.base.names import hint, nearest
from rapc.base.values import (
    Atom,
    Fact,
    format_atom,
    format_list,
    number,
)
from rapc.compiler.program import Program
from rapc.errors import FactError, PortError
from rapc.language.atoms import is_atom
from rapc.library.effects import complete_data
from rapc.library.kinds import said_of
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures, Use, kind_tests
from rapc.runtime.authors import Named, code_of_authors
from rapc.world import (
    NOT_KNOWN,
    Datum,
    Finished,
    Lost,
    Message,
    Picture,
    Refused,
    Reply,
    ResultHandler,
    Signal,
    Time,
    World,
    Wrapper,
    innermost,
)

MOST_FACTS = 1_000_000
"""The highest number of first facts of a world."""

LATEST = 10**15
"""The latest time of a clock: up to here a `float` can represent eighths of a unit."""

OF_THE_BYTES = (LookupError, TypeError, ValueError, AttributeError)
"""The exceptions of `restore` for bytes that no world has saved."""

_A_FACT = (
    "a tuple of a name and its arguments: symbols as programs write them, numbers, "
    "`Text` for any other text"
)
_A_REPLY = f"a `Reply` whose data are each {_A_FACT}"
_WANTED = {
    "now": "a number from 0 to 10^15",
    "save": "bytes",
    "picture": "a `Picture`",
    "usual_time": "a number from 0 to 10^15",
    "truth": "a mapping from each name to its facts",
    "next_time": "a number from 0 to 10^15, `None` or `NOT_KNOWN`",
    "ended": "a text or `None`",
    "perform": f"{_A_REPLY}, `None` or `Refused`",
    "activate": "`None` or a `Refused` that has tickets",
    "resume": "a mapping from tickets to `None`, `Reply` or `Refused`",
    "facts": "a list of facts",
    "a first fact": _A_FACT,
    "messages": "a list of messages",
    "a message": f"a `Datum` or `Signal` that holds {_A_FACT}, "
    "or a `Finished` or `Lost`",
    "the end of a request": _A_REPLY,
    "the changes": "a tuple of changes of memory",
}
"""The expected values in messages, by the name of the value or else of the method."""

_MOST_SHOWN = 60


class HeldWorld(Wrapper):
    """A wrapper that checks a world against its offer and one library's declarations.

    For speed, each pass of the loop also makes three calls to the world directly. The
    results of `clock`, `receive` and `ask` then go through `time`, `listed` and
    `answer`, except an unchanged time, no messages, or `okay` without data.

    Args:
        world: the world.
        program: the library of the run; without it the offer of the world counts.
        code: the Python code of authors; without it that of the world.
        strict: whether only data in `:tells` are allowed.
    """

    def __init__(
        self,
        world: World,
        program: Program | None = None,
        code: Mapping[str, Named] | None = None,
        strict: bool = False,
    ) -> None:
        super().__init__(world)
        #: The Python code of authors, by its kind in messages, then by name.
        self.code = code_of_authors(world.kit) if code is None else code
        offered = Signatures.offered(world.kit.offer)
        signatures = offered if program is None else program.signatures
        primitives = {} if program is None else program.library.primitives
        #: The declarations of the library; for undeclared names, the offer.
        self._data = {**offered.data, **signatures.data}
        self._events = {**offered.events, **signatures.events}
        #: The data that need no changes of memory with them.
        self._handled = {*world.kit.handlers.data}
        if program is not None:
            self._handled |= complete_data(program.library, signatures)
        #: The tests of their arguments with declared kinds, by name.
        told = {**self._data, **self._events}
        self._of_kinds = kind_tests(signatures.kinds, told)
        self._results = {
            name: frozenset(signature.results)
            for name, signature in signatures.primitives.items()
        }
        self._atomic = frozenset(
            name for name, form in primitives.items() if form.atomic
        )
        #: The data that may come with a primitive; empty without a declaration.
        self._tells = {
            name: frozenset(form.tells)
            for name, form in primitives.items()
            if strict and form.tells
        }

    def enclose(self, world: World) -> None:
        """Replace the wrapped world by another world of the same kit."""
        super().enclose(world)
        self.clock, self.receive, self.ask = world.now, world.messages, world.perform
        #: Whether the world may end the run by itself.
        self.may_end = type(innermost(world)).ended is not World.ended

    # --- the clock ----------------------------------------------------------------

    def now(self) -> Time:
        """Return the time of the clock. Raises PortError for an invalid time."""
        now = self.clock()
        if not is_time(now):
            raise self.wrong_type("now", "the time", now)
        return now

    def time(self, now: object, before: Time) -> Time:
        """Return the result of `clock` as in the trace: whole times as integers.

        Raises:
            PortError: for an invalid time, or a time before the last time.
        """
        if type(now) is not int:
            if not (isinstance(now, float) and is_time(now)):
                raise self.wrong_type("now", "the time", now)
            now = number(now)
        if now < before:
            times = f"from {format_atom(before)} to {format_atom(now)}"
            raise self.breach("now", f"sets its clock back, {times}")
        return now

    def next_time(self, now: Time = 0) -> Time | None:
        """Return when the world will next send a message; `now` is the present time.

        Raises:
            PortError: for an invalid time, or a past time.
        """
        due = super().next_time()
        if due is None or due == NOT_KNOWN:
            return due
        if not is_time(due):
            raise self.wrong_type("next_time", "the next time", due)
        if due < now:
            said = f"announces its next message for time {format_atom(due)}"
            said += f", but the time is {format_atom(now)}"
            raise self.breach("next_time", said)
        return due

    def check_stop(self, now: Time, target: Time) -> None:
        """Check that a world that has sent nothing let time pass until `target`.

        Raises:
            PortError: if not.
        """
        if now < target:
            said = f"stopped its clock at {format_atom(now)} on the way to "
            said += f"{format_atom(target)}, and sent nothing"
            raise self.breach("advance", said)

    def check_wait(self, now: Time, target: Time) -> None:
        """Check that a clock may stand still in a wait without messages.

        Args:
            now: the time.
            target: the time that the run waited for.

        Raises:
            PortError: if the clock should have moved, or a message have come.
        """
        due = super().next_time()
        announced = due is not None and due <= now
        if self.ended() is not None or not (announced or target > now):
            return
        at = format_atom(target)
        if announced:
            said = f"announced a message for time {at}, but sent none"
            raise self.breach("next_time", said)
        raise self.breach("advance", f"did not move its clock to {at}")

    def ended(self) -> str | None:
        """Return why the world has ended the run. Raises PortError for another type."""
        ended: object = self.behind.ended()
        if ended is None or isinstance(ended, str):
            return ended
        raise self.wrong_type("ended", "the end", ended)

    # --- requests and messages ------------------------------------------------------

    def facts(self) -> list[Fact]:
        """Return the first facts of the world.

        Raises:
            PortError: for a result that is no list of facts, and if `facts` breaks or
                has no end.
        """
        found: list[Fact] = []
        with self._laid("facts"):
            facts = super().facts()
            if not isinstance(facts, Iterable):
                raise self.wrong_type("facts", "the initial facts", facts)
            for fact in facts:
                if not is_fact(fact):
                    raise self.wrong_type("facts", "a first fact", fact)
                if len(found) == MOST_FACTS:
                    said = f"has more than {MOST_FACTS} first facts"
                    raise self.breach("facts", said)
                found.append(fact)
        return found

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Carry out a request. Raises PortError as `answer`."""
        return self.answer(request, self.ask(ticket, request))

    def answer(self, sent: Fact, answer: object) -> Reply | Refused | None:
        """Validate an answer to the request `sent`; return `answer`.

        Raises:
            PortError: for an invalid answer.
        """
        if is_refusal(answer):
            return answer
        if answer is None:
            if sent[0] in self._atomic:
                none = "did not answer it, and it is declared atomic"
                said = f"was asked {format_list(sent)} and {none}"
                raise self.breach("perform", said)
            return None
        if not is_reply(answer):
            what = f"the reply to {format_list(sent)}"
            raise self.wrong_type("perform", what, answer)
        self._check_content("perform", sent, answer)
        return answer

    def check_end(
        self, ended: Finished, asked: Mapping[int, tuple[object, Fact]]
    ) -> None:
        """Check that a late end belongs to a request under way, with a valid reply.

        Args:
            ended: the message.
            asked: the requests under way, by ticket.

        Raises:
            PortError: if not.
        """
        ticket = ended.ticket
        if type(ticket) is not int or ticket not in asked:
            said = f"ended a request that is not under way: {ticket!r}"
            raise self.breach("messages", said)
        if not is_reply(ended.reply):
            raise self.wrong_type("messages", "the end of a request", ended.reply)
        self._check_content("messages", asked[ticket][1], ended.reply)

    def check_lost(self, lost: Lost, known: Container[int]) -> None:
        """Check that the lost ticket is under way.

        Args:
            lost: the message.
            known: the tickets of requests and activations under way.

        Raises:
            PortError: if not.
        """
        if type(lost.ticket) is not int or lost.ticket not in known:
            said = f"lost a request that is not under way: {lost.ticket!r}"
            raise self.breach("messages", said)

    def messages(self) -> Sequence[Message]:
        """Return the messages of the world. Raises PortError as `listed`."""
        return self.listed(self.receive())

    def listed(self, sent: object) -> Sequence[Message]:
        """Return `sent` if a list; `check_message` checks the messages.

        Raises:
            PortError: for another type.
        """
        if not isinstance(sent, tuple | list):
            raise self.wrong_type("messages", "what `messages` returns", sent)
        return sent

    def check_message(self, message: object) -> None:
        """Check a datum or a signal, just before its handling.

        The preceding messages of the same pass have been handled by then. Ends of
        requests are for `check_end` and `check_lost`.

        Raises:
            PortError: if its arguments do not match the offer and the declaration.
        """
        if isinstance(message, Datum | Signal) and not _is_message_number(message):
            raise self.wrong_type("messages", "the number", message.number)
        if isinstance(message, Datum) and is_fact(message.content):
            if not are_changes(message.memory):
                raise self.wrong_type("messages", "the changes", message.memory)
            self._check_datum(message.content, "messages", message.memory)
        elif isinstance(message, Signal) and is_signal(message):
            self._check_fact("event", message.content, "messages")
        elif not isinstance(message, Finished):
            raise self.wrong_type("messages", "a message", message)

    def result_told(self, asked: Fact, told: object, handler: ResultHandler) -> str:
        """Return the result that a handler has put in place of the world's result.

        Raises:
            PortError: for a result that the primitive does not declare.
        """
        name = str(asked[0])
        known = self._results.get(name, frozenset())
        if isinstance(told, str) and told in known:
            return told
        what = self._undeclared(name, told)
        raise PortError(f"the handler of `{name}`{place_of(handler)} returned {what}")

    def check_signal(self, content: Fact) -> None:
        """Check that a host may send the signal `content`.

        Raises:
            FactError: for an undeclared event, or wrong arguments.
        """
        fault = self._fault(self._events, content)
        if fault is not None:
            meant = hint(str(content[0]), self._events)
            fault = fault or f"unknown event `{content[0]}`{meant}"
            raise FactError(f"{format_list(content)}: {fault}")

    def _check_content(self, call: str, asked: Fact, reply: Reply) -> None:
        """Check that result and data of a reply are declared. Raises PortError."""
        known = self._results.get(str(asked[0]))
        if known is not None and reply.result not in known:
            told = self._undeclared(str(asked[0]), reply.result)
            raise self.breach(call, f"ended {format_list(asked)} with {told}")
        tells = self._tells.get(str(asked[0]))
        for content in reply.data:
            self._check_datum(content, call)
            if tells is not None and content[0] not in tells:
                told = f"sent {format_list(content)} with {format_list(asked)}"
                raise self.breach(call, f"{told}, which `:tells` does not declare")

    def _check_datum(
        self, content: Fact, call: str, memory: Sequence[Change] | None = None
    ) -> None:
        """Check that a datum has a handler or changes, and declared arguments."""
        if memory is None and content[0] not in self._handled:
            raise self.breach(call, f"has no handler for its datum {content[0]}")
        self._check_fact("datum", content, call)

    def _fault(self, table: Mapping[str, Signature], content: Fact) -> str | None:
        """Return the fault of a datum or signal, or None; empty if undeclared."""
        name = str(content[0])
        known, given = table.get(name), len(content) - 1
        if known is None:
            return ""
        if given != known.most and (fault := known.miscount(given)) is not None:
            return fault
        for at, holds in self._of_kinds.get(name, ()):
            if known.args is not None and not holds(content[at]):
                return said_of(known.args[at - 1], content[at])
        return None

    def _check_fact(self, use: Use, content: Fact, call: str) -> None:
        table = self._data if use == "datum" else self._events
        fault = self._fault(table, content)
        if fault is not None:
            near = nearest(str(content[0]), table)
            meant = f"; did it mean `{near}`?" if near else ""
            fault = fault or f"which it does not offer{meant}"
            kind = "datum" if use == "datum" else "signal"
            raise self.breach(call, f"sent the {kind} {format_list(content)}: {fault}")

    def _undeclared(self, name: str, result: object) -> str:
        known = ", ".join(sorted(self._results.get(name, ())))
        what = f"`{result}`, which is not a result of `{name}`"
        return f"{what}; expected one of {known}" if known else what

    # --- optional protocols: there if the world has them ----------------------------

    def _activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on. Raises PortError for a result of another type."""
        answer: object = self.behind.activate(ticket, skills, events)
        if answer is None or is_refusal(answer):
            return answer
        raise self.wrong_type("activate", "the answer to an activation", answer)

    def _deactivate(self, ticket: int) -> None:
        self.behind.deactivate(ticket)

    def _usual_time(self, request: Fact) -> Time:
        """Return a request's usual duration. Raises PortError for an invalid time."""
        with self._laid("usual_time"):
            takes: Time = self.behind.usual_time(request)
        if not is_time(takes):
            raise self.wrong_type("usual_time", "a usual time", takes)
        return takes

    def _picture(self) -> Picture:
        """Return the picture of the world, with tuples in place of lists.

        Raises:
            PortError: if `picture` breaks, or returns an invalid picture.
        """
        with self._laid("picture"):
            picture = self.behind.picture()
            if not isinstance(picture, Picture):
                raise self.wrong_type("picture", "the picture", picture)
            try:
                return msgspec.convert(msgspec.to_builtins(picture), Picture)
            except (TypeError, ValueError, RecursionError) as error:
                said = f"returns a picture that cannot be drawn: {error}"
                raise self.breach("picture", said) from error

    def _figures(self) -> dict[str, Atom]:
        """Return the ground-truth figures. Raises PortError for another type."""
        with self._laid("figures"):
            return dict(msgspec.to_builtins(self.behind.figures()))

    def _truth(self) -> dict[str, list[Fact]]:
        """Return the true facts by name. Raises PortError for anything else."""
        with self._laid("truth"):
            told = self.behind.truth()
            if not isinstance(told, Mapping):
                raise self.wrong_type("truth", "the truth", told)
            found = {name: list(facts) for name, facts in told.items()}
        for name, facts in found.items():
            for fact in facts:
                if not is_fact(fact) or fact[0] != name:
                    raise self.wrong_type("truth", f"a true fact of {name!r}", fact)
        return found

    def _save(self) -> bytes:
        """Return the state. Raises PortError if `save` breaks or returns no bytes."""
        with self._laid("save"):
            state = self.behind.save()
        if not isinstance(state, bytes):
            raise self.wrong_type("save", "the saved state", state)
        return state

    def _restore(self, state: bytes) -> None:
        """Restore a saved state. Raises `OF_THE_BYTES`, or PortError."""
        with self._laid("restore", *OF_THE_BYTES):
            self.behind.restore(state)

    def _resume(
        self, tickets: Sequence[int], received: int
    ) -> dict[int, Reply | Refused | None]:
        """Continue the run; return the known tickets with their answers.

        Raises:
            ValueError: if the world no longer has all messages.
            PortError: if the world breaks, or returns anything else.
        """
        with self._laid("resume", ValueError):
            told = self.behind.resume(tickets, received)
            if not isinstance(told, Mapping):
                raise self.wrong_type("resume", "the state of the requests", told)
            found = dict(told)
        for answer in found.values():
            if not (answer is None or is_reply(answer) or is_refusal(answer)):
                raise self.wrong_type("resume", "the state of a request", answer)
        return found

    def _acknowledge(self, received: int) -> None:
        self.behind.acknowledge(received)

    def _adjustable(self) -> dict[str, Atom | bool]:
        """Return the options that can be changed. Raises PortError for another type."""
        with self._laid("adjustable"):
            return dict(self.behind.adjustable())

    def _adjust(self, name: str, value: Atom | bool) -> None:
        """Set an option. Raises ValueError, or PortError."""
        with self._laid("adjust", ValueError):
            self.behind.adjust(name, value)

    # --- errors of authors' code
    # --------------------------------------------------------

    def breach(self, call: str, said: str) -> PortError:
        """Return the error for a world that violates the port.

        Args:
            call: the method of the world that revealed the violation.
            said: the behaviour of the world as text: `sent nothing`.
        """
        return PortError(f"the world `{self.name}` {said}; see {self._method(call)}")

    def wrong_type(self, call: str, what: str, value: object) -> PortError:
        """Return the error for a `value` of the wrong type from an author's code.

        Args:
            call: the method of the world that returned the value.
            what: the expected value as text: `the reply to (look)`.
            value: the value.
        """
        shown = ascii(value)
        shown = shown if len(shown) <= _MOST_SHOWN else f"{shown[:_MOST_SHOWN]}..."
        said = f"{what} of the world `{self.name}` is `{shown}`"
        wanted = _WANTED[what if what in _WANTED else call]
        return PortError(f"{said}, not {wanted}; see {self._method(call)}")

    def _method(self, call: str) -> str:
        """Return the method of a world with its place in the author's code, as text.

        A method that the author's class inherits from rapc is named with this class. A
        world in another process names the answer that brought the value.
        """
        world = innermost(self)
        if (told_by := getattr(world, "told_by", None)) is not None:
            return str(told_by(call))
        method = getattr(world, call)
        kind = type(world)
        if _is_own(kind) or not _is_own(method):
            return f"`{call}`{place_of(method)}"
        return f"`{call}` of `{kind.__name__}`{place_of(kind.__init__)}"

    @contextmanager
    def _laid(self, call: str, *allowed: type[Exception]) -> Iterator[None]:
        """Raise exceptions of the block as failures of a method of the world.

        Use this context only for blocks without code of other authors.

        Args:
            call: the method.
            allowed: the exceptions that pass unchanged.

        Raises:
            PortError: for any other exception but Ctrl-C.
        """
        try:
            yield
        except (KeyboardInterrupt, PortError):
            raise
        except BaseException as error:  # any exception of the world's code
            if isinstance(error, allowed):
                raise
            place = place_of_error(error).strip(" ()")
            where = f" at {place}" if place else f" in {self._method(call)}"
            said = f"the world `{self.name}` failed{where}: {said_by(error)}"
            raise PortError(said) from error

    def blame(self, error: BaseException) -> NoReturn:
        """Raise `error`, which came out of a run, in its form for a host.

        Raises:
            PortError: if an author's code raised `error`, even `SystemExit`.
            BaseException: `error` itself if not.
        """
        if isinstance(error, KeyboardInterrupt | PortError):
            raise error
        passed = [one for one in frames(error) if _package(one[0]) != "rapc"]
        named = {
            found: f"{what} `{name}`"
            for what, table in self.code.items()
            for name, call in table.items()
            if (found := code_of(call)) is not None
        }
        whose = f"the world `{self.name}`"
        for at, (frame, _) in enumerate(passed):
            if frame.f_code in named or _is_of_world(frame):
                whose = named.get(frame.f_code, whose)
                own = [f for f in passed[at:] if _package(f[0]) == _package(frame)]
                inner, row = own[-1]
                place = f"{Path(inner.f_code.co_filename).name}:{row}"
                raise PortError(
                    f"{whose} failed at {place}: {said_by(error)}"
                ) from error
        raise error


def _package(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__")).partition(".")[0]


def _is_of_world(frame: FrameType) -> bool:
    """Return whether a frame is that of a method of a world."""
    first = frame.f_locals.get(next(iter(frame.f_code.co_varnames), ""))
    if isinstance(first, tuple) and first:  # of a method with `*args` alone
        first = first[0]
    return isinstance(first, World)


def is_fact(value: object) -> TypeGuard[Fact]:
    """Return whether `value` is a fact: a tuple of atoms that starts with a name."""
    if type(value) is not tuple or not value or type(value[0]) is not str:
        return False
    return all(map(is_atom, value))


def is_reply(value: object) -> TypeGuard[Reply]:
    """Return whether `value` is a reply with a result and data that are facts."""
    if type(value) is not Reply or type(value.result) is not str:
        return False
    if value.memory is not None and not are_changes(value.memory):
        return False
    return isinstance(value.data, tuple | list) and all(map(is_fact, value.data))


def are_changes(value: object) -> bool:
    """Return whether `value` has valid changes of memory, or is None."""
    if value is None:
        return True
    return isinstance(value, tuple | list) and all(map(_is_change, value))


def _is_change(value: object) -> bool:
    if not is_fact(value) or value[0] not in CHANGES:
        return False
    least, most = CHANGES[str(value[0])]
    if value[0] in ("arrive", "fix-cardinality"):
        return len(value) == 2
    names = value[1:3] if value[0] == "introduce" else value[1:2]
    whole = least < len(value) and (most is None or len(value) <= most + 1)
    return whole and all(type(name) is str for name in names)


def is_refusal(value: object) -> TypeGuard[Refused]:
    """Return whether `value` is a refusal that names requests by their tickets."""
    if type(value) is not Refused or not isinstance(value.conflicts, tuple | list):
        return False
    return all(type(ticket) is int for ticket in value.conflicts)


def is_signal(value: Signal) -> bool:
    """Return whether a signal is a fact with the tickets under which it arose."""
    whole = is_fact(value.content) and isinstance(value.tickets, tuple | list)
    return whole and all(type(ticket) is int for ticket in value.tickets)


def _is_message_number(message: Datum | Signal) -> bool:
    number = message.number
    return number is None or (type(number) is int and number >= 0)


def is_time(value: object) -> bool:
    """Return whether `value` is a time: a number from 0 to `LATEST`."""
    return type(value) in (int, float) and 0 <= value <= LATEST  # type: ignore[operator]


def _is_own(what: object) -> bool:
    """Whether a class or a method is rapc's own."""
    return str(getattr(what, "__module__", "")).partition(".")[0] == "rapc"
