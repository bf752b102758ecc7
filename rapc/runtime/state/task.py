"""Tasks and the methods they are carrying out: state only, no behaviour of its own.

What happens to a task in a cycle is in `rapc.runtime.tasks.cycle`, what happens when
something ends in `rapc.runtime.tasks.finish` (T 3.4.1, semantics 3). A task is made for
every step of every method, so what few tasks have stands apart: `WaitState` for times,
signals and monitors, `History` from the second method or the first failure on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rapc.base.resources import Counter, SetResource, Value
from rapc.compiler.net_plan import StepPlan, WindowPlan
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.watches import WatchKey
from rapc.ir import nodes
from rapc.runtime.events.events import Goal
from rapc.runtime.memory.notations import Notation
from rapc.runtime.state.states import ENDED, WAITING
from rapc.world import OKAY, Time

Env = dict[str, Value]
"""Variables and what they are bound to."""


def as_told(env: Env) -> dict[str, Any]:
    """Return a copy of bindings, with sets and counters as they are now, in words."""
    return {
        name: str(value) if isinstance(value, _RESOURCES) else value
        for name, value in env.items()
    }


_RESOURCES = (Counter, SetResource)


class WaitState:
    """What a task may have to wait for besides its turn, and what its inputs make.

    `opens` is the latest start of its windows, `windows` those whose times are not
    yet known; `held` is set while it waits for a signal. `ready_at` is when its
    monitored time comes, counted from when it was `made` at first; `keys` are the
    changes it listens to, None before it does. `timer` is the time it waits for now,
    `blocked_on` what the trace says of it, `formula` its monitor's in words, if that
    stays as it is. The deadlines are those given by windows or a host, by
    `monitor-time`, and the one last told of as missed. `begun` is set once it was
    selected with its monitors holding, `after_method` while it is to come up whatever
    its monitors say. `prepared` says that resources and times are made of its inputs,
    `spoilt` that they could not be.
    """

    __slots__ = (
        "after_method",
        "awaits_signal",
        "blocked_on",
        "duration",
        "earliest_start",
        "first_selected",
        "formula",
        "given_deadline",
        "keys",
        "made",
        "missed",
        "monitor_deadline",
        "prepared",
        "ready_at",
        "setup_failed",
        "timer",
        "windows",
    )

    def __init__(self, windows: tuple[WindowPlan, ...] = ()) -> None:
        self.windows = windows
        self.earliest_start: Time = 0
        self.awaits_signal = False
        self.ready_at: Time = 0
        self.made: Time = 0
        self.keys: tuple[WatchKey, ...] | None = None
        self.timer: Time | None = None
        self.blocked_on = ""
        self.formula: str | None = None
        self.given_deadline: float = math.inf
        self.monitor_deadline: float = math.inf
        self.missed: float | None = None
        self.first_selected = False
        self.after_method = False
        self.prepared = False
        self.setup_failed = False
        self.duration: Time = 0

    @property
    def deadline(self) -> float:
        """The deadline that the task itself states: by window, monitor or host."""
        return min(self.given_deadline, self.monitor_deadline)


class History:
    """What the methods of a task have come to: results by name, failures by index.

    `choices` counts what the futile-loop detector has seen, from the second choice on.
    `failure` is the last failure symbol from the world, `success` the environment of
    the last method that ended well, for a task with outputs.
    """

    __slots__ = ("choices", "failure", "failures", "results", "success")

    def __init__(self) -> None:
        self.choices: dict[tuple[object, ...], int] = {}
        self.results: dict[object, str | None] = {}
        self.failures: dict[int, int] = {}
        self.failure: str | None = None
        self.success: Env | None = None


class TopLevelTask:
    """What a top-level task has besides: `outcome` is `okay` or what it handed up.

    It is None unless the task has ended by itself; so are the `outputs`.
    """

    __slots__ = ("background", "outcome", "outputs", "task")

    def __init__(self, task: Task, background: bool) -> None:
        self.task = task
        self.background = background
        self.outcome: str | None = None
        self.outputs: Env = {}


class Task:
    """One goal under way; it has no number until it joins the run.

    `goal_args` are its inputs as far as they are known, `env` holds them and its
    resources by name. `identity` is set with the last input, and is the RAP with its
    input values where a recursion test needs them; `family` is the number of its
    top-level task; `limit` the nearest deadline of its own and its ancestors'.
    `waiting` counts the steps that it still follows. `method` is the one tried last,
    `choice` the first that its futile-loop detector has seen. `wait` and `history` are
    None for most; `told` is the goal, once an event holds it and if it stays as it is.
    """

    __slots__ = (
        "choice",
        "env",
        "family",
        "goal_args",
        "held_at",
        "history",
        "identity",
        "last_result",
        "limit",
        "method",
        "number",
        "plan",
        "priority",
        "run",
        "state",
        "step",
        "told",
        "wait",
        "waiting",
        "within",
    )

    def __init__(
        self, plan: RapPlan, within: MethodRun | None, step: StepPlan | None
    ) -> None:
        self.plan = plan
        self.within = within
        self.step = step
        self.number = 0
        if within is None or step is None:
            self.family: int = 0
            self.limit: float = math.inf
            self.priority = 0
            self.waiting = 0
            self.wait = WaitState() if plan.waits else None
        else:
            parent = within.task
            self.family = parent.family
            self.limit = parent.limit
            self.priority = parent.priority + step.priority
            self.waiting = step.before
            waits = plan.waits or step.has_timing
            self.wait = WaitState(step.windows) if waits else None
        self.goal_args: tuple[Value | None, ...] = ()
        self.env: Env = {}
        self.identity: tuple[object, ...] | None = plan.known
        self.state = WAITING
        self.run: MethodRun | None = None
        self.method: MethodPlan | None = None
        self.history: History | None = None
        self.choice: tuple[object, ...] | None = None
        self.last_result: str | None = None
        self.told: Goal | None = None
        #: `Monitors.changes` when its constraints, and those above, last held.
        self.held_at = -1

    @property
    def parent(self) -> Task | None:
        """The task whose method it is a step of; None for a top-level task."""
        return None if self.within is None else self.within.task

    @property
    def bound(self) -> bool:
        """Whether all its inputs are known."""
        return None not in self.goal_args

    @property
    def constrained(self) -> Task | None:
        """The nearest ancestor that states constraints."""
        return None if self.within is None else self.within.constrained

    @property
    def live(self) -> bool:
        """Whether the task has not ended and was not removed."""
        return self.state is not ENDED

    @property
    def failed(self) -> bool:
        """Whether one of its methods has ended badly."""
        return self.history is not None and bool(self.history.failures)

    @property
    def world_failure(self) -> str | None:
        """The last failure symbol from the world that has reached it."""
        return None if self.history is None else self.history.failure

    # --- history ---------------------------------------------------------------

    def begin_method(self, method: MethodPlan) -> None:
        """A method is tried that is not the one tried last."""
        if self.method is not None:
            self.remember().results.setdefault(method.node.name)
        self.method = method

    def note_result(self, method: MethodPlan, result: str) -> None:
        """A method has come to a result, which is to be remembered."""
        history = self.remember()
        history.results[method.node.name] = result
        if result != OKAY:
            failures = history.failures
            failures[method.index] = failures.get(method.index, 0) + 1

    def remember(self) -> History:
        """The history, written from the method tried so far if there is none."""
        if self.history is None:
            self.history = History()
            if self.method is not None:
                self.history.results[self.method.node.name] = self.last_result
        return self.history

    def has_tried(self, name: object) -> bool:
        """Whether a method of that name was tried."""
        if self.history is not None:
            return name in self.history.results
        return self.method is not None and self.method.node.name == name

    def result_of(self, name: object) -> str | None:
        """What the last method of that name has come to, None if there is none."""
        if self.history is not None:
            return self.history.results.get(name)
        return self.last_result if self.has_tried(name) else None

    def failures_of(self, method: MethodPlan) -> int:
        """How often a method has ended badly."""
        history = self.history
        return 0 if history is None else history.failures.get(method.index, 0)

    # --- the futile-loop detector (T 3.2.5) ------------------------------------

    def times_chosen(self, key: tuple[object, ...]) -> int:
        """How often a choice was made since the detector started afresh."""
        if self.history is not None and self.history.choices:
            return self.history.choices.get(key, 0)
        return 1 if self.choice == key else 0

    @property
    def choices(self) -> int:
        """How often a method was chosen since the detector started afresh."""
        if self.history is not None and self.history.choices:
            return sum(self.history.choices.values())
        return 0 if self.choice is None else 1

    def note_choice(self, key: tuple[object, ...]) -> None:
        """A choice is made; only from the second on they need a table."""
        if self.choice is None:
            self.choice = key
            return
        choices = self.remember().choices
        if not choices:
            choices[self.choice] = 1
        choices[key] = choices.get(key, 0) + 1

    def forget_choices(self) -> None:
        """The detector starts afresh."""
        self.choice = None
        if self.history is not None:
            self.history.choices.clear()

    # --- as events tell of it ----------------------------------------------------

    def goal(self, outputs: Mapping[str, Value] | None = None) -> Goal:
        """Return the goal with the inputs that are known, and `outputs` if given."""
        if self.told is None or self.plan.outputs:
            return self._goal(outputs)
        return self.told

    def _goal(self, outputs: Mapping[str, Value] | None) -> Goal:
        inputs = []
        terms = self.step.node.goal.args if self.step is not None else ()
        for at, name in enumerate(self.plan.inputs):
            value = self.env.get(name) if self.bound else None
            if value is None and at < len(self.goal_args):
                value = self.goal_args[at]
            if value is None:
                env = self.within.env if self.within is not None else {}
                inputs.append(_told(terms[at], env))
            else:
                inputs.append(str(value) if isinstance(value, _RESOURCES) else value)
        found = as_told(dict(outputs)) if outputs else {}
        named = tuple([found.get(name, name) for name in self.plan.outputs])
        goal = Goal(self.plan.name, tuple(inputs), named)
        if self.bound and not self.has_resources():
            self.told = goal
        return goal

    def has_resources(self) -> bool:
        """Whether it has sets or counters, or was given some."""
        return any(isinstance(value, _RESOURCES) for value in self.env.values())


def _told(term: nodes.Term, env: Env) -> Any:
    """A term as a value: computed ones as lists, unbound variables by their names."""
    if isinstance(term, nodes.Const):
        return term.value
    if isinstance(term, nodes.Var):
        value = env.get(term.name, term.name)
        return str(value) if isinstance(value, _RESOURCES) else value
    return (term.function, *[_told(arg, env) for arg in term.args])


class Ends:
    """How steps of a method have ended, where something depends on it.

    `times` holds when each of them did, None while it has not; `lapsed` are those that
    an `until` has ended.
    """

    __slots__ = ("ended_by_until", "times")

    def __init__(self, steps: int) -> None:
        self.times: list[Time | None] = [None] * steps
        self.ended_by_until: set[int] = set()


class MethodRun:
    """A method while it is carried out.

    `env` is the method's environment: what the task had, what the choice bound, then
    what `for` formulas and outputs add; it is the task's own where nothing can be
    added. `left` counts the steps that have not ended. `constrained` is the nearest
    task that states constraints, its own or above it; `guarded` says whether these or
    others keep steps from being carried out.
    """

    __slots__ = (
        "constrained",
        "ends",
        "env",
        "has_conditions",
        "notations",
        "plan",
        "started",
        "steps",
        "steps_left",
        "task",
        "ticket",
    )

    def __init__(self, task: Task, plan: MethodPlan, env: Env, started: Time) -> None:
        self.task = task
        self.plan = plan
        self.env = env
        self.started = started
        self.steps: list[Task] | tuple[()] = ()
        self.steps_left = left = plan.size
        self.ends = Ends(left) if plan.tracks_step_ends else None
        self.notations: tuple[Notation, ...] = ()
        self.ticket: int | None = None
        outer = task.within
        if task.plan.constraints is not None:
            self.constrained: Task | None = task
        else:
            self.constrained = None if outer is None else outer.constrained
        self.has_conditions = plan.conditions or self.constrained is not None

    def was_ended_by_until(self, position: int) -> bool:
        """Whether a step was ended by an `until`."""
        return self.ends is not None and position in self.ends.ended_by_until
