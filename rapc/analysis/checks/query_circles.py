"""RAP079: named queries that use themselves, directly or indirectly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.graph import circles
from rapc.ir import nodes, walk

CIRCLE = Rule(
    code="RAP079",
    name="query-in-a-circle",
    severity=Severity.ERROR,
    summary="a named query uses itself",
    source="T 4.1",
)


@check(CIRCLE)
def query_circles(run: Pass) -> Iterator[Diagnostic]:
    """Find named queries without a finite formula."""
    queries = run.library.queries
    asked = {name: _asked(query, queries) for name, query in queries.items()}
    for members in circles(asked):
        yield _finding(queries, members)


def _asked(
    query: nodes.DefineQuery, queries: Mapping[str, nodes.DefineQuery]
) -> Sequence[str]:
    """Return the names of the queries that a query uses, in the order of the text."""
    parts = walk.subformulas(query.formula)
    names = (part.name for part in parts if isinstance(part, nodes.Proposition))
    return tuple(dict.fromkeys(name for name in names if name in queries))


def _finding(
    queries: Mapping[str, nodes.DefineQuery], circle: Sequence[str]
) -> Diagnostic:
    first, *others = circle
    through = f", through {', '.join(f'`{name}`' for name in others)}" if others else ""
    use = next(
        part
        for name in reversed(circle)
        for part in walk.subformulas(queries[name].formula)
        if isinstance(part, nodes.Proposition) and part.name == first
    )
    return CIRCLE.at(
        queries[first].name_span,
        f"query `{first}` uses itself{through}",
        labels=tuple(
            [
                Label(queries[n].name_span, "this query is part of the cycle")
                for n in others
            ]
            + [Label(use.span, f"uses `{first}`")]
        ),
        help="use a RAP with `repeat-while`, or declare a function",
    )
