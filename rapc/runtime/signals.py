"""Signals, and the steps that wait for them (S 3.1, semantics 4).

A step listens from when all that it follows has ended; what a signal does to it is
said by the first of its `wait-for`s that matches.
"""

from __future__ import annotations

from rapc.base.values import Fact, format_list
from rapc.compiler.net_plan import WaitPlan
from rapc.runtime.beginnings import when_time_comes
from rapc.runtime.endings import end_by_signal, late_recursion, receive
from rapc.runtime.events import events
from rapc.runtime.machine import Machine
from rapc.runtime.task import Env, Task


def signal(machine: Machine, content: Fact) -> None:
    """A signal has come: decide the steps that wait for it, by task number."""
    if machine.recorder.on:
        machine.recorder.emit(events.Signal, task=None, what=format_list(content))
    listening = machine.listening.get(str(content[0]), {})
    for number in sorted(listening):
        task = listening.get(number)
        if task is not None:
            _decide(machine, task, content)


def _decide(machine: Machine, task: Task, content: Fact) -> None:
    run = task.within
    assert task.step is not None
    assert run is not None
    for wait in task.step.waits:
        if wait.mode == "proceed" and not (task.wait and task.wait.held):
            continue
        found = _matched(machine, task, wait, content)
        if found is None:
            continue
        run.env.update(found)
        if late_recursion(machine, run, found):
            return
        if wait.mode == "proceed":
            _proceed(machine, task, content)
        else:
            end_by_signal(machine, task, wait.mode)
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
        task.wait.held = False
    if machine.recorder.on:
        on = format_list(content)
        machine.recorder.emit(events.TaskWoken, task=task.number, on=on)
    when_time_comes(machine, task)
