"""Primitives: requests to the world, its replies, and the handlers (T 3.3).

The interpreter translates names in requests and in replies. A result and its data go
through their handlers as one batch, result first [L 5]. Not here: the effect of a
result on the method (`try_method`, `messages`).
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.base.resources import Counter, SetResource
from rapc.base.values import Atom, Fact
from rapc.compiler.compiler import RequestPlan
from rapc.events import (
    PrimitiveCancelled,
    PrimitiveEnded,
    PrimitiveRequested,
    RequestRefused,
)
from rapc.language.results import INTERFERENCE
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.world import OKAY, Refused, Reply

_RESOURCES = (Counter, SetResource)

_DONE = Reply(OKAY)
"""The reply of most primitives that end at once; it needs no validation."""


def ground(run: Run, method_run: MethodRun, plan: RequestPlan) -> Fact | None:
    """Return a request or notation filled in; None if an argument has no value."""
    run.context.task = method_run.task
    return fill_in(run, plan, method_run.env)


def fill_in(run: Run, plan: RequestPlan, env: Env, tells: bool = True) -> Fact | None:
    """Return the result of `ground` for the bindings `env`; `tells` traces faults."""
    context = run.context
    parts: list[Atom] = [plan.name]
    for arg in plan.args:
        value = env.get(arg.name) if arg.name is not None else None
        if value is None:
            value = (arg.needed if tells else arg.value)(context, env)
            if value is None:
                return None
        if isinstance(value, _RESOURCES):
            if tells:
                context.unfit(plan.where, value, "a symbol, number or string")
            return None
        parts.append(value)
    return tuple(parts)


def filled_in(run: Run, task: Task, plan: RequestPlan, env: Env) -> Fact | None:
    """Return the result of `ground` for a method of `task`; trace nothing."""
    run.context.task = task
    return fill_in(run, plan, env, tells=False)


def sendable(run: Run, task: Task, plan: RequestPlan, env: Env) -> Fact | None:
    """Return a request in the form for the world, or None if it cannot be sent."""
    asked = filled_in(run, task, plan, env)
    return None if asked is None else run.beliefs.items.sensed(asked)


def request(run: Run, method_run: MethodRun, plan: RequestPlan) -> str | Refused | None:
    """Send the request of a method; return the result that ends the method.

    None: the end comes later, or the method has left meanwhile. `Refused`: the world
    refuses the request because of a conflict.
    """
    asked = ground(run, method_run, plan) if plan.args else plan.bare
    if asked is None:
        return INTERFERENCE
    sent, items = asked, run.beliefs.items
    if items.known or items.gone:
        named = items.sensed(asked)
        if named is None:
            return INTERFERENCE
        sent = named
    task = method_run.task
    if run.recorder.on:
        run.recorder.emit(
            PrimitiveRequested,
            task=task.number,
            request=asked,
            sent=sent,
        )
    world, state = run.port, run.state
    state.tickets = method_run.ticket = ticket = state.tickets + 1
    answer = world.ask(ticket, sent)
    if type(answer) is Reply and answer == _DONE:
        reply: Reply | None = answer
    else:
        held = world.answer(sent, answer)
        if isinstance(held, Refused):
            run.sync_clock()
            return tell_refusal(run, task, [(asked, sent)], held)
        reply = held
    now = world.clock()
    if now != run.recorder.time:
        run.set_clock(now)
    if reply is None or state.past_until:
        # The primitive ends later; or never, if the run is over.
        state.pending[ticket] = task, asked
        if reply is None and task.run is not method_run:
            cancel(run, method_run)
        return None
    if run.host_timers:
        state.pending[ticket] = task, asked  # a host may cancel it now
        run.run_host_timers()
        del state.pending[ticket]
    return take_reply(run, task if task.run is method_run else None, asked, reply)


def tell_refusal(
    run: Run, task: Task, asked: Iterable[tuple[Fact, Fact]], reply: Refused
) -> Refused:
    """Report that the world has refused a request; return the refusal.

    `asked` has the request, or each skill, in memory names and in sensor names.
    """
    if run.recorder.on:
        for request, sent in asked:
            run.recorder.emit(
                RequestRefused,
                task=task.number,
                request=request,
                sent=sent,
                because=reply.reason or None,
            )
    return reply


def cancel(run: Run, method_run: MethodRun) -> None:
    """Cancel the request or the skills of a method in the world, if any.

    The interpreter ignores later replies.
    """
    ticket, pending = method_run.ticket, run.state.pending
    if (
        ticket is None
        or ticket not in pending
        or pending[ticket][0] is not method_run.task
    ):
        return
    asked = pending[ticket][1]
    pending[ticket] = None, asked
    gone = Activation(ticket, method_run.task.number, method_run.task, None, ())
    run.state.activations.off[ticket] = gone
    if run.recorder.on:
        run.recorder.emit(
            PrimitiveCancelled,
            task=method_run.task.number,
            request=run.beliefs.canonical(asked),
        )
    run.port.cancel(ticket)


def take_reply(run: Run, task: Task | None, asked: Fact, reply: Reply) -> str | None:
    """Run the handlers of a reply to the request `asked`.

    `task` is the requesting task, None if it has left. Return the result if a method of
    `task` is to end with it, else None; a handler may have changed the result [T
    3.3.2].

    Raises:
        PortError: for an undeclared result of a handler.
    """
    handler, result = run.result_handlers.get(asked[0]), reply.result
    if reply.memory is not None:
        handler = run.changing(str(asked[0]), reply.memory)
    if handler is not None or reply.data or run.recognizer.unsettled:
        canonical = run.beliefs.canonical
        with run.access.batch():
            if handler is not None:
                told = handler(run.access, canonical(asked), result)
                if told is not None:
                    result = run.port.result_told(asked, told, handler)
            for content in reply.data:
                run.access.receive(content, run.handlers.data)
        asked = canonical(asked)
    if run.recorder.on:
        run.recorder.emit(
            PrimitiveEnded,
            task=task.number if task is not None else None,
            request=run.beliefs.canonical(asked),
            result=result,
            data=tuple([run.beliefs.items.named(datum) for datum in reply.data]),
        )
    if task is None or task.run is None:
        return None
    if result != OKAY:
        task.remember().failure = result
    return result
