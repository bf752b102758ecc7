"""Signals: rules come first, then waiting primitives and steps [S 3, 4; L 4, 9].

A signal belongs to the activations, or the request, under which it arose, or to none.
Rules outside of RAPs receive the signal first; then the `:event` rules of its owners
and of their ancestors; then the primitives and the steps that wait. Each receives the
signal once, if it is live at its turn. A step listens from the end of all steps that it
follows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.compiler.net_plan import WaitPlan
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.tasks.finish import (
    end_method,
    finish_by_signal,
    receive,
    recheck_bound_steps,
)
from rapc.runtime.tasks.rules import run_event_rules, run_rules_of
from rapc.runtime.tasks.start import release
from rapc.world import OKAY


class _Source(NamedTuple):
    """An activation, or a request, under which a signal arose."""

    #: The number of the owner.
    owner: int
    #: The owner or, if it has ended, the nearest ancestor that has not, if any.
    task: Task | None
    #: The activation; None for a request.
    activation: Activation | None

    @property
    def covers_below(self) -> bool:
        """Return whether waiting tasks below the owner may receive the signals."""
        return self.activation is not None and self.activation.in_background


def signal(run: Run, content: Fact, tickets: Sequence[int] = ()) -> None:
    """Deliver a signal to all receivers.

    Args:
        run: the run.
        content: the signal, in memory names.
        tickets: the activations or the request under which the signal arose; without
            tickets, every task may receive it.
    """
    sources = _sources(run, tickets)
    if run.recorder.on:
        owner = sources[0].owner if sources else None
        run.recorder.emit(events.SignalReceived, task=owner, what=content)
    if run.library.event_rules:
        run_event_rules(run, content)
    if run.library.hears_events:
        for task in _context(run, sources, bool(tickets)):
            if task.plan.event_rules:
                run_rules_of(run, task, content)
    for source in sources:
        if source.activation is not None:
            _tell_primitive(run, source.activation, content)
    if tickets:
        _tell_around(run, sources, content)
    else:
        _tell(run, run.state.activations.on.values(), None, content)


def _sources(run: Run, tickets: Iterable[int]) -> list[_Source]:
    """Return the sources of a signal, oldest first, without those long ended."""
    found = []
    state = run.state
    for ticket in sorted(set(tickets)):
        activation = state.activations.get(ticket)
        if activation is not None:
            found.append(_Source(activation.owner, activation.hearer(), activation))
            continue
        task = state.pending.get(ticket, (None, ()))[0]
        if task is not None:
            found.append(_Source(task.number, task, None))
    return found


def _context(run: Run, sources: Sequence[_Source], belongs: bool) -> Iterable[Task]:
    """Return the tasks whose `:event` rules receive a signal, in order [S 4.1]."""
    if not belongs:
        tasks = run.state.live_tasks()
        return [task for task in reversed(tasks) if task.run is not None]
    found: dict[int, Task] = {}
    for source in sources:
        task = source.task
        while task is not None:
            found.setdefault(task.number, task)
            task = task.parent
    return found.values()


# --- waiting primitives and steps --------------------------------------------------


def _tell_around(run: Run, sources: Sequence[_Source], content: Fact) -> None:
    """Deliver to tasks beside and above the owners, and below those of `skills`."""
    around: set[int] = set()
    below = {source.owner for source in sources if source.covers_below}
    for source in sources:
        task = source.task
        if task is not None and task.run is not None:
            around.add(id(task.run))
        while task is not None:
            around.add(id(task.within))
            task = task.parent
    listening = run.state.listening.get(str(content[0]), {})
    steps = {
        number
        for number, task in listening.items()
        if id(task.within) in around or (below and _is_below(task, below))
    }
    primitives = [
        one
        for one in (run.state.activations.on.values() if below else ())
        if one.task is not None and _is_below(one.task, below)
    ]
    _tell(run, primitives, steps, content)


def _is_below(task: Task, numbers: set[int]) -> bool:
    above = task.parent
    while above is not None and above.number not in numbers:
        above = above.parent
    return above is not None


def _tell(
    run: Run,
    primitives: Iterable[Activation],
    steps: set[int] | None,
    content: Fact,
) -> None:
    """Deliver a signal to primitives and waiting steps, by task number.

    `steps` are the numbers of the steps that may receive the signal, None: all.
    """
    listening = run.state.listening.get(str(content[0]), {})
    chosen = listening.keys() if steps is None else steps
    turns: list[tuple[int, int, Activation | None]] = [(n, 1, None) for n in chosen]
    turns += [(one.task.number, 0, one) for one in primitives if one.task is not None]
    turns.sort(key=lambda turn: turn[:2])
    for number, _, activation in turns:
        if activation is not None:
            _tell_primitive(run, activation, content)
        elif number in listening:
            _decide(run, listening[number], content)


def _tell_primitive(run: Run, activation: Activation, content: Fact) -> None:
    """End the method of an activation, if the active method awaits the signal [S 4]."""
    method_run = activation.run
    if method_run is None:
        return
    for wait in activation.waits:
        found = _matched(run, method_run, wait, content)
        if found is None:
            continue
        method_run.env.update(found)
        result = OKAY
        if wait.mode == "fail":
            result = wait.signal.removeprefix(":")
            method_run.task.remember().failure = result
        end_method(run, method_run, result)
        return


def _decide(run: Run, task: Task, content: Fact) -> None:
    """Apply the first `wait-for` of a step that matches the signal."""
    method_run = task.within
    assert task.step is not None
    assert method_run is not None
    for wait in task.step.waits:
        if wait.mode == "proceed" and not (task.wait and task.wait.awaits_signal):
            continue
        found = _matched(run, method_run, wait, content)
        if found is None:
            continue
        method_run.env.update(found)
        if recheck_bound_steps(run, method_run, found):
            return
        if wait.mode == "proceed":
            _proceed(run, task, content)
        else:
            finish_by_signal(run, task, wait.mode)
        return


def _matched(
    run: Run, method_run: MethodRun, wait: WaitPlan, content: Fact
) -> Env | None:
    """Return the bindings of a signal in a method; None without a match."""
    if wait.signal != content[0] or len(wait.args) != len(content) - 1:
        return None
    arriving = zip(wait.args, content[1:], strict=True)
    return receive(run, method_run, list(arriving))


def _proceed(run: Run, task: Task, content: Fact) -> None:
    if task.wait is not None:
        task.wait.awaits_signal = False
    if run.recorder.on:
        on = format_list(content)
        run.recorder.emit(events.TaskWoken, task=task.number, on=on)
    release(run, task, again=True)
