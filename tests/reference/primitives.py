"""Requests to the world, and what comes back [L 3.69]."""

from __future__ import annotations

from typing import Any

from rapc import events
from rapc.base.values import Atom, Fact, format_list
from rapc.ir import nodes
from rapc.world import OKAY, Datum, Finished, Refused, Reply, Signal
from rapc.worlds.scripted import AT
from tests.reference.endings import method_badly, method_well
from tests.reference.kinds import (
    Broken,
    WrongKind,
    hold_data,
    hold_fact,
    hold_signal,
)
from tests.reference.run import Run
from tests.reference.signals import hear
from tests.reference.tasks import Running, Task


class Access:
    """What a handler may do to memory; items are not in sections 1 to 6."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.now = run.time
        self.query = run.memory.query
        self.value = run.memory.value

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now. Raises WrongKind."""
        hold_fact(self.run.library, fact)
        self.run.memory.assert_fact(fact, "handler")

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so."""
        self.run.memory.erase(prefix, "handler")


def request(run: Run, running: Running, body: nodes.Primitive) -> Refused | None:
    """Ask the world for a primitive; an atomic one holds the interpreter.

    What the world says is returned if it will not carry it out beside others.
    """
    fact = run.ground(running.task, body.request, running.env, "primitive")
    if fact is None:
        method_badly(run, running, "interference", "sibling-failed")
        return None
    text = format_list(fact)
    number = running.task.number
    run.tell(events.PrimitiveRequested, task=number, request=text, sent=text)
    ticket = len(run.tickets) + 1
    run.tickets[ticket] = (fact, None)
    run.owners[ticket] = running.task
    reply = run.world.perform(ticket, fact)
    if isinstance(reply, Reply):
        hold_data(run, reply.data)
    run.look_at_clock()
    if isinstance(reply, Refused):
        run.tell(events.RequestRefused, task=number, request=text, sent=text)
        return reply
    run.tickets[ticket] = (fact, running.task)
    if reply is not None and not run.late:
        run.keep_appointments()
        finish(run, ticket, reply)
    return None


def claim(run: Run, running: Running) -> bool:
    """Whether all that a method claims can be filled in; what cannot is traced."""
    return all(
        run.ground(running.task, pattern, running.env, "claim") is not None
        for pattern in running.method.claims
    )


def finish(run: Run, ticket: int, reply: Reply) -> None:
    """A primitive has ended: handlers first, then the method that asked for it."""
    asked, task = run.tickets[ticket]
    hold_data(run, reply.data)
    run.tickets[ticket] = (asked, None)
    access: Any = Access(run)
    run.handlers.results[str(asked[0])](access, asked, reply.result)
    for datum in reply.data:
        handle(run, datum)
    run.tell(
        events.PrimitiveEnded,
        task=None if task is None else task.number,
        request=format_list(asked),
        result=reply.result,
        data=tuple(format_list(datum) for datum in reply.data),
    )
    if task is not None:
        ended(run, task, reply.result)


def handle(run: Run, datum: Fact) -> None:
    """Hand a datum to its handler. Raises Broken if what that asserts is of no kind.

    Of a script the rows themselves are at fault, and WrongKind is what comes out.
    """
    access: Any = Access(run)
    try:
        run.handlers.data[str(datum[0])](access, datum)
    except WrongKind as wrong:
        if datum[0] == AT:
            raise
        raise Broken(str(wrong)) from None


def ended(run: Run, task: Task, result: str) -> None:
    """The task hears how its primitive ended."""
    assert task.running is not None
    if result == OKAY:
        method_well(run, task.running)
    else:
        task.symbol = result
        method_badly(run, task.running, result, "sibling-failed")


def take_in(run: Run) -> None:
    """What the world has sent: results first, then the rest in its order."""
    messages = run.world.messages()
    for message in messages:
        if isinstance(message, Finished):
            finish(run, message.ticket, message.reply)
    for message in messages:
        if isinstance(message, Datum):
            hold_data(run, (message.content,))
            handle(run, message.content)
            run.tell(events.DataReceived, data=format_list(message.content))
        elif isinstance(message, Signal):
            hold_signal(run, message.content)
            hear(run, message.content, message.tickets)
