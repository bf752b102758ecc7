"""Questions about tasks: agenda, families, single tasks and ancestors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.values import format_atom
from rapc.debug.answer import Answer, question, table
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.why_not import last_cycle
from rapc.runtime.events.report import cause_lines
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.state.task import Task


@question()
def agenda(history: History, args: Arguments) -> Answer:
    """List the tasks under way, and why each task waits."""
    rows = [
        (
            *(one.task, one.goal, one.state, one.priority or None),
            *(one.deadline, one.slack, one.waits_for),
        )
        for one in history.run.agenda()
    ]
    columns = ("task", "goal", "state", "priority", "deadline", "slack", "waits for")
    return table(columns, rows, none=none_now(history, "tasks under way"))


def none_now(history: History, what: str) -> str:
    """Return a line for an empty list; after the end, with the last cycle."""
    end = f": run over; see `:goto {history.cycle}`" if history.over else ""
    return f"no {what}{end}"


# --- families -----------------------------------------------------------------------

_Member = dict[str, Any]
"""A task in its family: parent, goal, state, method, last result and cause."""


@question(of_recordings=True)
def tree(history: History, args: Arguments) -> Answer:
    """Show the families of tasks with states, methods and last results."""
    members = _live(history.run) if history.is_run else _told(history)
    below: dict[int | None, list[int]] = {}
    for number, one in members.items():
        below.setdefault(one["parent"], []).append(number)
    rows = []
    for depth, number in _in_families(below):
        one = members[number]
        cause = "" if one["because"] is None else one["because"].clause
        told = "  " * depth + f"[{number}] {one['goal']}"
        rows.append((told, one["state"], one["method"], one["result"], cause))
    columns = ("task", "state", "method", "last result", "because of")
    return table(columns, rows, none=none_now(history, "tasks under way"))


def _live(run: Interpreter) -> Mapping[int, _Member]:
    """Return the live tasks of a run, by number."""
    tasks = {task.number: task for task in run.tasks()}
    found: dict[int, _Member] = {}
    for entry in run.agenda():
        task = tasks[entry.task]
        found[entry.task] = {
            "parent": entry.parent,
            "goal": entry.goal,
            "state": entry.state,
            "method": "" if task.method is None else task.method.name,
            "result": task.last_result,
            "because": None if task.history is None else task.history.because,
        }
    return found


_ENDS = (events.TaskSucceeded, events.TaskFailed, events.TaskRemoved)

_OF_FAMILIES = (
    *(events.TaskCreated, events.TaskSelected, *_ENDS),
    *(events.MethodChosen, events.MethodEnded, events.TaskBlocked, events.TaskWoken),
)


def _told(history: History) -> Mapping[int, _Member]:
    """Return the live tasks by number, reconstructed from events."""
    found: dict[int, _Member] = {}
    for told in history.scan(*_OF_FAMILIES):
        number = told.keys.get("task", 0)
        if told.kind is events.TaskCreated:
            found[number] = dict.fromkeys(("result", "because"))
            found[number]["parent"] = told.keys["parent"]
            found[number] |= {"goal": told.keys["goal"], "state": "made", "method": ""}
        elif told.kind in _ENDS:
            found.pop(number, None)
        elif number in found:
            found[number] |= _changed_by(told)
    return found


def _changed_by(told: ToldEvent) -> _Member:
    """Return the fields of a task that an event changes."""
    keys = told.keys
    changes: Mapping[type[events.Event], _Member] = {
        events.TaskSelected: {"goal": keys.get("goal"), "state": "selected"},
        events.MethodChosen: {
            "method": keys.get("method"),
            "state": "running",
            "because": None,
        },
        events.MethodEnded: {
            "state": "made",
            "result": keys.get("result"),
            "because": keys.get("because"),
        },
        events.TaskBlocked: {"state": "blocked"},
        events.TaskWoken: {"state": "eligible"},
    }
    return changes[told.kind]


def _in_families(
    below: Mapping[int | None, Sequence[int]],
) -> Iterator[tuple[int, int]]:
    """Yield tasks with depths, each after its parent; None is the root."""
    stack = [(0, task) for task in reversed(below.get(None, ()))]
    while stack:
        depth, task = stack.pop()
        yield depth, task
        stack += [(depth + 1, one) for one in reversed(below.get(task, ()))]


# --- one task -----------------------------------------------------------------------


@question("[TASK]", ":task", ":task 12")
def task(history: History, args: Arguments) -> Answer:
    """Show a task: bindings, method, times and result."""
    run, number = history.run, args.task(history)
    found = run.task(number)
    entry = next(one for one in run.agenda() if one.task == number)
    place = run.library.compiler.row(found.plan.node.name_span)
    rows: list[tuple[str, object]] = [
        ("goal", str(entry.goal)),
        ("state", entry.state),
        ("waits for", entry.waits_for or None),
        ("family", f"[{entry.family}]"),
        ("parent", None if entry.parent is None else f"[{entry.parent}]"),
        ("step", None if found.step is None else str(found.step.node.tag)),
        ("priority", entry.priority),
        ("deadline", entry.deadline),
        ("slack", entry.slack),
        ("method", None if found.method is None else found.method.name),
        ("last result", found.last_result),
        ("defined at", place),
    ]
    bound = found.env if found.run is None else {**found.run.env, **found.env}
    order = dict.fromkeys([*found.env, *bound])
    rows += [(name, format_atom(bound[name])) for name in order]
    notes: tuple[str, ...] = ()
    if found.history is not None:
        plans = run.methods(found.plan)
        counts = found.history.failures.items()
        rows += [(f"failures of {plans[at].name}", count) for at, count in counts]
        notes = tuple(cause_lines(found.history.because))
    kept = [row for row in rows if row[1] is not None]
    return table(("of", "is"), kept, f"task [{number}]", notes=notes)


@question("[TASK]", ":chain 157")
def chain(history: History, args: Arguments) -> Answer:
    """Show a task and its ancestors.

    The answer for an ended task describes the state before its last cycle.
    """
    number = args.task(history, ended=True)
    live = {task.number: task for task in history.run.tasks()}
    if number in live:
        return _chain(live[number])
    with history.at_choice(last_cycle(history, number)) as run:
        return _chain(run.task(number))


def _chain(task: Task) -> Answer:
    above: Task | None = task
    rows = []
    while above is not None:
        method = "" if above.run is None else above.run.plan.name
        rows.append((above.number, above.goal(), method))
        above = above.parent
    return table(("task", "goal", "method"), rows)
