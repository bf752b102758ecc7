"""`define-query`: a formula with a name."""

from __future__ import annotations

from rapc.ir import nodes
from rapc.parser.context import Context
from rapc.parser.special.formulas import formula
from rapc.parser.special.parts import parameters
from rapc.parser.syntax import List, String, Symbol


def define_query(ctx: Context, form: List) -> nodes.DefineQuery | None:
    """`(define-query (name arg...) formula ["doc"])`."""
    items = form.items[1:]
    head = items[0] if items else None
    name = head.items[0] if isinstance(head, List) and head.items else None
    if not isinstance(head, List) or not isinstance(name, Symbol):
        ctx.report(
            "malformed-form",
            "`define-query` begins with a name and its arguments in parentheses",
            name or head or form,
            help="write `(define-query (name ?argument...) formula)`",
        )
        return None
    asked = [one for one in items[1:] if not isinstance(one, String)]
    docs = [one for one in items[1:] if isinstance(one, String)]
    if len(asked) != 1 or len(docs) > 1:
        extra = (*asked[1:], *docs[1:])
        message = f"the query `{name.name}` has one formula"
        message += ", and one text that explains it" if len(docs) > 1 else ""
        ctx.report("malformed-form", message, extra[0] if extra else form)
    made = formula(ctx, asked[0]) if asked else None
    args = parameters(ctx, head.items[1:], {})
    if made is None:
        return None
    doc = docs[0].value if docs else ""
    return nodes.DefineQuery(name.name, args, made, doc, ctx.span(name), ctx.span(form))
