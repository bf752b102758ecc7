"""Tasks and their methods under way: state only, without behaviour.

`rapc.runtime.tasks.cycle` defines the cycle of a task, and `rapc.runtime.tasks.finish`
the consequences of an end [T 3.4.1; L 3]. The interpreter makes a task for every step
of every method. Therefore state that few tasks need is separate: a `WaitState` for
times, signals and monitors, a `History` from the second method or the first failure on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Fact, Text
from rapc.compiler.net_plan import StepPlan
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.events import Cause, Goal
from rapc.ir import nodes
from rapc.runtime.fields import LEFT_OUT, Fields, Limit, Natural
from rapc.runtime.memory.notations import Notation
from rapc.runtime.state.history import History
from rapc.runtime.state.states import ENDED, WAITING, State
from rapc.runtime.state.wait_state import WaitState
from rapc.world import OKAY, Time

Env = dict[str, Value]
"""Values of variables."""


def as_told(env: Env) -> dict[str, Any]:
    """Return a copy of bindings, with sets and counters as text."""
    if not env:
        return {}
    return {
        name: str(value) if isinstance(value, _RESOURCES) else value
        for name, value in env.items()
    }


@cache
def _bare_goal(name: str) -> Goal:
    """Return the goal of a RAP without inputs and outputs, shared by all its tasks."""
    return Goal(name)


_RESOURCES = (Counter, SetResource)


class Ends:
    """The ends of a method's steps, if a plan depends on them."""

    FIELDS: ClassVar[Fields] = {
        "times": list[Time | None],
        "ended_by_until": set[int],
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, steps: int) -> None:
        #: When each step ended; None before its end.
        self.times: list[Time | None] = [None] * steps
        #: The positions of the steps that an `until` has ended.
        self.ended_by_until: set[int] = set()


class MethodRun:
    """A method under way."""

    FIELDS: ClassVar[Fields] = {
        "task": LEFT_OUT,
        "plan": MethodPlan,
        "env": Env,
        "started": Time,
        "steps": LEFT_OUT,
        "steps_left": LEFT_OUT,
        "ends": Ends | None,
        "notations": tuple[Notation, ...],
        "skills": tuple[Fact, ...],
        "ticket": int | None,
        "constrained": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, task: Task, plan: MethodPlan, env: Env, started: Time) -> None:
        self.task = task
        self.plan = plan
        #: The environment of the task, the bindings of the choice, then those of `for`
        #: formulas and outputs; the task's own environment if the method can add
        #: nothing.
        self.env = env
        self.started = started
        #: The tasks of the steps, by position, with those that have ended.
        self.steps: list[Task] | tuple[()] = ()
        #: The number of steps that have not ended.
        self.steps_left = 0
        self.ends = Ends(len(plan.steps)) if plan.tracks_step_ends else None
        self.notations: tuple[Notation, ...] = ()
        #: The skills as filled in at their first start, in memory names.
        self.skills: tuple[Fact, ...] = ()
        #: The number of the request, if the method has sent one.
        self.ticket: int | None = None
        #: The nearest owner of constraints on steps: the method, its task, or an
        #: ancestor.
        self.constrained: Task | MethodRun | None = None

    def begin_steps(self, steps: list[Task]) -> None:
        """Set the tasks of the steps, none of which has ended yet."""
        self.steps, self.steps_left = steps, len(steps)
        if self.plan.constraints is not None:
            self.constrained = self
        else:
            self.constrained = self.constrained_above

    @property
    def constrained_above(self) -> Task | MethodRun | None:
        """Return the nearest owner of constraints above this method."""
        task = self.task
        return task if task.plan.constraints is not None else task.constrained

    def was_ended_by_until(self, position: int) -> bool:
        """Return whether an `until` has ended a step."""
        return self.ends is not None and position in self.ends.ended_by_until


