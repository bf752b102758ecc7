"""Tasks that are given: one by one in a test, together in `define-agenda`."""

from __future__ import annotations

from rapc.ir import nodes
from rapc.parser.context import Context
from rapc.parser.elaborate import made
from rapc.parser.fields import filled, slots
from rapc.parser.special.clauses import clauses
from rapc.parser.special.require import require
from rapc.parser.special.script import asked_goal, read_options
from rapc.parser.syntax import Datum, List, Symbol


def define_agenda(ctx: Context, form: List) -> nodes.DefineAgenda | None:
    """`(define-agenda name (require "name")... task...)`."""
    name = form.items[1] if len(form.items) > 1 else form
    if not isinstance(name, Symbol):
        message = "`define-agenda` wants a symbol for its name"
        ctx.report("malformed-form", message, name)
        return None
    found = list(clauses(ctx, form.items[2:], "define-agenda", ("require", "task")))
    required = made(require(ctx, one) for word, one in found if word == "require")
    given = made(
        _given(ctx, one, "_once_agenda_option") for w, one in found if w == "task"
    )
    return nodes.DefineAgenda(
        name.name, required, given, ctx.span(name), ctx.span(form)
    )


def task(ctx: Context, clause: Datum) -> nodes.GivenTask | None:
    """`(task goal [:priority n] [:deadline t] [:background true])`."""
    return _given(ctx, clause, "_once_task_option")


def _given(ctx: Context, clause: Datum, group: str) -> nodes.GivenTask | None:
    """A `task` with some of the options of a group."""
    assert isinstance(clause, List)
    if len(clause.items) == 1:
        ctx.report("malformed-clause", "`task` lacks its goal", clause)
        return None
    asked = asked_goal(ctx, clause.items[1], ground=True)
    read = read_options(ctx, clause.items[2:], "`task`", group)
    if asked is None:
        return None
    fields = filled(slots("agenda_task", nodes.GivenTask), read)
    return nodes.GivenTask(goal=asked, span=ctx.span(clause), **fields)
