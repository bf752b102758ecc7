"""`require`: the files a file needs. Finding them is for `rapc.library.loader`."""

from __future__ import annotations

from rapc.ir import nodes
from rapc.parser.context import Context
from rapc.parser.syntax import List, String, Symbol


def require(ctx: Context, form: List) -> nodes.Require | None:
    """`(require "name")`."""
    operands = form.items[1:]
    first = operands[0] if len(operands) == 1 else None
    if isinstance(first, Symbol):
        ctx.report_fixable(
            "malformed-form",
            "`require` takes a string",
            first,
            fix=ctx.replace(first, f'"{first.name}"'),
        )
        return nodes.Require(first.name, ctx.span(form))
    if isinstance(first, String) and first.value:
        return nodes.Require(first.value, ctx.span(form))
    ctx.report("malformed-form", "`require` takes the name of one file", form)
    return None