class Task:
    """A goal under way, or ended."""

    FIELDS: ClassVar[Fields] = {
        "plan": RapPlan,
        "within": LEFT_OUT,
        "step": LEFT_OUT,
        "number": Natural,
        "family": LEFT_OUT,
        "limit": Limit,
        "priority": int,
        "waiting": LEFT_OUT,
        "goal_args": tuple[Value | None, ...],
        "env": Env,
        "goal_key": tuple[object, ...] | None,
        "state": State,
        "run": MethodRun | None,
        "method": MethodPlan | None,
        "history": History | None,
        "choice": tuple[object, ...] | None,
        "last_result": str | None,
        "wait": WaitState | None,
        "told": LEFT_OUT,
        "held_at": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self, plan: RapPlan, within: MethodRun | None, step: StepPlan | None
    ) -> None:
        self.plan = plan
        self.within = within
        self.step = step
        #: The number of the task, 0 until it joins the run.
        self.number = 0
        if within is None or step is None:
            #: The number of its top-level task.
            self.family: int = 0
            #: The nearest deadline of the task and its ancestors.
            self.limit: float = math.inf
            self.priority = 0
            #: The number of steps that the task still follows.
            self.waiting = 0
            self.wait: WaitState | None = WaitState() if plan.needs_wait_state else None
        else:
            parent = within.task
            self.family = parent.family
            self.limit = parent.limit
            self.priority = parent.priority + step.priority
            self.waiting = step.before
            if plan.needs_wait_state or step.has_timing:
                self.wait = WaitState(step.windows)
            else:
                self.wait = None
        #: The inputs as far as they are known.
        self.goal_args: tuple[Value | None, ...] = ()
        #: The inputs and resources, by variable.
        self.env: Env = {}
        #: The RAP, with its inputs if a recursion test needs them; None until all
        #: inputs are known.
        self.goal_key: tuple[object, ...] | None = plan.static_goal_key
        self.state: State = WAITING
        #: The method under way.
        self.run: MethodRun | None = None
        #: The method tried last.
        self.method: MethodPlan | None = None
        #: The results of the methods, from the second method or the first failure on.
        self.history: History | None = None
        #: The first choice that the futile-loop detector has counted.
        self.choice: tuple[object, ...] | None = None
        self.last_result: str | None = None
        #: The goal, once an event holds it and if it is constant.
        self.told: Goal | None = None
        #: `Listeners.changes` when the constraints of the task and above last held.
        self.held_at = -1

    @property
    def parent(self) -> Task | None:
        """Return the task that this task is a step of; None for a top-level task."""
        return None if self.within is None else self.within.task

    @property
    def bound(self) -> bool:
        """Return whether all inputs are known."""
        return None not in self.goal_args

    @property
    def constrained(self) -> Task | MethodRun | None:
        """Return the nearest ancestor, or method of one, that states constraints."""
        return None if self.within is None else self.within.constrained

    @property
    def resources(self) -> int:
        """Return the number of sets and counters that the task owns."""
        return sum(one.variable.name in self.env for one, _ in self.plan.resources)

    @property
    def live(self) -> bool:
        """Return whether the task has neither ended nor been removed."""
        return self.state is not ENDED

    @property
    def failed(self) -> bool:
        """Return whether a method of the task has failed."""
        return self.history is not None and bool(self.history.failures)

    @property
    def world_failure(self) -> str | None:
        """Return the last failure symbol from the world that has reached the task."""
        return None if self.history is None else self.history.failure

    # --- history ---------------------------------------------------------------

    def begin_method(self, method: MethodPlan) -> None:
        """Record the start of a method other than the last one."""
        if self.method is not None:
            history = self.remember()
            history.results.setdefault(method.node.name)
            history.before = self.method
        self.method = method

    def note_result(self, method: MethodPlan, result: str) -> None:
        """Record the result of a method."""
        history = self.remember()
        history.results[method.node.name] = result
        if result != OKAY:
            failures = history.failures
            failures[method.index] = failures.get(method.index, 0) + 1

    def remember(self) -> History:
        """Return the history; if there is none, create it from the last method."""
        if self.history is None:
            self.history = History()
            if self.method is not None:
                self.history.results[self.method.node.name] = self.last_result
                self.history.before = self.method
        return self.history

    def has_tried(self, name: object) -> bool:
        """Return whether a method of that name was tried."""
        if self.history is not None:
            return name in self.history.results
        return self.method is not None and self.method.node.name == name

    def result_of(self, name: object) -> str | None:
        """Return the result of the last method of that name, or None."""
        if self.history is not None:
            return self.history.results.get(name)
        return self.last_result if self.has_tried(name) else None

    def failures_of(self, method: MethodPlan) -> int:
        """Return how often a method has failed."""
        history = self.history
        return 0 if history is None else history.failures.get(method.index, 0)

    # --- the futile-loop detector (T 3.2.5) ------------------------------------

    def times_chosen(self, key: tuple[object, ...], most: int) -> int:
        """Return how often a choice was made since the count was reset.

        Only the `most` last different choices count. This method drops older choices,
        because the last choice may be undone until another is made.
        """
        if self.history is None or not self.history.tries:
            return 1 if self.choice == key else 0
        choices = self.history.choices
        if len(choices) > most:
            del choices[next(iter(choices))]
        return choices.get(key, 0)

    @property
    def choices(self) -> int:
        """Return how many choices were made since the count was reset."""
        if self.history is not None and self.history.tries:
            return sum(self.history.tries.values())
        return 0 if self.choice is None else 1

    def times_tried(self, method: MethodPlan) -> int:
        """Return how often a method was chosen since the count was reset."""
        if self.history is not None and self.history.tries:
            return self.history.tries.get(method.index, 0)
        return 1 if self.choice is not None and self.choice[0] == method.index else 0

    def note_choice(self, key: tuple[object, ...]) -> None:
        """Count a choice; create the table for the second one."""
        if self.choice is None:
            self.choice = key
            return
        history = self.remember()
        choices, tries = history.choices, history.tries
        if not tries:
            choices[self.choice] = tries[self.choice[0]] = 1
        choices[key] = choices.get(key, 0) + 1
        tries[key[0]] = tries.get(key[0], 0) + 1
        history.last_choice = key

    def forget_choice(self) -> None:
        """Undo the choice that was counted last."""
        history = self.history
        if history is None or not history.tries:
            self.choice = None
            return
        key = history.last_choice
        _count_down(history.choices, key)
        _count_down(history.tries, key[0])
        if not history.tries:
            self.choice = None

    def forget_method(self) -> None:
        """Undo the start of the method under way."""
        method, history = self.method, self.history
        if self.last_result is None:  # no method has ended: it is the first
            self.method = None
        elif history is not None:
            self.method = history.before
        if method is None or history is None:
            return
        if history.results.get(method.node.name, OKAY) is None:
            del history.results[method.node.name]

    def forget_choices(self) -> None:
        """Reset the detector."""
        self.choice = None
        if self.history is not None:
            self.history.choices.clear()
            self.history.tries.clear()

    # --- as shown in events ------------------------------------------------------

    def goal(self, outputs: Mapping[str, Value] | None = None) -> Goal:
        """Return the goal with the inputs that are known, and `outputs` if given."""
        if self.told is None or self.plan.outputs:
            return self._goal(outputs)
        return self.told

    def _goal(self, outputs: Mapping[str, Value] | None) -> Goal:
        if not (self.plan.inputs or self.plan.outputs):
            goal = _bare_goal(self.plan.name)
            if not self.has_resources():
                self.told = goal
            return goal
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

    def goal_fact(self) -> Fact | None:
        """Return the RAP and its inputs; None if an input is unknown or a resource."""
        inputs = [v for v in self.goal_args if isinstance(v, str | int | float | Text)]
        whole = len(inputs) == len(self.plan.inputs)
        return (self.plan.name, *inputs) if whole else None

    def has_resources(self) -> bool:
        """Return whether the task has or was passed sets or counters."""
        return any(isinstance(value, _RESOURCES) for value in self.env.values())


