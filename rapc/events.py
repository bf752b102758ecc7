"""Events of a run, one frozen record for each kind of event.

The fields are the keys of the trace format (`docs/reference/trace.md`) after `event`,
`n`, `cycle` and `time`. An event's name in the trace is its tag.

Events hold values: goals, facts, bindings. A value is a symbol or a string of the
language (`str`, `Text`), a number, or a tuple for a list; a variable without a value is
represented by its name, and a set or counter by a text with its contents at the time of
the event.

This is the only list of events: each event defines which of its fields a trace writes
as text, and its line in a trace for people. Traces themselves are in
`rapc.runtime.events.trace`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any

import msgspec

from rapc.base.names import plural
from rapc.base.values import Atom, Fact, format_atom, format_list, number, readable
from rapc.base.visible import visible
from rapc.spec import RunSpec


def _kebab(name: str) -> str:
    words = ["-" + c.lower() if c.isupper() else c for c in name]
    return "".join(words).lstrip("-")


class Goal:
    """The goal of a task; immutable. `str` returns RAP text: `(find box => ?place)`."""

    __slots__ = ("inputs", "name", "outputs", "text")

    def __init__(
        self, name: str, inputs: tuple[Any, ...] = (), outputs: tuple[Any, ...] = ()
    ) -> None:
        #: The name of the RAP.
        self.name = name
        #: A value for each input; see the head of this module.
        self.inputs = inputs
        #: A value, or the name of the variable, for each output of the RAP.
        self.outputs = outputs
        #: The goal as RAP text, cached at the first use: many events have the same
        #: goal.
        self.text: str | None = None

    @property
    def parts(self) -> tuple[Any, ...]:
        """Return the name, the inputs, and after `=>` the outputs, if any."""
        if not self.outputs:
            return (self.name, *self.inputs)
        return (self.name, *self.inputs, "=>", *self.outputs)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Goal) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash(self.parts)

    def __str__(self) -> str:
        if self.text is None:
            self.text = format_list(self.parts)
        return self.text

    def __repr__(self) -> str:
        return f"Goal{self.parts!r}"


class ResourceChange(msgspec.Struct, frozen=True):
    """A change of a set or counter."""

    #: `set-add`, `set-sub`, `counter-add` or `counter-sub`.
    op: str
    amount: Atom
    #: The set or counter after the change, as text: `#counter(3)`.
    resource: str

    def __str__(self) -> str:
        return f"{self.op} {format_atom(self.amount)}: {self.resource}"


class KnownFact(msgspec.Struct, frozen=True):
    """A fact in memory at the time of a failure."""

    #: The fact as RAP text.
    fact: str
    #: The time since its last assertion; None for a fact without a time.
    age: int | float | None

    @classmethod
    def at(cls, now: int | float, fact: Fact, since: int | float | None) -> KnownFact:
        """Return a fact as known at time `now`, last asserted at time `since`."""
        return cls(format_list(fact), None if since is None else number(now - since))

    def __str__(self) -> str:
        return (
            self.fact if self.age is None else f"{self.fact}, {readable(self.age)} old"
        )


class Cause(msgspec.Struct, frozen=True, omit_defaults=True):
    """The cause of a failure of a task or method."""

    #: The clause with its owner: "preconditions of `fetch`".
    clause: str
    #: The file and line of the clause or part; empty without a source text.
    place: str = ""
    #: The first part of the clause without a solution, as in the source.
    part: str = ""
    #: The error, if the part does not merely fail to hold.
    note: str = ""
    #: The bindings of the variables of the part at that time.
    bindings: Mapping[str, str] = {}
    #: The facts because of which the part does not hold.
    facts: tuple[KnownFact, ...] = ()
    #: The causes inside the part: of a named query, or of the branches of an `or`.
    inside: tuple[Cause, ...] = ()
    #: The reason against each excluded method, if there was no method or a futile one.
    methods: tuple[Cause, ...] = ()
    #: The number of the task of a step that failed.
    task: int | None = None
    #: The number of causes left out between this cause and the next.
    skipped: int = 0
    #: The underlying cause: of the step's task, or of the last method.
    because: Cause | None = None

    def short(self) -> Cause:
        """Return the cause with file names instead of paths."""
        return msgspec.structs.replace(
            self,
            place=self.place.replace("\\", "/").rpartition("/")[2],
            inside=tuple([one.short() for one in self.inside]),
            methods=tuple([method.short() for method in self.methods]),
        )

    def lines(self) -> Iterator[str]:
        """Yield the cause, the causes inside its part and the excluded methods."""
        yield self.line()
        for one in (*self.inside, *self.methods):
            yield from (f"  {line}" for line in one.lines())

    def line(self) -> str:
        """Return the cause on one line, without the underlying cause."""
        at = f" at {self.place}" if self.place else ""
        said = self.part
        if self.bindings:
            pairs = " ".join(f"{name} {value}" for name, value in self.bindings.items())
            said = f"{said} with {pairs}" if said else f"with {pairs}"
        note = self.note or ("does not hold" if self.part else "")
        if self.facts:
            note += f": memory has {'; '.join(map(str, self.facts))}"
        said = ", ".join(one for one in (said, note) if one)
        return f"{self.clause}{at}: {said}" if said else f"{self.clause}{at}"


Write = Callable[[Any], Any]
"""A function that returns the text of a value in a trace."""


def _facts(data: Iterable[Fact]) -> tuple[str, ...]:
    return tuple([format_list(fact) for fact in data])


def _bindings(bindings: Mapping[str, object]) -> dict[str, str]:
    return {name: format_atom(value) for name, value in bindings.items()}


def _result_or_signal(what: str | Fact) -> str:
    return what if isinstance(what, str) else format_list(what)


_WRITES: Mapping[Any, Write] = {
    Fact: format_list,
    tuple[Fact, ...]: _facts,
    str | Fact: _result_or_signal,
    Mapping[str, Any]: _bindings,
    Atom: format_atom,
    ResourceChange: str,
}
"""The writers of values in a trace, by the types of fields of events.

