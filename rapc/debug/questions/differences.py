"""Differences between two moments of a run, and between two runs."""

from __future__ import annotations

from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list, readable
from rapc.debug.answer import Answer, bound_to, question, say, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.recording import Recording
from rapc.runtime.events.trace import record


@question(
    "CYCLE [CYCLE] | FILE",
    ":diff 20",
    ":diff 20 60",
    ":diff other-seed.jsonl",
    of_recordings=True,
)
def diff(history: History, args: Arguments) -> Answer:
    """Show the differences between two moments, or from a recorded run.

    For two runs, the first different decision is shown: the selected task or the chosen
    method.
    """
    if args and not args.peek().isdecimal():
        return _from_a_recording(history, Path(args.word("file")))
    history.check_is_run()
    first = args.count("cycle")
    second = args.count("cycle", history.cycle)
    one, other = _at(history, first), _at(history, second)
    rows = [("+", "fact", format_list(f)) for f in other.facts if f not in one.facts]
    rows += [("-", "fact", format_list(f)) for f in one.facts if f not in other.facts]
    for sign, these, those in (("+", other, one), ("-", one, other)):
        left = [n for n in these.tasks if n not in those.tasks]
        rows += [(sign, "task", f"[{n}] {these.tasks[n][0]}") for n in left]
    for number, (goal, after) in other.tasks.items():
        before = one.tasks.get(number, (goal, after))[1]
        if before != after:
            rows.append(("~", "task", f"[{number}] {goal}: {before}, now {after}"))
    head = f"cycle {first} to cycle {second}"
    return table(("", "of", "what"), rows, head, none="no difference")


class _Snapshot(msgspec.Struct):
    """Facts in memory, and the goal, state and method of each task."""

    facts: dict[Fact, None]
    tasks: dict[int, tuple[str, str]]


def _at(history: History, cycle: int) -> _Snapshot:
    with history.at(cycle) as run:
        methods = {
            task.number: "" if task.run is None else f" {task.run.plan.name}"
            for task in run.tasks()
        }
        tasks = {e.task: (str(e.goal), e.state + methods[e.task]) for e in run.agenda()}
        return _Snapshot(dict.fromkeys(run.memory), tasks)


# --- two runs -----------------------------------------------------------------------

_DECISIONS = (events.TaskSelected, events.MethodChosen)
"""The events of decisions."""

_Event = dict[str, Any]


def _from_a_recording(history: History, path: Path) -> Answer:
    """Return the first decision in which the run differs from a recorded run."""
    own = (record(told.event()) for told in history.scan(*_DECISIONS))
    for here, there in zip_longest(own, Recording(path).written(_DECISIONS)):
        if {**(here or {}), "n": 0} != {**(there or {}), "n": 0}:
            cycle = (here or there or {})["cycle"]
            return say(
                f"first different decision, in cycle {cycle}:",
                f"  here:  {_decision(here)}",
                f"  there: {_decision(there)}",
            )
    return say("no different decision up to the end of the shorter run")


def _decision(event: _Event | None) -> str:
    if event is None:
        return "end of the run"
    at = f"at {readable(event['time'])}"
    if event["event"] == "task-selected":
        return f"{event['goal']} [{event['task']}] was selected {at}"
    chose = f"[{event['task']}] chose {event['method']} of {event['rap']} {at}"
    return f"{chose}{bound_to(event['bindings'])}"
