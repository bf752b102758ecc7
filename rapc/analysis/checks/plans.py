"""Goals that the planner cannot plan for, and RAPs that it cannot use [L 10]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Rule
from rapc.base.names import Suggestions
from rapc.ir import nodes
from rapc.ir.walk import through_queries

NO_GOAL = Rule(
    code="RAP199",
    name="plan-without-goal",
    summary="a RAP has `(plan)`, but `succeed` queries no fact",
    ignore="never: the planner finds no plan",
    source="T 7.4.1",
)

NO_OPERATOR = Rule(
    code="RAP200",
    name="no-operator",
    summary="`(plan rap)` names an unknown RAP, or one without `effects`",
    ignore="never: the planner does not use the RAP",
    source="T 7.4.1",
)


@check(NO_GOAL, NO_OPERATOR, needs_whole="form")
def plans(run: Pass) -> Iterator[Diagnostic]:
    """Find goals without facts, and RAPs that are no operators."""
    known = Suggestions([rap.name for rap in run.library.raps.values() if rap.effects])
    for rap in run.library.raps.values():
        if rap.plan is None:
            continue
        if not _queries_a_fact(run, rap.succeed):
            yield NO_GOAL.at(
                rap.plan.span,
                f"the goal of `{rap.name}` has no fact",
                help="add `(succeed (fact))`",
            )
        for name in rap.plan.raps:
            named = run.library.raps.get(name)
            if named is None:
                yield NO_OPERATOR.at(
                    rap.plan.span,
                    f"unknown RAP `{name}`",
                    help=known.did_you_mean(name),
                )
            elif not named.effects:
                yield NO_OPERATOR.at(
                    rap.plan.span,
                    f"`{name}` has no `effects`",
                    help="declare the effects of the RAP, or leave it out",
                )


def _queries_a_fact(run: Pass, goal: nodes.Formula | None) -> bool:
    """Return whether a formula or a query in it has a fact."""
    library = run.library
    return goal is not None and any(
        isinstance(part, nodes.Proposition)
        and part.name not in library.queries
        and part.name not in library.functions
        for part in through_queries(goal, library.queries)
    )
