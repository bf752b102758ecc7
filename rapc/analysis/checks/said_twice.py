"""RAP117: what is said twice in one `and` or `or`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import subformulas, variable_names

TWICE = Rule(
    code="RAP117",
    name="said-twice",
    severity=Severity.WARNING,
    summary="an `and` or `or` has the same part twice",
    why="""The second one asks nothing new. It was mostly copied to be changed: another
argument or another fact was meant, and that is not asked.""",
    fix="safe: takes the second one away",
    ignore="never: the second one asks nothing",
    source="T 4.1.3",
    example="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?from ?to) (okay))
(define-rap (pass ?one ?other)
  (method
    (context (and (door ?one open) (door ?one open)))
    (primitive (drive ?one ?other))))
""",
    better="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?from ?to) (okay))
(define-rap (pass ?one ?other)
  (method
    (context (and (door ?one open) (door ?other open)))
    (primitive (drive ?one ?other))))
""",
)


@check(TWICE)
def said_twice(run: Pass) -> Iterator[Diagnostic]:
    """Find parts of an `and` or `or` that say the same."""
    index = run.result(INDEX)
    for conjunction in index.of(nodes.And):
        yield from _look(run, conjunction.node.parts, joined=True)
    for choice in index.of(nodes.Or):
        yield from _look(run, choice.node.parts, joined=False)


def _look(
    run: Pass, parts: tuple[nodes.Formula, ...], *, joined: bool
) -> Iterator[Diagnostic]:
    if len({_head(part) for part in parts}) == len(parts):
        return
    first: dict[nodes.Formula, nodes.Formula] = {}
    for at, part in enumerate(parts):
        other = first.setdefault(part, part)
        if other is part or (joined and _is_another(run, parts[:at], part)):
            continue
        whole = Span(part.span.file, parts[at - 1].span.end, part.span.end)
        fix = Fix(Applicability.SAFE, "take it away", (Edit(whole, ""),))
        yield TWICE.at(
            part.span,
            f"`{format_formula(part)}` is said already",
            labels=(Label(other.span, "here"),),
            fix=fix,
        )


def _is_another(
    run: Pass, before: Sequence[nodes.Formula], part: nodes.Formula
) -> bool:
    """Whether a part may mean something else than the same one before it.

    A `not` may be about one thing that was bound in between, and before about all: a
    default, or a query, may hold of that one though it holds of none [L 2.21]. An age
    that a `believe` has bound is a bound behind it [L 2.56].
    """
    if isinstance(part, nodes.Believe):
        return isinstance(part.age, nodes.Var) and not part.age.anonymous
    if not isinstance(part, nodes.Not):
        return False
    at = before.index(part)
    late = set(_bound(before[at:])) - set(_bound(before[:at]))
    relations = run.signatures.relations
    return not late.isdisjoint(variable_names(part)) and any(
        isinstance(one, nodes.SensorName)
        or (
            isinstance(one, nodes.Proposition)
            and (one.name not in relations or relations[one.name].is_property)
        )
        for one in subformulas(part)
    )


def _bound(parts: Sequence[nodes.Formula]) -> Sequence[str]:
    return variable_names(*[one for one in parts if not isinstance(one, nodes.Not)])


def _head(part: nodes.Formula) -> object:
    """Return what two parts that say the same have in common, and few others."""
    return part.name if type(part) is nodes.Proposition else type(part)
