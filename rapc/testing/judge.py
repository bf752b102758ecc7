"""Evaluate a test's expectations and explain failures.

Each expectation has one function, which returns None or lines that explain the failure.
The functions read a record and query memory, without side effects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import msgspec

from rapc import events
from rapc.base.values import (
    Fact,
    Number,
    format_atom,
    format_list,
    holds_between,
    match_pattern,
    readable,
)
from rapc.ir import nodes, walk
from rapc.runtime.events.report import cause_lines
from rapc.runtime.events.trace import record
from rapc.testing.patterns import atom, event_matches, flat, goal_matches, read_value
from rapc.testing.record import Record, TaskStory

_MANY = 8
"""The highest number of listed tasks, requests or facts."""

_MOST_STARTS = 10_000
"""The highest number of sets of steps with which an order of a plan may begin."""

Happened = tuple[str, ...]


class Evidence(msgspec.Struct, frozen=True):
    """The evidence for an expectation: record of the run, memory, and figures."""

    record: Record
    holds: Callable[[nodes.Formula], bool]
    figures: Callable[[], Mapping[str, Number]]


def judge(expectation: nodes.Expectation, scene: Evidence) -> Happened | None:
    """Return None if an expectation holds now, else the explanation."""
    return _JUDGES[type(expectation)](expectation, scene)


def _some(lines: Sequence[str]) -> Happened:
    """Return the first of many lines, and the number of the remaining lines."""
    if len(lines) <= _MANY + 1:
        return tuple(lines)
    return (*lines[:_MANY], f"and {len(lines) - _MANY} more")


# --- goals -------------------------------------------------------------------------


def _tasks(goal: nodes.Goal, scene: Evidence, found: Sequence[TaskStory]) -> Happened:
    """Return the ends of the tasks that match a goal, or else of its RAP's tasks."""
    lines = [f"{task.text} [{task.number}] {task.state()}" for task in found]
    if lines:
        return _why(found[0]) if len(lines) == 1 else _some(lines)
    asked = format_list(flat(goal))
    others = [t for t in scene.record.tasks.values() if t.inputs[0] == goal.name]
    if not others:
        return (f"no task {asked} was made, nor any other of `{goal.name}`",)
    lines = [f"{task.text} [{task.number}] {task.state()}" for task in others]
    return (f"no task {asked} was made, but", *_some(lines))


def _why(task: TaskStory) -> Happened:
    """Return the end of a task and, after a failure, the causes to the first one."""
    told = f"{task.text} [{task.number}] {task.state()}"
    return (told, *_some([f"  {line}" for line in cause_lines(task.because)]))


def _succeeds(node: nodes.Succeeds, scene: Evidence) -> Happened | None:
    found = scene.record.matching(node.goal)
    wanted = (*flat(node.goal), *[atom(out) for out in node.outputs])
    for task in found:
        values = (*task.inputs, *task.outputs) if node.outputs else task.inputs
        if task.ended == "succeeded" and match_pattern(wanted, values) is not None:
            return None
    return _tasks(node.goal, scene, found)


def _fails(node: nodes.Fails, scene: Evidence) -> Happened | None:
    found = scene.record.matching(node.goal)
    wanted = flat(node.goal)
    if node.result is not None:
        wanted = (*wanted, atom(node.result))
    for task in found:
        values = task.inputs if node.result is None else (*task.inputs, task.result)
        if task.ended == "failed" and match_pattern(wanted, values) is not None:
            return None
    return _tasks(node.goal, scene, found)


def _active(node: nodes.Active, scene: Evidence) -> Happened | None:
    found = scene.record.matching(node.goal)
    if any(task.ended is None for task in found):
        return None
    return _tasks(node.goal, scene, found)


def _ends_by(node: nodes.EndsBy, scene: Evidence) -> Happened | None:
    found = scene.record.matching(node.goal)
    if any(t.ended == "succeeded" and t.time <= node.time for t in found):
        return None
    return _tasks(node.goal, scene, found)


def _selected_before(node: nodes.SelectedBefore, scene: Evidence) -> Happened | None:
    firsts = _selected(node.first, scene)
    seconds = _selected(node.second, scene)
    if any(a < b for a in firsts for b in seconds):
        return None
    lines = []
    for goal in (node.first, node.second):
        for task in scene.record.matching(goal):
            if task.selected is None:
                lines.append(f"{task.text} [{task.number}] was never selected")
            else:
                event = scene.record.events[task.selected]
                lines.append(
                    f"{task.text} [{task.number}] was first selected in cycle "
                    f"{event.cycle}, at time {readable(event.time)}"
                )
        if not scene.record.matching(goal):
            lines.extend(_tasks(goal, scene, ()))
    return _some(lines)


