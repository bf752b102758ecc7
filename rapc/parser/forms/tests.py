"""`define-test`: its clauses, what is given, and what is done at a time.

The rows of a script are read by `rapc.parser.special.script`, expectations by
`rapc.parser.special.expectations`. What a test means is in docs/testing.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rapc.ir import nodes
from rapc.language.heads import TEST_CLAUSES
from rapc.parser.special.clauses import clauses, single
from rapc.parser.special.context import Context
from rapc.parser.special.expectations import expectations
from rapc.parser.special.require import require
from rapc.parser.special.script import (
    asked_goal,
    facts,
    made,
    number,
    options,
    row,
    signals,
    whole,
)
from rapc.parser.syntax import Datum, List, Numeral, String, Symbol

_MANY = ("require", "facts", "script", "at", "task", "expect")
_TASK_OPTIONS = {":priority": 1, ":deadline": 1, ":background": 1}


def define_test(ctx: Context, datum: List) -> nodes.DefineTest | None:
    """`(define-test name ["doc"] clause...)`."""
    items = datum.items[1:]
    name = items[0] if items else datum
    if not isinstance(name, Symbol):
        ctx.report("malformed-form", "`define-test` wants a symbol for its name", name)
        return None
    doc = ""
    first = items[1] if len(items) > 1 else None
    if isinstance(first, String):
        doc, items = first.value, items[1:]
    found = clauses(ctx, items[1:], "define-test", TEST_CLAUSES)
    kept = single(ctx, found, _MANY)
    return nodes.DefineTest(
        name=name.name,
        doc=doc,
        requires=made(require(ctx, clause) for clause in kept.get("require", ())),
        world=_world(ctx, kept),
        facts=facts(ctx, _inside(kept, "facts")),
        script=made(row(ctx, one) for one in _inside(kept, "script")),
        ats=made(_at(ctx, clause) for clause in kept.get("at", ())),
        tasks=made(_task(ctx, clause) for clause in kept.get("task", ())),
        until=_until(ctx, kept),
        expectations=expectations(ctx, _inside(kept, "expect")),
        name_span=ctx.span(name),
        span=ctx.span(datum),
    )


def _inside(kept: Mapping[str, Sequence[List]], name: str) -> list[Datum]:
    return [datum for clause in kept.get(name, ()) for datum in clause.items[1:]]


def _lone(ctx: Context, clause: List, what: str) -> Datum | None:
    """The one operand of a clause."""
    if len(clause.items) == 2:
        return clause.items[1]
    head = ctx.text(clause.items[0])
    ctx.report("malformed-clause", f"`{head}` takes {what}, nothing else", clause)
    return None


def _world(ctx: Context, kept: Mapping[str, Sequence[List]]) -> str | None:
    for clause in kept.get("world", ()):
        operand = _lone(ctx, clause, "the name of a world")
        if isinstance(operand, Symbol | String):
            return operand.name if isinstance(operand, Symbol) else operand.value
        if operand is not None:
            ctx.report("malformed-clause", "the name of a world is wanted", operand)
    return None


def _until(ctx: Context, kept: Mapping[str, Sequence[List]]) -> nodes.Until | None:
    """`(until t)`, `(until (cycles n))`, and `cycles` as a clause of its own."""
    time: nodes.Const | None = None
    cycles: int | None = None
    place: List | None = None
    for clause in (*kept.get("until", ()), *kept.get("cycles", ())):
        place = clause
        operand = _lone(ctx, clause, "a time or `(cycles n)`")
        if isinstance(operand, List):
            place, operand = operand, _lone(ctx, operand, "a number")
        if operand is None:
            continue
        if ctx.text(place.items[0]).lower() == "cycles":
            cycles = whole(ctx, operand, "a number of cycles", least=1)
        elif isinstance(operand, Numeral) and operand.value >= 0:
            time = nodes.Const(operand.value, ctx.span(operand))
        else:
            ctx.report("malformed-clause", "a time is wanted here", operand)
    if place is None or (time is None and cycles is None):
        return None
    value = time.value if time is not None else None
    assert value is None or isinstance(value, int | float)
    return nodes.Until(value, cycles, ctx.span(place))


# --- tasks and times ---------------------------------------------------------------


def _task(ctx: Context, clause: List) -> nodes.GivenTask | None:
    """`(task goal [:priority n] [:deadline t] [:background true])`."""
    if len(clause.items) == 1:
        ctx.report("malformed-clause", "`task` lacks its goal", clause)
        return None
    asked = asked_goal(ctx, clause.items[1], ground=True)
    given = options(ctx, clause.items[2:], "`task`", _TASK_OPTIONS)
    if asked is None:
        return None
    priority = given.get(":priority")
    deadline = given.get(":deadline")
    background = given.get(":background")
    if background is not None and ctx.text(background).lower() not in _TRUTHS:
        message = "`:background` takes `true` or `false`"
        ctx.report("malformed-clause", message, background)
    return nodes.GivenTask(
        goal=asked,
        priority=0 if priority is None else whole(ctx, priority, "a priority") or 0,
        deadline=None if deadline is None else number(ctx, deadline, "a time"),
        background=background is not None and ctx.text(background).lower() == "true",
        span=ctx.span(clause),
    )


_TRUTHS = ("true", "false")


def _cancel(ctx: Context, clause: List) -> nodes.Cancel | None:
    operand = _lone(ctx, clause, "one goal")
    asked = None if operand is None else asked_goal(ctx, operand)
    return None if asked is None else nodes.Cancel(asked, ctx.span(clause))


def _at(ctx: Context, clause: List) -> nodes.At | None:
    """`(at time action...)`."""
    time = number(ctx, clause.items[1], "a time") if len(clause.items) > 1 else None
    if time is None:
        if len(clause.items) == 1:
            ctx.report("malformed-clause", "`at` lacks its time", clause)
        return None
    found = clauses(ctx, clause.items[2:], "at", tuple(ACTIONS))
    actions: tuple[nodes.Action, ...] = made(
        ACTIONS[name](ctx, one) for name, one in found
    )
    return nodes.At(time, actions, ctx.span(clause))


ACTIONS: Mapping[str, Callable[[Context, List], nodes.Action | None]] = {
    "asserts": lambda ctx, clause: nodes.Asserts(
        facts(ctx, clause.items[1:]), ctx.span(clause)
    ),
    "erases": lambda ctx, clause: nodes.Erases(
        facts(ctx, clause.items[1:]), ctx.span(clause)
    ),
    "signals": lambda ctx, clause: nodes.Signals(
        signals(ctx, clause.items[1:], ground=True), ctx.span(clause)
    ),
    "task": _task,
    "cancel": _cancel,
    "expect": lambda ctx, clause: nodes.Expect(
        expectations(ctx, clause.items[1:]), ctx.span(clause)
    ),
}
"""What may be done at a time."""
