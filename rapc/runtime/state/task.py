"""Tasks and the methods they are carrying out: state only, no behaviour of its own.

What happens to a task in a cycle is in `rapc.runtime.tasks.cycle`, what happens when
something ends in `rapc.runtime.tasks.finish` [T 3.4.1; L 3]. A task is made for
every step of every method, so what few tasks have stands apart: a `WaitState` for
times, signals and monitors, a `History` from the second method or the first failure on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Fact
from rapc.compiler.net_plan import StepPlan
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.events import Goal
from rapc.ir import nodes
from rapc.runtime.fields import LEFT_OUT, Fields, Limit, Natural
from rapc.runtime.memory.notations import Notation
from rapc.runtime.state.history import History
from rapc.runtime.state.states import ENDED, WAITING, State
from rapc.runtime.state.wait_state import WaitState
from rapc.world import OKAY, Time

Env = dict[str, Value]
"""Variables and what they are bound to."""


def as_told(env: Env) -> dict[str, Any]:
    """Return a copy of bindings, with sets and counters as they are now, in words."""
    if not env:
        return {}
    return {
        name: str(value) if isinstance(value, _RESOURCES) else value
        for name, value in env.items()
    }


@cache
def _bare_goal(name: str) -> Goal:
    """Return the goal of a RAP without inputs and outputs: one for all tasks."""
    return Goal(name)


_RESOURCES = (Counter, SetResource)


class Ends:
    """How steps of a method have ended, where something depends on it."""

    FIELDS: ClassVar[Fields] = {
        "times": list[Time | None],
        "ended_by_until": set[int],
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, steps: int) -> None:
        #: When each step ended; None while it has not.
        self.times: list[Time | None] = [None] * steps
        #: The positions of the steps that an `until` has ended.
        self.ended_by_until: set[int] = set()


class MethodRun:
    """A method while it is carried out."""

    FIELDS: ClassVar[Fields] = {
        "task": LEFT_OUT,
        "plan": MethodPlan,
        "env": Env,
        "started": Time,
        "steps": LEFT_OUT,
        "steps_left": LEFT_OUT,
        "ends": Ends | None,
        "notations": LEFT_OUT,
        "skills": tuple[Fact, ...],
        "ticket": int | None,
        "constrained": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, task: Task, plan: MethodPlan, env: Env, started: Time) -> None:
        self.task = task
        self.plan = plan
        #: What the task had, what the choice bound, then what `for` formulas and
        #: outputs add; the task's own environment where nothing can be added.
        self.env = env
        self.started = started
        #: The tasks of its steps, by position, those among them that have ended.
        self.steps: list[Task] | tuple[()] = ()
        #: How many steps have not ended.
        self.steps_left = left = plan.size
        self.ends = Ends(left) if plan.tracks_step_ends else None
        self.notations: tuple[Notation, ...] = ()
        #: Its skills as they were filled in when they first came on, in memory names.
        self.skills: tuple[Fact, ...] = ()
        #: The number of its request, if it has sent one.
        self.ticket: int | None = None
        outer = task.within
        nearest = None if outer is None else outer.constrained
        if plan.constrains:
            nearest = task if plan.constraints is None else self
        #: The nearest that states constraints: itself, its task, or what is above.
        self.constrained: Task | MethodRun | None = nearest

    @property
    def constrained_above(self) -> Task | MethodRun | None:
        """The nearest that states constraints, this method left out."""
        task = self.task
        return task if task.plan.constraints is not None else task.constrained

    def was_ended_by_until(self, position: int) -> bool:
        """Whether a step was ended by an `until`."""
        return self.ends is not None and position in self.ends.ended_by_until


class Task:
    """One goal under way."""

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
        "identity": tuple[object, ...] | None,
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
        #: Its number, 0 until it joins the run.
        self.number = 0
        if within is None or step is None:
            #: The number of its top-level task.
            self.family: int = 0
            #: The nearest deadline of its own and its ancestors'.
            self.limit: float = math.inf
            self.priority = 0
            #: How many steps it still follows.
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
        #: Its inputs as far as they are known.
        self.goal_args: tuple[Value | None, ...] = ()
        #: Its inputs and resources, by variable.
        self.env: Env = {}
        #: The RAP, with its inputs where a recursion test needs them; None until all
        #: inputs are known.
        self.identity: tuple[object, ...] | None = plan.static_identity
        self.state: State = WAITING
        #: The method it is at work on.
        self.run: MethodRun | None = None
        #: The method tried last.
        self.method: MethodPlan | None = None
        #: What its methods have come to, from the second or the first failure on.
        self.history: History | None = None
        #: The first choice that its futile-loop detector has seen.
        self.choice: tuple[object, ...] | None = None
        self.last_result: str | None = None
        #: The goal, once an event holds it and if it stays as it is.
        self.told: Goal | None = None
        #: `Listeners.changes` when its constraints, and those above, last held.
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
    def constrained(self) -> Task | MethodRun | None:
        """The nearest ancestor, or method of one, that states constraints."""
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
        """Note that a method is tried which is not the one tried last."""
        if self.method is not None:
            history = self.remember()
            history.results.setdefault(method.node.name)
            history.before = self.method
        self.method = method

    def note_result(self, method: MethodPlan, result: str) -> None:
        """Remember the result that a method has come to."""
        history = self.remember()
        history.results[method.node.name] = result
        if result != OKAY:
            failures = history.failures
            failures[method.index] = failures.get(method.index, 0) + 1

    def remember(self) -> History:
        """Return the history, made of the method tried so far if there is none."""
        if self.history is None:
            self.history = History()
            if self.method is not None:
                self.history.results[self.method.node.name] = self.last_result
                self.history.before = self.method
        return self.history

    def has_tried(self, name: object) -> bool:
        """Whether a method of that name was tried."""
        if self.history is not None:
            return name in self.history.results
        return self.method is not None and self.method.node.name == name

    def result_of(self, name: object) -> str | None:
        """Return what the last method of that name came to, None if there is none."""
        if self.history is not None:
            return self.history.results.get(name)
        return self.last_result if self.has_tried(name) else None

    def failures_of(self, method: MethodPlan) -> int:
        """Return how often a method has ended badly."""
        history = self.history
        return 0 if history is None else history.failures.get(method.index, 0)

    # --- the futile-loop detector (T 3.2.5) ------------------------------------

    def times_chosen(self, key: tuple[object, ...], most: int) -> int:
        """Return how often a choice was made since the detector started afresh.

        Only the `most` last different choices count; the others are forgotten here,
        as the last one may be put back until another is made.
        """
        if self.history is None or not self.history.tries:
            return 1 if self.choice == key else 0
        choices = self.history.choices
        if len(choices) > most:
            del choices[next(iter(choices))]
        return choices.get(key, 0)

    @property
    def choices(self) -> int:
        """Return how often a method was chosen since the detector started afresh."""
        if self.history is not None and self.history.tries:
            return sum(self.history.tries.values())
        return 0 if self.choice is None else 1

    def times_tried(self, method: MethodPlan) -> int:
        """Return how often a method was chosen since the detector started afresh."""
        if self.history is not None and self.history.tries:
            return self.history.tries.get(method.index, 0)
        return 1 if self.choice is not None and self.choice[0] == method.index else 0

    def note_choice(self, key: tuple[object, ...]) -> None:
        """Count a choice; a table is made for the second one."""
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
        """Let the choice that was noted last never have been made."""
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
        """Let the method under way never have been tried."""
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
        """The detector starts afresh."""
        self.choice = None
        if self.history is not None:
            self.history.choices.clear()
            self.history.tries.clear()

    # --- as events tell of it ----------------------------------------------------

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

    def has_resources(self) -> bool:
        """Whether it has sets or counters, or was given some."""
        return any(isinstance(value, _RESOURCES) for value in self.env.values())


def _count_down(counts: dict[Any, int], key: object) -> None:
    counts[key] -= 1
    if not counts[key]:
        del counts[key]


def _told(term: nodes.Term, env: Env) -> Any:
    """A term as a value: computed ones as lists, unbound variables by their names."""
    if isinstance(term, nodes.Const):
        return term.value
    if isinstance(term, nodes.Var):
        value = env.get(term.name, term.name)
        return str(value) if isinstance(value, _RESOURCES) else value
    return (term.function, *[_told(arg, env) for arg in term.args])