Goals need no row: the encoder writes values of unknown types as text.
"""


class Event(msgspec.Struct, frozen=True, tag_field="event", tag=_kebab, kw_only=True):
    """The base of all events. `n` is a serial from 0; `time` in time units."""

    n: int
    cycle: int
    time: int | float

    def line(self) -> str | None:
        """Return the line of a trace for people, without the time; None for no line."""
        return None


class RunStarted(Event, frozen=True, kw_only=True):
    """The first event; `format` is the version of the trace format.

    `spec` has all settings; its tasks include the tasks of an agenda.
    """

    format: int
    spec: RunSpec

    def line(self) -> str:  # noqa: D102  # see `Event`
        spec = self.spec
        tasks = ", ".join(spec.tasks) or "no task"
        library = visible(spec.library)
        return f"run of {library} in {spec.world}, seed {spec.seed}: {tasks}"


class TaskCreated(Event, frozen=True, kw_only=True):
    """A task joined the agenda.

    `family` is the number of the top-level task that the task works for. A top-level
    task has no `parent` and no `step` (the tag of the step).
    """

    task: int
    goal: Goal
    parent: int | None
    family: int
    priority: int
    step: str | None

    def line(self) -> str:  # noqa: D102  # see `Event`
        priority = f" priority {self.priority}" if self.priority else ""
        return f"    ... creating task {self.goal} [{self.task}]{priority}"


class TaskSelected(Event, frozen=True, kw_only=True):
    """The agenda selected a task: a cycle begins."""

    task: int
    goal: Goal

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"--> considering {self.goal} [{self.task}]"


class MethodChosen(Event, frozen=True, kw_only=True):
    """A task starts a method, with the bindings of the choice.

    `method` is the name of the method, or `#1`, `#2` by its position.
    """

    task: int
    rap: str
    method: str
    bindings: Mapping[str, Any]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... method {self.method} of {self.rap} [{self.task}]"


class MethodEnded(Event, frozen=True, kw_only=True):
    """A method ended; `result` is `okay` or the reason of the failure."""

    task: int
    method: str
    result: str
    because: Cause | None = None


class TaskBlocked(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A task is blocked until `on`: a formula, a time, a signal or a thing.

    `holder` is the task that holds the thing; the key is missing for other waits.
    """

    task: int
    on: str
    holder: int | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        if self.holder is None:
            return f"    ... blocked until {self.on} [{self.task}]"
        held = f"held by [{self.holder}]"
        return f"    ... waits for {self.on}, {held} [{self.task}]"


