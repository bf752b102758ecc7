"""Facts, properties and `believe` to generated Python.

A property whose index is known is one look-up with its default behind it (T 2.2.2);
everything else runs through the smallest index that a known argument selects, oldest
assertion first.
"""

from __future__ import annotations

import msgspec

from rapc.compiler.emitter import Scope
from rapc.compiler.terms import (
    Clause,
    arguments,
    attempt,
    bound_value,
    fault,
    known_value,
    match,
    registered,
)
from rapc.compiler.vocabulary import Relation
from rapc.ir import nodes


class _Query(msgspec.Struct, frozen=True):
    """A pattern with the expressions of its known arguments (None: unknown)."""

    relation: Relation
    args: tuple[nodes.Term, ...]
    known: tuple[str | None, ...]
    age: nodes.Term | None

    @property
    def may_be_external(self) -> bool:
        """Whether it may ask for items at the robot's own place (semantics 7)."""
        if self.relation.name != "location" or not self.relation.is_property:
            return False
        place = self.args[-1]
        if len(self.args) != 2 or self.known[-1] is None:
            return False
        return not isinstance(place, nodes.Const) or place.value == "external"


def pattern(clause: Clause, scope: Scope, formula: nodes.Pattern) -> None:
    """A proposition, a property, or a declared function used as a test."""
    relation = clause.vocabulary.relations.get(formula.name)
    if relation is not None:
        _fact(clause, scope, relation, formula, None)
    elif formula.name in clause.vocabulary.functions:
        args = arguments(clause, scope, formula.args)
        if args is not None:
            name = clause.emitter.constant(formula.name)
            listed = "".join(f"{a}, " for a in args)
            scope.require(f"holds(ctx.functions[{name}](ctx.view, {listed}))")
    else:
        what = clause.emitter.constant(f"`{formula.name}` is not declared")
        fault(clause, scope, what)


def believe(clause: Clause, scope: Scope, formula: nodes.Believe) -> None:
    """A pattern with a limit on its age, or asking for it (T 2.2.3)."""
    relation = clause.vocabulary.relations.get(formula.pattern.name)
    if relation is None:
        pattern(clause, scope, formula.pattern)
    else:
        _fact(clause, scope, relation, formula.pattern, formula.age)


def _fact(
    clause: Clause,
    scope: Scope,
    relation: Relation,
    formula: nodes.Pattern,
    age: nodes.Term | None,
) -> None:
    args = relation.full(formula.args)
    if not args:
        fact = clause.emitter.constant((relation.name,))
        scope.require(f"{fact} in ctx.stamps")
        _aged(clause, scope, fact, age)
        return
    known = tuple([known_value(clause, scope, arg) for arg in args])
    query = _Query(relation, args, known, age)
    if relation.is_property and None not in known[:-1]:
        _look_up(clause, scope, query)
    else:
        _scan(clause, scope, query)


def _look_up(clause: Clause, scope: Scope, query: _Query) -> None:
    """A property whose index is known: one look, then the default (T 2.2.2)."""
    index, fact = (clause.emitter.fresh(p) for p in ("i", "f"))
    name = clause.emitter.constant(query.relation.name)
    parts = "".join(f"{k}, " for k in query.known[:-1])
    scope.line(f"{index} = ({name}, {parts})")
    scope.line(f"{fact} = values.get({index})")
    must_exist = query.age is not None and _asks_age(scope, query.age, query.args)
    if must_exist:
        scope.refuse(f"{fact} is None")
        value = f"{fact}[-1]"
    else:
        default = _default(clause, query.relation, index)
        either = f"{default} if {fact} is None else {fact}[-1]"
        value = attempt(clause, scope, either)
    expected = query.known[-1]
    if query.may_be_external:
        scope.require(f"{value} == {expected} or ctx.is_here({fact}, {expected})")
    else:
        match(clause, scope, query.args[-1], value)
    if must_exist or query.age is None:
        _aged(clause, scope, fact, query.age)
    else:
        limit = _limit(clause, scope, query.age)
        scope.refuse(f"{fact} is not None and not ctx.young({fact}, {limit})")


def _default(clause: Clause, relation: Relation, index: str) -> str:
    function = relation.default_function
    if function is None:
        return clause.emitter.constant(relation.default)
    return registered(clause, function, index)


def _scan(clause: Clause, scope: Scope, query: _Query) -> None:
    """Run through the facts of the smallest index that a known argument selects."""
    name = clause.emitter.constant(query.relation.name)
    keys = [
        f"({name}, {at}, {k})" for at, k in enumerate(query.known, 1) if k is not None
    ]
    fact = clause.emitter.fresh("f")
    if query.may_be_external:
        scope.loop(f"for {fact} in ctx.facts_at({query.known[-1]}):")
    elif not keys:
        scope.loop(f"for {fact} in buckets.get(({name},), ()):")
    elif len(keys) == 1:
        scope.loop(f"for {fact} in buckets.get({keys[0]}, ()):")
    else:
        sizes = ", ".join(f"buckets.get({key}, ())" for key in keys)
        scope.loop(f"for {fact} in min({sizes}, key=len):")
    if query.relation.arity is None:
        scope.require(f"len({fact}) == {len(query.args) + 1}")
    for at, (arg, value) in enumerate(zip(query.args, query.known, strict=True), 1):
        if value is None:
            match(clause, scope, arg, f"{fact}[{at}]")
        elif len(keys) > 1:
            scope.require(f"{fact}[{at}] == {value}")
    _aged(clause, scope, fact, query.age)


def _asks_age(scope: Scope, age: nodes.Term, args: tuple[nodes.Term, ...] = ()) -> bool:
    """Whether an age is a variable that is unbound and that no argument will bind."""
    if not isinstance(age, nodes.Var) or age.name in scope.bound:
        return False
    return age.anonymous or age not in args


def _limit(clause: Clause, scope: Scope, age: nodes.Term) -> str:
    """An expression for the bound age limit of a `believe`."""
    limit = bound_value(clause, scope, age)
    what = clause.emitter.constant("the age of a `believe` is not a number")
    scope.line(f"if type({limit}) not in NUMBERS:")
    scope.line(f"    ctx.fault({clause.where}, {what})")
    scope.line(f"    {scope.skip}")
    return str(limit)


def _aged(clause: Clause, scope: Scope, fact: str, age: nodes.Term | None) -> None:
    if age is None:
        return
    if _asks_age(scope, age):
        scope.refuse(f"ctx.stamps[{fact}] < 0")
        match(clause, scope, age, f"ctx.age({fact})")
    else:
        scope.require(f"ctx.young({fact}, {_limit(clause, scope, age)})")
