"""What happens in a run, one frozen record per kind of event.

The fields are the keys of the trace format (`docs/trace.md`) after `event`, `n`,
`cycle` and `time`. An event's name in the trace is its tag.

Events hold values: goals, facts, bindings. A value is a symbol or a string of the
language (`str`, `Text`), a number, or a tuple for a list; a variable that has no value
stands as its name, and a set or counter as it was then, in words.

This is the one list of events: each says which of its fields a trace writes as text and
what a trace for people writes in a line. Traces themselves are in
`rapc.runtime.events.trace`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import msgspec

from rapc.base.values import Atom, Fact, format_atom, format_list, readable
from rapc.base.visible import visible
from rapc.spec import RunSpec


def _kebab(name: str) -> str:
    words = ["-" + c.lower() if c.isupper() else c for c in name]
    return "".join(words).lstrip("-")


class Goal:
    """What a task is to do; immutable. `str` gives RAP text: `(find box => ?place)`."""

    __slots__ = ("inputs", "name", "outputs", "text")

    def __init__(
        self, name: str, inputs: tuple[Any, ...] = (), outputs: tuple[Any, ...] = ()
    ) -> None:
        #: The name of the RAP.
        self.name = name
        #: A value for each input: see the head of this module.
        self.inputs = inputs
        #: A value, or the name of the variable, for each output of the RAP.
        self.outputs = outputs
        #: It as RAP text, once somebody has asked: many events tell of one goal.
        self.text: str | None = None

    @property
    def parts(self) -> tuple[Any, ...]:
        """The name, the inputs, and behind `=>` the outputs, if the RAP has any."""
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
    """What became of a set or counter."""

    #: `set-add`, `set-sub`, `counter-add` or `counter-sub`.
    op: str
    amount: Atom
    #: The set or counter as it is after the change, in words: `#counter(3)`.
    resource: str

    def __str__(self) -> str:
        return f"{self.op} {format_atom(self.amount)}: {self.resource}"


class Cause(msgspec.Struct, frozen=True, omit_defaults=True):
    """Why a task has failed or a method ended badly; all of it text."""

    #: The clause in words, with what it belongs to: "preconditions of `fetch`".
    clause: str
    #: Where it, or the part, stands: file and line; empty where there is no text.
    place: str = ""
    #: The first part of the clause without a solution, as it is written.
    part: str = ""
    #: What is wrong with it, where that is more than that it does not hold.
    note: str = ""
    #: What the variables of the part were bound to then.
    bindings: Mapping[str, str] = {}
    #: Where there was no method: for each one what ruled it out.
    methods: tuple[Cause, ...] = ()
    #: The number of the task of a step that failed.
    task: int | None = None
    #: How many causes are left out between this one and the next.
    skipped: int = 0
    #: What it came from: why the step's task failed, or the method tried last.
    because: Cause | None = None

    def short(self) -> Cause:
        """Return the cause with its file, but not with the folders of that."""
        file = self.place.replace("\\", "/").rpartition("/")[2]
        return msgspec.structs.replace(self, place=file)

    def line(self) -> str:
        """Return the cause on one line, without what it came from."""
        at = f" at {self.place}" if self.place else ""
        said = self.part
        if self.bindings:
            pairs = " ".join(f"{name} {value}" for name, value in self.bindings.items())
            said = f"{said} with {pairs}" if said else f"with {pairs}"
        note = self.note or ("does not hold" if self.part else "")
        said = ", ".join(one for one in (said, note) if one)
        return f"{self.clause}{at}: {said}" if said else f"{self.clause}{at}"


Write = Callable[[Any], Any]
"""Returns the text that a trace has for a value."""


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
"""How a trace writes values as text, by the types of fields of events.

