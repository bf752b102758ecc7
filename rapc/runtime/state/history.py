"""What has become of the methods that a task has tried [T 3.2.2, 3.2.5].

State only: `Task` keeps it, from the second method or the first failure on.
"""

from __future__ import annotations

from typing import ClassVar

from rapc.base.resources import Value
from rapc.base.values import Atom
from rapc.compiler.rap_plan import MethodPlan
from rapc.events import Cause
from rapc.runtime.fields import Fields


class History:
    """What the methods of a task have come to."""

    FIELDS: ClassVar[Fields] = {
        "choices": dict[tuple[object, ...], int],
        "tries": dict[int, int],
        "last_choice": tuple[object, ...],
        "before": MethodPlan | None,
        "results": dict[Atom | None, str | None],
        "failures": dict[int, int],
        "failure": str | None,
        "because": Cause | None,
        "success": dict[str, Value] | None,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: What the futile-loop detector has seen, from the second choice on: the last
        #: different choices, in the order in which each was first made.
        self.choices: dict[tuple[object, ...], int] = {}
        #: How often each method was chosen, by index, whatever was bound.
        self.tries: dict[object, int] = {}
        #: The last choice that `choices` has counted; only then is it asked for.
        self.last_choice: tuple[object, ...] = ()
        #: The method tried before the one tried last; None if that was the first.
        self.before: MethodPlan | None = None
        #: The last result of each method tried, by name.
        self.results: dict[object, str | None] = {}
        #: How often each method has ended badly, by index.
        self.failures: dict[int, int] = {}
        #: The last failure symbol from the world.
        self.failure: str | None = None
        #: Why the last method ended badly; None if it did not, or nobody is told.
        self.because: Cause | None = None
        #: The environment of the last method that ended well, for outputs.
        self.success: dict[str, Value] | None = None
