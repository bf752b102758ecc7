"""Signals, and the steps that wait for them [S 3.1; L 4].

A step listens from when all that it follows has ended; what a signal does to it is
said by the first of its `wait-for`s that matches.
"""

from __future__ import annotations

from rapc.base.values import Fact, format_list
from rapc.compiler.net_plan import WaitPlan
from rapc.runtime.events import events
from rapc.runtime.machine import Machine
from rapc.runtime.state.task import Env, Task
from rapc.runtime.tasks.finish import finish_by_signal, receive, recheck_bound_steps
from rapc.runtime.tasks.start import release_at_start_time


def signal(machine: Machine, content: Fact) -> None:
    """A signal has come: decide the steps that wait for it, by task number."""
    if machine.recorder.on:
        machine.recorder.emit(events.Signal, task=None, what=content)
    listening = machine.state.listening.get(str(content[0]), {})
    for number in sorted(listening):
        task = listening.get(number)
        if task is not None:
            _decide(machine, task, content)


def _decide(machine: Machine, task: Task, content: Fact) -> None:
    run = task.within
    assert task.step is not None
    assert run is not None
    for wait in task.step.waits:
        if wait.mode == "proceed" and not (task.wait and task.wait.awaits_signal):
            continue
        found = _matched(machine, task, wait, content)
        if found is None:
            continue
        run.env.update(found)
        if recheck_bound_steps(machine, run, found):
            return
        if wait.mode == "proceed":
            _proceed(machine, task, content)
        else:
            finish_by_signal(machine, task, wait.mode)
        return


def _matched(machine: Machine, task: Task, wait: WaitPlan, content: Fact) -> Env | None:
    """What a signal binds in the method's environment; None if it is another one."""
    assert task.within is not None
    if wait.signal != content[0] or len(wait.args) != len(content) - 1:
        return None
    arriving = zip(wait.args, content[1:], strict=True)
    return receive(machine, task.within, list(arriving))


def _proceed(machine: Machine, task: Task, content: Fact) -> None:
    if task.wait is not None:
        task.wait.awaits_signal = False
    if machine.recorder.on:
        on = format_list(content)
        machine.recorder.emit(events.TaskWoken, task=task.number, on=on)
    release_at_start_time(machine, task)
