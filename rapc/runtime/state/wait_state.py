"""Waits of a task besides its turn: times, signals, monitors [L 3, 4].

State only: `rapc.runtime.tasks.start` fills it in, `rapc.runtime.monitors` watches it.
"""

from __future__ import annotations

import math
from typing import ClassVar

from rapc.compiler.net_plan import WindowPlan
from rapc.compiler.watches import WatchKey
from rapc.runtime.fields import Fields, Limit
from rapc.world import Time


class WaitState:
    """The waits of a task, and the state computed from its inputs."""

    FIELDS: ClassVar[Fields] = {
        "windows": tuple[WindowPlan, ...],
        "earliest_start": Time,
        "awaits_signal": bool,
        "ready_at": Time,
        "made": Time,
        "keys": tuple[WatchKey, ...] | None,
        "timer": Time | None,
        "blocked_on": str,
        "formula": str | None,
        "given_deadline": Limit,
        "monitor_deadline": Limit,
        "missed": Time | None,
        "first_selected": bool,
        "after_method": bool,
        "prepared": bool,
        "setup_failed": bool,
        "over_limit": bool,
        "duration": Time,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, windows: tuple[WindowPlan, ...] = ()) -> None:
        #: The windows whose times are not yet known.
        self.windows = windows
        #: The latest start of the windows that are known.
        self.earliest_start: Time = 0
        #: Whether the task waits for a signal.
        self.awaits_signal = False
        #: When the monitored time comes.
        self.ready_at: Time = 0
        #: When the task joined the run; the monitored time counts from then.
        self.made: Time = 0
        #: The changes that the task listens to; None before it does.
        self.keys: tuple[WatchKey, ...] | None = None
        #: The time that the task waits for.
        self.timer: Time | None = None
        #: The wait of the task, as the trace shows it.
        self.blocked_on = ""
        #: The monitor as text, if that is constant.
        self.formula: str | None = None
        #: The deadline given by windows or a host.
        self.given_deadline: float = math.inf
        #: The deadline given by `monitor-time`.
        self.monitor_deadline: float = math.inf
        #: The deadline last reported as missed.
        self.missed: float | None = None
        #: Whether the task was selected with its monitors holding.
        self.first_selected = False
        #: Whether the task is to be selected whatever its monitors report.
        self.after_method = False
        #: Whether resources and times have been computed from the inputs,
        self.prepared = False
        #: and whether that has failed.
        self.setup_failed = False
        #: Whether it has failed because there were too many resources.
        self.over_limit = False
        #: The duration that its RAP states.
        self.duration: Time = 0

    @property
    def deadline(self) -> float:
        """Return the deadline of the task itself: by window, monitor or host."""
        return min(self.given_deadline, self.monitor_deadline)
