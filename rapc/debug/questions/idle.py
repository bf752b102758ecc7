"""Idle times of a thing, and the tasks that could have used the thing."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise

from rapc.base.names import hint
from rapc.base.values import Fact, format_atom, format_list, number, readable
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments, read_pattern
from rapc.debug.history import History
from rapc.debug.questions.times import account
from rapc.debug.questions.why_not import methods
from rapc.errors import ArgumentError
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.state.states import ELIGIBLE
from rapc.world import Time

_MOST = 10
"""The highest number of idle intervals that are listed: the longest."""

_Interval = tuple[Time, Time]


@question("THING", ":idle wheels", ":idle (arm arm1)")
def idle(history: History, args: Arguments) -> Answer:
    """List the times at which a thing was idle, and the tasks that could have used it.

    A thing is idle while no method holds the thing and no request uses it. For each
    interval, the answer lists the tasks that at its beginning had no method under way,
    could go on or waited for another thing, and lead to a use of the thing. Tasks that
    wait for a monitor, a time or the steps before them are left out. `could choose` has
    the methods whose contexts held. The 10 longest intervals are listed.
    """
    thing = _thing(history.library.program.library, args.word("thing"))
    found = idle_times(history, thing)
    longest = sorted(found, key=lambda one: one[0] - one[1])[:_MOST]
    leading = _leading(history.library.program.library, str(thing[0]))
    cycles = _cycles(history)
    rows = [
        (start, stop, stop - start, *row)
        for start, stop in sorted(longest)
        for row in _could(history, _cycle_at(cycles, start), leading)
    ]
    total, now = sum(stop - start for start, stop in found), history.now
    share = f", {100 * total / now:.0f} %" if now else ""
    said = format_atom(thing[0]) if len(thing) == 1 else format_list(thing)
    shown = f"{readable(number(round(total, 2)))} of {readable(now)}{share}"
    columns = ("from", "to", "time", "task", "goal", "waits for", "could choose")
    return table(columns, rows, none="never idle", notes=[f"{said} idle: {shown}"])


def _thing(library: Library, text: str) -> Fact:
    """Return the thing that a text names.

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


def idle_times(history: History, thing: Fact) -> list[_Interval]:
    """Return the intervals in which no method held a thing and no request used it.

    Raises:
        StateError: if the run cannot go back.
    """
    library = history.library.program.library
    used = [
        (spell.start, spell.stop)
        for spell in account(history).spells
        if any(thing in _used_by(library, part) for part in spell.parts)
    ]
    samples: list[tuple[Time, bool]] = [
        (run.now, any(claim.thing == thing for claim in run.claims()))
        for run in history.replayed()
    ]
    samples.append((history.now, False))
    used += [(one[0], two[0]) for one, two in pairwise(samples) if one[1]]
    found: list[_Interval] = []
    reached: Time = 0
    for start, stop in sorted(used):
        if start > reached:
            found.append((reached, start))
        reached = max(reached, stop)
    if history.now > reached:
        found.append((reached, history.now))
    return found


def _used_by(library: Library, request: Fact) -> list[Fact]:
    """Return the things that a request or a skill uses, as declared."""
    name, *given = request
    form = library.primitives.get(str(name)) or library.skills.get(str(name))
    if form is None:
        return []
    names = [one.variable.name for one in form.args]
    bound = dict(zip(names, given, strict=False))
    found = []
    for thing in form.uses:
        values = [
            term.value if isinstance(term, nodes.Const) else bound.get(term.name)
            for term in thing.args
            if isinstance(term, nodes.Const | nodes.Var)
        ]
        found.append((thing.name, *(one for one in values if one is not None)))
    return found


# --- the tasks ----------------------------------------------------------------------


def _leading(library: Library, name: str) -> Collection[str]:
    """Return the RAPs that lead to a use of a thing with a name."""
    found = {rap.name for rap in library.raps.values() if _uses(library, rap, name)}
    before = -1
    while len(found) > before:
        before = len(found)
        for rap in library.raps.values():
            called = (step.goal.name for m in rap.methods for step in steps(m))
            if any(one in found for one in called):
                found.add(rap.name)
    return found


def _uses(library: Library, rap: nodes.DefineRap, name: str) -> bool:
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


def _cycles(history: History) -> list[Time]:
    """Return the time at the end of each cycle, from 0 on."""
    ends: dict[int, Time] = {}
    for told in history.scan():
        ends[told.cycle] = told.time
    return [ends.get(cycle, 0) for cycle in range(history.cycle + 1)]


def _cycle_at(ends: Sequence[Time], time: Time) -> int:
    """Return the last cycle that had ended at a time."""
    return max((n for n, end in enumerate(ends) if end <= time), default=0)


def _could(
    history: History, cycle: int, leading: Collection[str]
) -> Iterator[tuple[object, ...]]:
    """Yield the tasks at the end of a cycle that lead to a use of a thing."""
    with history.at(cycle) as run:
        blocked = {number for claim in run.claims() for number in claim.waiting}
        rows: list[tuple[object, ...]] = [
            (f"[{one.task}]", str(one.goal), one.waits_for, _choices(run, one.task))
            for one in run.agenda()
            if (one.state == ELIGIBLE or one.task in blocked)
            and one.goal.name in leading
        ]
    yield from rows or [(None, "no task could use it", None, None)]


def _choices(run: Interpreter, number: int) -> str:
    """Return the methods of a task that could be chosen now."""
    task = run.task(number)
    if not task.bound:
        return ""
    return " ".join(one.name for one in methods(run, task) if one.holds)
