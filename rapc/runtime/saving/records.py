"""What a saved run holds, as records that msgspec writes and reads.

Tasks stand in one list, each after the task whose method it is a step of. Whatever is
shared (environments, sets, counters) stands in a list of its own and is spoken of by
its place there. Plans are named: a RAP by its name, a method and a step by position.
"""

from __future__ import annotations

import msgspec

from rapc.base.chance import Stream
from rapc.base.values import Atom, Fact, Number, Text
from rapc.events import Cause
from rapc.ir.nodes import Method
from rapc.runtime.memory.saving import MemoryState
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest
from rapc.world import Time


class Ref(msgspec.Struct, frozen=True, tag="resource"):
    """A set or counter, by its place among `RunRecord.resources`."""

    at: int


class Parts(msgspec.Struct, frozen=True, tag="list"):
    """A tuple in a detector's key or in an identity."""

    parts: tuple[str | int | float | Text | Parts | Members | None, ...]


class Members(msgspec.Struct, frozen=True, tag="members"):
    """What a set held when a detector saw it; in a fixed order."""

    members: tuple[str | int | float | Text, ...]


Saved = str | int | float | Text | Ref | None
"""A value of a variable; None for an input that is not known."""

Frozen = str | int | float | Text | Parts | Members | None
"""A part of a detector's key: resources by what they held."""


class CounterRecord(msgspec.Struct, frozen=True, tag="counter"):
    """A counter."""

    value: Number


class SetRecord(msgspec.Struct, frozen=True, tag="set"):
    """A set; members in the order in which they were added."""

    members: tuple[Atom, ...]


class WaitRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `WaitState`; deadlines that are not stated, and no timer, are None."""

    #: The positions of the windows that are not yet fixed, among those of the step.
    windows: tuple[int, ...] = ()
    earliest_start: Time = 0
    awaits_signal: bool = False
    ready_at: Time = 0
    made: Time = 0
    keys: tuple[tuple[Atom, ...] | Ref, ...] | None = None
    timer: Time | None = None
    blocked_on: str = ""
    formula: str | None = None
    given_deadline: Time | None = None
    monitor_deadline: Time | None = None
    missed: Time | None = None
    first_selected: bool = False
    after_method: bool = False
    prepared: bool = False
    setup_failed: bool = False
    duration: Time = 0


class AskRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A thing that is held or waited for; `said` where it has no name."""

    thing: Fact
    priority: int
    used: bool
    said: str = ""


class ThingWaitRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `ThingWait`."""

    alternatives: tuple[tuple[AskRecord, ...], ...]
    on: str
    holder: int
    woken: bool = False
    #: Which of the skills of its method are off.
    skills: tuple[int, ...] = ()


class HistoryRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `History`; `success` is an environment by its place."""

    choices: tuple[tuple[Parts, int], ...] = ()
    #: How often each method was chosen, by index; other choices may be forgotten.
    tries: tuple[tuple[int, int], ...] = ()
    #: The place in `choices` of the last choice, if it is still counted.
    last_choice: int | None = None
    #: The method tried before the one tried last, by position.
    before: int | None = None
    results: tuple[tuple[Atom | None, str | None], ...] = ()
    failures: tuple[tuple[int, int], ...] = ()
    failure: str | None = None
    success: int | None = None
    because: Cause | None = None


class MethodRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `MethodRun`: the method by position, the environment and the steps by place."""

    method: int
    env: int
    started: Time
    steps: tuple[int, ...] = ()
    steps_left: int = 0
    #: When each step ended, if that is asked; then also which were ended by `until`.
    ends: tuple[Time | None, ...] | None = None
    ended_by_until: tuple[int, ...] = ()
    notations: tuple[Fact, ...] = ()
    #: Its skills as they were filled in.
    skills: tuple[Fact, ...] = ()
    ticket: int | None = None
    held: tuple[AskRecord, ...] = ()


class TaskRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `Task`. Of a step that has ended there is no more than its number."""

    rap: str
    number: int
    state: str
    env: int = -1
    family: int = 0
    priority: int = 0
    #: The nearest deadline of its own and its ancestors', if there is one.
    limit: Time | None = None
    #: How many steps it still follows.
    waiting: int = 0
    inputs: tuple[Saved, ...] = ()
    identity: Parts | None = None
    #: The method tried last, by position.
    method: int | None = None
    choice: Parts | None = None
    last_result: str | None = None
    history: HistoryRecord | None = None
    wait: WaitRecord | None = None
    #: What a thing keeps it waiting for.
    things: ThingWaitRecord | None = None
    run: MethodRecord | None = None


class TopRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """A `TopLevelTask`: the task and the outputs (an environment) by place."""

    task: int
    background: bool
    outcome: str | None = None
    outputs: int = -1
    because: Cause | None = None
    came: Time = 0
    ended: Time | None = None


class ActivationRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """An `Activation` whose signals may still come."""

    ticket: int
    owner: int
    #: The owner or, if that has ended, the nearest ancestor that has not; or None.
    task: int | None
    skills: tuple[Fact, ...]
    #: Whether it is on, for the method that the task is at work on.
    on: bool = True


class AgendaRecord(msgspec.Struct, frozen=True):
    """The agenda: tasks by number."""

    #: The families that were chosen, each with the priority it was chosen under.
    stack: tuple[tuple[int, int], ...]
    last_family: int | None
    #: The task that is alone on the agenda, not yet sorted in.
    sole: int | None
    #: The tasks that are sorted in, each with its latest start (None: never too late)
    #: and whether it had failed.
    sorted: tuple[tuple[int, Time | None, bool], ...]


class MonitorsRecord(msgspec.Struct, frozen=True):
    """What the monitors hold that the tasks themselves do not say; tasks by number."""

    to_test: tuple[int, ...]
    aging: tuple[int, ...]
    tested_at: Time
    deadlines: tuple[tuple[Time, int], ...]
    missed: tuple[tuple[int, tuple[Time, ...]], ...]
    #: The tasks whose way may have become another, and how often a world has told of
    #: a conflict.
    ways: tuple[int, ...] = ()
    conflicts: int = 0


class CountsRecord(msgspec.Struct, frozen=True):
    """The counts and flags of a `RunState` and of the recorder."""

    time: Time
    cycle: int
    serial: int
    numbers: int
    tickets: int
    requests: int
    succeeded: int
    idle: int
    waits: int
    until: Time | None
    past_until: bool
    started: bool
    over: bool
    reason: str | None


COUNTS = CountsRecord.__struct_fields__[3:]
"""What of it a `RunState` has under the same names."""


class RunRecord(msgspec.Struct, frozen=True):
    """A whole run."""

    #: The digest of the library's sources.
    library: str
    #: What the world is called.
    world_name: str
    #: The options that the world was made with, if that is known.
    options: dict[str, str | int | float | bool]
    settings: Settings
    seed: int
    #: The state of the interpreter's random stream.
    random: Stream
    counts: CountsRecord
    #: The methods that solvers have added, in order, each with its RAP.
    added_methods: tuple[tuple[str, Method], ...]
    resources: tuple[CounterRecord | SetRecord, ...]
    environments: tuple[dict[str, Saved], ...]
    tasks: tuple[TaskRecord, ...]
    top_level: tuple[TopRecord, ...]
    scheduled: tuple[tuple[Time, int, TaskRequest], ...]
    #: Requests under way: ticket, task (None once it has left), what was asked.
    pending: tuple[tuple[int, int | None, Fact], ...]
    #: The activations that are on, then those that went off; each by ticket.
    activations: tuple[ActivationRecord, ...]
    #: The steps that wait for a signal, by its name.
    listening: tuple[tuple[str, tuple[int, ...]], ...]
    agenda: AgendaRecord
    monitors: MonitorsRecord
    memory: MemoryState
    #: What the world says of itself.
    world: bytes
