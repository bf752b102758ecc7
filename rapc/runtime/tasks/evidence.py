"""Facts behind a formula: facts that make the formula true, and opposing facts.

Not here: the part of a query without a solution (`rapc.runtime.tasks.causes`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.base.resources import Value
from rapc.base.values import Fact
from rapc.compiler.program import value_in
from rapc.ir import nodes
from rapc.runtime.memory.access import Evidence, Pattern
from rapc.runtime.memory.memory import EXTERNAL
from rapc.runtime.run import Run


def supporting(run: Run, formula: nodes.Formula, env: Mapping[str, Value]) -> Evidence:
    """Return the facts that make a formula true, in the order of the formula."""
    found: Evidence = {}
    stack = [formula]
    while stack:
        part = stack.pop()
        if isinstance(part, nodes.And | nodes.Or):
            stack.extend(reversed(part.parts))
        elif isinstance(part, nodes.Believe):
            stack.append(part.pattern)
        elif isinstance(part, nodes.Proposition):
            for fact in _supporting(run, part, env):
                found.setdefault(fact, run.context.view.since(fact))
    return found


def _supporting(
    run: Run, part: nodes.Proposition, env: Mapping[str, Value]
) -> Iterable[Fact]:
    """Return the first fact that matches; for a named query, its evidence."""
    for _, query, inner in run.library.opened(part, env):
        found = query.first(run.explaining_context, inner) or {}
        return supporting(run, query.formula, {**inner, **found})
    pattern = pattern_of(run, part, env)
    return () if pattern is None else run.context.view.query(*pattern)[:1]


def opposing(run: Run, part: nodes.Formula, env: Mapping[str, Value]) -> Evidence:
    """Return the facts because of which a part of a query does not hold.

    For a negated part, these are the facts that make its formula true; for a property,
    the fact with its present value; for a belief, the facts that are too old.
    """
    if isinstance(part, nodes.Not):
        return supporting(run, part.part, env)
    inner = part.pattern if isinstance(part, nodes.Believe) else part
    if not isinstance(inner, nodes.Proposition):
        return {}
    pattern, view = pattern_of(run, inner, env), run.context.view
    if pattern is None:
        return {}
    facts = view.query(*pattern)
    if not facts and run.library.signatures.relations[inner.name].is_property:
        facts = view.query(*pattern[:-1], None) if None not in pattern[:-1] else []
    return {fact: view.since(fact) for fact in facts[:1]}


def pattern_of(
    run: Run, part: nodes.Proposition, env: Mapping[str, Value]
) -> Pattern | None:
    """Return a proposition with values for variables, None if unbound.

    The result is None for a proposition that no fact of memory can match.
    """
    relation = run.library.signatures.relations.get(part.name)
    if relation is None:
        return None
    values: list[object] = [value_in(term, env) for term in relation.full(part.args)]
    view = run.context.view
    place = view.place
    if part.name == "location" and values[-1:] == [EXTERNAL] and place is not None:
        values[-1] = place
    return view.canonical((part.name, *values))
