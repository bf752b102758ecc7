"""Changes that are no slips: other names, another order where order is free, comments.

As in `bench.mutation_words`, a kind yields every place where the change can be made.
`check` must find nothing in what they leave.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from bench.mutation_base import Base, Edit, Kind, swap
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import formulas, subformulas, variable_names


def _renamed(text: str, name: str, other: str) -> str:
    return re.sub(rf"(?<=[( ]){re.escape(name)}(?=[ )\n])", other, text)


def _variable_renamed(base: Base) -> Iterator[Edit]:
    for owner, names in base.index.variables():
        if isinstance(owner, nodes.DefineRap | nodes.DefineQuery):
            for name in names:
                text = _renamed(base.text(owner.span), name, f"{name}-here")
                if name != "?" and text.count(f"{name}-here") > 1:
                    yield Edit(owner.span, text)


def _tag_renamed(base: Base) -> Iterator[Edit]:
    for net, step in base.steps():
        yield Edit(net.span, _renamed(base.text(net.span), step.tag, "begin"))


def _inputs_fresh_age(base: Base) -> Iterator[Edit]:
    """A belief may be a little older."""
    for one in base.index.of(nodes.Believe):
        if isinstance(one.node.age, nodes.Const):
            age = base.text(one.node.age.span)
            if age.isdigit():
                yield Edit(one.node.age.span, str(int(age) + 1))


def _rap_moved(base: Base) -> Iterator[Edit]:
    for one, other in pairwise(base.library.forms):
        both = isinstance(one, nodes.DefineRap) and isinstance(other, nodes.DefineRap)
        if both and one.span.file == other.span.file:
            yield swap(base, one.span, other.span)


def _queries_moved(base: Base) -> Iterator[Edit]:
    for one, other in pairwise(base.library.forms):
        named = isinstance(one, nodes.DefineQuery)
        behind = isinstance(other, nodes.DefineRap | nodes.DefineQuery)
        if named and behind and one.span.file == other.span.file:
            yield swap(base, one.span, other.span)


def _facts_exchanged(base: Base) -> Iterator[Edit]:
    """Two conjuncts without a common variable change places."""
    for rap in base.raps:
        for one in formulas(rap):
            for part in subformulas(one.formula):
                for first, second in pairwise(
                    part.parts if isinstance(part, nodes.And) else ()
                ):
                    both = isinstance(first, nodes.Proposition) and isinstance(
                        second, nodes.Proposition
                    )
                    names = set(variable_names(first)) & set(variable_names(second))
                    if both and names <= {v.name for v in rap.inputs}:
                        yield swap(base, first.span, second.span)


def _true_added(base: Base) -> Iterator[Edit]:
    """A method says that it has no context."""
    for rap in base.raps:
        for method in rap.methods:
            if method.context is None:
                at = method.body.span.start
                yield Edit(Span(method.span.file, at, at), "(context true) ")


def _comment_added(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        at = rap.span.start
        yield Edit(Span(rap.span.file, at, at), "; (succeed ?never)\n")
        end = rap.span.end
        more = "\n(define-rap (another-one) (succeed true))"
        yield Edit(Span(rap.span.file, end, end), more)


def _step_wrapped(base: Base) -> Iterator[Edit]:
    """A method of one primitive asks for it by a step of its own RAP."""
    for rap in base.raps:
        for method in rap.methods:
            body = method.body
            if isinstance(body, nodes.Primitive) and rap.succeed is not None:
                if "-result" in base.text(rap.span) or "tried" in base.text(rap.span):
                    continue
                terms = dict.fromkeys(
                    base.text(a.span)
                    for a in body.request.args
                    if isinstance(a, nodes.Var)
                )
                kinds = {k.variable: k.kind for k in rap.kinds}
                inputs = " ".join(
                    f"({v} {kinds[v]})" if v in kinds else v for v in terms
                )
                name = f"{rap.name}-once"
                yield Edit(
                    Span(rap.span.file, rap.span.start, rap.span.end),
                    base.text(rap.span).replace(
                        base.text(body.span),
                        f"(task-net (t1 ({' '.join([name, *terms])})))",
                        1,
                    )
                    + f"\n(define-rap ({' '.join([name, inputs]).strip()})\n"
                    + f"  (method {base.text(body.span)}))",
                )


def _and_nested(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        others = formula.parts[1:]
        if len(others) > 1:
            whole = others[0].span.to(others[-1].span)
            yield Edit(whole, f"(and {base.text(whole)})")


def _method_named(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods:
            if method.name is None:
                at = method.span.start + len("(method")
                yield Edit(Span(method.span.file, at, at), " only")


def _steps_exchanged(base: Base) -> Iterator[Edit]:
    """Two steps are written in another order; their annotations say the order."""
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            if any(isinstance(n, nodes.For) for n in one.annotations):
                yield swap(base, one.span, other.span)


def _negation_pulled(base: Base) -> Iterator[Edit]:
    """`(not (or a b))` for `(and (not a) (not b))`, where both are negated."""
    for _, formula in base.contexts():
        for one, other in pairwise(formula.parts):
            both = isinstance(one, nodes.Not) and isinstance(other, nodes.Not)
            texts = (base.text(one.span), base.text(other.span))
            if both and all(text.startswith("(not") for text in texts):
                parts = [text[len("(not") : -1].strip() for text in texts]
                yield Edit(one.span.to(other.span), f"(not (or {' '.join(parts)}))")


def _last_resort(base: Base) -> Iterator[Edit]:
    """A RAP gets a last method for what no other covers: it waits a little."""
    for rap in base.raps:
        for method in rap.methods[-1:]:
            asks = method.context is not None and "otherwise" not in base.text(
                method.context.span
            )
            if asks and len(rap.methods) > 1 and rap.succeed is not None:
                more = (
                    "\n  (method give-time (context otherwise) "
                    "(task-net (t1 (give-time-a-chance) (window now 1 2))))"
                )
                text = base.text(rap.span)[:-1] + more + ")"
                yield Edit(
                    rap.span, text + "\n(define-rap (give-time-a-chance) (succeed t))"
                )


KINDS: Mapping[str, Kind] = {
    "variable renamed": _variable_renamed,
    "tag renamed": _tag_renamed,
    "belief a little older": _inputs_fresh_age,
    "RAPs in another order": _rap_moved,
    "queries in another order": _queries_moved,
    "conjuncts in another order": _facts_exchanged,
    "`true` as a context": _true_added,
    "comment or RAP added": _comment_added,
    "primitive in a RAP of its own": _step_wrapped,
    "conjunction nested": _and_nested,
    "method named": _method_named,
    "steps in another order": _steps_exchanged,
    "negations joined": _negation_pulled,
    "last resort added": _last_resort,
}
"""Every kind of harmless change."""
