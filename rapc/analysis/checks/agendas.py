"""RAP130 to RAP132: agendas whose tasks block each other permanently.

The priority of a step is added to the priority of its parent. The highest priority
below a task is therefore the sum of its own priority and of the steps on the highest
path below the task (T 5.4.1).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Container, Iterator, Mapping

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import below_agendas, endless
from rapc.analysis.facts.logic import is_never
from rapc.analysis.facts.statistics import LIMITS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.walk import steps

LOW = Rule(
    code="RAP130",
    name="powerless-reaction",
    severity=Severity.WARNING,
    summary="a standing task has no higher priority than the tasks that it "
    "must interrupt",
    ignore="where the reaction may wait until the other task ends",
    source="T 5.4.1",
)


REACHES = Rule(
    code="RAP131",
    name="priority-out-of-band",
    severity=Severity.WARNING,
    summary="a step has a higher priority than a standing task with "
    "priority over the parent",
    ignore="where the step must run before the reaction, for example to "
    "wake the robot up",
    source="T 5.4.1",
)

ENDS = Rule(
    code="RAP132",
    name="standing-task-ends",
    severity=Severity.WARNING,
    summary="a standing task in the background ends after one reaction",
    ignore="where the task must end",
    source="T 4.7.1, figure 4.3",
)


@check(LOW, REACHES, ENDS)
def agenda_bands(run: Pass) -> Iterator[Diagnostic]:
    """Find tasks of an agenda whose priorities or goals defeat its standing tasks."""
    if not run.library.agendas:
        return
    reach = _reach(run)
    told: set[int] = set()
    never_done = endless(below_agendas(run.library))
    for agenda in run.library.agendas.values():
        yield from (
            *_low(run, agenda, never_done),
            *_reaches(run, agenda, reach, told),
        )
        for task in agenda.tasks:
            if task.background:
                yield from _ended(run, task, task.goal.name)


def _stands(run: Pass, task: nodes.GivenTask) -> bool:
    """Return whether a task of an agenda waits for a state of the world."""
    rap = run.library.raps.get(task.goal.name)
    return task.background and rap is not None and _reacts(run, rap)


def _reacts(run: Pass, rap: nodes.DefineRap) -> bool:
    """Return whether a RAP, or each of its steps, waits for a monitor."""
    if rap.monitor_state is not None:
        return True
    below = [run.library.raps.get(s.goal.name) for m in rap.methods for s in steps(m)]
    plain = rap.monitor_time is None and rap.succeed is None and below
    return bool(plain) and all(
        one is not None and one.monitor_state is not None for one in below
    )


def _low(
    run: Pass, agenda: nodes.DefineAgenda, never_done: Container[str]
) -> Iterator[Diagnostic]:
    work = [task for task in agenda.tasks if not task.background]
    work = [task for task in work if task.goal.name not in never_done]
    if not work:
        return
    highest = max(work, key=lambda one: one.priority)
    lowest = min(one.priority for one in work)
    for task in agenda.tasks:
        if lowest >= task.priority and _stands(run, task):
            yield LOW.at(
                task.goal.span,
                f"standing task `{task.goal.name}` has priority {task.priority} "
                "and interrupts nothing",
                labels=(Label(highest.span, f"priority {highest.priority}"),),
                help="give the standing task a higher priority than the other tasks",
            )


_Reach = Mapping[str, tuple[int, nodes.Step | None]]


def _reach(run: Pass) -> _Reach:
    """Return the highest added priority below each RAP, with its first step."""
    reach: dict[str, tuple[int, nodes.Step | None]] = {}
    raps = run.library.raps.values()
    rows = [(rap.name, [s for m in rap.methods for s in steps(m)]) for rap in raps]
    for _ in range(LIMITS.priority_depth):
        changed = False
        for name, there in rows:
            best = reach.get(name, (0, None))
            for step in there:
                high = step.priority + reach.get(step.goal.name, (0, None))[0]
                if high > best[0]:
                    best = (high, step)
                    changed = True
            if best[1] is not None:
                reach[name] = best
        if not changed:
            break
    return reach


def _reaches(
    run: Pass, agenda: nodes.DefineAgenda, reach: _Reach, told: set[int]
) -> Iterator[Diagnostic]:
    standing = sorted(
        [task for task in agenda.tasks if _stands(run, task)], key=_priority
    )
    for task in agenda.tasks:
        high, _ = reach.get(task.goal.name, (0, None))
        at = bisect_right(standing, task.priority, key=_priority)
        next_ = standing[at] if at < len(standing) else None
        if next_ is None or next_.priority > task.priority + high:
            continue
        step = _raised(task.goal.name, reach)
        if step is not None and id(step) not in told:
            told.add(id(step))
            yield REACHES.at(
                step.span,
                f"step `{step.tag}` raises `{task.goal.name}` to priority "
                f"{task.priority + high}, up to `{next_.goal.name}`",
                labels=(
                    Label(task.span, f"this task has priority {task.priority}"),
                    Label(next_.span, f"this task has priority {next_.priority}"),
                ),
                help="lower the priority of the step, or increase the difference "
                "between the two tasks",
            )


def _priority(task: nodes.GivenTask) -> int:
    return task.priority


def _raised(name: str, reach: _Reach) -> nodes.Step | None:
    """Return the step with the highest priority on the highest path below a RAP."""
    most: nodes.Step | None = None
    for _ in range(LIMITS.priority_depth):
        _, step = reach.get(name, (0, None))
        if step is None:
            break
        if most is None or step.priority > most.priority:
            most = step
        name = step.goal.name
    return most


def _ended(run: Pass, task: nodes.GivenTask, name: str) -> Iterator[Diagnostic]:
    """Find RAPs of a standing task that end, also as one of its steps with monitors."""
    rap = run.library.raps.get(name)
    if rap is None or not rap.methods or is_never(rap.succeed):
        return
    monitors = [rap.monitor_state, rap.monitor_time]
    monitor = next((one for one in monitors if one is not None), None)
    if monitor is None:
        for step in (
            (s for m in rap.methods for s in steps(m)) if _reacts(run, rap) else ()
        ):
            if not step.annotations and step.goal.name != name:
                yield from _ended(run, task, step.goal.name)
        return
    message = f"`{rap.name}` ends when a method has succeeded once"
    if rap.succeed is not None:
        message = f"`{rap.name}` ends when this formula holds once"
    yield ENDS.at(
        rap.name_span if rap.succeed is None else rap.succeed.span,
        message,
        labels=(
            Label(monitor.span, "the monitor of the RAP"),
            Label(task.span, "submitted here as a standing task"),
        ),
        help="write `(succeed nil)` to let the task stand by without end",
    )
