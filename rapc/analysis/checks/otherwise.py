"""RAP078 and RAP085: `otherwise` without effect."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes

MISPLACED = Rule(
    code="RAP078",
    name="misplaced-otherwise",
    severity=Severity.ERROR,
    summary="`otherwise` outside of the context of a method",
    source="T 4.5.1",
)

FIRST = Rule(
    code="RAP085",
    name="first-otherwise",
    severity=Severity.WARNING,
    summary="the first method of a RAP has `otherwise`, which always holds there",
    ignore="never: remove the context if the method fits always",
    source="T 4.5.1",
)


@check(MISPLACED, FIRST)
def otherwise(run: Pass) -> Iterator[Diagnostic]:
    """Find `otherwise` without other methods that the word could refer to."""
    index = run.result(INDEX)
    asked = index.of(nodes.Otherwise)
    if not asked:
        return
    sound = {
        id(part)
        for method in index.of(nodes.Method)
        for part in _conjuncts(method.node.context)
    }
    for rap in index.of(nodes.DefineRap):
        first = rap.node.methods[0].context if rap.node.methods else None
        for part in _conjuncts(first):
            if isinstance(part, nodes.Otherwise):
                yield _first(part)
    for one in asked:
        if id(one.node) not in sound:
            yield MISPLACED.at(
                one.node.span,
                "`otherwise` is not allowed here",
                help="write `otherwise` as the whole context of a method, or as a "
                "part of its `and`",
            )


def _first(part: nodes.Otherwise) -> Diagnostic:
    return FIRST.at(
        part.span,
        "`otherwise` always holds here: no method precedes this method",
        help="move this method after the other methods",
    )


def _conjuncts(formula: nodes.Formula | None) -> Iterator[nodes.Formula]:
    if isinstance(formula, nodes.And):
        for part in formula.parts:
            yield from _conjuncts(part)
    elif formula is not None:
        yield formula
