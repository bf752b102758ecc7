"""Explanation, for people, of how the clauses of a RAP query memory.

The explanation lists the steps that the writers of generated code record
(`rapc.compiler.query.plan_steps`). The number of facts read depends on the memory:
without a memory, the explanation only names the facts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import msgspec

from rapc.compiler.program import Program
from rapc.compiler.query.plan_steps import AccessPath, PlanStep
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula, format_term


class ClausePlan(msgspec.Struct, frozen=True):
    """The plan of one clause.

    `where` is the clause with its position in the source; `bound` are its variables
    that have a value beforehand, `binds` the variables that its solution adds; `steps`
    run from left to right, with backtracking [L 2.1].
    """

    where: str
    bound: tuple[str, ...]
    binds: tuple[str, ...]
    steps: tuple[PlanStep, ...]


def explain(library: Program, name: str) -> tuple[ClausePlan, ...]:
    """Return the plan of each clause of a RAP, in the order of a task's life [L 3].

    A step's `for` formulas are shown for an environment with inputs, resources and the
    bindings of the method's choice, and without outputs.

    Raises:
        ValueError: if the library has no RAP with this name.
    """
    plan = library.rap(name)
    if plan is None:
        raise ValueError(str(library.signatures.unknown("goal", name)))
    return tuple(_of_rap(plan))


def _of_rap(plan: RapPlan) -> Iterator[ClausePlan]:
    own = (*plan.inputs, *(r.variable.name for r in plan.node.resources))
    for clause in clauses.RAP:
        if clause.word in plan.clauses and not clause.hands_on:
            yield _clause_plan(plan.clauses[clause.word], own)
    for method in plan.methods:
        yield from _of_method(method, own)


def _of_method(method: MethodPlan, own: tuple[str, ...]) -> Iterator[ClausePlan]:
    known = own
    asked = _choice_plan(method, own)
    if asked is not None:
        known = (*own, *asked.binds)
        yield asked
    if method.constraints is not None:
        yield _clause_plan(method.constraints, known)
    for step in method.steps:
        for _, condition in step.conditions:
            yield _clause_plan(condition, known)


def _choice_plan(method: MethodPlan, own: tuple[str, ...]) -> ClausePlan | None:
    """Return the plan of the context of a method, `otherwise` first."""
    plan = None if method.choice is None else _clause_plan(method.choice, own)
    if not method.otherwise:
        return plan
    first = PlanStep(nodes.Otherwise(), 0, AccessPath.OTHERWISE)
    if plan is None:
        return ClausePlan(f"context of method `{method.name}`", (), (), (first,))
    return msgspec.structs.replace(plan, steps=(first, *plan.steps))


def _clause_plan(query: Query, known: Sequence[str]) -> ClausePlan:
    bound = tuple(name for name in query.variables if name in known)
    return ClausePlan(query.where, bound, query.outputs(bound), query.steps(bound))


# --- in words ---------------------------------------------------------------------


_RUNS = (AccessPath.ALL, AccessPath.INDEX, AccessPath.SMALLEST)
"""The access paths that may return several facts."""

Spread = Callable[..., float]
"""For a name and places of arguments: the average number of matching facts."""


def describe(
    plans: Sequence[ClausePlan], spread: Spread | None = None
) -> Iterator[str]:
    """Yield the plans that `explain` returns as text: a heading, a line for each step.

    With the `spread` of a memory (`MemoryView.spread`), the lines contain the expected
    number of facts of each scan.
    """
    for plan in plans:
        given = f" ({' '.join(plan.bound)} bound)" if plan.bound else ""
        yield f"{plan.where}{given}"
        for step in plan.steps:
            yield f"{'  ' * (step.depth + 1)}{describe_step(step, spread)}"


def describe_step(step: PlanStep, spread: Spread | None = None) -> str:
    """Return a step as text: the part of the formula, and its access path."""
    if step.way is AccessPath.NAMED:
        return f"{format_formula(step.formula)}: {step.way.value}:"
    if step.way in (AccessPath.EITHER, AccessPath.NEITHER):
        return f"{step.way.value}:"
    parts = [_how(step)]
    pattern = _pattern(step) if step.way in _RUNS else None
    if spread is not None and pattern is not None:
        expected = min(spread(pattern.name, *places) for places in _looks(step))
        parts[0] += f" (about {expected:,.1f})".replace(".0)", ")")
    if step.default is not None:
        parts.append(f"default `{step.default}` if there is no value")
    if step.tested:
        terms = ", ".join(_term(step, at) for at in step.tested)
        parts.append(f"compare with {terms}")
    if step.binds:
        parts.append(f"bind {' '.join(step.binds)}")
    return f"{format_formula(step.formula)}: {'; '.join(parts)}"


def _how(step: PlanStep) -> str:
    pattern = _pattern(step)
    if step.way is AccessPath.TEST:
        return "test"
    if step.way is AccessPath.VALUE and pattern is not None:
        index = " ".join([pattern.name, *(_term(step, at) for at in step.by)])
        return f"look up the value of ({index})"
    if step.way is AccessPath.ALL and pattern is not None:
        return f"search all facts of `{pattern.name}`"
    if step.way is AccessPath.INDEX:
        return f"search the facts with {_place(step, step.by[0])}"
    if step.way is AccessPath.SMALLEST:
        places = [_place(step, at) for at in step.by]
        return f"search the smaller set of the facts with {' or '.join(places)}"
    words: str = step.way.value
    return words


def _looks(step: PlanStep) -> Iterable[tuple[int, ...]]:
    """Return the places of arguments that can select facts, each by itself."""
    return [(at,) for at in step.by] or [()]


def _pattern(step: PlanStep) -> nodes.Proposition | None:
    formula = step.formula
    if isinstance(formula, nodes.Believe):
        return formula.pattern
    return formula if isinstance(formula, nodes.Proposition) else None


def _term(step: PlanStep, at: int) -> str:
    """Return an argument of a step's pattern; the value `true` may be omitted."""
    pattern = _pattern(step)
    if pattern is None or at > len(pattern.args):
        return "true"
    return format_term(pattern.args[at - 1])


def _place(step: PlanStep, at: int) -> str:
    return f"{_term(step, at)} as argument {at}"
