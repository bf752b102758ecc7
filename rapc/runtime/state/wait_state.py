"""What a task may have to wait for besides its turn: times, signals, monitors [L 3, 4].

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
    """What a task may have to wait for besides its turn, and what its inputs make."""

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
        "duration": Time,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self, windows: tuple[WindowPlan, ...] = ()) -> None:
        #: The windows whose times are not yet known.
        self.windows = windows
        #: The latest start of its windows that are known.
        self.earliest_start: Time = 0
        #: Whether it waits for a signal.
        self.awaits_signal = False
        #: When its monitored time comes.
        self.ready_at: Time = 0
        #: When the task joined the run; its monitored time is counted from then.
        self.made: Time = 0
        #: The changes it listens to; None before it does.
        self.keys: tuple[WatchKey, ...] | None = None
        #: The time it waits for now.
        self.timer: Time | None = None
        #: What it waits for, as the trace has it.
        self.blocked_on = ""
        #: Its monitor in words, if that stays as it is.
        self.formula: str | None = None
        #: The deadline given by windows or a host.
        self.given_deadline: float = math.inf
        #: The deadline given by `monitor-time`.
        self.monitor_deadline: float = math.inf
        #: The deadline that was last told of as missed.
        self.missed: float | None = None
        #: Whether it was selected with its monitors holding.
        self.first_selected = False
        #: Whether it is to come up whatever its monitors say.
        self.after_method = False
        #: Whether resources and times have been made of its inputs,
        self.prepared = False
        #: and whether they could not be.
        self.setup_failed = False
        #: How long its RAP says that it takes.
        self.duration: Time = 0

    @property
    def deadline(self) -> float:
        """The deadline that the task itself states: by window, monitor or host."""
        return min(self.given_deadline, self.monitor_deadline)
