"""Differences between two moments of a run, and between two runs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec

from rapc import events
from rapc.base.source import place
from rapc.base.values import Fact, format_list, readable
from rapc.compiler.program import Program
from rapc.debug import costs
from rapc.debug.account import account_of
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments
from rapc.debug.bug import SUFFIX
from rapc.debug.history import History
from rapc.debug.log import EventLog, ToldEvent
from rapc.debug.names import program_of
from rapc.debug.questions import why
from rapc.debug.questions.times import sensors_of
from rapc.debug.questions.why_not import method_in_words
from rapc.debug.recording import Playback, Recording
from rapc.debug.reload import differing
from rapc.debug.story import Story
from rapc.errors import ArgumentError, Error, StateError
from rapc.host import find_plan, load
from rapc.runtime.events.trace import record
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import Time
from rapc.worlds.registry import world_of


@question(
    "CYCLE [CYCLE] | FILE | branch NAME | seed N | library PATH",
    ":diff 20",
    ":diff 20 60",
    ":diff yesterday.jsonl",
    ":diff branch main",
    ":diff seed 3",
    ":diff library old/",
    of_recordings=True,
)
def diff(history: History, args: Arguments) -> Answer:
    """Show the differences between two moments of the run, or between two runs.

    The other run is a recorded run, another branch, or a run that begins as this run
    did, with another seed or library. For two runs, the answer has the first different
    decision (the selected task or the chosen method) with the reasons on both sides,
    and a table with the cost of all differences in time.
    """
    if args and not args.peek().isdecimal():
        return compared(this_run(history), _other(history, args)).answer
    history.check_is_run()
    first = args.count("cycle")
    second = args.count("cycle", history.cycle)
    before, after = _snapshot(history, first), _snapshot(history, second)
    sides = (("+", after, before), ("-", before, after))
    rows = []
    for sign, one, other in sides:
        facts = [fact for fact in one.facts if fact not in other.facts]
        rows += [(sign, "fact", format_list(fact)) for fact in facts]
    for sign, one, other in sides:
        tasks = [n for n in one.tasks if n not in other.tasks]
        rows += [(sign, "task", f"[{n}] {one.tasks[n][0]}") for n in tasks]
    for number, (goal, state) in after.tasks.items():
        old = before.tasks.get(number, (goal, state))[1]
        if old != state:
            rows.append(("~", "task", f"[{number}] {goal}: {old}, now {state}"))
    head = f"cycle {first} to cycle {second}"
    return table(("", "of", "what"), rows, head, none="no difference")


class _Snapshot(msgspec.Struct):
    """The facts and the tasks at the end of a cycle."""

    facts: dict[Fact, None]
    #: The goal of each task, and its state with its method.
    tasks: dict[int, tuple[str, str]]


def _snapshot(history: History, cycle: int) -> _Snapshot:
    with history.at(cycle) as run:
        methods = {
            task.number: "" if task.run is None else f" {task.run.plan.name}"
            for task in run.tasks()
        }
        tasks = {e.task: (str(e.goal), e.state + methods[e.task]) for e in run.agenda()}
        return _Snapshot(dict.fromkeys(run.memory), tasks)


# --- two runs -----------------------------------------------------------------------


class Side(msgspec.Struct):
    """One of two runs to compare: its events up to a moment."""

    #: The name in tables and texts.
    name: str
    told: Sequence[ToldEvent]
    #: The time of the moment.
    now: Time
    #: Whether the run is over at the moment.
    over: bool
    spec: RunSpec
    sensors: Collection[str] = ()
    #: The history that explains past decisions; None if it cannot go back.
    history: History | None = None
    #: The library, if it is known.
    program: Program | None = None


def this_run(history: History, name: str = "here") -> Side:
    """Return a run up to its present moment."""
    told = list(history.scan())
    program = program_of(history)
    explains = history if history.is_run and not history.no_way_back else None
    now, spec, sensors = history.now, history.spec, sensors_of(history)
    return Side(name, told, now, history.over, spec, sensors, explains, program)


def recorded_run(path: Path, name: str = "there") -> Side:
    """Return a recorded run from its file, up to its end.

    Raises:
        LoadError: if the file is not the trace of a run.
    """
    recording = Recording(path)
    history = History(Playback(recording))
    history.goto(recording.last_cycle + 1)
    return this_run(history, name)


def _other(history: History, args: Arguments) -> Side:
    """Return the run that the arguments name, up to the present time of this run."""
    word = args.word("file")
    if word == "branch":
        found = _branch(history, args.word("name of a branch"))
    elif word == "seed":
        found = _begun_again(history, seed=args.count("seed"))
    elif word == "library":
        found = _begun_again(history, library=args.word("path of a library"))
    elif word.endswith(SUFFIX):
        raise ArgumentError(f"cannot compare with `{word}` here; use `rapc compare`")
    else:
        found = recorded_run(Path(word))
    if not history.over:
        found.told = [one for one in found.told if one.time <= history.now]
        found.now, found.over = history.now, False
    return found


def _branch(history: History, name: str) -> Side:
    """Return another branch of a history, up to its furthest moment."""
    told = history.told_by(name)
    now = told[-1].time if told else 0
    over = any(one.kind is events.RunEnded for one in told)
    spec, sensors = history.spec, sensors_of(history)
    program = history.library.program
    return Side(name, told, now, over, spec, sensors, None, program)


MOST_DURATIONS = 10
"""The time limit of a run begun for a comparison, in durations of the first run."""


def _begun_again(history: History, seed: int | None = None, library: str = "") -> Side:
    """Return a run that begins as this run did, with another seed or library.

    Raises:
        ArgumentError: for a run with faults, or with code of a Python program.
        Error: if the library or the world cannot be loaded or run.
    """
    history.check_is_run()
    spec = history.spec
    if spec.faults:
        raise ArgumentError(
            "cannot begin a run with faults again", "compare two traces of such runs"
        )
    if seed is not None:
        spec = msgspec.structs.replace(spec, seed=seed)
    program = history.library.program if not library else load(library).program
    run = Interpreter.prepared(program, world_of(spec), spec, planner=find_plan)
    until = spec.until
    if not history.over:
        until = history.now
    elif until is None:
        until = history.now * MOST_DURATIONS
    return finished(run, until, f"seed {seed}" if seed is not None else library)


def finished(run: Interpreter, until: Time | None, name: str) -> Side:
    """Run to the end or to a time, and return the run as one side."""
    log = EventLog()
    run.listen(log)
    run.start(until)
    history = History(run, log)
    history.go()
    return this_run(history, name)


# --- the first difference -----------------------------------------------------------

_MOST_REASONS = 8
"""The highest number of lines about the reasons of a decision."""

_FOLDER = re.compile(r"[^\s()]*[/\\](?=[^/\\\s]+\.rap:[0-9])")
"""The folder in the position of a definition."""

_DECISIONS = (events.TaskSelected, events.MethodChosen)
"""The events of decisions."""

_COMPARED = (
    *(events.TaskCreated, events.TaskBlocked, events.TaskWoken),
    *(events.TaskFailed, events.TaskSucceeded, events.MethodEnded),
    *(events.PrimitiveEnded, events.DataReceived, events.SignalReceived),
    *(events.FactAsserted, events.FactErased, *_DECISIONS),
)
"""The decisions, and the events that can be the reason for a different decision."""

_NOT_COMPARED = ("n", "by", "because")
"""The keys that may differ between events of equal runs."""

_Pair = tuple[ToldEvent | None, ToldEvent | None]
"""An event of each side at the same position; None after the last event of a side."""


class Difference(msgspec.Struct, frozen=True):
    """The first decision in which two runs differ; None for the end of a run."""

    here: ToldEvent | None
    there: ToldEvent | None
    #: The first different event before the decision, if there is one.
    before: _Pair | None = None


def first_difference(here: Side, there: Side) -> Difference | None:
    """Return the first different decision of two runs; None without a difference.

    Names of variables are not compared. The last event of a side that is not over is
    not a difference.
    """
    found = _first_different(_DECISIONS, here, there)
    if found is None:
        return None
    before = _first_different(_COMPARED, here, there)
    times = [one.time for one in found if one is not None]
    if before is None or before == found:
        return Difference(*found)
    earlier = any(one is not None and one.time <= max(times) for one in before)
    return Difference(*found, before if earlier else None)


def _first_different(
    kinds: Collection[type[events.Event]], here: Side, there: Side
) -> _Pair | None:
    sides = [[one for one in side.told if one.kind in kinds] for side in (here, there)]
    for one, other in zip_longest(*sides):
        if (one is None and not here.over) or (other is None and not there.over):
            return None
        if not _same(one, other):
            return one, other
    return None


def _same(one: ToldEvent | None, other: ToldEvent | None) -> bool:
    if one is None or other is None or one.kind is not other.kind:
        return False
    if one.time == other.time and one.keys == other.keys:
        return True
    return _compared_keys(one) == _compared_keys(other)


def _compared_keys(told: ToldEvent) -> Mapping[str, Any]:
    """Return the keys of an event that must agree in two equal runs."""
    found = record(told.event())
    for key in _NOT_COMPARED:
        found.pop(key, None)
    if told.kind is events.MethodChosen:
        found["bindings"] = list(found["bindings"].values())
    return found


def _lines(found: Difference, here: Side, there: Side) -> Iterator[str]:
    """Yield the first difference as text, with the reasons on both sides."""
    cycle = next(one.cycle for one in (found.here, found.there) if one is not None)
    yield f"first different decision, in cycle {cycle}:"
    stories = [Story(side.told, _library(side)) for side in (here, there)]
    reasons = [
        _reasons(here, stories[0], found.here, found.there),
        _reasons(there, stories[1], found.there, found.here),
    ]
    common = {_FOLDER.sub("", line) for line in reasons[0]}
    common &= {_FOLDER.sub("", line) for line in reasons[1]}
    shown = set(common)
    for side, other, told, beside, lines, story in (
        (*(here, there), *(found.here, found.there), reasons[0], stories[1]),
        (*(there, here), *(found.there, found.here), reasons[1], stories[0]),
    ):
        yield f"  {side.name}: {_decision(told)}"
        if told is not None:
            own = [one for one in lines if _FOLDER.sub("", one) not in common]
            shown.update(own)
            yield from (f"    {line}" for line in own[:_MOST_REASONS])
            if beside is None or beside.keys["task"] != told.keys["task"]:
                state, *behind = _state_at(other, story, told)
                shown.update(behind)
                yield f"    {other.name}: {state}"
                yield from (f"      {line}" for line in behind)
    if found.before is not None:
        yield "first different event before:"
        for side, story, told in zip((here, there), stories, found.before, strict=True):
            yield f"  {side.name}: {_event(told)}"
            places = [] if told is None else [*_behind(story, told)]
            yield from (f"    {line}" for line in places if line not in shown)


def _behind(story: Story, told: ToldEvent) -> Iterator[str]:
    """Yield the place of the step, method or formula behind an event, if known."""
    keys, what, where = told.keys, "", ""
    if told.kind is events.TaskCreated:
        chosen, step = story.step(told)
        if chosen is not None:
            of = f"method {chosen.keys['method']} of {chosen.keys['rap']}"
            what, where = f"step {keys['step']} of {of}", story.row(step)
    elif told.kind is events.MethodChosen:
        what = f"method {keys['method']} of {keys['rap']}"
        where = story.row(story.method(told))
    elif told.kind in (events.TaskBlocked, events.TaskWoken):
        what, where = story.wait(keys["on"], keys["task"])
    if where:
        yield f"{what} at {where}"


def _decision(told: ToldEvent | None) -> str:
    if told is None:
        return "end of the run"
    keys, at = told.keys, f"at {readable(told.time)}"
    if told.kind is events.TaskSelected:
        return f"{keys['goal']} [{keys['task']}] was selected {at}"
    chose = f"[{keys['task']}] chose {keys['method']} of {keys['rap']} {at}"
    bound = [f"{name} {readable(value)}" for name, value in keys["bindings"].items()]
    return f"{chose} with {' '.join(bound)}" if bound else chose


def _event(told: ToldEvent | None) -> str:
    """Return an event as a line."""
    if told is None:
        return "no further event"
    keys, at = told.keys, f"at {readable(told.time)}"
    if told.kind is events.FactAsserted:
        return f"{format_list(keys['fact'])} asserted {at} by {keys['by']}"
    if told.kind is events.FactErased:
        return f"{format_list(keys['fact'])} erased {at} by {keys['by']}"
    if told.kind is events.DataReceived:
        return f"datum {format_list(keys['data'])} {at}"
    line = (told.event().line() or "").strip()
    line = line.removeprefix("... ").removeprefix("--> ").split("\n")[0]
    return f"{line or told.kind.__struct_config__.tag} {at}"


def _reasons(
    side: Side, story: Story, told: ToldEvent | None, beside: ToldEvent | None
) -> list[str]:
    """Return the reasons of a decision: from the events, and from a replay.

    If the sides chose different methods, the two methods are explained.

    Args:
        side: the run of the decision.
        story: the events of that run.
        told: the decision.
        beside: the decision of the other run.
    """
    if told is None:
        return []
    found = [*_behind(story, told), *_why_eligible(side, story, told)]
    if side.history is None:
        return found
    try:
        choice, doing = why.reasons(side.history, told.keys["task"], told.cycle)
    except (ArgumentError, StateError):
        return found
    if told.kind is events.TaskSelected:
        return found + [line.strip() for line in list(why.of_choice(choice))[1:]]
    chosen = {one.keys.get("method") for one in (told, beside) if one is not None}
    for method in doing.methods if len(chosen) > 1 else ():
        if method.name in chosen:
            found.append(f"method {method.name}: {method_in_words(method)}")
    return found + [str(origin) for origin in doing.rests_on]


def _why_eligible(side: Side, story: Story, told: ToldEvent) -> Iterator[str]:
    """Yield the last event that made a selected task eligible.

    For a task that was woken, the request or datum of that time is added.
    """
    if told.kind is not events.TaskSelected:
        return
    number = told.keys["task"]
    woken = None
    for one in reversed(side.told):
        if one.serial >= told.serial:
            continue
        if woken is not None:
            if one.time != woken.time:
                return
            if one.kind in (events.PrimitiveEnded, events.DataReceived):
                yield f"after {_event(one)}"
                return
        elif one.keys.get("task") != number:
            continue
        elif one.kind is events.TaskWoken:
            woken = one
            yield f"woken by {one.keys['on']}"
            yield from _behind(story, one)
        elif one.kind is events.MethodEnded:
            yield f"its method {one.keys['method']} ended: {one.keys['result']}"
            return
        elif one.kind is events.TaskCreated:
            parent = one.keys["parent"]
            made = (
                f"step {one.keys['step']} of [{parent}]" if parent else "top-level task"
            )
            yield f"{made}, created at {readable(one.time)}"
            return


_STATES: Mapping[type[events.Event], str] = {
    events.TaskBlocked: "blocked until {on}",
    events.TaskWoken: "woken by {on}",
    events.MethodChosen: "method {method} of {rap} is under way",
    events.MethodSuspended: "suspended by [{by}]",
    events.MethodEnded: "method {method} has ended: {result}",
    events.TaskSucceeded: "has succeeded",
    events.TaskFailed: "has failed: {result}",
    events.TaskRemoved: "was removed: {cause}",
    events.TaskCreated: "has been created",
}
"""The state of a task after an event, as text."""


def _state_at(side: Side, story: Story, told: ToldEvent) -> Iterator[str]:
    """Yield the state of a task at the time of an event, and the position of its wait.

    Args:
        side: the run with the state.
        story: the events of that run.
        told: an event of the task in the other run.
    """
    number, at = told.keys["task"], readable(told.time)
    state, last = "has not been created", None
    for one in side.told:
        if one.time > told.time:
            break
        if one.keys.get("task") == number and one.kind in _STATES:
            since = f" since {readable(one.time)}" if one.time < told.time else ""
            state, last = _STATES[one.kind].format(**one.keys) + since, one
    yield f"[{number}] at {at}: {state}"
    if last is not None and last.kind is events.TaskBlocked:
        yield from _behind(story, last)


# --- the whole comparison -----------------------------------------------------------


def _library(side: Side) -> Program | None:
    return side.program or library_of(side.spec)


def library_of(spec: RunSpec) -> Program | None:
    """Return the library of a run; None if it has changed since the run."""
    try:
        found = load(spec.library).program
    except Error:
        return None
    return found if found.digest == spec.digest else None


def changed_definitions(here: Side, there: Side) -> list[str]:
    """Return the definitions that differ between the libraries of two sides.

    Each line has the place in the library of the second side, or of the first for a
    definition that was removed.
    """
    if here.spec.digest == there.spec.digest and here.program is there.program:
        return []
    first, second = _library(here), _library(there)
    if first is None or second is None or first is second:
        return []
    one, other = first.library, second.library
    found = []
    for kind, name, before, after in differing(one, other):
        node, files = (after, other.files) if after else (before, one.files)
        assert node is not None
        what = "removed" if after is None else "added" if before is None else "changed"
        called = kind if name == kind else f"{kind} `{name}`"
        found.append(f"{place(node.span, files)}: {called} {what}")
    return found


def _times(side: Side) -> costs.Times:
    return costs.times_of(account_of(side.told, side.now, side.sensors))


class Comparison(msgspec.Struct, frozen=True):
    """The comparison of two runs, or of pairs of runs."""

    answer: Answer
    #: Whether the second side is worse by at least the threshold.
    worse: bool


def compared(
    here: Side,
    there: Side,
    *,
    pairs: Sequence[costs.Pair] = (),
    of: str = "",
    threshold: float = 0,
) -> Comparison:
    """Compare two runs: the first different decision, and the cost of all differences.

    Args:
        here: the first run.
        there: the second run.
        pairs: the sums of several pairs of runs, one of which is the pair of the two
            runs; default: of the two runs.
        of: the name of the pair of the two runs.
        threshold: see `costs.verdict`.
    """
    pairs = pairs or [(_times(here), _times(there))]
    names, lines = (here.name, there.name), ["no difference in decisions"]
    found = first_difference(here, there)
    if found is not None:
        lines = list(_lines(found, here, there))
    if of:
        lines[0] = f"{of}: {lines[0]}"
    notes = changed_definitions(here, there)
    answer = costs.table_of(pairs, names, *lines, notes=notes)
    return Comparison(answer, costs.verdict(pairs, names, threshold).worse)
