"""Facts, properties and `believe` to generated Python.

A fact all of which is known is looked for in memory; a property whose index is known
is one look-up with its default behind it (T 2.2.2); everything else runs through the
smallest index that a known argument selects. Every index keeps its facts in the
order of their last assertion, so the choice never shows in the answers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from rapc.compiler.query.code import Scope
from rapc.compiler.query.plan_steps import Way
from rapc.compiler.query.term_code import (
    Clause,
    arguments,
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

    formula: nodes.Formula
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

    @property
    def has_no_default(self) -> bool:
        """Whether its value is another constant than the default: a fact must say it.

        The default does not answer then, nor does the age of a fact with that index.
        """
        value = self.args[-1]
        return (
            self.relation.default_function is None
            and isinstance(value, nodes.Const)
            and value.value != self.relation.default
            and not self.may_be_external
        )

    @property
    def places(self) -> tuple[int, ...]:
        """The places of the known arguments, from 1."""
        return tuple(at for at, k in enumerate(self.known, 1) if k is not None)


def pattern(clause: Clause, scope: Scope, formula: nodes.Proposition) -> None:
    """A proposition, a property, or a declared function used as a test."""
    relation = clause.vocabulary.relations.get(formula.name)
    if relation is not None:
        _fact(clause, scope, relation, formula, formula)
    elif formula.name in clause.vocabulary.functions:
        clause.note(formula, Way.TEST)
        args = arguments(clause, scope, formula.args)
        if args is not None:
            listed = "".join(f"{a}, " for a in args)
            held = registered(clause, scope, formula.name, listed, "holds({})")
            scope.require(held)
    else:
        clause.note(formula, Way.NEVER)
        what = clause.emitter.constant(f"`{formula.name}` is not declared")
        fault(clause, scope, what)


def believe(clause: Clause, scope: Scope, formula: nodes.Believe) -> None:
    """A pattern with a limit on its age, or asking for it (T 2.2.3)."""
    relation = clause.vocabulary.relations.get(formula.pattern.name)
    if relation is None:
        pattern(clause, scope, formula.pattern)
    else:
        _fact(clause, scope, relation, formula.pattern, formula)


def _fact(
    clause: Clause,
    scope: Scope,
    relation: Relation,
    wanted: nodes.Proposition,
    formula: nodes.Proposition | nodes.Believe,
) -> None:
    args = relation.full(wanted.args)
    known = tuple([known_value(clause, scope, arg) for arg in args])
    age = formula.age if isinstance(formula, nodes.Believe) else None
    query = _Query(formula, relation, args, known, age)
    is_property = relation.is_property and bool(args)
    if None not in known and (not is_property or query.has_no_default):
        _member(clause, scope, query)
    elif is_property and None not in known[:-1]:
        _look_up(clause, scope, query)
    else:
        _scan(clause, scope, query)


def _member(clause: Clause, scope: Scope, query: _Query) -> None:
    """A fact all of which is known: it is in memory or not."""
    clause.note(query.formula, Way.MEMBER, by=query.places)
    name = query.relation.name
    if all(isinstance(arg, nodes.Const) for arg in query.args):
        values = [arg.value for arg in query.args if isinstance(arg, nodes.Const)]
        fact = clause.emitter.constant((name, *values))
    else:
        parts = "".join(f", {k}" for k in query.known)
        fact = f"({clause.emitter.constant(name)}{parts})"
    stamps = clause.emitter.stamps(name)
    if query.age is None:
        scope.refuse(f"{fact} not in {stamps}")
        return
    local = clause.emitter.fresh("f")
    scope.line(f"{local} = {fact}")
    scope.refuse(f"{local} not in {stamps}")
    _aged(clause, scope, local, query)


def _look_up(clause: Clause, scope: Scope, query: _Query) -> None:
    """A property whose index is known: one look, then the default (T 2.2.2)."""
    must_exist = query.age is not None and _asks_age(scope, query.age, query.args)
    _note_look_up(clause, scope, query, must_exist)
    size = len(query.args)
    fact = clause.emitter.fresh("f")
    parts = [str(k) for k in query.known[:-1]]
    index = parts[0] if size == 2 else f"({''.join(f'{p}, ' for p in parts)})"
    look = clause.emitter.value_of(query.relation.name)
    scope.line(f"{fact} = {look}({index})")
    if must_exist:
        scope.refuse(f"{fact} is None")
        value = f"{fact}[{size}]"
    else:
        value = _either(clause, scope, query, fact, parts)
    expected = query.known[-1]
    if query.may_be_external:
        here = f"ctx.is_here({fact}, {expected})"
        scope.refuse(f"{value} != {expected} and not {here}")
    else:
        match(clause, scope, query.args[-1], value)
    if must_exist or query.age is None:
        _aged(clause, scope, fact, query)
    else:
        limit = _limit(clause, scope, query.age)
        scope.refuse(f"{fact} is not None and not {_young(clause, query, fact, limit)}")


def _either(
    clause: Clause, scope: Scope, query: _Query, fact: str, parts: Sequence[str]
) -> str:
    """A local for the value that a fact gives, or else the default."""
    relation = query.relation
    function = relation.default_function
    stored = f"{fact}[{len(query.args)}]"
    if function is None:
        value = clause.emitter.fresh("t")
        default = clause.emitter.constant(relation.default)
        scope.line(f"{value} = {default} if {fact} is None else {stored}")
        return value
    name = clause.emitter.constant(relation.name)
    index = f"({name}, {''.join(f'{p}, ' for p in parts)})"
    form = f"as_value({{}}) if {fact} is None else {stored}"
    return registered(clause, scope, function, index, form)


def _note_look_up(
    clause: Clause, scope: Scope, query: _Query, must_exist: bool
) -> None:
    size = len(query.args)
    last = query.known[-1] is not None
    clause.note(
        query.formula,
        Way.VALUE,
        by=tuple(range(1, size)),
        tested=(size,) if last else (),
        binds=_binds(scope, query),
        default=None if must_exist else query.relation.default,
    )


def _scan(clause: Clause, scope: Scope, query: _Query) -> None:
    """Run through the facts of the smallest index that a known argument selects."""
    places = _worth_an_index(query)
    rest = tuple(at for at in query.places if at not in places or len(places) > 1)
    ways = (Way.ALL, Way.INDEX, Way.SMALLEST)
    clause.note(
        query.formula,
        ways[min(len(places), 2)],
        by=places,
        tested=rest,
        binds=_binds(scope, query),
    )
    fact = clause.emitter.fresh("f")
    scope.loop(f"for {fact} in {_candidates(clause, scope, query, places)}:")
    size = len(query.args)
    if query.relation.arity is None:
        scope.require(f"len({fact}) == {size + 1}")
    for at in rest:
        scope.refuse(f"{fact}[{at}] != {query.known[at - 1]}")
    for at, (arg, value) in enumerate(zip(query.args, query.known, strict=True), 1):
        if value is None:
            match(clause, scope, arg, f"{fact}[{at}]")
    _aged(clause, scope, fact, query)


def _worth_an_index(query: _Query) -> tuple[int, ...]:
    """The places of known arguments to look facts up by.

    A truth value as a property's value tells little: it counts only by itself.
    """
    places = query.places
    value = query.args[-1] if query.args else None
    if (
        len(places) > 1
        and query.relation.is_property
        and isinstance(value, nodes.Const)
        and value.value in ("true", "false")
    ):
        return places[:-1]
    return places


def _candidates(
    clause: Clause, scope: Scope, query: _Query, places: Sequence[int]
) -> str:
    """The expression for the facts to run through; the shortest of several indexes."""
    name, emitter = query.relation.name, clause.emitter
    if not places:
        return emitter.stamps(name)
    found = [
        f"{emitter.bucket_of(name, at)}({query.known[at - 1]}, ())" for at in places
    ]
    if query.may_be_external:
        place = query.args[-1]
        external = f"ctx.facts_at({query.known[-1]})"
        if isinstance(place, nodes.Const):
            return external
        word = emitter.constant("external")
        return f"{found[0]} if {query.known[-1]} != {word} else {external}"
    if len(found) == 1:
        return found[0]
    if len(found) > 2:
        return f"min({', '.join(found)}, key=len)"
    one, two = (emitter.fresh("b") for _ in found)
    scope.line(f"{one} = {found[0]}")
    scope.line(f"{two} = {found[1]}")
    return f"{one} if len({one}) <= len({two}) else {two}"


def _binds(scope: Scope, query: _Query) -> tuple[str, ...]:
    """The variables that have a value after a pattern and had none before it."""
    terms: Iterable[nodes.Term] = (*query.args, *([query.age] if query.age else ()))
    names = (t.name for t in terms if isinstance(t, nodes.Var) and not t.anonymous)
    return tuple(dict.fromkeys(name for name in names if name not in scope.bound))


def _asks_age(scope: Scope, age: nodes.Term, args: tuple[nodes.Term, ...] = ()) -> bool:
    """Whether an age is a variable that is unbound and that no argument will bind."""
    if not isinstance(age, nodes.Var) or age.name in scope.bound:
        return False
    return age.anonymous or age not in args


def _limit(clause: Clause, scope: Scope, age: nodes.Term) -> str:
    """An expression for the bound age limit of a `believe`."""
    limit = bound_value(clause, scope, age)
    if isinstance(age, nodes.Const) and isinstance(age.value, int | float):
        return str(limit)
    what = clause.emitter.constant("the age of a `believe` is not a number")
    scope.line(f"if type({limit}) not in NUMBERS:")
    scope.line(f"    ctx.fault({clause.where}, {what})")
    scope.line(f"    {scope.skip}")
    return str(limit)


def _young(clause: Clause, query: _Query, fact: str, limit: str) -> str:
    """The expression for whether a fact is younger than a limit."""
    stamps = clause.emitter.stamps(query.relation.name)
    return f"ctx.young({stamps}[{fact}], {limit})"


def _aged(clause: Clause, scope: Scope, fact: str, query: _Query) -> None:
    age = query.age
    if age is None:
        return
    stamps = clause.emitter.stamps(query.relation.name)
    if _asks_age(scope, age):
        stamp = clause.emitter.fresh("t")
        scope.line(f"{stamp} = {stamps}[{fact}]")
        scope.refuse(f"{stamp} < 0")
        match(clause, scope, age, f"ctx.age({stamp})")
    else:
        limit = _limit(clause, scope, age)
        scope.require(_young(clause, query, fact, limit))
