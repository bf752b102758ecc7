"""Why a method has ended badly by itself, and not by a step of its: see `causes`."""

from __future__ import annotations

from rapc.base.resources import Counter, SetResource
from rapc.base.values import format_atom
from rapc.compiler.compiler import RequestPlan
from rapc.errors import FactError
from rapc.events import Cause
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_term
from rapc.runtime.machine import Machine
from rapc.runtime.state.task import MethodRun
from rapc.runtime.tasks.causes import context_of, file_and_line, told_of, variables_in


def of_bad_start(machine: Machine, run: MethodRun) -> Cause | None:
    """Return which notation of a method cannot be asserted, or which claim made."""
    if not machine.recorder.tells_causes:
        return None
    for plan in run.plan.notations:
        note = _unfilled(machine, run, plan) or _refusal(machine, run, plan)
        if note:
            return _cause(machine, run, "notation", plan.node, note)
    for asked in run.plan.things:
        note = "" if asked.used else _unfilled(machine, run, asked.plan)
        if note:
            what = f"claims of method `{run.plan.name}`"
            return _cause(machine, run, what, asked.plan.node, note)
    return None


def of_result(machine: Machine, run: MethodRun, result: str) -> Cause | None:
    """Return why a method has ended badly that asks something of the world.

    A request or a skill that cannot be filled in, what the world has answered, or an
    event that was to fail the primitive.
    """
    plan, skills = run.plan.request, run.plan.activation
    if not machine.recorder.tells_causes:
        return None
    asked = [] if skills is None else list(skills.skills)
    asked += [] if plan is None else [plan]
    for one in asked if run.ticket is None else ():
        note = _unfilled(machine, run, one, sent=True)
        if note:
            what = "request" if one is plan else "skill"
            return _cause(machine, run, what, one.node, note)
    if plan is not None:
        note = f"the world answered `{result}`"
        return _cause(machine, run, "primitive", plan.node, note)
    body = run.plan.node.body
    for wait in body.waits if isinstance(body, nodes.Skills) else ():
        if wait.mode == "fail" and wait.signal == f":{result}":
            signal = nodes.Signal(wait.signal, wait.args, span=wait.span)
            return _cause(machine, run, "wait-for", signal, "its event came")
    return None


def of_refusal(machine: Machine, run: MethodRun) -> Cause | None:
    """Return what the world has refused, beside nothing that could be waited for."""
    plan, skills = run.plan.request, run.plan.activation
    asked = plan if skills is None else skills.skills[0]
    if not machine.recorder.tells_causes or asked is None:
        return None
    what = "primitive" if skills is None else "skill"
    note = "the world refused it, and nothing could be waited for"
    return _cause(machine, run, what, asked.node, note)


def _cause(
    machine: Machine, run: MethodRun, what: str, node: nodes.Pattern, note: str
) -> Cause:
    return Cause(
        clause=f"{what} of `{run.task.plan.name}`",
        place=file_and_line(machine, node.span),
        part=format_formula(node),
        note=note,
        bindings=told_of(run.env, variables_in(node.args)),
    )


def _unfilled(
    machine: Machine, run: MethodRun, plan: RequestPlan, sent: bool = False
) -> str:
    """Return what keeps a clause from being filled in; nothing if it can be.

    With `sent` its items need sensor names.
    """
    context = context_of(machine, run.task)
    for arg in plan.args:
        value = arg.needed(context, run.env)
        if value is None:
            return context.noted
        if isinstance(value, Counter | SetResource):
            return f"{format_term(arg.term)} is a resource"
        if sent and _out_of_reach(machine, value):
            return f"`{format_atom(value)}` has no sensor name now"
    return ""


def _refusal(machine: Machine, run: MethodRun, plan: RequestPlan) -> str:
    """Return why memory refuses a notation that is filled in, if it does."""
    context = context_of(machine, run.task)
    filled = [arg.needed(context, run.env) for arg in plan.args]
    try:
        machine.memory.checked((plan.name, *filled))  # type: ignore[arg-type]  # atoms
    except FactError as error:
        return str(error)
    return ""


def _out_of_reach(machine: Machine, value: object) -> bool:
    return isinstance(value, str) and machine.memory.items.sensor_of(value) is None
