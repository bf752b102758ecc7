"""Tasks and the methods they are carrying out: state only, no behaviour of its own.

What happens to a task in a cycle is in `rapc.runtime.cycle`, what happens when
something ends in `rapc.runtime.endings` (T 3.4.1, semantics 3).
"""

from __future__ import annotations

import enum
import math

from rapc.compiler.plans import MethodPlan, RapPlan, StepPlan, WindowPlan
from rapc.parser.printer import format_term
from rapc.resources import Value
from rapc.runtime.memory.memory import Notation
from rapc.runtime.world import Time
from rapc.terms import format_atom

Env = dict[str, Value]
"""Variables and what they are bound to."""


class State(enum.Enum):
    """Where a task stands between its cycles."""

    WAITING = "waiting"
    UNTESTED = "untested"
    ELIGIBLE = "eligible"
    BLOCKED = "blocked"
    RUNNING = "running"
    ENDED = "ended"


class Task:
    """One goal under way; it has no number until it joins the run.

    `env` holds inputs and resources, once `bound`; `identity` the RAP with its input
    values, for the recursion test; `constrained` is the nearest ancestor that states
    constraints; `family` is the number of its top-level task. `outcome` is `okay` or
    what the task handed up, None unless it has ended by itself.
    `deadline` is its own, `limit` the nearest of its own and its ancestors', `missed`
    the one last told of as missed; `opens` is the latest start of its windows,
    `windows` those whose times are not yet known. `begun`
    is set once it was selected with its monitors holding, `after_method` while it is
    to come up whatever its monitors say, `held` while it waits for a signal; `timer` is
    the time that it waits for.
    """

    __slots__ = (
        "after_method",
        "background",
        "begun",
        "blocked_on",
        "bound",
        "choices",
        "constrained",
        "duration",
        "env",
        "failed",
        "failures",
        "family",
        "given_deadline",
        "goal_args",
        "held",
        "identity",
        "key",
        "last_result",
        "limit",
        "made",
        "missed",
        "monitor_deadline",
        "number",
        "opens",
        "outcome",
        "outputs",
        "parent",
        "plan",
        "prepared",
        "priority",
        "ready_at",
        "results",
        "run",
        "spoilt",
        "state",
        "step",
        "success_env",
        "timer",
        "tried",
        "waiting",
        "watching",
        "windows",
        "within",
        "world_failure",
    )

    def __init__(self, plan: RapPlan, within: MethodRun | None) -> None:
        self.number = 0
        self.plan = plan
        self.within = within
        self.parent = within.task if within is not None else None
        self.family: int = 0 if within is None else within.task.family
        self.constrained = _constrained(self.parent)
        self.step: StepPlan | None = None
        self.goal_args: tuple[Value | None, ...] = ()
        self.priority = 0
        self.background = False
        self.begun = False
        self.env: Env = {}
        self.bound = False
        self.spoilt = False
        self.prepared = False
        self.identity: object = None
        self.duration: Time = 0
        self.given_deadline: float = math.inf
        self.monitor_deadline: float = math.inf
        self.limit: float = math.inf if within is None else within.task.limit
        self.made: Time = 0
        self.missed: float | None = None
        self.waiting = 0
        self.opens: Time = 0
        self.windows: tuple[WindowPlan, ...] = ()
        self.held = False
        self.state = State.WAITING
        self.key: tuple[float, float, bool] = (0, 0, False)
        self.ready_at: Time = 0
        self.watching = False
        self.timer: Time | None = None
        self.blocked_on = ""
        self.after_method = False
        self.run: MethodRun | None = None
        self.failed = False
        self.failures: dict[int, int] = {}
        self.choices: dict[object, int] = {}
        self.tried: set[object] = set()
        self.results: dict[object, str] = {}
        self.last_result: str | None = None
        self.outcome: str | None = None
        self.world_failure: str | None = None
        self.success_env: Env | None = None
        self.outputs: Env = {}

    @property
    def live(self) -> bool:
        """Whether the task has not ended and was not removed."""
        return self.state is not State.ENDED

    @property
    def deadline(self) -> float:
        """The deadline that the task itself states: by window, monitor or host."""
        return min(self.given_deadline, self.monitor_deadline)

    def goal(self) -> str:
        """The goal as the trace prints it: inputs by value, outputs once known."""
        words = [self.plan.name]
        terms = self.step.node.goal.args if self.step is not None else ()
        for at, name in enumerate(self.plan.inputs):
            value = self.env.get(name) if self.bound else None
            if value is None and at < len(self.goal_args):
                value = self.goal_args[at]
            if value is not None:
                words.append(format_atom(value))
            else:
                env = self.within.env if self.within is not None else {}
                words.append(format_term(terms[at], env))
        if self.plan.outputs:
            words.append("=>")
            for name in self.plan.outputs:
                known = self.outputs.get(name)
                words.append(name if known is None else format_atom(known))
        return f"({' '.join(words)})"


def _constrained(parent: Task | None) -> Task | None:
    if parent is None or parent.plan.constraints is not None:
        return parent
    return parent.constrained


class MethodRun:
    """A method while it is carried out.

    `env` is the method's environment: what the task had, what the choice bound, then
    what `for` formulas and outputs add. `ends` holds the time at which each step
    ended, None while it has not; `lapsed` the steps that an `until` ended.
    """

    __slots__ = (
        "bindings",
        "ends",
        "env",
        "lapsed",
        "left",
        "notations",
        "plan",
        "started",
        "steps",
        "task",
        "ticket",
    )

    def __init__(self, task: Task, plan: MethodPlan, env: Env, started: Time) -> None:
        self.task = task
        self.plan = plan
        self.env = env
        self.started = started
        self.steps: list[Task] = []
        self.left = len(plan.steps)
        self.ends: list[Time | None] = [None] * len(plan.steps)
        self.lapsed: set[int] = set()
        self.notations: list[Notation] = []
        self.ticket: int | None = None
