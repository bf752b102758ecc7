"""Intake: unrequested messages of the world, late ends of primitives [T 3.3, S 4].

Each pass of the loop takes in messages: data go to their handlers, signals to the steps
that wait for them.
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.base.messages import Resumed
from rapc.events import DataReceived
from rapc.language.results import INTERFERENCE
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.tasks import causes
from rapc.runtime.tasks.finish import end_method
from rapc.runtime.tasks.primitives import take_reply, tell_refusal
from rapc.runtime.tasks.signals import signal
from rapc.world import Datum, Finished, Lost, Message, Refused, Signal


def take_in(run: Run, messages: Iterable[Message | Resumed]) -> None:
    """Take in `messages` of the world: ends of requests first, then the rest.

    Raises:
        PortError: as `finish`, `lose` and `HeldWorld.check_message`.
    """
    others: list[Message | Resumed] = []
    gone = tuple(run.state.activations.off)
    for message in messages:
        if isinstance(message, Finished):
            finish(run, message)
        elif isinstance(message, Lost):
            lose(run, message)
        else:
            if isinstance(message, Resumed) and run.port.kit.resumed is not None:
                with run.access.batch():
                    run.port.kit.resumed(run.access, message.seconds)
            others.append(message)
    for message in others:
        if isinstance(message, Resumed):
            signal(run, (":resumed", message.seconds))
            continue
        run.port.check_message(message)
        if isinstance(message, Datum):
            with run.access.batch():
                handlers = run.handlers.data
                if message.memory is not None:
                    name = str(message.content[0])
                    handlers = {name: run.changing(name, message.memory, datum=True)}
                fact = run.access.receive(message.content, handlers)
            if run.recorder.on:
                run.recorder.emit(DataReceived, data=run.beliefs.canonical(fact))
        elif isinstance(message, Signal):
            signal(run, run.beliefs.items.named(message.content), message.tickets)
    if gone:
        run.state.activations.forget(gone)


def finish(run: Run, ended: Finished) -> None:
    """End a primitive: run its handlers, end its method.

    Raises:
        PortError: for a ticket that is not under way, or a datum without a handler.
    """
    run.port.check_end(ended, run.state.pending)
    ticket, reply = ended.ticket, ended.reply
    task, asked = run.state.pending.pop(ticket)
    if task is not None:
        over = Activation(ticket, task.number, task, None, ())
        run.state.activations.off[ticket] = over
    result = take_reply(run, task, asked, reply)
    if result is not None and task is not None and task.run is not None:
        end_method(run, task.run, result)


def lose(run: Run, lost: Lost) -> None:
    """End the method of a request or an activation with an unknown outcome.

    Raises:
        PortError: for a ticket that is not under way.
    """
    pending, on = run.state.pending, run.state.activations.on
    run.port.check_lost(lost, {*pending, *on})
    if lost.ticket in on:
        method_run = on[lost.ticket].run
        asked = on[lost.ticket].skills
    else:
        task, request = pending.pop(lost.ticket)
        method_run = None if task is None else task.run
        asked = (request,)
    if method_run is None:
        return
    sensed = run.beliefs.items.sensed
    named = [(one, sensed(one) or one) for one in asked]
    tell_refusal(run, method_run.task, named, Refused(reason=lost.reason))
    because = causes.of_refusal(run, method_run, lost.reason)
    end_method(run, method_run, INTERFERENCE, because)
