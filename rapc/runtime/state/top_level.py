"""Record of a top-level task, kept for the run beside the task."""

from __future__ import annotations

from typing import ClassVar

from rapc.events import Cause
from rapc.runtime.fields import LEFT_OUT, Fields
from rapc.runtime.state.task import Env, Task
from rapc.world import Time


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
