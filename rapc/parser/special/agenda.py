"""Tasks that are given: one by one in a test, together in `define-agenda`."""

from __future__ import annotations

from collections.abc import Mapping

from rapc.ir import nodes
from rapc.parser.context import Context
from rapc.parser.elaborate import made
from rapc.parser.special.clauses import clauses
from rapc.parser.special.require import require
from rapc.parser.special.script import (
    asked_goal,
    number,
    option_counts,
    options,
    whole,
)
from rapc.parser.syntax import Datum, List, Symbol

_TASK_OPTIONS = option_counts("_once_task_option")
_AGENDA_OPTIONS = option_counts("_once_agenda_option")
_TRUTHS = ("true", "false")


def define_agenda(ctx: Context, form: List) -> nodes.DefineAgenda | None:
    """`(define-agenda name (require "name")... task...)`."""
    name = form.items[1] if len(form.items) > 1 else form
    if not isinstance(name, Symbol):
        message = "`define-agenda` wants a symbol for its name"
        ctx.report("malformed-form", message, name)
        return None
    found = list(clauses(ctx, form.items[2:], "define-agenda", ("require", "task")))
    required = made(require(ctx, one) for word, one in found if word == "require")
    given = made(_given(ctx, one, _AGENDA_OPTIONS) for w, one in found if w == "task")
    return nodes.DefineAgenda(
        name.name, required, given, ctx.span(name), ctx.span(form)
    )


def task(ctx: Context, clause: Datum) -> nodes.GivenTask | None:
    """`(task goal [:priority n] [:deadline t] [:background true])`."""
    return _given(ctx, clause, _TASK_OPTIONS)


def _given(
    ctx: Context, clause: Datum, known: Mapping[str, int]
) -> nodes.GivenTask | None:
    """A `task` with some of the options in `known`."""
    assert isinstance(clause, List)
    if len(clause.items) == 1:
        ctx.report("malformed-clause", "`task` lacks its goal", clause)
        return None
    asked = asked_goal(ctx, clause.items[1], ground=True)
    given = options(ctx, clause.items[2:], "`task`", known)
    if asked is None:
        return None
    times = {word: number(ctx, given[word], "a time") for word in _TIMES & given.keys()}
    priority = given.get(":priority")
    background = given.get(":background")
    if background is not None and ctx.text(background).lower() not in _TRUTHS:
        message = "`:background` takes `true` or `false`"
        ctx.report("malformed-clause", message, background)
    return nodes.GivenTask(
        goal=asked,
        priority=0 if priority is None else whole(ctx, priority, "a priority") or 0,
        deadline=times.get(":deadline"),
        at=times.get(":at"),
        background=background is not None and ctx.text(background).lower() == "true",
        span=ctx.span(clause),
    )


_TIMES = {":deadline", ":at"}
