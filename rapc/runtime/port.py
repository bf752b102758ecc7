"""The port held: what a world answers and sends is what was offered and declared.

What does not keep to it is told at once, as a `PortError` that names the world, the
call and where its author wrote it; the run does not go on in silence. A known good
reply, `okay` without data, is never looked at here.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.base.code_places import place_of
from rapc.base.names import hint, nearest
from rapc.base.values import Fact, format_atom, format_list
from rapc.errors import FactError, PortError
from rapc.ir.nodes import Argument
from rapc.library.kinds import misfits, said_of
from rapc.library.library import Library
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures, Use
from rapc.runtime.authors import (
    breach,
    is_fact,
    is_reply,
    is_signal,
    wrong_type,
)
from rapc.world import (
    Datum,
    Finished,
    Message,
    Reply,
    ResultHandler,
    Signal,
    Time,
    World,
)

_Arguments = Mapping[str, tuple[Argument, ...] | None]
"""The declared arguments of each name."""


class Port:
    """Holds one world to what it offers and to what one library declares.

    Args:
        library: the library that runs.
        signatures: the signatures of the library.
        world: the world it runs in.
        strict: whether data must be among those that `:tells` names.
    """

    def __init__(
        self,
        library: Library,
        signatures: Signatures,
        world: World,
        strict: bool = False,
    ) -> None:
        self._world = world
        self._kinds = signatures.kinds
        offered = Signatures.offered(world.kit.offer)
        #: What the library declares counts; what it says nothing of, as offered.
        self._data = {**offered.data, **signatures.data}
        self._events = {**offered.events, **signatures.events}
        self._results = {
            name: frozenset(signature.results)
            for name, signature in signatures.primitives.items()
        }
        self._atomic = frozenset(
            name for name, form in library.primitives.items() if form.atomic
        )

        #: The data that may come with a primitive; nothing where nothing is said.
        self._tells = {
            name: frozenset(form.tells)
            for name, form in library.primitives.items()
            if strict and form.tells
        }

    def checked(self, sent: Fact, reply: object) -> Reply | None:
        """Return `reply`, once it is seen that the request `sent` may have it.

        Raises:
            PortError: if not.
        """
        if reply is None:
            if sent[0] in self._atomic:
                none = "did not answer it, and it is declared atomic"
                raise self._breach(sent, none)
            return None
        if not is_reply(reply):
            raise wrong_type(
                self._world, "perform", f"the reply to {format_list(sent)}", reply
            )
        assert isinstance(reply, Reply)
        self._check_content("perform", sent, reply)
        return reply

    def check_end(self, asked: Fact, reply: object) -> None:
        """See that `reply` may be the late end of the request `asked`.

        Raises:
            PortError: if not.
        """
        if not is_reply(reply):
            raise wrong_type(self._world, "messages", "the end of a request", reply)
        assert isinstance(reply, Reply)
        self._check_content("messages", asked, reply)

    def _check_content(self, call: str, asked: Fact, reply: Reply) -> None:
        """See that result and data of a reply are declared. Raises PortError."""
        known = self._results.get(str(asked[0]))
        if known is not None and reply.result not in known:
            told = self._undeclared(str(asked[0]), reply.result)
            raise breach(
                self._world, call, f"answered {format_list(asked)} with {told}"
            )
        tells = self._tells.get(str(asked[0]))
        for content in reply.data:
            self.check_datum(content, call)
            if tells is not None and content[0] not in tells:
                told = f"sent {format_list(content)} with {format_list(asked)}"
                said = f"{told}, which `:tells` does not say"
                raise breach(self._world, call, said)

    def result_told(self, asked: Fact, told: object, handler: ResultHandler) -> str:
        """Return the result that a handler has put in place of the world's.

        Raises:
            PortError: for what is no declared result of the primitive asked.
        """
        name = str(asked[0])
        known = self._results.get(name, frozenset())
        if isinstance(told, str) and told in known:
            return told
        what = self._undeclared(name, told)
        raise PortError(f"the handler of `{name}`{place_of(handler)} returned {what}")

    def check_datum(self, content: Fact, call: str = "messages") -> None:
        """See that a datum has a handler, and the arguments it is to have.

        Raises:
            PortError: if not.
        """
        if content[0] not in self._world.kit.handlers.data:
            said = f"has no handler for its datum {content[0]}"
            raise breach(self._world, call, said)
        self._check_fact("datum", content, call)

    def check_message(self, message: Message) -> None:
        """See that a message is one, with arguments as offered and declared.

        Ends of requests are for `check_end`.

        Raises:
            PortError: if not.
        """
        if isinstance(message, Datum) and is_fact(message.content):
            self.check_datum(message.content)
        elif isinstance(message, Signal) and is_signal(message):
            self._check_fact("event", message.content, "messages")
        elif not isinstance(message, Finished):
            raise wrong_type(self._world, "messages", "a message", message)

    def check_signal(self, content: Fact) -> None:
        """See that a host may send the signal `content`.

        Raises:
            FactError: if no event is called so, or it has other arguments.
        """
        fault = self._fault(self._events, content)
        if fault is not None:
            meant = hint(str(content[0]), self._events)
            fault = fault or f"no event is called `{content[0]}`{meant}"
            raise FactError(f"{format_list(content)}: {fault}")

    def _fault(self, table: Mapping[str, Signature], content: Fact) -> str | None:
        """Return what is wrong with a datum or signal; nothing is said of no such."""
        known = table.get(str(content[0]))
        if known is None:
            return ""
        fault = known.miscount(len(content) - 1)
        if fault is None and known.args:
            for arg, value in misfits(self._kinds, known.args, content[1:]):
                return said_of(arg, value)
        return fault

    def _check_fact(self, use: Use, content: Fact, call: str) -> None:
        table = self._data if use == "datum" else self._events
        fault = self._fault(table, content)
        if fault is not None:
            near = nearest(str(content[0]), table)
            meant = f"; did it mean `{near}`?" if near else ""
            fault = fault or f"which it does not offer{meant}"
            kind = "datum" if use == "datum" else "signal"
            said = f"sent the {kind} {format_list(content)}: {fault}"
            raise breach(self._world, call, said)

    def _undeclared(self, name: str, result: object) -> str:
        known = ", ".join(sorted(self._results.get(name, ())))
        what = f"`{result}`, which is no result of `{name}`"
        return f"{what} (those are {known})" if known else what

    def _breach(self, sent: Fact, said: str) -> PortError:
        return breach(
            self._world, "perform", f"was asked {format_list(sent)} and {said}"
        )


def next_in_the_past(world: World, due: Time, now: Time) -> PortError:
    """Return what to raise for a `world` that announces something for a time gone."""
    said = f"will next send something at {format_atom(due)}, and it is"
    return breach(world, "next_time", f"says that it {said} {format_atom(now)} by now")


def stopped_for_nothing(world: World, now: Time, target: Time) -> PortError:
    """Return what to raise for a `world` that stops its clock and has sent nothing."""
    said = (
        f"stopped its clock at {format_atom(now)} on the way to {format_atom(target)}"
    )
    return breach(world, "advance", f"{said}, and sent nothing")


def no_time_passed(world: World, target: Time, due: bool) -> PortError:
    """Return what to raise where waiting for a world leads nowhere.

    Args:
        world: the world.
        target: the time that was waited for.
        due: whether the world had said that it would send something by now.
    """
    if due:
        at = format_atom(target)
        said = f"said that it would send something at {at}, and sent nothing"
        return breach(world, "next_time", said)
    return breach(
        world, "advance", f"did not move its clock on to {format_atom(target)}"
    )
