"""Idle times of a thing, and the tasks that could have used the thing."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.names import hint
from rapc.base.values import Fact, format_atom, format_list, number, readable
from rapc.debug.account import Account, Wait, first_word
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.questions.times import account
from rapc.errors import ArgumentError
from rapc.events import Goal
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library
from rapc.world import Time

_MOST = 10
"""The highest number of idle intervals that are listed: the longest."""

_Interval = tuple[Time, Time]


@question("THING", ":idle wheels", ":idle (arm arm1)")
def idle(history: History, args: Arguments) -> Answer:
    """List the times at which a thing was idle, and the tasks that could have used it.

    A thing is idle while no method holds the thing and no request uses it. For each
    interval, the answer lists the tasks that lead to a use of the thing and meanwhile
    waited for another thing or request, were suspended, or waited for their selection.
    Tasks that waited for a monitor, a time, a signal or the steps before them are left
    out. The 10 longest intervals are listed.
    """
    library = history.library.program.library
    thing = _thing(library, args.word("thing"))
    whole = account(history)
    found = idle_times(history, whole, thing)
    longest = sorted(found, key=lambda one: one[0] - one[1])[:_MOST]
    users = _raps_leading_to(library, str(thing[0]))
    waits = [
        one
        for one in whole.waits
        if first_word(one.goal) in users and (one.by is not None or one.kind == "turn")
    ]
    rows = [row for interval in sorted(longest) for row in _rows(interval, waits)]
    total, now = sum(stop - start for start, stop in found), history.now
    share = f", {100 * total / now:.0f} %" if now else ""
    text = format_atom(thing[0]) if len(thing) == 1 else format_list(thing)
    shown = f"{readable(number(round(total, 2)))} of {readable(now)}{share}"
    columns = ("from", "to", "task", "goal", "waited", "for", "of")
    return table(columns, rows, none="never idle", notes=[f"{text} idle: {shown}"])


def _rows(interval: _Interval, waits: Sequence[Wait]) -> Iterator[tuple[object, ...]]:
    """Yield a row for each task that could have used a thing in an interval."""
    start, stop = interval
    waited: dict[tuple[object, ...], Time] = {}
    for one in waits:
        took = min(one.stop, stop) - max(one.start, start)
        if took > 0:
            key = (one.task, one.goal, one.on, one.by)
            waited[key] = waited.get(key, 0) + took
    longest = sorted(waited.items(), key=lambda item: -item[1])
    for (task, goal, on, by), took in longest:
        yield start, stop, f"[{task}]", goal, took, on, by and f"[{by}]"
    if not waited:
        yield start, stop, None, "no task could use it", None, None, None


def _thing(library: Library, text: str) -> Fact:
    """Return the thing of an argument: `wheels` or `(arm arm1)`.

    Raises:
        ArgumentError: if the library neither claims nor uses such a thing.
        TextError: for an invalid text.
    """
    thing = read_pattern(text) if text.startswith("(") else (text,)
    if any(str(part).startswith("?") for part in thing[1:]):
        raise ArgumentError(f"the thing must not contain variables: {text}")
    known = {(one.name, len(one.args)) for one in _things(library)}
    if (thing[0], len(thing) - 1) not in known:
        names = [name for name, _ in known]
        raise ArgumentError(f"unknown thing `{text}`{hint(str(thing[0]), names)}")
    return thing


def _things(library: Library) -> Iterator[nodes.Thing]:
    """Yield the things that a library claims or uses, with repetitions."""
    for primitive in library.primitives.values():
        yield from primitive.uses
    for skill in library.skills.values():
        yield from skill.uses
    for rap in library.raps.values():
        for method in rap.methods:
            yield from method.claims


def bare_things(library: Library) -> set[str]:
    """Return the things without arguments that a library claims or uses."""
    return {one.name for one in _things(library) if not one.args}


def idle_times(history: History, whole: Account, thing: Fact) -> list[_Interval]:
    """Return the intervals in which no method held a thing and no request used it.

    Args:
        history: the run.
        whole: the account of the run up to the present time.
        thing: the thing.

    Raises:
        StateError: if the log has dropped events and the run cannot go back.
    """
    library = history.library.program.library
    used = [
        (spell.start, spell.stop)
        for spell in whole.spells
        if any(thing in _used_by(library, part) for part in spell.parts)
    ]
    used += _claim_times(history, library, thing)
    found: list[_Interval] = []
    reached: Time = 0
    for start, stop in sorted(used):
        if start > reached:
            found.append((reached, start))
        reached = max(reached, stop)
    if history.now > reached:
        found.append((reached, history.now))
    return found


_METHOD_ENDS = (
    *(events.MethodEnded, events.MethodSuspended),
    *(events.TaskSucceeded, events.TaskFailed, events.TaskRemoved),
)
"""The events that end the method of a task."""


def _claim_times(
    history: History, library: Library, thing: Fact
) -> Iterator[_Interval]:
    """Yield the intervals in which a method under way claimed a thing."""
    claims = {
        (rap.name, method.traced_name): (rap, claim)
        for rap in library.raps.values()
        for method in rap.methods
        for claim in method.claims
        if claim.name == thing[0]
    }
    if not claims:
        return
    goals: dict[int, Goal] = {}
    since: dict[int, Time] = {}
    kinds = (events.TaskSelected, events.MethodChosen, *_METHOD_ENDS)
    for told in history.scan(*kinds):
        task = told.keys["task"]
        if told.kind is events.TaskSelected:
            goals[task] = told.keys["goal"]
        elif told.kind is events.MethodChosen:
            found = claims.get((told.keys["rap"], told.keys["method"]))
            if found is not None:
                rap, claim = found
                inputs = [one.name for one in rap.inputs]
                bound = dict(zip(inputs, goals[task].inputs, strict=False))
                if _filled_in(claim, {**bound, **told.keys["bindings"]}) == thing:
                    since[task] = told.time
        elif task in since:
            yield since.pop(task), told.time
    yield from ((start, history.now) for start in since.values())


def _used_by(library: Library, request: Fact) -> list[Fact]:
    """Return the things that a request or a skill uses, as declared."""
    name, *given = request
    form = library.primitives.get(str(name)) or library.skills.get(str(name))
    if form is None:
        return []
    names = [one.variable.name for one in form.args]
    bound = dict(zip(names, given, strict=False))
    return [_filled_in(thing, bound) for thing in form.uses]


def _filled_in(thing: nodes.Thing, bound: Mapping[str, Any]) -> Fact:
    """Return a thing with the values of its variables.

    Computed terms and variables without a value are left out.
    """
    values = [
        term.value if isinstance(term, nodes.Const) else bound.get(term.name)
        for term in thing.args
        if isinstance(term, nodes.Const | nodes.Var)
    ]
    return (thing.name, *(value for value in values if value is not None))


# --- the tasks ----------------------------------------------------------------------


def _raps_leading_to(library: Library, name: str) -> Collection[str]:
    """Return the RAPs whose methods, or descendants, claim or use a thing of a name."""
    found = {
        rap.name for rap in library.raps.values() if _uses_itself(library, rap, name)
    }
    before = -1
    while len(found) > before:
        before = len(found)
        for rap in library.raps.values():
            called = (step.goal.name for m in rap.methods for step in steps(m))
            if any(one in found for one in called):
                found.add(rap.name)
    return found


def _uses_itself(library: Library, rap: nodes.DefineRap, name: str) -> bool:
    """Return whether a method of a RAP itself claims or uses a thing."""
    for method in rap.methods:
        requests: list[str] = [one.name for one in method.skills]
        if isinstance(method.body, nodes.Primitive):
            requests.append(method.body.request.name)
        elif isinstance(method.body, nodes.Skills):
            requests += [one.name for one in method.body.enable]
        things = [*method.claims]
        for request in requests:
            form = library.primitives.get(request) or library.skills.get(request)
            things += form.uses if form is not None else ()
        if any(one.name == name for one in things):
            return True
    return False
