"""What happens in a run, one frozen record per kind of event.

The fields are the keys of the trace format (`docs/trace.md`) after `event`, `n`,
`cycle` and `time`. Terms are RAP text. An event's name in the trace is its tag.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec


def _kebab(name: str) -> str:
    words = ["-" + c.lower() if c.isupper() else c for c in name]
    return "".join(words).lstrip("-")


class Event(msgspec.Struct, frozen=True, tag_field="event", tag=_kebab, kw_only=True):
    """The base of all events. `n` is a serial from 0; `time` in time units."""

    n: int
    cycle: int
    time: int | float


class RunStarted(Event, frozen=True, kw_only=True):
    """The first event; `format` is the version of the trace format."""

    format: int
    library: str
    world: str
    options: Mapping[str, str | int | float | bool]
    settings: Mapping[str, int | float]
    seed: int
    tasks: tuple[str, ...]
    faults: tuple[str, ...]


class TaskCreated(Event, frozen=True, kw_only=True):
    """A task joined the agenda. `family` is the number of its top-level task."""

    task: int
    goal: str
    parent: int | None
    family: int
    priority: int
    step: str | None


class TaskSelected(Event, frozen=True, kw_only=True):
    """The agenda chose a task."""

    task: int
    goal: str


class MethodChosen(Event, frozen=True, kw_only=True):
    """A task starts a method, with the bindings it was chosen under."""

    task: int
    rap: str
    method: str
    bindings: Mapping[str, str]


class MethodEnded(Event, frozen=True, kw_only=True):
    """A method ended; `result` is `okay` or what failed it."""

    task: int
    method: str
    result: str


class TaskBlocked(Event, frozen=True, kw_only=True):
    """A task cannot go on until what `on` says."""

    task: int
    on: str


class TaskWoken(Event, frozen=True, kw_only=True):
    """What a task waited for has come."""

    task: int
    on: str


class TaskSucceeded(Event, frozen=True, kw_only=True):
    """A task ended well."""

    task: int
    goal: str
    outputs: Mapping[str, str]


class TaskFailed(Event, frozen=True, kw_only=True):
    """A task failed; `result` is what its parent sees."""

    task: int
    goal: str
    reason: str
    result: str


class TaskRemoved(Event, frozen=True, kw_only=True):
    """A task left the agenda without ending by itself."""

    task: int
    cause: str


class PrimitiveRequested(Event, frozen=True, kw_only=True):
    """A request went to the world: memory names, and sensor names as sent."""

    task: int
    request: str
    sent: str


class PrimitiveEnded(Event, frozen=True, kw_only=True):
    """A primitive ended and its handlers have changed what they change."""

    task: int | None
    request: str
    result: str
    data: tuple[str, ...]


class DataReceived(Event, frozen=True, kw_only=True):
    """A datum came unasked."""

    data: str


class FactAsserted(Event, frozen=True, kw_only=True):
    """A fact was asserted or refreshed."""

    fact: str
    by: str


class FactErased(Event, frozen=True, kw_only=True):
    """A fact went."""

    fact: str
    by: str


class ResourceChanged(Event, frozen=True, kw_only=True):
    """A set or counter changed; `what` is the effect and the new value."""

    task: int
    what: str


class Signal(Event, frozen=True, kw_only=True):
    """A signal came; `task` is the one it was for, if it was for one alone."""

    task: int | None
    what: str


class QueryFaulted(Event, frozen=True, kw_only=True):
    """A query met an unbound variable or a value of the wrong kind."""

    task: int | None
    what: str


class ItemEvent(Event, frozen=True, kw_only=True):
    """What the events about introduced items have in common; `sensor` may be lost.

    `with` is the name that `item` now stands for too, if descriptions were merged;
    `score` how well they match, and `rival` how well the best other candidate does.
    """

    item: str
    sensor: str | None
    kind: str = msgspec.field(name="class")
    location: str
    with_: str | None = msgspec.field(name="with", default=None)
    score: int | float | None = None
    rival: int | float | None = None


class ItemIntroduced(ItemEvent, frozen=True, kw_only=True):
    """An item came into reach under a sensor name."""


class ItemMerged(ItemEvent, frozen=True, kw_only=True):
    """Two descriptions have turned out to be of one item."""


class ItemMoved(ItemEvent, frozen=True, kw_only=True):
    """An item is at another place than before."""


class ItemLost(ItemEvent, frozen=True, kw_only=True):
    """An item is not where it was: its location is `unknown`."""


class FamilySwitched(Event, frozen=True, kw_only=True):
    """The family chosen differs from the one chosen last."""

    task: int
    from_: int = msgspec.field(name="from")
    to: int


class DeadlineMissed(Event, frozen=True, kw_only=True):
    """The clock has passed a task's deadline."""

    task: int
    deadline: int | float


class SolverCalled(Event, frozen=True, kw_only=True):
    """A problem solver was asked and returned so many methods."""

    task: int
    goal: str
    methods: int


class TaskResult(msgspec.Struct, frozen=True):
    """What became of a top-level task: `succeeded`, `failed` or `unfinished`."""

    task: int
    goal: str
    outcome: str
    result: str | None
    background: bool


class RunEnded(Event, frozen=True, kw_only=True):
    """The last event: why the run is over, and what became of each task given.

    `waiting` names the tasks that were left over, each with what it waited for;
    `because` is what a world said that ended the run.
    """

    reason: str
    because: str | None = None
    results: tuple[TaskResult, ...]
    waiting: tuple[str, ...]