class TaskWoken(Event, frozen=True, kw_only=True, omit_defaults=True):
    """The condition of a blocked task is met; `holder` held the thing, if any."""

    task: int
    on: str
    holder: int | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... woken by {self.on} [{self.task}]"


class Deadlock(Event, frozen=True, kw_only=True):
    """Tasks wait for each other in a circle.

    Each of `tasks` waits for a thing of the next task or its ancestor; the last task
    waits for the first, which is the task that has just been blocked. `waiting` has a
    line for each task.
    """

    tasks: tuple[int, ...]
    waiting: tuple[str, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... deadlock: {'; '.join(self.waiting)}"


class MethodSuspended(Event, frozen=True, kw_only=True):
    """A method is suspended and undone: the task `by` takes the thing `for`.

    Its task is blocked until the task can hold again the things that the method
    claimed. The event replaces `method-ended` and `task-blocked`.
    """

    task: int
    method: str
    for_: str = msgspec.field(name="for")
    by: int

    def line(self) -> str:  # noqa: D102  # see `Event`
        taken = f"{self.for_} of [{self.by}]"
        return f"    ... method {self.method} suspended for {taken} [{self.task}]"


class TaskSucceeded(Event, frozen=True, kw_only=True):
    """A task succeeded."""

    task: int
    goal: Goal
    outputs: Mapping[str, Any]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... task accomplished {self.goal} [{self.task}]"


class TaskFailed(Event, frozen=True, kw_only=True):
    """A task failed; `result` is the failure as its parent sees it."""

    task: int
    goal: Goal
    reason: str
    result: str
    because: Cause | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        told = f"    ... goal failed ({self.reason}) - {self.result}: "
        told += f"{self.goal} [{self.task}]"
        if self.because is None:
            return told
        first, *rest = self.because.short().lines()
        below = [f"because of {first}", *rest]
        return "\n".join([told, *(" " * 16 + line for line in below)])


class TaskRemoved(Event, frozen=True, kw_only=True):
    """A task left the agenda without an end of its own.

    The descendants of the task are removed before the task.
    """

    task: int
    cause: str

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... removing task [{self.task}] ({self.cause})"


class PrimitiveRequested(Event, frozen=True, kw_only=True):
    """A request goes to the world.

    `request` has the memory names of items, `sent` the sensor names.
    """

    task: int
    request: Fact
    sent: Fact


class PrimitiveEnded(Event, frozen=True, kw_only=True):
    """A primitive ended, and its handlers have changed memory.

    `task` is null if the task was removed before.
    """

    task: int | None
    request: Fact
    result: str
    data: tuple[Fact, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        request = format_list(self.request)
        return f"    ... primitive operation {request} - {self.result}"


class PrimitiveCancelled(Event, frozen=True, kw_only=True):
    """A request was cancelled; the event precedes the consequences."""

    task: int
    request: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... primitive operation {format_list(self.request)} - cancelled"


class RequestRefused(Event, frozen=True, kw_only=True):
    """The world refused a request, or a skill, beside active requests.

    `because` is the world's reason, or null.
    """

    task: int
    request: Fact
    sent: Fact
    #: The world's reason; None without a reason.
    because: str | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        reason = f": {self.because}" if self.because else ""
        request = format_list(self.request)
        return f"    ... primitive operation {request} - refused{reason}"


class SkillEnabled(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A skill of an activation of `task` was switched on.

    Each skill of the activation has an event of its own, in the order of the text.
    `background` is true if the method does not wait for the skill; otherwise the key is
    missing.
    """

    task: int
    what: Fact
    background: bool = False

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... skill {format_list(self.what)} enabled [{self.task}]"


class SkillDisabled(Event, frozen=True, kw_only=True):
    """A skill of an activation of `task` was switched off."""

    task: int
    what: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... skill {format_list(self.what)} disabled [{self.task}]"


class DataReceived(Event, frozen=True, kw_only=True):
    """A datum was received without a request; its handler has run."""

    data: Fact


class FactAsserted(Event, frozen=True, kw_only=True):
    """A fact was asserted or refreshed."""

    fact: Fact
    by: str


class FactErased(Event, frozen=True, kw_only=True):
    """A fact was erased.

    An old value of a property is erased before the new value is asserted.
    """

    fact: Fact
    by: str


class Pictured(Event, frozen=True, kw_only=True):
    """The world's picture has changed; only with the setting `rapc.pictures`.

    `changed` has the parts that changed, as a JSON merge patch (RFC 7396); the first
    event has the whole picture.
    """

    changed: dict[str, Any]


class ResourceChanged(Event, frozen=True, kw_only=True):
    """A step changed a set or counter; `what` is the change and the new value."""

    task: int
    what: ResourceChange

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... {self.what} [{self.task}]"


class SignalReceived(Event, frozen=True, kw_only=True, tag="signal"):
    """A signal was received.

    `task` has the oldest of the activations under which the signal arose, even if the
    task has ended; null for a signal of no activation.
    """

    task: int | None
    what: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... signal {format_list(self.what)}"


class RuleRun(Event, frozen=True, kw_only=True):
    """A rule over memory ran, for a result or a signal.

    `what` is the result at the end of `task`, or the signal; `task` is null for a rule
    of no RAP. `at` is the position of the query and the actions, `doors.rap:12`, and
    `bindings` are the variables of the rule with the first solution of its query.
    """

    task: int | None
    what: str | Fact
    at: str
    bindings: Mapping[str, Any]


class QueryFaulted(Event, frozen=True, kw_only=True):
    """A query failed: an unbound variable, or a value of the wrong kind."""

    task: int | None
    what: str

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... query fault: {self.what}"


class ItemEvent(Event, frozen=True, kw_only=True):
    """The base of the events about introduced items; `sensor` may be lost.

    `with` is the second name of `item`, if descriptions were merged; `score` is the
    quality of the match, and `rival` the quality of the second-best match.
    """

    item: str
    sensor: str | None
    kind: str = msgspec.field(name="class")
    location: Atom
    with_: str | None = msgspec.field(name="with", default=None)
    score: int | float | None = None
    rival: int | float | None = None


class ItemIntroduced(ItemEvent, frozen=True, kw_only=True):
    """An item became accessible under a sensor name."""


class ItemMerged(ItemEvent, frozen=True, kw_only=True):
    """Two descriptions were recognised as one item.

    `item` is the older name, which stays; `with` is the name that is replaced.
    """


class ItemMoved(ItemEvent, frozen=True, kw_only=True):
    """An item has changed its place."""


class ItemLost(ItemEvent, frozen=True, kw_only=True):
    """An item is no longer at its place: its location is `unknown`."""


class FamilySwitched(Event, frozen=True, kw_only=True):
    """The selected family differs from the family selected before."""

    task: int
    from_: int = msgspec.field(name="from")
    to: int

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"--> switching family from [{self.from_}] to [{self.to}]"


class DeadlineMissed(Event, frozen=True, kw_only=True):
    """The clock has passed the deadline of a task; emitted once for a task."""

    task: int
    deadline: int | float

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... deadline {readable(self.deadline)} missed [{self.task}]"


class SolverCalled(Event, frozen=True, kw_only=True):
    """A problem solver was called and returned a number of methods."""

    task: int
    goal: Goal
    methods: int

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... problem solver for {self.goal}: {self.methods} methods"


class PlanLink(msgspec.Struct, frozen=True):
    """A fact that a step of a plan makes true for another step, or for the goal."""

    #: The tag of the other step; None for the goal.
    step: str | None
    #: The fact, as RAP text.
    fact: str

    def __str__(self) -> str:
        return f"for {self.step or 'the goal'}: {self.fact}"


class PlanStep(msgspec.Struct, frozen=True):
    """A step of a plan, with its purpose."""

    tag: str
    #: The goal of the step, as RAP text.
    goal: str
    links: tuple[PlanLink, ...]
    #: The tags of the other steps that only start after the end of this step.
    before: tuple[str, ...]

    @property
    def purpose(self) -> str:
        """Return the links and the order as text."""
        order = [f"before {', '.join(self.before)}"] if self.before else []
        return "; ".join([*map(str, self.links), *order])


class PlanMade(Event, frozen=True, kw_only=True):
    """The planner has looked for a method of a RAP with `(plan)` [L 10].

    `outcome` is `solved`, `unsolvable` or `limit`; `text` is the whole method. Each of
    `steps` has its `tag`, its `goal`, its `links` (a `fact`, and the tag of the `step`
    that needs the fact, null for the goal of the plan), and in `before` the tags of the
    steps that only start after its end. `expanded` is the number of states that the
    planner looked at, `left_out` the number of parts of RAPs that it did not see.
    `unreachable` has the parts of the goal that nothing brings about. `engine` is
    `builtin` or the engine that made the plan; `refused` is the reason why the answer
    of an engine was not used, or empty.
    """

    task: int
    goal: Goal
    outcome: str
    method: str | None
    text: str
    steps: tuple[PlanStep, ...]
    expanded: int
    left_out: int
    unreachable: tuple[str, ...]
    engine: str
    refused: str

    def line(self) -> str:  # noqa: D102  # see `Event`
        by = "" if self.engine == "builtin" else f" by {visible(self.engine)}"
        by += f" ({visible(self.refused)})" if self.refused else ""
        if self.method is None:
            missing = "".join(f" {one}" for one in self.unreachable)
            return f"    ... no plan for {self.goal}{by}: {self.outcome}{missing}"
        steps = plural(len(self.steps), "step")
        return f"    ... {self.method} for {self.goal}: {steps}{by}"


class TaskResult(msgspec.Struct, frozen=True, omit_defaults=True):
    """The end of a top-level task: `succeeded`, `failed`, `cancelled`, `unfinished`."""

    task: int
    goal: Goal
    outcome: str
    result: str | None
    background: bool
    #: The time of arrival, and the time of the end; None before the end.
    came: int | float = 0
    ended: int | float | None = None
    #: The cause of the failure; None without a failure, or if no listener received it.
    because: Cause | None = None


class RunEnded(Event, frozen=True, kw_only=True):
    """The last event: the reason of the end, and the result of each top-level task.

    `waiting` has a line for each deadlock and for each task that is left, with the
    condition that the task waits for. `because` explains the reasons `world`, `broken`,
    `runaway` and `stuck`; otherwise it is null.
    """

    reason: str
    because: str | None = None
    results: tuple[TaskResult, ...]
    waiting: tuple[str, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        because = f": {self.because}" if self.because else ""
        return f"run over: {self.reason}{because}"


@cache
def kinds() -> Mapping[str, type[Event]]:
    """Return the kinds of events by their names in a trace."""
    found: dict[str, type[Event]] = {}
    waiting = Event.__subclasses__()
    while waiting:
        kind = waiting.pop(0)
        waiting = [*kind.__subclasses__(), *waiting]
        if kind is not ItemEvent:
            found[str(kind.__struct_config__.tag)] = kind
    return found


def words(kind: type[Event]) -> list[tuple[str, Write]]:
    """Return the keys with text in a trace, each with its writer."""
    return [
        (field.encode_name, _WRITES[field.type])
        for field in msgspec.structs.fields(kind)
        if field.type in _WRITES
    ]


@cache
def keys(kind: type[Event]) -> tuple[str, ...]:
    """Return the keys of a kind of event in a trace, the common keys first."""
    return tuple([field.encode_name for field in msgspec.structs.fields(kind)])
