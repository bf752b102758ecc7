"""Top-level tasks, as a host or a user on the command line submits them.

A task request is text, or a part of an agenda of the library (`define-agenda`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import msgspec

from rapc.base.names import hint
from rapc.base.source import place
from rapc.base.values import Atom, Fact, format_atom, format_list
from rapc.compiler.program import Program
from rapc.errors import RefusedError, TextError
from rapc.ir import nodes
from rapc.ir.nodes import Const
from rapc.library.library import Library
from rapc.parser.parse import parse_goal_options
from rapc.world import Time


class TaskRequest(msgspec.Struct, frozen=True):
    """A top-level task: a goal `(rap args...)` with options of its execution.

    `deadline` and `at` are absolute times; a task in the `background` does not keep the
    run going.
    """

    goal: Fact
    priority: int = 0
    deadline: Time | None = None
    at: Time | None = None
    background: bool = False


def read_task_request(text: str) -> TaskRequest:
    """Return a task from text: `(rap args) :priority 4 :deadline 290 :at 120`.

    Raises:
        TextError: a ValueError with one line that describes the error.
    """
    goal, options = parse_goal_options(text)
    args = [arg.value for arg in goal.args if isinstance(arg, Const)]
    if len(args) != len(goal.args) or goal.outputs:
        raise TextError("the inputs of a task must be symbols, numbers or strings")
    background = options.get("background", "false")
    if background not in ("true", "false"):
        raise TextError(f"`:background` takes true or false, not `{background}`")
    priority = options.get("priority", 0)
    if not isinstance(priority, int):
        raise TextError(f"`:priority` takes a whole number, not `{priority}`")
    return TaskRequest(
        goal=(goal.name, *args),
        priority=priority,
        deadline=_time(options, "deadline"),
        at=_time(options, "at"),
        background=background == "true",
    )


def of_node(task: nodes.GivenTask) -> TaskRequest:
    """Return the request of a line in an agenda or in a test."""
    args = [arg.value for arg in task.goal.args if isinstance(arg, Const)]
    return TaskRequest(
        goal=(task.goal.name, *args),
        priority=task.priority,
        deadline=task.deadline,
        at=task.at,
        background=task.background,
    )


def of_agenda(library: Library, name: str) -> tuple[TaskRequest, ...]:
    """Return the requests of the agenda `name` of `library`, in the order of its text.

    Raises:
        RefusedError: if the library has no such agenda.
    """
    agenda = library.agendas.get(name)
    if agenda is None:
        meant = hint(name, library.agendas)
        raise RefusedError([f"unknown agenda `{name}`{meant}"])
    return tuple([of_node(task) for task in agenda.tasks])


def as_text(request: TaskRequest) -> str:
    """Return the text from which `read_task_request` makes the same request."""
    words = [format_list(request.goal)]
    if request.priority:
        words.append(f":priority {request.priority}")
    if request.deadline is not None:
        words.append(f":deadline {format_atom(request.deadline)}")
    if request.at is not None:
        words.append(f":at {format_atom(request.at)}")
    if request.background:
        words.append(":background true")
    return " ".join(words)


def _time(options: Mapping[str, Atom], name: str) -> Time | None:
    value = options.get(name)
    if value is not None and not isinstance(value, int | float):
        raise TextError(f"`:{name}` takes a time, not `{value}`")
    if value is not None and value < 0:
        raise TextError(f"`:{name}` takes a time, and the clock begins at 0")
    return value


# --- checks -------------------------------------------------------------------------


def refuse_tasks(library: Program, goals: Iterable[Fact]) -> None:
    """Refuse goals without a RAP, or goals that reach a step without a RAP.

    Raises:
        RefusedError: with one line for each goal without a RAP.
    """
    reasons: list[str] = []
    seen: set[str] = set()
    for goal in goals:
        name, *args = goal
        plan, signatures = library.rap(str(name)), library.signatures
        if plan is None or len(plan.inputs) != len(args):
            reasons.append(str(signatures.fault("goal", str(name), len(args))))
            continue
        wrong = signatures.wrong_kind("goal", str(name), args) if plan.kinds else None
        if wrong is not None:
            reasons.append(f"{format_list(goal)}: {wrong}")
        reasons.extend(_reached(library.library, plan.node, seen))
    if reasons:
        raise RefusedError(list(dict.fromkeys(reasons)))


def _reached(library: Library, root: nodes.DefineRap, seen: set[str]) -> Iterator[str]:
    """Yield the goals without a RAP that a task of a RAP can reach, with places.

    RAPs in `seen` are left out; the RAPs that a task can reach are added.
    """
    stack = [] if root.name in seen else [root]
    seen.add(root.name)
    while stack:
        rap = stack.pop()
        for method in rap.methods:
            body = method.body
            if isinstance(body, nodes.TaskNet):
                for step in body.steps:
                    below = library.raps.get(step.goal.name)
                    if below is None:
                        where = place(step.goal.span, library.files)
                        yield f"{where}: unknown RAP `{step.goal.name}`"
                    elif below.name not in seen:
                        seen.add(below.name)
                        stack.append(below)
