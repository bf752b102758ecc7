"""The context of compiled queries: memory, and the history of the querying task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.values import Fact, Number, format_atom, number
from rapc.compiler.query.query import BoundQueries
from rapc.compiler.query.term_value import TermValue
from rapc.events import QueryFaulted
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.memory.memory import EXTERNAL, Memory
from rapc.runtime.settings import Settings
from rapc.runtime.state.task import Env, Task
from rapc.world import Time

MOST_EXPLAINED = 2_000
"""The shared limit of steps back in vain for queries that explain a clause: some

hundredths of a second.
"""


class QueryContext:
    """The interface of `rapc.compiler.query.query` to a run.

    `task` is set before each query to the task with the clause. While `horizon` is a
    list, a query appends the times at which beliefs that held go stale.

    Args:
        memory: the memory to query.
        recorder: receives events about faults.
        functions: the registered functions, by name.
        most_steps: the limit of steps back in vain in a query.
        quiet: whether queries leave the run unchanged: queries of a host, and
            queries that explain a failure. Faults are then only noted.
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
        #: The limit of steps back in vain in a query of the run.
        self.step_limit = most_steps
        self.most_steps = self.steps_left = most_steps
        #: The number of faults, and the text of the last one.
        self.faults = 0
        self.noted = ""
        #: The clauses aborted in a cycle, by name, each with its last cycle.
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
        """Trace or note that a query exceeded its steps back in vain [L 2.70]."""
        if self.most_steps < self.step_limit:
            most = f"given up after {MOST_EXPLAINED} steps back"
            self.noted = f"{most}: an explanation takes no more"
            return
        self.given_up[where] = self._recorder.cycle
        self.fault(where, self._told_of_giving_up())

    def told_if_given_up(self, where: str) -> str:
        """Return the note on a clause that this cycle has aborted, or nothing."""
        given_up = self.given_up.get(where) == self._recorder.cycle
        return self._told_of_giving_up() if given_up else ""

    def _told_of_giving_up(self) -> str:
        return f"given up after {self.step_limit} steps back: see `rapc.query-steps`"

    def unfit(self, where: str, value: object, wanted: str) -> None:
        """Trace a value that is not of the `wanted` kind, for example `a number`."""
        self.fault(where, f"`{format_atom(value)}` is not {wanted}")

    # --- explanations ---------------------------------------------------------------

    def begin(self, asker: Task | None) -> None:
        """Begin an explanation of a query by a task, or by a user."""
        self.task = asker
        self.most_steps, self.steps_left = MOST_EXPLAINED, MOST_EXPLAINED
        self._left = MOST_EXPLAINED
        self.next_part()

    def next_part(self) -> None:
        """Go on to the next query of an explanation, with the remaining steps."""
        self.noted = ""
        self._left -= self.most_steps - self.steps_left
        self.most_steps = self.steps_left = max(min(self._left, self.step_limit), 0)

    # --- for formulas -----------------------------------------------------------------

    def young(self, stamp: Time, limit: Number) -> bool:
        """Return whether a fact with that stamp is younger than `limit` time units."""
        stale = stamp + limit
        if self._recorder.time >= stale:
            return False
        if self.horizon is not None:
            self.horizon.append(stale)
        return True

    def age(self, stamp: Time) -> Number:
        """Return the time units since a stamp."""
        return number(self._recorder.time - stamp)

    def is_here(self, fact: Fact | None, place: object) -> bool:
        """Return whether `place` is `external` and a fact puts an item there."""
        return place == EXTERNAL and self._memory.is_here(fact)

    def method_tried(self, name: object) -> bool:
        """Return whether the task has tried a method of that name."""
        return self.task is not None and self.task.has_tried(name)

    def last_result(self, method: object = None) -> str | None:
        """Return the result of the last method, or of the last named `method`."""
        if self.task is None:
            return None
        if method is None:
            return self.task.last_result
        return self.task.result_of(method)

    def count(self, kind: object, place: Any) -> Number:
        """Return how many items of a class memory expects at a place."""
        return self.view.count(str(kind), place)


def time_of(context: QueryContext, term: TermValue, env: Env) -> Number | None:
    """Return a term as a time; None, with a fault traced, if unbound or no number."""
    value = term.needed(context, env)
    if value is None or isinstance(value, int | float):
        return value
    context.unfit(term.where, value, "a number")
    return None