Goals need no row: the encoder writes as text what it does not know.
"""


class Event(msgspec.Struct, frozen=True, tag_field="event", tag=_kebab, kw_only=True):
    """The base of all events. `n` is a serial from 0; `time` in time units."""

    n: int
    cycle: int
    time: int | float

    def line(self) -> str | None:
        """Return what a trace for people writes, without the time; None for nothing."""
        return None


class RunStarted(Event, frozen=True, kw_only=True):
    """The first event; `format` is the version of the trace format.

    The tasks of an agenda are among those of the `spec`, which holds all settings.
    """

    format: int
    spec: RunSpec

    def line(self) -> str:  # noqa: D102  # see `Event`
        spec = self.spec
        tasks = ", ".join(spec.tasks) or "no task"
        library = visible(spec.library)
        return f"run of {library} in {spec.world}, seed {spec.seed}: {tasks}"


class TaskCreated(Event, frozen=True, kw_only=True):
    """A task joined the agenda. `family` is the number of its top-level task."""

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
    """The agenda chose a task."""

    task: int
    goal: Goal

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"--> considering {self.goal} [{self.task}]"


class MethodChosen(Event, frozen=True, kw_only=True):
    """A task starts a method, with the bindings it was chosen under."""

    task: int
    rap: str
    method: str
    bindings: Mapping[str, Any]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... method {self.method} of {self.rap} [{self.task}]"


class MethodEnded(Event, frozen=True, kw_only=True):
    """A method ended; `result` is `okay` or what failed it."""

    task: int
    method: str
    result: str
    because: Cause | None = None


class TaskBlocked(Event, frozen=True, kw_only=True, omit_defaults=True):
    """A task cannot go on until what `on` says; `holder` is who has it, if a thing."""

    task: int
    on: str
    holder: int | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        if self.holder is None:
            return f"    ... blocked until {self.on} [{self.task}]"
        held = f"held by [{self.holder}]"
        return f"    ... waits for {self.on}, {held} [{self.task}]"


class TaskWoken(Event, frozen=True, kw_only=True, omit_defaults=True):
    """What a task waited for has come; `holder` had it, if it is a thing."""

    task: int
    on: str
    holder: int | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... woken by {self.on} [{self.task}]"


class Deadlock(Event, frozen=True, kw_only=True):
    """A deadlock: each of `tasks` waits for a thing held above the next of them.

    The last waits for the first; it is the task that has just been blocked that comes
    first. `waiting` has a line for each task.
    """

    tasks: tuple[int, ...]
    waiting: tuple[str, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... deadlock: {'; '.join(self.waiting)}"


class MethodSuspended(Event, frozen=True, kw_only=True):
    """A method is gone as if never chosen: the task `by` takes the thing `for`.

    Its task is blocked until it can have again what the method had asked for.
    """

    task: int
    method: str
    for_: str = msgspec.field(name="for")
    by: int

    def line(self) -> str:  # noqa: D102  # see `Event`
        taken = f"{self.for_} of [{self.by}]"
        return f"    ... method {self.method} suspended for {taken} [{self.task}]"


class TaskSucceeded(Event, frozen=True, kw_only=True):
    """A task ended well."""

    task: int
    goal: Goal
    outputs: Mapping[str, Any]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... task accomplished {self.goal} [{self.task}]"


class TaskFailed(Event, frozen=True, kw_only=True):
    """A task failed; `result` is what its parent sees."""

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
        below = " " * 16
        lines = [told, f"{below}because of {self.because.short().line()}"]
        for ruled_out in self.because.methods:
            lines.append(f"{below}  {ruled_out.short().line()}")
        return "\n".join(lines)


class TaskRemoved(Event, frozen=True, kw_only=True):
    """A task left the agenda without ending by itself."""

    task: int
    cause: str

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... removing task [{self.task}] ({self.cause})"


class PrimitiveRequested(Event, frozen=True, kw_only=True):
    """A request went to the world: memory names, and sensor names as sent."""

    task: int
    request: Fact
    sent: Fact


class PrimitiveEnded(Event, frozen=True, kw_only=True):
    """A primitive ended and its handlers have changed what they change."""

    task: int | None
    request: Fact
    result: str
    data: tuple[Fact, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        request = format_list(self.request)
        return f"    ... primitive operation {request} - {self.result}"


class PrimitiveCancelled(Event, frozen=True, kw_only=True):
    """What was under way is wanted no more; told before what follows from it."""

    task: int
    request: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... primitive operation {format_list(self.request)} - cancelled"


class RequestRefused(Event, frozen=True, kw_only=True):
    """The world will not carry a request out beside others: names as requested."""

    task: int
    request: Fact
    sent: Fact
    #: Why, in the world's words; None where it gives no reason.
    because: str | None = None

    def line(self) -> str:  # noqa: D102  # see `Event`
        reason = f": {self.because}" if self.because else ""
        request = format_list(self.request)
        return f"    ... primitive operation {request} - refused{reason}"


class SkillEnabled(Event, frozen=True, kw_only=True):
    """A skill of an activation of `task` is on from now."""

    task: int
    what: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... skill {format_list(self.what)} enabled [{self.task}]"


class SkillDisabled(Event, frozen=True, kw_only=True):
    """A skill of an activation of `task` is wanted no more."""

    task: int
    what: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... skill {format_list(self.what)} disabled [{self.task}]"


class DataReceived(Event, frozen=True, kw_only=True):
    """A datum came unasked."""

    data: Fact


class FactAsserted(Event, frozen=True, kw_only=True):
    """A fact was asserted or refreshed."""

    fact: Fact
    by: str


class FactErased(Event, frozen=True, kw_only=True):
    """A fact went."""

    fact: Fact
    by: str


class ResourceChanged(Event, frozen=True, kw_only=True):
    """A set or counter changed; `what` is the effect and the new value."""

    task: int
    what: ResourceChange

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... {self.what} [{self.task}]"


class SignalReceived(Event, frozen=True, kw_only=True, tag="signal"):
    """A signal came; `task` has the oldest activation under which it arose, if any.

    The task may have ended.
    """

    task: int | None
    what: Fact

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... signal {format_list(self.what)}"


class RuleRun(Event, frozen=True, kw_only=True):
    """A rule over memory acts, for `what`: a result at the end of `task`, or a signal.

    `at` is where the query and the actions stand, `doors.rap:12`.
    """

    task: int | None
    what: str | Fact
    at: str


class QueryFaulted(Event, frozen=True, kw_only=True):
    """A query met an unbound variable or a value of the wrong kind."""

    task: int | None
    what: str

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... query fault: {self.what}"


class ItemEvent(Event, frozen=True, kw_only=True):
    """What the events about introduced items have in common; `sensor` may be lost.

    `with` is the name that `item` now stands for too, if descriptions were merged;
    `score` how well they match, and `rival` how well the best other candidate does.
    """

    item: str
    sensor: str | None
    kind: str = msgspec.field(name="class")
    location: Atom
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

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"--> switching family from [{self.from_}] to [{self.to}]"


class DeadlineMissed(Event, frozen=True, kw_only=True):
    """The clock has passed a task's deadline."""

    task: int
    deadline: int | float

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... deadline {readable(self.deadline)} missed [{self.task}]"


