"""How a run begins and how it ends, each told by an event with all that it takes."""

from __future__ import annotations

import msgspec

from rapc.events import RunEnded, RunStarted
from rapc.library.library import digest
from rapc.runtime import snapshot
from rapc.runtime.machine import Machine
from rapc.runtime.tasks.remove import remove
from rapc.spec import RunSpec

FORMAT = 2
"""The version of the trace format."""


def tell_start(machine: Machine, spec: RunSpec) -> None:
    """Emit the first event of a run: what is run, and with which settings."""
    if not (machine.recorder.on and machine.recorder.wants(RunStarted)):
        return
    machine.recorder.emit(
        RunStarted,
        format=FORMAT,
        spec=msgspec.structs.replace(
            spec,
            library=machine.library.name,
            digest=digest(machine.library.library),
            world=machine.world.name,
            settings=machine.settings.named(),
        ),
    )


def end_run(machine: Machine, reason: str, because: str | None = None) -> None:
    """End a run that is not over: every live task is removed, the results are told.

    Args:
        machine: that of the run.
        reason: why it is over, in a word.
        because: more of it, where somebody knows more.
    """
    machine.state.reason = reason
    machine.state.over = True
    for action in machine.at_end:
        action()
    results = snapshot.results(machine.state.top_level)
    if reason == "world":
        because = machine.world.ended()
    if reason == "runaway" and machine.recorder.on:
        because = snapshot.looping(machine) or None
    if reason == "stuck" and machine.waited_in_vain():
        because = f"no cycle in {machine.state.waits} waits (`rapc.idle-waits`)"
    waiting = snapshot.deadlocks_in_words(machine)
    if reason != "done":
        waiting += snapshot.waiting(machine)
    for given in machine.state.top_level:
        if given.task.live:
            remove(machine, given.task, "run-over")
    assert not machine.state.activations.on, "skills are on that nobody has"
    if machine.recorder.on:
        machine.recorder.emit(
            RunEnded,
            reason=reason,
            because=because,
            results=results,
            waiting=waiting,
        )
