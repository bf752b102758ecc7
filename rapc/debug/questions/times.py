"""Questions about the time of a run: retries, deadlines, and the timeline.

The answers come from the events of the run up to the present moment.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any

from rapc import events
from rapc.base.values import Atom, Fact, format_atom, format_list, number, readable
from rapc.debug.account import (
    SUSPENDED,
    WAITING,
    Account,
    Piece,
    Spell,
    account_of,
    idle_in_words,
    times,
)
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import ArgumentError, WorldError
from rapc.world import Time
from rapc.worlds.registry import find_world


@question(of_recordings=True)
def retries(history: History, args: Arguments) -> Answer:
    """List the goals that failed more than once, with reasons.

    If `times` is 1, all failures happened at the same time.
    """
    by_goal: dict[str, list[ToldEvent]] = {}
    for told in history.scan(events.TaskFailed):
        by_goal.setdefault(str(told.keys["goal"]), []).append(told)
    rows = []
    for goal, failed in sorted(by_goal.items(), key=lambda item: -len(item[1])):
        if len(failed) > 1:
            results = Counter(one.keys["result"] for one in failed).items()
            [(cause, _)] = Counter(map(_root, failed)).most_common(1)
            span = f"{readable(failed[0].time)} to {readable(failed[-1].time)}"
            said = ", ".join(f"{count} {result}" for result, count in results)
            times = len({one.time for one in failed})
            rows.append((goal, len(failed), times, span, said, cause))
    columns = ("goal", "failed", "times", "from", "results", "most frequent reason")
    return table(columns, rows, none="no goal failed more than once")


def _root(told: ToldEvent) -> str:
    """Return the clause of the first cause of a failure."""
    cause = told.keys["because"]
    while cause is not None and cause.because is not None:
        cause = cause.because
    return "" if cause is None else cause.clause


@question(of_recordings=True)
def deadlines(history: History, args: Arguments) -> Answer:
    """List the missed and the next deadlines."""
    goals: dict[int, str] = {}
    ended: dict[int, Time] = {}
    missed: dict[tuple[int, Time], None] = {}
    ends = (events.TaskSucceeded, events.TaskFailed, events.TaskRemoved)
    for told in history.scan(events.TaskCreated, events.DeadlineMissed, *ends):
        task = told.keys["task"]
        if told.kind is events.TaskCreated:
            goals[task] = str(told.keys["goal"])
        elif told.kind is events.DeadlineMissed:
            missed[task, told.keys["deadline"]] = None
        else:
            ended[task] = told.time
    now = history.now
    rows: list[tuple[object, ...]] = [
        (task, goals[task], time, "missed", end, (now if end is None else end) - time)
        for task, time in missed
        for end in [ended.get(task)]
    ]
    # A playback has no agenda: its future deadlines are unknown.
    entries = {e.task: e for e in (history.run.agenda() if history.is_run else ())}
    for entry in entries.values():
        above, due = entries.get(entry.parent or 0), entry.deadline
        if due is not None and due >= now and (above is None or above.deadline != due):
            rows.append((entry.task, str(entry.goal), due, "ahead", None, due - now))
    columns = ("task", "goal", "deadline", "", "ended", "late or left")
    return table(columns, rows, none="no deadlines")


# --- the timeline and waits -----------------------------------------------------------


def account(history: History) -> Account:
    """Return the account of the time of a run, up to the present moment."""
    told = history.scan(*Account.kinds)
    return account_of(told, history.now, sensors_of(history))


def sensors_of(history: History) -> Collection[str]:
    """Return the sensor primitives of the world of a run.

    A recorded run may name a world that is not installed: then no primitive counts as a
    sensor.
    """
    if history.is_run:
        return history.run.world.kit.offer.sensors
    if history.spec.world_class:
        return ()
    try:
        return find_world(history.spec.world).kit.offer.sensors
    except WorldError:
        return ()


@question("[FROM [TO]]", ":timeline", ":timeline 200 240", of_recordings=True)
def timeline(history: History, args: Arguments) -> Answer:
    """Show the requests, active skills and waiting over time.

    Each request and skill is listed at its start, with the result of the request or the
    events reported by the skill. A wrong belief is listed too, if the world tells the
    truth. If several requests or skills overlap, the last to start counts for its
    family. A time without them counts for one of the waits; `:waits` lists all waits.
    """
    start = args.time("time") if args else 0
    stop = args.time("time") if args else None
    whole = account(history)
    rows: list[tuple[Any, ...]] = [
        (
            *(one.start, one.stop, one.family and f"[{one.family}]"),
            one.task and f"[{one.task}]",
            " ".join(map(format_list, one.parts)) or one.waits,
            one.result or _in_words(one.heard),
        )
        for one in spells(whole, start, stop)
    ]
    for one in history.branch.discrepancies.up_to(history.serial).all:
        ended = history.now if one.ended is None else one.ended
        if ended > max(start, one.time) and (stop is None or one.time < stop):
            wrong = f"wrong belief: {format_list(one.belief.fact)}"
            rows.append((one.time, ended, None, None, wrong, ""))
    rows.sort(key=lambda row: row[0])
    used = times(whole.of_run, _user, start, stop)
    total = sum(used.values())
    notes = [
        f"{user}: {format_atom(number(round(time, 2)))} of "
        f"{format_atom(number(round(total, 2)))}, {100 * time / total:.0f} %"
        for user, time in used.items()
    ]
    columns = ("from", "to", "family", "task", "what", "result or events")
    return table(columns, rows, none="no time passed", notes=notes)


def _user(piece: Piece) -> str:
    """Return the family or the wait that a piece of the time counts for."""
    if piece.kind in (WAITING, SUSPENDED):
        return idle_in_words(piece.kind, piece.what)
    return f"family [{piece.family}]"


def _in_words(signals: Sequence[Fact]) -> str:
    """Return signals as text: unique signals in full, repeats by name and count."""
    by_name: dict[Atom, list[Fact]] = {}
    for one in signals:
        by_name.setdefault(one[0], []).append(one)
    return ", ".join(
        format_list(same[0]) if len(same) == 1 else f"{name} {len(same)} times"
        for name, same in by_name.items()
    )


def spells(account: Account, start: Time = 0, stop: Time | None = None) -> list[Spell]:
    """Return the intervals between two times, ordered by start.

    Intervals of waiting fill the gaps, so that the intervals cover all time.

    Args:
        account: the account of the run.
        start: omit intervals that ended at or before this time.
        stop: omit intervals that began at or after this time; None for no limit.
    """
    waiting = [
        Spell(one.start, one.stop, one.family, one.task, [], waits=_user(one))
        for one in account.of_run
        if one.kind in (WAITING, SUSPENDED)
    ]
    found = [one for one in account.spells if one.stop > one.start]
    return sorted(
        (
            one
            for one in (*found, *waiting)
            if one.stop > start and (stop is None or one.start < stop)
        ),
        key=lambda one: one.start,
    )


@question("[TASK]", ":waits", ":waits 12", of_recordings=True)
def waits(history: History, args: Arguments) -> Answer:
    """List the waits of a task and its steps; or sum up all waits of the run.

    A task waits for a monitor, a window (a time), a thing, a signal, the order of
    steps, a device (its request is under way, or the world refused it), after a
    suspension, or for its turn.
    """
    whole = account(history)
    if args:
        return _waits_of(whole, args.task(history, ended=True))
    groups: dict[tuple[str, str, str], list[Time]] = {}
    for one in whole.waits:
        rap = one.goal[1:].rstrip(")").split(" ")[0]
        groups.setdefault((one.kind, one.on, rap), []).append(one.stop - one.start)
    rows = [
        (kind, on, rap, len(took), sum(took), max(took))
        for (kind, on, rap), took in groups.items()
    ]
    rows.sort(key=lambda row: -row[4])
    columns = ("for", "what", "by tasks of", "times", "time", "longest")
    return table(columns, rows, none="no task has waited")


def _waits_of(account: Account, task: int) -> Answer:
    """Return the waits of a task and its descendants, by their start."""
    if task not in account.parents and task not in account.families:
        raise ArgumentError(f"unknown task [{task}]")
    family = {task}
    for child, parent in account.parents.items():
        if parent in family:
            family.add(child)
    rows = [
        (
            *(one.start, one.stop, one.stop - one.start, f"[{one.task}] {one.goal}"),
            *(one.kind, one.on, one.by and f"[{one.by}]"),
        )
        for one in sorted(account.waits, key=lambda one: (one.start, one.task))
        if one.task in family
    ]
    columns = ("from", "to", "time", "task", "for", "what", "of")
    return table(columns, rows, none=f"task [{task}] and its steps have not waited")
