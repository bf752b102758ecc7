"""What a run keeps of each task that it was given, besides the task itself."""

from __future__ import annotations

from typing import ClassVar

from rapc.events import Cause
from rapc.runtime.fields import LEFT_OUT, Fields
from rapc.runtime.state.task import Env, Task
from rapc.world import Time


class TopLevelTask:
    """A task that was given to the robot: when it came, and what has become of it."""

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
        #: When it joined the run, and when it left; None while it has not.
        self.came = came
        self.ended: Time | None = None
        #: Whether it does not keep the run going.
        self.background = background
        #: `okay` or the failure it handed up; None unless it has ended by itself.
        self.outcome: str | None = None
        #: Why it failed, if anybody is told.
        self.because: Cause | None = None
        #: What it handed out.
        self.outputs: Env = {}
