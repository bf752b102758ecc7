"""Intake: unrequested messages of the world, late ends of primitives [T 3.3, S 4].

Each pass of the loop takes in messages: data go to their handlers, signals to the steps
that wait for them.
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.events import DataReceived
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.tasks.finish import end_method
from rapc.runtime.tasks.primitives import take_reply
from rapc.runtime.tasks.signals import signal
from rapc.world import Datum, Finished, Message, Signal


def take_in(run: Run, messages: Iterable[Message]) -> None:
    """Take in `messages` of the world: ends of primitives first, then the rest.

    Raises:
        PortError: as `finish` and `HeldWorld.check_message`.
    """
    others: list[Message] = []
    gone = tuple(run.state.activations.off)
    for message in messages:
        if isinstance(message, Finished):
            finish(run, message)
        else:
            others.append(message)
    for message in others:
        run.port.check_message(message)
        if isinstance(message, Datum):
            with run.access.batch():
                fact = run.access.receive(message.content, run.handlers.data)
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