def _selected(goal: nodes.Goal, scene: Evidence) -> list[int]:
    found = scene.record.matching(goal)
    return [task.selected for task in found if task.selected is not None]


# --- requests ------------------------------------------------------------------------


def _requests(scene: Evidence) -> list[Fact]:
    return [request for request, _ in scene.record.requests]


def _primitives(node: nodes.Primitives, scene: Evidence) -> Happened | None:
    done, wanted = _requests(scene), node.requests
    same = 0
    for pattern, request in zip(wanted, done, strict=False):
        if match_pattern(flat(pattern), request) is None:
            break
        same += 1
    if same == len(done) == len(wanted):
        return None
    if same == len(wanted):
        return ("unexpected requests:", *_listed(done[same:]))
    missing = _written(flat(wanted[same]))
    if same == len(done):
        return (f"{missing} did not follow; all requests:", *_listed(done))
    return (
        f"request {same + 1} was {_written(done[same])}, not {missing}; all requests:",
        *_listed(done),
    )


def _listed(requests: Sequence[Fact]) -> Happened:
    if not requests:
        return ("no primitive was requested",)
    return _some([_written(request) for request in requests])


def _written(asked: Fact) -> str:
    """Return a request, or a skill that is enabled, in the syntax of tests."""
    text = format_list(asked)
    return f"(enable {text})" if str(asked[0]).startswith(":") else text


def _include(node: nodes.PrimitivesInclude, scene: Evidence) -> Happened | None:
    rest = iter(_requests(scene))
    for at, pattern in enumerate(node.requests):
        wanted = flat(pattern)
        if not any(match_pattern(wanted, request) is not None for request in rest):
            after = " after those before it" if at else ""
            return (
                f"{_written(wanted)} did not come{after}; all requests:",
                *_listed(_requests(scene)),
            )
    return None


def _never(node: nodes.Never, scene: Evidence) -> Happened | None:
    for request, event in scene.record.requests:
        if match_pattern(flat(node.request), request) is not None:
            task = scene.record.tasks[event.task]
            how = "enabled" if isinstance(event, events.SkillEnabled) else "requested"
            return (
                f"{format_list(request)} was {how} at time "
                f"{readable(event.time)} by {task.text} [{task.number}]",
            )
    return None


# --- memory, methods, the trace -----------------------------------------------------


def _memory(node: nodes.MemoryHolds, scene: Evidence) -> Happened | None:
    if scene.holds(node.formula):
        return None
    lines: list[str] = []
    names = [
        f.name
        for f in walk.subformulas(node.formula)
        if isinstance(f, nodes.Proposition)
    ]
    for name in dict.fromkeys(names):
        facts = scene.record.about(name)
        if facts:
            lines += _some([f"in memory: {fact}" for fact in facts])
        else:
            lines.append(f"no fact `{name}` is in memory")
    return tuple(lines) or ("it does not hold",)


def _method(node: nodes.MethodChosen, scene: Evidence) -> Happened | None:
    chosen = [
        event.method
        for event in scene.record.events
        if isinstance(event, events.MethodChosen) and event.rap == node.rap
    ]
    count = chosen.count(node.method)
    if count == node.times or (node.times is None and count):
        return None
    if not chosen:
        return (f"no method of `{node.rap}` was chosen",)
    times = {name: chosen.count(name) for name in chosen}
    said = {name: "once" if n == 1 else f"{n} times" for name, n in times.items()}
    return _some([f"method {name} was chosen {often}" for name, often in said.items()])


def _plans(node: nodes.Plans, scene: Evidence) -> Happened | None:
    asked = _planned(node.goal, scene)
    made = [one for one in asked if one.method is not None]
    wanted = [flat(step) for step in node.steps]
    if any(not wanted or _allows(plan.steps, wanted) for plan in made):
        return None
    if not asked:
        return (f"the planner was not asked for {format_list(flat(node.goal))}",)
    lines = []
    for plan in asked:
        lines.append(_told_plan(plan))
        lines += [f"  {one.tag} {one.goal}  {one.purpose}" for one in plan.steps]
    return tuple(lines)


