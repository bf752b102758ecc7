"""The records of a journal in the form of a run: answers, plans, acts, its end."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any, NamedTuple

import msgspec

from rapc.debug import act_lines
from rapc.debug.acts import Act
from rapc.debug.history import Done
from rapc.durable.folder import Stored
from rapc.durable.records import (
    Acted,
    Answered,
    Ended,
    Reached,
    Record,
    Requested,
    Solved,
)
from rapc.durable.resuming import Sent
from rapc.errors import Error, LoadError
from rapc.runtime.answers import Answer, Answers, Position


class Past(NamedTuple):
    """The contents of some records."""

    answers: list[Answer]
    #: The readings after the last answer.
    readings: int
    #: The request after the last answer, if any.
    sent: Sent | None
    #: The methods of solvers: the cycle, the RAP and the methods.
    solved: list[tuple[int, str, Any]]
    acts: list[Done]
    #: The last cycle that the run is known to have reached.
    cycle: int
    #: The reason for the end of the run, or an empty text.
    reason: str


def past_of(records: Iterable[Record], cycle: int = 0) -> Past:
    """Return the contents of records.

    Args:
        records: the records, in their order.
        cycle: the cycle that the run has reached before.

    Raises:
        LoadError: for an act that cannot be read.
    """
    answers: list[Answer] = []
    solved: list[tuple[int, str, Any]] = []
    acts: list[Done] = []
    readings, sent, reason = 0, None, ""
    for record in records:
        if isinstance(record, Answered):
            answers.append(
                Answer(record.readings, record.call, record.asked, record.told)
            )
            readings, sent = 0, None
        elif isinstance(record, Requested):
            readings, sent = record.readings, Sent(record.call, record.asked)
        elif isinstance(record, Solved):
            found = record.planned or record.methods
            solved.append((record.cycle, record.rap, found))
        elif isinstance(record, Acted):
            readings = max(readings, record.readings)
            act = _act(record.act)
            acts.append(Done(record.cycle, record.arrivals, record.time, act))
        elif isinstance(record, Reached):
            readings, cycle = max(readings, record.readings), record.cycle
        elif isinstance(record, Ended):
            readings = max(readings, record.readings)
            cycle, reason = record.cycle, record.reason
        elif acts:
            acts.pop()
    return Past(answers, readings, sent, solved, acts, cycle, reason)


def _act(line: Any) -> Act:
    try:
        return act_lines.read(msgspec.convert(line, act_lines.line_types()))
    except (Error, ValueError, RecursionError) as error:
        said = f"the journal has an act that cannot be read: {error}"
        raise LoadError(said) from error


def fill(answers: Answers, stored: Stored, past: Past) -> None:
    """Fill the store of a run with the answers of a journal."""
    first = stored.snapshot.answers if stored.snapshot else 0
    answers.kept, answers.first = past.answers, first
    answers.readings = past.readings
    answers.position = Position(first)
    answers.coming = deque(past.solved)
