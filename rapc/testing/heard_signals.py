"""Which `wait-for` a signal has decided, told from the events of a run.

A trace says what came and what followed. Until the next task is selected, what wakes,
ends a step or ends a primitive of skills is the signal that came last.
"""

from __future__ import annotations

from rapc import events
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.testing.asked_queries import traced_name

Heard = tuple[str, str, str]
"""A RAP, the name of its method, and the signal that a `wait-for` in it has heard."""


def waits_of(method: nodes.Method) -> list[nodes.WaitFor]:
    """Return what a method, or a step of it, waits for, in the order of the text."""
    if isinstance(method.body, nodes.Skills):
        return list(method.body.waits)
    steps = method.body.steps if isinstance(method.body, nodes.TaskNet) else ()
    notes = [note for step in steps for note in step.annotations]
    return [note for note in notes if isinstance(note, nodes.WaitFor)]


class HeardSignals:
    """Follows the events of runs of one library.

    Args:
        library: the library.
    """

    def __init__(self, library: Library) -> None:
        self._skilled = {
            (rap.name, traced_name(method))
            for rap in library.raps.values()
            for method in rap.methods
            if isinstance(method.body, nodes.Skills)
        }
        self._raps: dict[int, str] = {}
        self._methods: dict[int, str] = {}
        self._parents: dict[int, int | None] = {}
        self._signal: str | None = None

    def heard(self, event: events.Event) -> Heard | None:
        """Take one event in; return what it shows to have been heard, if anything."""
        match event:
            case events.TaskCreated():
                self._raps[event.task] = event.goal.name
                self._parents[event.task] = event.parent
            case events.MethodChosen():
                self._methods[event.task] = event.method
            case events.SignalReceived():
                self._signal = str(event.what[0])
            case events.TaskSelected():
                self._signal = None
            case events.TaskWoken() if event.on.startswith("(:"):
                return self._in_method_of(self._parents.get(event.task))
            case events.TaskFailed() | events.TaskSucceeded():
                return self._in_method_of(self._parents.get(event.task))
            case events.MethodEnded():
                found = self._in_method_of(event.task)
                return found if found and found[:2] in self._skilled else None
            case _:
                pass
        return None

    def _in_method_of(self, task: int | None) -> Heard | None:
        if self._signal is None or task is None:
            return None
        return self._raps[task], self._methods[task], self._signal