class SolverCalled(Event, frozen=True, kw_only=True):
    """A problem solver was asked and returned so many methods."""

    task: int
    goal: Goal
    methods: int

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"    ... problem solver for {self.goal}: {self.methods} methods"


class TaskResult(msgspec.Struct, frozen=True, omit_defaults=True):
    """The end of a top-level task: `succeeded`, `failed`, `cancelled`, `unfinished`."""

    task: int
    goal: Goal
    outcome: str
    result: str | None
    background: bool
    #: When it came, and when it succeeded, failed or was cancelled; None before.
    came: int | float = 0
    ended: int | float | None = None
    #: Why it failed; None if it has not, or where nobody was told of it.
    because: Cause | None = None


class RunEnded(Event, frozen=True, kw_only=True):
    """The last event: why the run is over, and what became of each task given.

    `waiting` names the tasks that were left over, each with what it waited for;
    `because` is what a world said that ended the run.
    """

    reason: str
    because: str | None = None
    results: tuple[TaskResult, ...]
    waiting: tuple[str, ...]

    def line(self) -> str:  # noqa: D102  # see `Event`
        return f"run over: {self.reason}"


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
    """Return the keys that a trace has as text, each with how it is written."""
    return [
        (field.encode_name, _WRITES[field.type])
        for field in msgspec.structs.fields(kind)
        if field.type in _WRITES
    ]


@cache
def keys(kind: type[Event]) -> tuple[str, ...]:
    """Return the keys of a kind of event in a trace, those of all events first."""
    return tuple([field.encode_name for field in msgspec.structs.fields(kind)])
