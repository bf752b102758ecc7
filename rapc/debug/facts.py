"""What has been: of facts and items, of retries and deadlines.

Gathered from the events of the run up to now.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import msgspec

from rapc import events
from rapc.base.values import Fact, format_atom, format_list, match_pattern, readable
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.world import Time

_FACTS = (events.FactAsserted, events.FactErased)
_ITEMS = (
    events.ItemIntroduced,
    events.ItemMerged,
    events.ItemMoved,
    events.ItemLost,
)
_CAUSES = (events.PrimitiveEnded, events.DataReceived, events.TaskSelected)


class FactChange(NamedTuple):
    """A fact that came or went, or what became of an item."""

    time: Time
    cycle: int
    #: `+`, `-`, or what became of the item.
    what: str
    said: str
    #: By what: a request of a task, a datum, a notation, the user.
    by: str


def of_facts(history: History, pattern: Fact) -> list[FactChange]:
    """Return when facts that match a pattern came and went.

    Args:
        history: the history.
        pattern: a name with values and variables; as many arguments as are known.
    """
    size = len(pattern)

    def wanted(told: ToldEvent) -> bool:
        fact = told.keys["fact"]
        return len(fact) >= size and match_pattern(pattern, fact[:size]) is not None

    return _changes(history, wanted, lambda told: False)


def of_item(history: History, name: str, predicate: str = "") -> list[FactChange]:
    """Return what has become of an item under all its names, and the facts about it.

    Args:
        history: the history.
        name: one of its names.
        predicate: the facts of this name alone, if it is given.
    """
    names = _names_of(history, name)

    def about(told: ToldEvent) -> bool:
        fact = told.keys["fact"]
        if predicate and fact[0] != predicate:
            return False
        return not names.isdisjoint([part for part in fact[1:] if type(part) is str])

    def became(told: ToldEvent) -> bool:
        return not predicate and (told.keys["item"] in names)

    return _changes(history, about, became)


def _names_of(history: History, name: str) -> set[str]:
    """Return all names that stand for one item now."""
    if not history.is_run:
        merged = history.scan(events.ItemMerged)
        pairs = [{told.keys["item"], told.keys["with_"]} for told in merged]
        return {name}.union(*(pair for pair in pairs if name in pair))
    items = history.run.machine.memory.items
    kept = str(items.canonical(name))
    return {name, kept} | {n for n in items.aliases if items.canonical(n) == kept}


def _changes(history: History, fact: Any, item: Any) -> list[FactChange]:
    """Return the changes that are wanted, each with what made it."""
    found: list[FactChange] = []
    open_since = 0
    chooser: int | None = None
    for told in history.scan(*_FACTS, *_ITEMS, *_CAUSES):
        if told.kind is events.TaskSelected:
            chooser, open_since = told.keys["task"], len(found)
        elif told.kind in (events.PrimitiveEnded, events.DataReceived):
            by = _source(told)
            for at in range(open_since, len(found)):
                if found[at].by == "handler":
                    found[at] = found[at]._replace(by=by)
            open_since = len(found)
        elif told.kind in _FACTS:
            if fact(told):
                found.append(_of_fact(told, chooser))
        elif item(told):
            found.append(_of_item(told))
    return found


def _source(told: ToldEvent) -> str:
    if told.kind is events.DataReceived:
        return f"datum {format_list(told.keys['data'])}"
    task = told.keys["task"]
    return format_list(told.keys["request"]) + ("" if task is None else f" [{task}]")


def _of_fact(told: ToldEvent, chooser: int | None) -> FactChange:
    by = told.keys["by"]
    if by == "notation" and chooser is not None:
        by = f"notation [{chooser}]"
    sign = "+" if told.kind is events.FactAsserted else "-"
    return FactChange(told.time, told.cycle, sign, format_list(told.keys["fact"]), by)


def _of_item(told: ToldEvent) -> FactChange:
    keys = told.keys
    what = told.kind.__struct_config__.tag
    assert isinstance(what, str)
    said = f"{keys['item']} at {format_atom(keys['location'])}"
    if keys.get("with_") is not None:
        said += f", also {keys['with_']}"
        if keys.get("score") is not None:
            said += f", score {readable(keys['score'])}"
    return FactChange(
        told.time, told.cycle, what.removeprefix("item-"), said, "handler"
    )


# --- retries ------------------------------------------------------------------------


class Retry(msgspec.Struct, frozen=True):
    """A goal that has failed more than once."""

    goal: str
    failed: int
    #: At how many different times; 1 means: again and again with the clock standing.
    times: int
    first: Time
    last: Time
    #: What it came to, with how often.
    results: Mapping[str, int]
    #: The clause that was named as the cause, and how often, most often first.
    causes: Mapping[str, int]


def retries(history: History) -> list[Retry]:
    """Return the goals that have failed more than once, the most frequent first."""
    by_goal: dict[str, list[ToldEvent]] = {}
    for told in history.scan(events.TaskFailed):
        by_goal.setdefault(str(told.keys["goal"]), []).append(told)
    found = [
        Retry(
            goal=goal,
            failed=len(told),
            times=len({one.time for one in told}),
            first=told[0].time,
            last=told[-1].time,
            results=dict(Counter(one.keys["result"] for one in told)),
            causes=dict(Counter(map(_root, told)).most_common()),
        )
        for goal, told in by_goal.items()
        if len(told) > 1
    ]
    return sorted(found, key=lambda one: -one.failed)


def _root(told: ToldEvent) -> str:
    """Return the clause of the first cause of a failure."""
    cause = told.keys["because"]
    while cause is not None and cause.because is not None:
        cause = cause.because
    return "" if cause is None else cause.clause


# --- deadlines ----------------------------------------------------------------------


class Deadline(msgspec.Struct, frozen=True):
    """A deadline: missed, or still ahead."""

    task: int
    goal: str
    deadline: Time
    missed: bool
    #: When the task ended; None while it is under way.
    ended: Time | None
    #: How much too late it ended or is by now; how much is left if it is ahead.
    by: Time


def deadlines(history: History) -> list[Deadline]:
    """Return the deadlines that were missed, and those of tasks under way.

    Of a recorded run that is only looked at those that were missed alone are known.
    """
    goals: dict[int, str] = {}
    ended: dict[int, Time] = {}
    missed: dict[tuple[int, Time], None] = {}
    ends = (events.TaskSucceeded, events.TaskFailed, events.TaskRemoved)
    for told in history.scan(events.TaskCreated, events.DeadlineMissed, *ends):
        number = told.keys["task"]
        if told.kind is events.TaskCreated:
            goals[number] = str(told.keys["goal"])
        elif told.kind is events.DeadlineMissed:
            missed[number, told.keys["deadline"]] = None
        else:
            ended[number] = told.time
    now = history.now
    found = [
        Deadline(
            number,
            goals[number],
            time,
            True,
            ended.get(number),
            ended.get(number, now) - time,
        )
        for number, time in missed
    ]
    if not history.is_run:
        return found
    entries = {entry.task: entry for entry in history.run.agenda()}
    for entry in entries.values():
        above = entries.get(entry.parent or 0)
        own = above is None or above.deadline != entry.deadline
        if entry.deadline is not None and own and entry.deadline >= now:
            left = entry.deadline - now
            found.append(
                Deadline(entry.task, str(entry.goal), entry.deadline, False, None, left)
            )
    return found
