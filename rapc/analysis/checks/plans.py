"""Goals that the planner cannot plan for, and RAPs that it cannot use [L 10]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import Effect, declared_effects, may_establish
from rapc.analysis.facts.logic import Literal, asked_by, literals
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions
from rapc.ir import nodes
from rapc.ir.walk import through_queries, ways
from rapc.library.library import usable_in_plans

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

NOTHING = Rule(
    code="RAP201",
    name="nothing-to-plan-with",
    severity=Severity.WARNING,
    summary="no RAP that a plan may use makes a fact of `succeed` true",
    ignore="where the fact already holds, or the world makes it true",
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


@check(NOTHING, needs_whole="form")
def nothing_to_plan_with(run: Pass) -> Iterator[Diagnostic]:
    """Find goals with a fact that no operator makes true."""
    acted = {
        one.pattern.name
        for form in run.library.primitives.values()
        for on in form.on
        for one in on.effects
    }
    for rap in run.library.raps.values():
        goal = rap.succeed
        if rap.plan is None or not run.complete or not _queries_a_fact(run, goal):
            continue
        assert goal is not None
        done = list(_operator_effects(run, rap))
        missing = [_missing(run, rap, way, done, acted) for way in ways(goal)]
        lacking = [one for one in missing if one is not None]
        if not lacking or len(lacking) < len(missing):
            continue
        yield NOTHING.at(
            lacking[0].span,
            f"no RAP that a plan may use makes `{lacking[0].written}` true",
            help="declare the fact in the `effects` of a RAP",
        )


def _operator_effects(run: Pass, rap: nodes.DefineRap) -> Iterator[Effect]:
    """Yield the effects of the RAPs that the plans of a RAP may use."""
    raps = run.library.raps
    for name in usable_in_plans(raps, rap):
        if name in raps:
            goal = raps[name].succeed
            facts = [one for way in ways(goal) for one in literals(way)] if goal else []
            achieved = [
                nodes.DeclaredEffect(one.formula, not one.holds, False)
                for one in facts
                if isinstance(one.formula, nodes.Proposition)
            ]
            yield from declared_effects([*raps[name].effects, *achieved])


def _missing(
    run: Pass,
    rap: nodes.DefineRap,
    way: nodes.Formula,
    done: list[Effect],
    acted: set[str],
) -> Literal | None:
    """Return a part of a goal that no effect can make true, or None.

    A fact with a variable may already hold for a value, and so may a fact that no
    primitive changes; such a part is missing only if all parts are.
    """
    inputs = {one.name for one in rap.inputs}
    parts = [(one, _fact(one)) for one in literals(way)]
    facts = [(one, fact) for one, fact in parts if fact is not None]
    never = [row for row in facts if not may_establish(run.library, row[0], done)]
    if never and len(never) == len(facts):
        return never[0][0]
    for one, fact in never:
        fixed = all(
            isinstance(arg, nodes.Const)
            or (isinstance(arg, nodes.Var) and arg.name in inputs)
            for arg in fact.args
        )
        asked = asked_by(run.library, fact) - run.library.queries.keys()
        if one.holds and fixed and asked <= acted:
            return one
    return None


def _fact(one: Literal) -> nodes.Proposition | None:
    """Return the fact or query of a literal, also of a belief."""
    found = one.formula
    if isinstance(found, nodes.Believe):
        found = found.pattern
    return found if isinstance(found, nodes.Proposition) else None
