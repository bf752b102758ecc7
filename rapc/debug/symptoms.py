"""Symptoms of a run: what kept its goals, each with a line of the library.

Symptoms come from the events of a run that has ended and the text of its library. A
symptom concerns goals that were not reached. Wrong beliefs are symptoms too, but need a
history: see `rapc.debug.questions.beliefs`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from typing import NamedTuple

import msgspec

from rapc import events
from rapc.analysis.facts.index import Index
from rapc.base.names import plural
from rapc.base.values import format_list, match_pattern, readable
from rapc.compiler.program import Program
from rapc.debug.arguments import read_pattern
from rapc.debug.log import ToldEvent
from rapc.debug.names import predicates
from rapc.debug.story import Story, first_causes, thresholds
from rapc.errors import TextError
from rapc.ir import nodes, walk
from rapc.ir.printer import format_formula, format_node
from rapc.runtime.events.report import OF_DECISIONS

OF_SYMPTOMS: tuple[type[events.Event], ...] = (
    *OF_DECISIONS,
    *(events.FactAsserted, events.ResourceChanged),
    *(events.TaskSucceeded, events.TaskFailed, events.TaskRemoved),
    *(events.MethodEnded, events.SignalReceived),
)
"""The kinds of events that symptoms are made of."""

_MOST = 3
"""The number of symptoms of a kind."""

LEAST = 2
"""The number of rounds or failures from which they are a symptom."""


class Symptom(NamedTuple):
    """A symptom with its place in the library."""

    #: The file and line; may be empty.
    where: str
    said: str

    @property
    def line(self) -> str:
        """The symptom as text, after the name of the file and the line."""
        place = _short(self.where)
        return f"{place}: {self.said}" if place else self.said


def symptoms(told: Iterable[ToldEvent], story: Story) -> list[Symptom]:
    """Return the symptoms of a run that has ended, the most decisive first.

    Without a library, only failures are symptoms.

    Args:
        told: the events of the run, of `OF_SYMPTOMS`.
        story: the run, from these events.
    """
    program = story.program
    if story.end is None:
        return []
    results = story.end.keys["results"]
    left = {one.task for one in results if one.outcome != "succeeded"}
    goals = left - {one.task for one in results if one.background}
    found: list[Symptom] = []
    is_cut_off = story.end.keys["reason"] == "world"
    if program is not None:
        found += () if is_cut_off else _unchanged(story, program, goals)
        found += _in_vain(story, told, goals)
        found += _never_asserted(story, program, goals)
    found += _failures(story, results)
    if is_cut_off and program is not None:
        found += _never_woken(story, program, left - goals)
    return list(dict.fromkeys(found))


# --- failures -------------------------------------------------------------------------


def _failures(story: Story, results: Iterable[events.TaskResult]) -> Iterator[Symptom]:
    """Yield the failed top-level tasks, together those with the same first causes."""
    groups: dict[object, list[events.TaskResult]] = {}
    for one in results:
        if one.outcome == "failed":
            key = tuple((c.place, c.clause) for c in first_causes(one.because))
            groups.setdefault(key or one.task, []).append(one)
    for failed in [*groups.values()][:_MOST]:
        first, *more = failed
        said = f"[{first.task}] {first.goal}"
        said = f"background task {said}" if first.background else said
        said += f" and {plural(len(more), 'more task')} failed" if more else " failed"
        if first.ended is not None and not more:
            said += f" at {readable(first.ended)}"
        said += f": {first.result}"
        causes = [*first_causes(first.because)]
        for at, cause in enumerate(causes):
            inner = cause.short()
            if not at:
                inner = msgspec.structs.replace(inner, place="")
            said += f"; because of {inner.line()}"
        said += _rounds(story, first.task)
        woken = story.woken.get(first.task)
        if woken is not None:
            on = woken.keys["on"]
            said += f"; woken by {on}{at_place(story.wait(on, first.task)[1])}"
        yield Symptom(causes[0].place if causes else "", said)


def _short(where: str) -> str:
    return where.replace("\\", "/").rpartition("/")[2]


def at_place(where: str) -> str:
    """Return the name of a file and the line after ` at `; empty without a place."""
    return f" at {_short(where)}" if where else ""


def _rounds(story: Story, task: int) -> str:
    """Return the methods of a task that has repeated them, with their results."""
    ended = story.methods.get(task, [])
    if len(ended) < LEAST:
        return ""
    counts = Counter((one.keys["method"], one.keys["result"]) for one in ended)
    said = (
        f"{method} {result} {plural(count, 'time')}"
        for (method, result), count in counts.items()
    )
    return f"; rounds: {', '.join(said)}"


# --- sets and counters ----------------------------------------------------------------


def _unchanged(
    story: Story, program: Program, families: Collection[int]
) -> Iterator[Symptom]:
    """Yield the sets and counters that a loop tests and that stayed as they were."""
    raps = program.library.raps
    changed = _changed_by(story)
    groups: dict[tuple[str, str], list[int]] = {}
    for task, chosen in story.chosen.items():
        rap = raps.get(chosen[0].keys["rap"])
        if rap is None or not rap.resources or len(chosen) < LEAST:
            continue
        if story.family(task) not in families:
            continue
        tested = [one for one in (rap.succeed, rap.repeat_while) if one is not None]
        names = set(walk.variable_names(*tested))
        for resource in rap.resources:
            name = resource.variable.name
            changes = _changes(program, rap, name)
            is_goal = rap.succeed is not None and name in walk.variable_names(
                rap.succeed
            )
            if name not in names or (changes and not is_goal):
                continue
            if changed.get(task, set()).isdisjoint(map(id, changes)):
                groups.setdefault((rap.name, name), []).append(len(chosen))
    for (rap_name, name), rounds in groups.items():
        rap = raps[rap_name]
        said = (
            f"`{name}` of `{rap_name}` did not change in {plural(sum(rounds), 'round')}"
        )
        if rounds[1:]:
            said += f" of {len(rounds)} tasks"
        said += f"; {_changers(story, program, rap, name)}"
        declared = next(one for one in rap.resources if one.variable.name == name)
        yield Symptom(story.row(declared), said)


def _changed_by(story: Story) -> dict[int, set[int]]:
    """Return the annotations that changed sets and counters below each task."""
    found: dict[int, set[int]] = {}
    for one in story.resources:
        task = one.keys["task"]
        made = story.created.get(task)
        _, step = (None, None) if made is None else story.step(made)
        for change in () if step is None else step.annotations:
            if isinstance(change, nodes.ResourceChange):
                for above in story.parents(task):
                    found.setdefault(above, set()).add(id(change))
    return found


def _changes(
    program: Program, rap: nodes.DefineRap, name: str
) -> list[nodes.ResourceChange]:
    """Return the changes of a set or counter, also in the RAPs that receive it."""
    return [
        change
        for owner, inner in _receivers(program, rap, name)
        for change in _all_changes(owner)
        if _is_variable(change.resource, inner)
    ]


def _all_changes(rap: nodes.DefineRap) -> Iterator[nodes.ResourceChange]:
    for method in rap.methods:
        for step in walk.steps(method):
            for one in step.annotations:
                if isinstance(one, nodes.ResourceChange):
                    yield one


def _receivers(
    program: Program, rap: nodes.DefineRap, name: str
) -> Iterator[tuple[nodes.DefineRap, str]]:
    """Yield a RAP with a variable, and the RAPs that receive the variable as input."""
    stack, seen = [(rap, name)], {(rap.name, name)}
    while stack:
        owner, inner = stack.pop()
        yield owner, inner
        for method in owner.methods:
            for step in walk.steps(method):
                below = program.library.raps.get(step.goal.name)
                if below is None:
                    continue
                for into, term in walk.input_terms(below, step.goal).items():
                    if _is_variable(term, inner) and (below.name, into) not in seen:
                        seen.add((below.name, into))
                        stack.append((below, into))


def _is_variable(term: nodes.Term, name: str) -> bool:
    return isinstance(term, nodes.Var) and term.name == name


def _changers(story: Story, program: Program, rap: nodes.DefineRap, name: str) -> str:
    """Return as text the steps that could have changed a set or counter."""

    def listed(changes: Iterable[nodes.ResourceChange]) -> str:
        return ", ".join(
            f"{format_node(one)}{at_place(story.row(one))}" for one in changes
        )

    changes = _changes(program, rap, name)
    if changes:
        return f"no round came to {listed(changes)}"
    receivers = [owner for owner, _ in _receivers(program, rap, name)][1:]
    others = {one.name: listed(_all_changes(one)) for one in receivers}
    has = [f"`{one}` has {steps}" for one, steps in others.items() if steps]
    return "; ".join(["no step changes it", *has])


# --- signals --------------------------------------------------------------------------


class _Wait(NamedTuple):
    """A wait of a task for a signal that has not come."""

    on: str
    #: The signals of the same name that came meanwhile.
    others: list[str]


_ENDS = (
    *(events.TaskWoken, events.TaskBlocked),
    *(events.TaskSucceeded, events.TaskFailed, events.TaskRemoved),
)


def _in_vain(
    story: Story, told: Iterable[ToldEvent], families: Collection[int]
) -> Iterator[Symptom]:
    """Yield the signals that did not come, while others of the same name came."""
    open_: dict[int, _Wait] = {}
    missed: dict[tuple[str, str, str], list[_Wait]] = {}

    def end(task: int) -> None:
        wait, goal = open_.pop(task, None), story.goal(task)
        if wait is not None and wait.others and goal is not None:
            where = story.wait(wait.on, task)[1]
            missed.setdefault((where, wait.on, goal.name), []).append(wait)

    for one in told:
        task = one.keys.get("task")
        if one.kind is events.SignalReceived:
            for wait in open_.values():
                _hear(wait, one)
        elif one.kind in _ENDS and task is not None:
            if one.kind is events.TaskWoken:
                open_.pop(task, None)
            end(task)
            on = one.keys.get("on", "")
            waits = one.kind is events.TaskBlocked and on.startswith("(:")
            if waits and story.family(task) in families:
                open_[task] = _Wait(on, [])
    for task in [*open_]:
        end(task)
    listed = sorted(missed.items(), key=lambda item: -len(item[1]))
    for (where, on, rap), waits in listed[:_MOST]:
        came = Counter(other for wait in waits for other in wait.others)
        (most, count), *_ = came.most_common(1)
        said = f"`{rap}` waited for {on} {plural(len(waits), 'time')} in vain"
        yield Symptom(where, f"{said}; {most} came meanwhile {plural(count, 'time')}")


def _hear(wait: _Wait, signal: ToldEvent) -> None:
    """Add a signal to a wait, if it has the name but does not match."""
    what = signal.keys["what"]
    # A wait for a computed value has no pattern.
    with suppress(TextError):
        pattern = read_pattern(f"({wait.on[2:]}")
        if f":{pattern[0]}" == what[0] and match_pattern(pattern[1:], what[1:]) is None:
            wait.others.append(format_list(what))


# --- facts ----------------------------------------------------------------------------


def _never_asserted(
    story: Story, program: Program, families: Collection[int]
) -> Iterator[Symptom]:
    """Yield the methods that were never chosen for want of a fact never asserted.

    Only RAPs are listed with tasks that failed below a goal that was not reached.
    """
    asserted = {one.keys["fact"][0] for one in story.asserted}
    index = Index(program.library)
    failures: Counter[str] = Counter()
    for task in story.failed:
        goal = story.goal(task)
        if goal is not None and story.family(task) in families:
            failures[goal.name] += 1
    used: dict[str, Counter[str]] = {}
    for chosen in story.chosen.values():
        for one in chosen:
            used.setdefault(one.keys["rap"], Counter())[one.keys["method"]] += 1
    found = 0
    for rap, _ in failures.most_common():
        plan, choices = program.rap(rap), used.get(rap, Counter())
        if plan is None or choices.total() < LEAST:
            continue
        for method in plan.methods:
            context = method.node.context
            if choices[method.name] or context is None:
                continue
            for fact in _required(program, context):
                if fact.name in asserted or found == _MOST:
                    continue
                reason = _reason(story, program, index, fact.name)
                if reason is not None:
                    found += 1
                    said = (
                        f"`{method.name}` of `{rap}` was never chosen in "
                        f"{choices.total()} choices: no {format_formula(fact)} "
                        f"was ever asserted{reason}"
                    )
                    yield Symptom(story.row(fact), said)


def _reason(story: Story, program: Program, index: Index, name: str) -> str | None:
    """Return why a fact should have been asserted; None if this is not known.

    A rule that did not run, or a result that no request had, need not assert a fact.
    """
    owners = {one.owner for one in index.uses_of("asserted", name)}
    owners = {one for one in owners if not isinstance(one, nodes.DefineTest)}
    if not owners:
        return "; nothing in the library asserts it"
    for owner in owners:
        if not isinstance(owner, nodes.DeclarePrimitive):
            return None
        for on in owner.on:
            names = {one.pattern.name for one in on.effects if not one.negated}
            times = sum(
                1
                for one in story.requests
                if one.what[0] == owner.name
                and one.ended is not None
                and one.ended.keys.get("result") == on.result
            )
            if name in names and times:
                came = f"{on.result} {plural(times, 'time')}"
                return f", though `{owner.name}` had {came}"
    return None


def _required(program: Program, formula: nodes.Formula) -> Iterator[nodes.Proposition]:
    """Yield the facts that a formula requires, also inside named queries."""
    library, stack, seen = program.library, [formula], set[str]()
    while stack:
        part = stack.pop()
        if isinstance(part, nodes.And):
            stack += part.parts
        elif isinstance(part, nodes.Believe):
            stack.append(part.pattern)
        elif isinstance(part, nodes.Proposition):
            if part.name in library.queries and part.name not in seen:
                seen.add(part.name)
                stack.append(library.queries[part.name].formula)
            elif part.name in program.signatures.relations:
                yield part


# --- monitors -------------------------------------------------------------------------


def _never_woken(
    story: Story, program: Program, families: Collection[int]
) -> Iterator[Symptom]:
    """Yield the background tasks that waited for a state which never held."""
    found = 0
    for task, blocked in story.blocked.items():
        formula = story.awaited(blocked.keys["on"], task)
        if formula is None or task in story.woken or found == _MOST:
            continue
        if story.family(task) not in families:
            continue
        tests = [one for one in thresholds(program, formula) if _is_threshold(one)]
        if not tests:
            continue
        found += 1
        names = predicates(program.library, formula)
        last = {one.keys["fact"][0]: one.keys["fact"] for one in story.asserted}
        known = [format_list(last[one]) for one in names if one in last]
        said = f"{story.named(task)} was never woken, with {format_formula(tests[0])}"
        said += f"; at the end {' '.join(known)}" if known else ""
        yield Symptom(story.row(tests[0]), said)


def _is_threshold(test: nodes.Formula) -> bool:
    """Return whether a test bounds a value by a number in the text."""
    if not isinstance(test, nodes.Compare) or test.op in ("=", "n="):
        return False
    return any(
        isinstance(term, nodes.Const) and isinstance(term.value, int | float)
        for term in (test.left, test.right)
    )
