"""What compiled queries see: memory, and the history of the task that asks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.values import Fact, Number, format_atom, number
from rapc.compiler.query.query import BoundQueries
from rapc.compiler.query.term_value import TermValue
from rapc.events import QueryFaulted
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.gate import MemoryView
from rapc.runtime.memory.memory import EXTERNAL, Memory
from rapc.runtime.settings import Settings
from rapc.runtime.state.task import Env, Task
from rapc.world import Time

MOST_EXPLAINED = 2_000
"""How often the questions that explain a clause may go back in vain, together: some
hundredths of a second."""


class QueryContext:
    """What `rapc.compiler.query.query` asks of a run.

    `task` is set before each query to the task whose clause it is. While `horizon`
    is a list, the times at which beliefs that held go stale are added to it.

    Args:
        memory: what is asked.
        recorder: is told of faults.
        functions: the registered functions, by name.
        most_steps: how often a question may go back in vain.
        quiet: whether questions leave no mark on the run: those of a host, and those
            that ask why something failed. Faults are then only noted.
    """

    def __init__(
        self,
        memory: Memory,
        recorder: Recorder,
        functions: Mapping[str, Callable[..., Any]],
        most_steps: int = Settings().query_steps,
        quiet: bool = False,
    ) -> None:
        self.facts = memory.facts
        self.bound = BoundQueries(self)
        self.functions = functions
        self.view = MemoryView(memory, recorder)
        self.task: Task | None = None
        self.horizon: list[Time] | None = None
        #: How often a question of the run may go back in vain.
        self.step_limit = most_steps
        self.most_steps = self.steps_left = most_steps
        #: How many faults there have been, and what the last one was.
        self.faults = 0
        self.noted = ""
        #: The clauses that were given up in a cycle, by name, each with its last one.
        self.given_up: dict[str, int] = {}
        self.facts_at = memory.facts_at
        self.accessible_items = memory.items.accessible
        self.is_accessible = memory.items.is_accessible
        self._memory = memory
        self._recorder = recorder
        self._quiet = quiet

    def fault(self, where: str, what: str) -> None:
        """Trace or note that a clause met an unbound variable or an ill-typed value."""
        self.faults += 1
        self.noted = what
        if self._recorder.on and not self._quiet:
            number = self.task.number if self.task is not None else None
            self._recorder.emit(QueryFaulted, task=number, what=f"{where}: {what}")

    def give_up(self, where: str) -> None:
        """Trace or note that a question went back too often in vain [L 2.70]."""
        if self.most_steps < self.step_limit:
            most = f"given up after {MOST_EXPLAINED} steps back"
            self.noted = f"{most}: an explanation takes no more"
            return
        self.given_up[where] = self._recorder.cycle
        self.fault(where, self._told_of_giving_up())

    def told_if_given_up(self, where: str) -> str:
        """Return what is said of a clause that this cycle has given up, or nothing."""
        given_up = self.given_up.get(where) == self._recorder.cycle
        return self._told_of_giving_up() if given_up else ""

    def _told_of_giving_up(self) -> str:
        return f"given up after {self.step_limit} steps back: see `rapc.query-steps`"

    def unfit(self, where: str, value: object, wanted: str) -> None:
        """Trace that a value is not what a clause needs: `a number`, say."""
        self.fault(where, f"`{format_atom(value)}` is not {wanted}")

    # --- explanations ---------------------------------------------------------------

    def begin(self, asker: Task | None) -> None:
        """Begin an explanation of what a task asked, or a user."""
        self.task = asker
        self.most_steps, self.steps_left = MOST_EXPLAINED, MOST_EXPLAINED
        self._left = MOST_EXPLAINED
        self.next_part()

    def next_part(self) -> None:
        """Go on to the next question of an explanation, with what steps are left."""
        self.noted = ""
        self._left -= self.most_steps - self.steps_left
        self.most_steps = self.steps_left = max(min(self._left, self.step_limit), 0)

    # --- what formulas ask ----------------------------------------------------------

    def young(self, stamp: Time, limit: Number) -> bool:
        """Whether a fact with that stamp is younger than `limit` time units."""
        stale = stamp + limit
        if self._recorder.time >= stale:
            return False
        if self.horizon is not None:
            self.horizon.append(stale)
        return True

    def age(self, stamp: Time) -> Number:
        """Time units since a stamp."""
        return number(self._recorder.time - stamp)

    def is_here(self, fact: Fact | None, place: object) -> bool:
        """Whether `place` is `external` and a location fact says it of an item."""
        return place == EXTERNAL and self._memory.is_here(fact)

    def method_tried(self, name: object) -> bool:
        """Whether the task has tried a method of that name."""
        return self.task is not None and self.task.has_tried(name)

    def last_result(self, method: object = None) -> str | None:
        """The result of the last method, or of the last one so named, or None."""
        if self.task is None:
            return None
        if method is None:
            return self.task.last_result
        return self.task.result_of(method)

    def count(self, kind: object, place: Any) -> Number:
        """Return how many items of a class memory expects at a place."""
        return self.view.count(str(kind), place)


def time_of(context: QueryContext, term: TermValue, env: Env) -> Number | None:
    """A term as a time; None, with a fault traced, if it is unbound or no number."""
    value = term.needed(context, env)
    if value is None or isinstance(value, int | float):
        return value
    context.unfit(term.where, value, "a number")
    return None
