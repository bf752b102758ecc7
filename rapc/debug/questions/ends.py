"""Questions about the end of a run: its decisions, and what kept the goals.

The answers come from the events of the run and the text of the library. They need no
replay, so that `rapc run` gives them too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import msgspec

from rapc import events
from rapc.base.names import plural
from rapc.base.values import format_list, number, readable
from rapc.compiler.program import Program
from rapc.debug.account import (
    SUSPENDED,
    WAITING,
    Account,
    Piece,
    account_of,
    idle_in_words,
)
from rapc.debug.answer import Answer, in_pairs, question, say, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.names import predicates, program_of
from rapc.debug.questions.beliefs import wrong_beliefs
from rapc.debug.sources import Source, sources
from rapc.debug.story import Request, Story, first_causes, thresholds
from rapc.debug.symptoms import LEAST, OF_SYMPTOMS, Symptom, symptoms
from rapc.ir.printer import format_formula
from rapc.runtime.events.report import OF_GOALS
from rapc.world import OKAY, Time

_MOST = 3
"""The number of failures, and of waits, that are listed for a goal not reached."""

_REACHED = "succeeded"
"""The outcome of a goal that was reached."""

_MOST_DECISIONS = (2, 4)
"""The numbers of decisions before the end that are listed: the last, the first."""


class Decision(NamedTuple):
    """A decision or an event before the end of a run."""

    time: Time
    cycle: int
    task: str
    what: str
    #: The bindings of a choice, or the facts that woke a task.
    because: str = ""
    where: str = ""


class Obstacle(NamedTuple):
    """A reason for which a goal is not reached, or was reached late."""

    kept_by: str
    times: int
    time: Time | None
    #: The cause of a failure; or the requests or the wait of other tasks meanwhile.
    because: str
    where: str


_NOTHING = Obstacle("", 0, None, "", "")
"""The obstacle in the row of a goal without obstacles."""


# --- the decisions behind the end -----------------------------------------------------


SourceOf = Callable[[ToldEvent], Source | None]
"""A function that returns the source of the assertion of a fact, if it is known."""


def _no_source(told: ToldEvent) -> Source | None:
    return None


def decisions(story: Story, source_of: SourceOf) -> list[Decision]:
    """Return the last request of a run and the decisions behind it, latest first.

    Args:
        story: the run, from events of `OF_DECISIONS` and of facts.
        source_of: the source of an assertion.
    """
    last = _last_request(story)
    if last is None:
        return []
    found = [_of_request(story, last)]
    for task in story.parents(last.task):
        chosen = story.choice(task, last.begun.serial)
        if chosen is not None and task != last.task:
            found.append(_of_choice(story, chosen))
        woken = story.woken.get(task)
        if woken is not None and (chosen is None or woken.serial < chosen.serial):
            found.append(_of_wake(story, woken, source_of))
            found += _of_hold(story, woken, last.begun.serial)
            break
    return sorted(found, key=lambda one: -one.time)


def _of_hold(story: Story, woken: ToldEvent, before: int) -> Iterator[Decision]:
    """Yield the longest wait for a thing after a wake, and the choice of the holder.

    The constraints of the chosen method are a row of their own.
    """
    task = woken.keys["task"]
    waits = [
        (start, stop)
        for start, stop in story.held.get(task, ())
        if woken.serial < start.serial < before and stop.time > start.time
    ]
    if not waits:
        return
    start, stop = max(waits, key=lambda wait: wait[1].time - wait[0].time)
    holder, thing = start.keys["holder"], start.keys["on"]
    waited = readable(number(stop.time - start.time))
    said = f"waited {waited} for {thing} of {story.named(holder)}"
    yield Decision(stop.time, stop.cycle, story.named(task), said)
    chosen = story.choice(holder, start.serial)
    if chosen is None:
        return
    yield _of_choice(story, chosen)
    method = story.method(chosen)
    if method is not None and method.constraints is not None:
        because, where = story.test(method.constraints)
        said = f"under constraints {format_formula(method.constraints)}"
        where = where or story.row(method.constraints)
        at = chosen.time, chosen.cycle, story.named(holder)
        yield Decision(*at, said, because, where)


def _last_request(story: Story) -> Request | None:
    """Return the last request that failed, was under way at the end, or ended."""
    at_end = [one for one in story.requests if _ends_at(story, one)]
    bad = [one for one in at_end if one.ended and one.ended.keys.get("result") != OKAY]
    return next(iter([*reversed(bad), *reversed(story.requests)]), None)


def _ends_at(story: Story, request: Request) -> bool:
    if story.end is None or request.ended is None:
        return False
    is_result = request.ended.kind is events.PrimitiveEnded
    return is_result and request.ended.time == story.end.time


def _of_request(story: Story, request: Request) -> Decision:
    chosen = story.choice(request.task, request.begun.serial)
    method = None if chosen is None else story.method(chosen)
    said, at = format_list(request.what), request.begun
    if request.ended is not None:
        at = request.ended
        said += f": {at.keys.get('result', 'cancelled')}"
    where = story.row(None if method is None else method.body)
    return Decision(at.time, at.cycle, story.named(request.task), said, "", where)


def _of_choice(story: Story, chosen: ToldEvent) -> Decision:
    keys = chosen.keys
    return Decision(
        chosen.time,
        chosen.cycle,
        story.named(keys["task"]),
        f"chose method {keys['method']}",
        in_pairs(keys["bindings"]),
        story.row(story.method(chosen)),
    )


def _of_wake(story: Story, woken: ToldEvent, source_of: SourceOf) -> Decision:
    on = woken.keys["on"]
    formula = story.awaited(on, woken.keys["task"])
    because, where = "", ""
    if formula is not None and story.program is not None:
        names = predicates(story.program.library, formula)
        facts: dict[object, ToldEvent] = {}
        for one in story.asserted:
            fact = one.keys["fact"]
            if one.serial < woken.serial and fact[0] in names:
                facts[fact[0]] = one
        tests = thresholds(story.program, formula)
        said = [_with_source(one, source_of(one)) for one in facts.values()]
        because = " ".join([*said, *map(format_formula, tests)])
        _, where = story.wait(on, woken.keys["task"])
    task = story.named(woken.keys["task"])
    return Decision(woken.time, woken.cycle, task, f"woken by {on}", because, where)


def _with_source(told: ToldEvent, source: Source | None) -> str:
    """Return an asserted fact, with the rule that has asserted it."""
    by_rule = source is not None and source.rule is not None
    return format_list(told.keys["fact"]) + (f" by {source}" if by_rule else "")


# --- what kept the goals --------------------------------------------------------------


def obstacles(
    account: Account, story: Story, family: int, most: int = _MOST
) -> list[Obstacle]:
    """Return what kept a top-level goal: failed requests and long waits.

    Args:
        account: the time of the run.
        story: the run.
        family: the top-level task.
        most: the greatest number of each of the two.
    """
    failures = sorted(_failures(story, family), key=lambda one: -one.times)
    return [*failures[:most], *_waits(account, story, family, most)]


def _causes(story: Story, family: int) -> Iterator[Obstacle]:
    """Yield the first causes of the failure of a goal, or of its excluded methods."""
    failed = story.failed.get(family)
    if failed is None:
        return
    for one in first_causes(failed.keys["because"]):
        said = msgspec.structs.replace(one, place="").line()
        kept_by = f"failed: {failed.keys['result']}"
        yield Obstacle(kept_by, 1, None, said, one.place)


def _failures(story: Story, family: int) -> Iterator[Obstacle]:
    """Yield the failed requests of a family, by name and result."""
    groups: dict[tuple[str, str], list[Request]] = {}
    for one in story.requests:
        result = OKAY if one.ended is None else one.ended.keys.get("result", OKAY)
        if result != OKAY and story.family(one.task) == family:
            groups.setdefault((str(one.what[0]), result), []).append(one)
    for (name, result), failed in groups.items():
        others = [other for one in failed for other in _beside(story, one, family)]
        said = _counted(
            f"{o.what[0]} of {story.named(story.family(o.task))}" for o in others
        )
        where = ""
        unclaimed = _unclaimed(story, failed[-1], others)
        if unclaimed is not None:
            words, where = unclaimed
            said = f"{said}; {words}"
        yield Obstacle(f"{name}: {result}", len(failed), None, said, where)


def _beside(story: Story, failed: Request, family: int) -> list[Request]:
    """Return the last request that another family began during a failed request."""
    assert failed.ended is not None
    found = [
        one
        for one in story.requests
        if failed.begun.serial < one.begun.serial < failed.ended.serial
        and story.family(one.task) != family
    ]
    return found[-1:]


def _unclaimed(
    story: Story, failed: Request, others: Sequence[Request]
) -> tuple[str, str] | None:
    """Return the method that should have claimed a thing which others used meanwhile.

    This is the method with the step of the failed request. None if a method above the
    request claims the thing, or the request uses the thing.
    """
    program = story.program
    if program is None or not others:
        return None
    primitives = program.library.primitives
    known = [primitives[str(o.what[0])] for o in others if o.what[0] in primitives]
    used = {thing.name for one in known for thing in one.uses}
    above = [
        (chosen, method)
        for task in story.parents(failed.task)
        for chosen in [story.choice(task, failed.begun.serial)]
        if chosen is not None
        for method in [story.method(chosen)]
        if method is not None
    ]
    claimed = {thing.name for _, method in above for thing in method.claims}
    own = primitives.get(str(failed.what[0]))
    claimed |= set() if own is None else {thing.name for thing in own.uses}
    if not used or used & claimed or len(above) < 2:
        return None
    chosen, method = above[1]
    named = f"`{chosen.keys['method']}` of `{chosen.keys['rap']}`"
    return f"{named} does not claim {' or '.join(sorted(used))}", story.row(method)


def _unclaimed_things(story: Story) -> Iterator[Symptom]:
    """Yield the methods without a claim for which requests failed again and again."""
    found: dict[str, tuple[int, Obstacle]] = {}
    for one in () if story.end is None else story.end.keys["results"]:
        if one.outcome != "succeeded" and not one.background:
            for kept in _failures(story, one.task):
                known = found.get(kept.where)
                if kept.where and (known is None or known[1].times < kept.times):
                    found[kept.where] = one.task, kept
    for where, (task, kept) in found.items():
        if kept.times >= LEAST:
            said = (
                f"{kept.kept_by} {plural(kept.times, 'time')} for {story.named(task)}"
            )
            yield Symptom(where, f"{said}; meanwhile {kept.because}")


def _waits(
    account: Account, story: Story, family: int, most: int
) -> Iterator[Obstacle]:
    """Yield the longest waits of a family, each with the wait of the other family."""
    groups: dict[tuple[str, str], list[Piece]] = {}
    for one in account.of_family[family]:
        if one.kind in (WAITING, SUSPENDED):
            groups.setdefault((one.kind, one.what), []).append(one)
    listed = sorted(groups.items(), key=lambda item: -_duration(item[1]))
    for (kind, what), pieces in listed[:most]:
        said, where = _meanwhile(account, story, pieces)
        yield Obstacle(
            idle_in_words(kind, what), len(pieces), _duration(pieces), said, where
        )


def _duration(pieces: Iterable[Piece]) -> Time:
    return number(sum(one.stop - one.start for one in pieces))


def _meanwhile(
    account: Account, story: Story, pieces: Sequence[Piece]
) -> tuple[str, str]:
    """Return the longest wait of the family that kept another one waiting."""
    spent: dict[str, list[Piece]] = {}
    for one in pieces:
        holder = next(
            (
                wait.by
                for wait in account.waits
                if wait.task == one.task and wait.start <= one.start < wait.stop
            ),
            None,
        )
        other = None if holder is None else story.family(holder)
        for piece in account.of_family.get(other or 0, ()):
            start, stop = max(one.start, piece.start), min(one.stop, piece.stop)
            if stop > start and piece.kind == WAITING and piece.on.startswith("("):
                both = piece._replace(start=start, stop=stop)
                spent.setdefault(piece.on, []).append(both)
    if not spent:
        return "", next(filter(None, (_place(story, one) for one in pieces)), "")
    on, waits = max(spent.items(), key=lambda item: _duration(item[1]))
    time, where = _duration(waits), _place(story, waits[0])
    return f"it waited for {on}, {readable(time)}", where


def _place(story: Story, wait: Piece) -> str:
    """Return the line of what a task waits for."""
    return story.wait(wait.on, wait.task or 0)[1]


def _counted(words: Iterable[str]) -> str:
    """Return texts with their numbers, the most frequent first."""
    return ", ".join(
        f"{text} {plural(count, 'time')}"
        for text, count in Counter(words).most_common()
    )


# --- the questions --------------------------------------------------------------------


def end_of(
    told: Sequence[ToldEvent],
    program: Program | None,
    beliefs: Sequence[Symptom] = (),
    source_of: SourceOf = _no_source,
) -> Answer:
    """Return the reason of the end of a run with the decisions behind it.

    Args:
        told: the events of the run, of `OF_DECISIONS`; facts are optional.
        program: the library; None if it is unknown.
        beliefs: the wrong beliefs of the run.
        source_of: the source of an assertion.
    """
    end = next((one for one in reversed(told) if one.kind is events.RunEnded), None)
    if end is None:
        return say("the run has not ended")
    reason, because = end.keys["reason"], end.keys["because"]
    said = f"{reason}: {because}" if because else reason
    story = Story(told, program)
    rows = decisions(story, source_of) if reason == "world" else []
    found = [*_late(rows), *beliefs, *_unclaimed_things(story), *symptoms(told, story)]
    lines = [one.line for one in found]
    left = [
        one.goal
        for one in end.keys["results"]
        if not one.background and one.outcome != "succeeded"
    ]
    notes = [f"{plural(len(left), 'goal')} not reached: see `:goals`"] if left else []
    head = f"run ended ({said}) at time {readable(end.time)}"
    columns = ("time", "cycle", "task", "what", "because of", "where")
    if not rows:
        return Answer((head, *lines), None, tuple(notes))
    return table(columns, _shortened(rows), head, *lines, notes=notes)


def _late(decisions: Iterable[Decision]) -> Iterator[Symptom]:
    """Yield the wake behind the end of a run, and the constraints of a wait for it."""
    for one in decisions:
        if one.what.startswith(("woken by", "under constraints")):
            said = f"{one.task}, {one.what} at {readable(one.time)}"
            yield Symptom(one.where, f"{said}: {one.because}")


def _shortened(decisions: Sequence[Decision]) -> Iterator[tuple[object, ...]]:
    """Yield the decisions in short: the first and last ones."""
    first, last = _MOST_DECISIONS
    left = len(decisions) - first - last
    if left < 2:
        yield from decisions
        return
    yield from decisions[:first]
    yield (None, None, None, f"... {plural(left, 'decision')} omitted", "", "")
    yield from decisions[-last:]


def goals_of(
    told: Sequence[ToldEvent],
    now: Time,
    program: Program | None,
    *,
    all_: bool = True,
) -> Answer:
    """Return the top-level goals with what kept them.

    A background task is listed if it has failed, with the cause.

    Args:
        told: the events of the run, of `OF_GOALS`.
        now: the present time.
        program: the library; None if it is unknown.
        all_: whether also goals that have ended are listed.
    """
    account, story = account_of(told, now), Story(told, program)
    rows: list[tuple[object, ...]] = []
    ordered = sorted(account.families.values(), key=lambda one: one.outcome == _REACHED)
    for family in ordered:
        dead = family.background and family.outcome == "failed"
        if not dead and (family.background or not (all_ or family.ended is None)):
            continue
        state = f"under way since {readable(family.came)}"
        if family.ended is not None:
            state = f"{family.outcome} at {readable(family.ended)}"
        head: tuple[object, ...] = (family.task, family.goal, state)
        kept = [*_causes(story, family.task)]
        if not dead:
            most = 2 if family.outcome == _REACHED else _MOST
            kept += obstacles(account, story, family.task, most)
        for one in kept or [_NOTHING]:
            rows.append((*head, *one))
            head = (family.task, None, None)
    columns = ("task", "goal", "result", "kept by", "times", "time", "because of")
    return table((*columns, "where"), rows, none="no goals")


def why_end(history: History) -> Answer:
    """Return the reason of the end of a run with the decisions behind it."""
    told = [*history.scan(*OF_SYMPTOMS)]

    def source_of(one: ToldEvent) -> Source:
        return sources(history, [one])[one.serial]

    return end_of(told, program_of(history), [*wrong_beliefs(history)], source_of)


@question(of_recordings=True)
def goals(history: History, args: Arguments) -> Answer:
    """List the top-level goals with what kept each, how often and by which task.

    The goals that were not reached come first. A goal is kept by a failure, by failed
    requests and by waits: the worst three of each, or two for a goal that was reached.
    For a failed request, the requests that other tasks began meanwhile are listed, and
    the method that claims no thing for which the request failed. For a wait, the wait
    of the task that held the thing is listed, with the line of the condition.
    Background tasks that failed are listed too, with the cause.
    """
    told = [*history.scan(*OF_GOALS)]
    return goals_of(told, history.now, program_of(history))