class TopLevelTask:
    """A top-level task with its times and its result."""

    FIELDS: ClassVar[Fields] = {
        "task": LEFT_OUT,
        "came": Time,
        "ended": Time | None,
        "background": bool,
        "outcome": str | None,
        "because": Cause | None,
        "outputs": Env,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, task: Task, background: bool, came: Time = 0) -> None:
        self.task = task
        #: When the task joined the run, and when it left; None before that.
        self.came = came
        self.ended: Time | None = None
        #: Whether the task is in the background: it does not keep the run going.
        self.background = background
        #: `okay` or the failure of the task; None unless it has ended by itself.
        self.outcome: str | None = None
        #: The cause of the failure, if the run has listeners for causes.
        self.because: Cause | None = None
        #: The outputs.
        self.outputs: Env = {}


def _count_down(counts: dict[Any, int], key: object) -> None:
    counts[key] -= 1
    if not counts[key]:
        del counts[key]


def _told(term: nodes.Term, env: Env) -> Any:
    """Return a term as a value: lists if computed, names for unbound variables."""
    if isinstance(term, nodes.Const):
        return term.value
    if isinstance(term, nodes.Var):
        value = env.get(term.name, term.name)
        return str(value) if isinstance(value, _RESOURCES) else value
    return (term.function, *[_told(arg, env) for arg in term.args])
