"""Questions about the time of a run: retries, deadlines, and the timeline.

The answers come from the events of the run up to the present moment.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import msgspec

from rapc import events
from rapc.base.values import Atom, Fact, format_atom, format_list, number, readable
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.world import Time


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


# --- the timeline -------------------------------------------------------------------

_ENDS = (
    events.PrimitiveEnded,
    events.PrimitiveCancelled,
    events.RequestRefused,
)


class Spell(msgspec.Struct, eq=False):
    """An interval of a run: a request, the skills of an activation, or waiting."""

    start: Time
    #: The end of the interval; the present time while under way.
    stop: Time
    family: int | None
    task: int | None
    #: The request or the skills (more may be added); empty while all tasks wait.
    parts: list[Fact]
    #: The signals of the skills, in order.
    heard: list[Fact] = []
    #: The number of skills still enabled; 0 for a request.
    on: int = 0


@question("[FROM [TO]]", ":timeline", ":timeline 200 240", of_recordings=True)
def timeline(history: History, args: Arguments) -> Answer:
    """Show the requests, active skills and waiting over time.

    Each request and skill is listed at its start, with the events reported by the
    skill. If several requests or skills overlap, the last to start counts for its
    family.
    """
    start = args.time("time") if args else 0
    stop = args.time("time") if args else None
    found = spells(history, start, stop)
    rows = [
        (
            *(one.start, one.stop, one.family and f"[{one.family}]"),
            one.task and f"[{one.task}]",
            " ".join(map(format_list, one.parts)) or "waiting",
            _in_words(one.heard),
        )
        for one in found
    ]
    used = time_by_family(found, start, stop)
    total = sum(used.values())
    notes = [
        f"{'waiting' if family is None else f'family [{family}]'}: "
        f"{format_atom(number(round(time, 2)))} of "
        f"{format_atom(number(round(total, 2)))}, {100 * time / total:.0f} %"
        for family, time in used.items()
    ]
    columns = ("from", "to", "family", "task", "what", "heard")
    return table(columns, rows, none="no time passed", notes=notes)


def _in_words(signals: Sequence[Fact]) -> str:
    """Return signals as text: unique signals in full, repeats by name and count."""
    by_name: dict[Atom, list[Fact]] = {}
    for one in signals:
        by_name.setdefault(one[0], []).append(one)
    return ", ".join(
        format_list(same[0]) if len(same) == 1 else f"{name} {len(same)} times"
        for name, same in by_name.items()
    )


def spells(history: History, start: Time = 0, stop: Time | None = None) -> list[Spell]:
    """Return the intervals between two times, ordered by start.

    Intervals of waiting fill the gaps, so that the intervals cover all time.

    Args:
        history: the run.
        start: omit intervals that ended at or before this time.
        stop: omit intervals that began at or after this time; None for no limit.
    """
    found = [one for one in _read(history) if one.stop > one.start]
    return [
        one
        for one in _with_waiting(found, history.now)
        if one.stop > start and (stop is None or one.start < stop)
    ]


def _read(history: History) -> list[Spell]:
    """Return the requests and activations from events, ordered by start."""
    now = history.now
    families: dict[int, int] = {}
    found: list[Spell] = []
    requests: list[Spell] = []
    #: The latest activation of each task.
    activations: dict[int, Spell] = {}
    kinds = (*_ENDS, events.TaskCreated, events.PrimitiveRequested)
    of_skills = (events.SkillEnabled, events.SkillDisabled, events.SignalReceived)
    for told in history.scan(*kinds, *of_skills):
        keys, task = told.keys, told.keys["task"]
        if told.kind is events.TaskCreated:
            families[task] = keys["family"]
        elif told.kind is events.PrimitiveRequested:
            part = keys["request"]
            spell = Spell(told.time, now, families.get(task), task, [part])
            found.append(spell)
            requests.append(spell)
        elif told.kind in _ENDS:
            for spell in requests:
                if keys["request"] in spell.parts and task in (None, spell.task):
                    spell.stop = told.time
                    requests.remove(spell)
                    break
        elif told.kind is events.SkillEnabled:
            known = activations.get(task)
            if known is None or not known.on:
                known = Spell(told.time, now, families.get(task), task, [])
                activations[task] = known
                found.append(known)
            known.on += 1
            if keys["what"] not in known.parts:
                known.parts.append(keys["what"])
        elif task in activations and told.kind is events.SignalReceived:
            activations[task].heard.append(keys["what"])
        elif task in activations:
            activations[task].on -= 1
            if not activations[task].on:
                activations[task].stop = told.time
    return found


def _with_waiting(spells: Sequence[Spell], now: Time) -> Iterator[Spell]:
    """Yield intervals ordered by start, with waiting in the gaps."""
    reached: Time = 0
    for one in spells:
        if one.start > reached:
            yield Spell(reached, one.start, None, None, [])
        yield one
        reached = max(reached, one.stop)
    if now > reached:
        yield Spell(reached, now, None, None, [])


def time_by_family(
    spells: Iterable[Spell], start: Time = 0, stop: Time | None = None
) -> dict[int | None, Time]:
    """Return the time that each family used between two times, most first.

    Each moment counts for the interval that began last among those under way. The key
    None stands for waiting.
    """
    marks: list[tuple[Time, int, bool]] = []
    listed = list(spells)
    for at, one in enumerate(listed):
        begin = max(one.start, start)
        end = one.stop if stop is None else min(one.stop, stop)
        if end > begin:
            marks += [(begin, at, True), (end, at, False)]
    found: Counter[int | None] = Counter()
    under_way: list[int] = []
    last: Time = start
    for time, at, begins in sorted(marks):
        if under_way and time > last:
            used = time - last
            found[listed[max(under_way)].family] += used  # type: ignore[assignment]
        last = time
        if begins:
            under_way.append(at)
        else:
            under_way.remove(at)
    return dict(found.most_common())
