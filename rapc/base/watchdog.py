"""A watchdog: it halts a body when the interpreter gives no sign of life."""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Callable

PERIOD = 0.25
"""The seconds without a sign of life after which a watchdog halts the body."""

TICK = 0.01
"""The seconds between two looks of a watchdog."""


class Watchdog:
    """A watchdog of a body, which is armed while the body may move.

    `beat` may be called in one thread, and `look` in another one.

    Args:
        halt: stops the body. It is called at most once between two beats.
    """

    def __init__(self, halt: Callable[[], object]) -> None:
        #: Whether the body may move.
        self.armed = False
        self._stop_body = halt
        self._halted = False
        self._heard = time.monotonic()

    def beat(self) -> float:
        """Note a sign of life; return the seconds since the preceding one."""
        now = time.monotonic()
        gap, self._heard, self._halted = now - self._heard, now, False
        return gap

    def look(self) -> None:
        """Halt the body if no sign of life has come for `PERIOD`."""
        if self.armed and time.monotonic() - self._heard > PERIOD:
            self.halt()

    def watch(self, over: threading.Event) -> None:
        """Look every `TICK` seconds until `over` is set."""
        while not over.wait(TICK):
            self.look()

    def halt(self) -> None:
        """Halt the body, unless it is halted or does not move."""
        if self._halted or not self.armed:
            return
        self._halted = True
        try:
            self._stop_body()
        except Exception:  # the author's own code; the watchdog must go on
            traceback.print_exc()