def _plans_none(node: nodes.PlansNone, scene: Evidence) -> Happened | None:
    made = [one for one in _planned(node.goal, scene) if one.method is not None]
    return _some([_told_plan(one) for one in made]) if made else None


def _planned(goal: nodes.Goal, scene: Evidence) -> list[events.PlanMade]:
    """Return the answers of the planner for the tasks that match a goal."""
    return [
        event
        for event in scene.record.events
        if isinstance(event, events.PlanMade)
        and goal_matches(goal, (event.goal.name, *event.goal.inputs))
    ]


def _told_plan(event: events.PlanMade) -> str:
    """Return the answer of the planner with its task and time, as text."""
    line = (event.line() or "").strip(" .")
    return f"{line} [{event.task}] at time {readable(event.time)}"


def _allows(steps: Sequence[events.PlanStep], wanted: Sequence[Fact]) -> bool:
    """Return whether patterns match all steps of a plan in an order that it allows."""
    if len(steps) != len(wanted):
        return False
    goals = {step.tag: _inputs(step.goal) for step in steps}
    earlier: dict[str, set[str]] = {tag: set() for tag in goals}
    for step in steps:
        for tag in (*step.before, *[one.step for one in step.links if one.step]):
            earlier[tag].add(step.tag)
    starts = [frozenset[str]()]
    for pattern in wanted:
        matching = [
            t for t, g in goals.items() if match_pattern(pattern, g) is not None
        ]
        found = dict.fromkeys(
            done | {tag}
            for done in starts
            for tag in matching
            if tag not in done and earlier[tag] <= done
        )
        starts = list(found)[:_MOST_STARTS]
    return bool(starts)


def _inputs(goal: str) -> Fact:
    """Return the RAP and the inputs of a goal; an item not yet found is a variable."""
    parts = read_value(goal)
    assert isinstance(parts, tuple)
    return parts[: parts.index("=>")] if "=>" in parts else parts


def _trace(node: nodes.TraceHas, scene: Evidence) -> Happened | None:
    reached = -1
    for at, pattern in enumerate(node.events):
        same = scene.record.of_kind(pattern.event)
        found = (e.n for e in same if e.n > reached and event_matches(pattern, e))
        serial = next(found, None)
        if serial is None:
            after = f" after the first {at}" if at else ""
            told = _some([_told(event) for event in same])
            return (
                f"no event fits pattern {at + 1}{after}",
                *(told or (f"there was no event `{pattern.event}`",)),
            )
        reached = serial
    return None


def _told(event: events.Event) -> str:
    """Return an event in the syntax of a pattern, without its long cause."""
    keys = record(event)
    hidden = ("event", "n", "cycle", "time", "because")
    shown = {k: v for k, v in keys.items() if k not in hidden}
    told = [f":{k} {'null' if v is None else format_atom(v)}" for k, v in shown.items()]
    words = " ".join((keys["event"], *told))
    return f"({words}) at time {readable(keys['time'])}"


# --- figures and failures -----------------------------------------------------------


def _figure(node: nodes.Figure, scene: Evidence) -> Happened | None:
    figure = scene.figures().get(node.name)
    if figure is None:
        return (f"the figure `{node.name}` is not a number",)
    value = node.value.value
    assert isinstance(value, int | float)  # the grammar takes no other value
    if holds_between(node.comparison, figure, value):
        return None
    return (f"the figure `{node.name}` is {readable(figure)}",)


def _fails_at_most(node: nodes.FailsAtMost, scene: Evidence) -> Happened | None:
    total = scene.record.mended.counts().total()
    if total <= node.count:
        return None
    lines = [f"  {line}" for line in scene.record.mended.lines()]
    return (f"mended failures: {total}", *lines)


_JUDGES: Mapping[type, Callable[[Any, Evidence], Happened | None]] = {
    nodes.Succeeds: _succeeds,
    nodes.Fails: _fails,
    nodes.Active: _active,
    nodes.EndsBy: _ends_by,
    nodes.SelectedBefore: _selected_before,
    nodes.Primitives: _primitives,
    nodes.PrimitivesInclude: _include,
    nodes.Never: _never,
    nodes.MemoryHolds: _memory,
    nodes.MethodChosen: _method,
    nodes.Plans: _plans,
    nodes.PlansNone: _plans_none,
    nodes.TraceHas: _trace,
    nodes.Figure: _figure,
    nodes.FailsAtMost: _fails_at_most,
}
