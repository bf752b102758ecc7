"""History of the methods that a task has tried [T 3.2.2, 3.2.5].

State only: `Task` creates a history with the second method or the first failure.
"""

from __future__ import annotations

from typing import ClassVar

from rapc.base.resources import Value
from rapc.base.values import Atom, Fact
from rapc.compiler.rap_plan import MethodPlan
from rapc.events import Cause
from rapc.runtime.fields import Fields


class History:
    """Results of the methods of a task."""

    FIELDS: ClassVar[Fields] = {
        "choices": dict[tuple[object, ...], int],
        "tries": dict[int, int],
        "last_choice": tuple[object, ...],
        "before": MethodPlan | None,
        "results": dict[Atom | None, str | None],
        "failures": dict[int, int],
        "failed_steps": dict[Fact, int],
        "failure": str | None,
        "because": Cause | None,
        "success": dict[str, Value] | None,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: The choices that the futile-loop detector has counted, from the second one
        #: on: the last different choices, in the order in which each was first made.
        self.choices: dict[tuple[object, ...], int] = {}
        #: How often each method was chosen, by index, for all bindings.
        self.tries: dict[object, int] = {}
        #: The last choice that `choices` has counted; set only from then on.
        self.last_choice: tuple[object, ...] = ()
        #: The method tried before the last one; None if the last one was the first.
        self.before: MethodPlan | None = None
        #: The last result of each method tried, by name.
        self.results: dict[object, str | None] = {}
        #: How often each method has failed, by index.
        self.failures: dict[int, int] = {}
        #: How often each step of a plan has failed, by goal [L 10.7].
        self.failed_steps: dict[Fact, int] = {}
        #: The last failure symbol from the world.
        self.failure: str | None = None
        #: The cause of the last method's failure; None without failure or listeners.
        self.because: Cause | None = None
        #: The environment of the last successful method, for outputs.
        self.success: dict[str, Value] | None = None

    def note_failed_step(self, goal: Fact | None) -> None:
        """Count the failure of a step of a plan; None for an incomplete goal."""
        if goal is not None:
            self.failed_steps[goal] = self.failed_steps.get(goal, 0) + 1
