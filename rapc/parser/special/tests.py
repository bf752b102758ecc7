"""`define-test`: its clauses, what is given, and what is done at a time.

The rows of a script are read by `rapc.parser.special.script`, expectations by
`rapc.parser.special.expectations`. What a test means is in docs/testing.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from rapc.ir import nodes
from rapc.language.heads import TEST_CLAUSES, heads
from rapc.parser.context import Context
from rapc.parser.elaborate import made
from rapc.parser.special.clauses import clauses, read_clauses, single
from rapc.parser.special.script import (
    asked_goal,
    number,
    option_counts,
    options,
    whole,
)
from rapc.parser.syntax import Datum, List, String, Symbol

T = TypeVar("T")

_ONCE = heads("_once_test_clause")
_TASK_OPTIONS = option_counts("_once_task_option")


def define_test(ctx: Context, datum: Datum) -> nodes.DefineTest | None:
    """`(define-test name ["doc"] clause...)`."""
    assert isinstance(datum, List)
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
    kept = single(ctx, found, set(TEST_CLAUSES) - set(_ONCE))
    read = dict.fromkeys(TEST_CLAUSES, ()) | read_clauses(ctx, kept, "_test_clause")
    return nodes.DefineTest(
        name=name.name,
        doc=doc,
        requires=made(read["require"]),
        world=next(iter(made(read["world"])), None),
        facts=_joined(read["facts"]),
        script=_joined(read["script"]),
        ats=made(read["at"]),
        tasks=made(read["task"]),
        until=_until(made((*read["until"], *read["cycles"]))),
        expectations=_joined(e.expectations for e in made(read["expect"])),
        name_span=ctx.span(name),
        span=ctx.span(datum),
    )


def _joined(found: Iterable[tuple[T, ...] | None]) -> tuple[T, ...]:
    return tuple([one for row in made(found) for one in row])


def _until(found: Sequence[nodes.Until]) -> nodes.Until | None:
    """`(until t)`, `(until (cycles n))` and `cycles` as a clause of its own, as one."""
    if not found:
        return None
    times = [one.time for one in found if one.time is not None]
    cycles = [one.cycles for one in found if one.cycles is not None]
    time, count = next(iter(times), None), next(iter(cycles), None)
    return nodes.Until(time, count, found[-1].span)


# --- tasks and times ---------------------------------------------------------------


def task(ctx: Context, clause: Datum) -> nodes.GivenTask | None:
    """`(task goal [:priority n] [:deadline t] [:background true])`."""
    assert isinstance(clause, List)
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


def at(ctx: Context, datum: Datum) -> nodes.At | None:
    """`(at time action...)`."""
    assert isinstance(datum, List)
    time = number(ctx, datum.items[1], "a time") if len(datum.items) > 1 else None
    if time is None:
        if len(datum.items) == 1:
            ctx.report("malformed-clause", "`at` lacks its time", datum)
        return None
    found = clauses(ctx, datum.items[2:], "at", ACTIONS)
    readers = ctx.readers.group("_action")
    actions: tuple[nodes.Action, ...] = made(readers[n](ctx, one) for n, one in found)
    return nodes.At(time, actions, ctx.span(datum))


ACTIONS = heads("_action")
"""What may be done at a time."""
