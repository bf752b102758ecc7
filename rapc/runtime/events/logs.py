"""Traces in the logs of Python."""

from __future__ import annotations

import logging
from io import StringIO

from rapc import events
from rapc.base.values import readable
from rapc.runtime.events.trace import TextTrace


class LogTrace(TextTrace):
    """A listener that logs the lines of a `TextTrace` with Python's `logging`.

    The level is INFO, for a task that has failed WARNING. The log record has the event
    as `record.event`.

    Args:
        logger: the logger; by default the one named `rapc.run`.
    """

    def __init__(self, logger: logging.Logger | None = None) -> None:
        super().__init__(StringIO())
        self._logger = logger or logging.getLogger("rapc.run")

    def _write(self, event: events.Event, text: str) -> None:
        """Log the line of an event."""
        failed = isinstance(event, events.TaskFailed)
        level = logging.WARNING if failed else logging.INFO
        time, more = readable(event.time), {"event": event}
        self._logger.log(level, "%s %s", time, text.strip(), extra=more)
