"""Facts, properties and `believe` to generated Python.

A completely known fact is tested for membership in memory; a property with a known
index is one look-up and then its default (T 2.2.2); any other pattern scans the
smallest index that a known argument selects. Each index keeps its facts in the order of
their last assertion, so the choice of an index never changes the order of solutions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from rapc.compiler.query.function import FunctionWriter
from rapc.compiler.query.plan_steps import AccessPath
from rapc.compiler.query.term_code import (
    argument_code,
    bound_value,
    fault,
    known_value,
    match,
    registered,
)
from rapc.ir import nodes
from rapc.library.signature import Signature


class _Query(msgspec.Struct, frozen=True):
    """A pattern with the expressions of its known arguments (None: unknown)."""

    formula: nodes.Formula
    relation: Signature
    args: tuple[nodes.Term, ...]
    known: tuple[str | None, ...]
    age: nodes.Term | None

    @property
    def may_be_external(self) -> bool:
        """Return whether it may match items at the robot's own place (L 7)."""
        if self.relation.name != "location" or not self.relation.is_property:
            return False
        place = self.args[-1]
        if len(self.args) != 2 or self.known[-1] is None:
            return False
        return not isinstance(place, nodes.Const) or place.value == "external"

    @property
    def has_no_default(self) -> bool:
        """Return whether its value is a constant other than the default.

        Then only a fact can match, and neither the default nor the age of a fact with
        that index applies.
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
        """Return the places of the known arguments, from 1."""
        return tuple(at for at, k in enumerate(self.known, 1) if k is not None)


def write_pattern(fn: FunctionWriter, formula: nodes.Proposition) -> None:
    """Write a proposition, a property, or a declared function used as a test."""
    relation = fn.code.signatures.relations.get(formula.name)
    if relation is not None:
        _fact(fn, relation, formula, formula)
    elif formula.name in fn.code.signatures.functions:
        fn.code.note(formula, AccessPath.TEST)
        args = argument_code(fn, formula.args)
        if args is not None:
            listed = "".join(f"{a}, " for a in args)
            held = registered(fn, formula.name, listed, "holds({})")
            fn.skip_unless(held)
    else:
        fn.code.note(formula, AccessPath.NEVER)
        what = fn.code.constant(f"unknown predicate `{formula.name}`")
        fault(fn, what)


def write_believe(fn: FunctionWriter, formula: nodes.Believe) -> None:
    """Write a pattern with a limit on its age, or with its age as output (T 2.2.3)."""
    relation = fn.code.signatures.relations.get(formula.pattern.name)
    if relation is None:
        write_pattern(fn, formula.pattern)
    else:
        _fact(fn, relation, formula.pattern, formula)


def _fact(
    fn: FunctionWriter,
    relation: Signature,
    wanted: nodes.Proposition,
    formula: nodes.Proposition | nodes.Believe,
) -> None:
    args = relation.full(wanted.args)
    known = tuple([known_value(fn, arg) for arg in args])
    age = formula.age if isinstance(formula, nodes.Believe) else None
    query = _Query(formula, relation, args, known, age)
    is_property = relation.is_property and bool(args)
    if None not in known and (not is_property or query.has_no_default):
        _member(fn, query)
    elif is_property and None not in known[:-1]:
        _look_up(fn, query)
    else:
        _scan(fn, query)


def _member(fn: FunctionWriter, query: _Query) -> None:
    """Write the membership test of a completely known fact."""
    fn.code.note(query.formula, AccessPath.MEMBER, by=query.places)
    name = query.relation.name
    if all(isinstance(arg, nodes.Const) for arg in query.args):
        values = [arg.value for arg in query.args if isinstance(arg, nodes.Const)]
        fact = fn.code.constant((name, *values))
    else:
        parts = "".join(f", {k}" for k in query.known)
        fact = f"({fn.code.constant(name)}{parts})"
    stamps = fn.code.stamps(name)
    if query.age is None:
        fn.skip_if(f"{fact} not in {stamps}")
        return
    local = fn.code.fresh("f")
    fn.line(f"{local} = {fact}")
    fn.skip_if(f"{local} not in {stamps}")
    _aged(fn, local, query)


def _look_up(fn: FunctionWriter, query: _Query) -> None:
    """Write a look-up of a property by its index, with its default (T 2.2.2)."""
    must_exist = query.age is not None and _asks_age(fn, query.age, query.args)
    _note_look_up(fn, query, must_exist)
    size = len(query.args)
    fact = fn.code.fresh("f")
    parts = [str(k) for k in query.known[:-1]]
    index = parts[0] if size == 2 else f"({''.join(f'{p}, ' for p in parts)})"
    look = fn.code.value_of(query.relation.name)
    fn.line(f"{fact} = {look}({index})")
    if must_exist:
        fn.skip_if(f"{fact} is None")
        value = f"{fact}[{size}]"
    else:
        value = _either(fn, query, fact, parts)
    expected = query.known[-1]
    if query.may_be_external:
        here = f"ctx.is_here({fact}, {expected})"
        fn.skip_if(f"{value} != {expected} and not {here}")
    else:
        match(fn, query.args[-1], value)
    if must_exist or query.age is None:
        _aged(fn, fact, query)
    else:
        limit = _limit(fn, query.age)
        fn.skip_if(f"{fact} is not None and not {_young(fn, query, fact, limit)}")


def _either(fn: FunctionWriter, query: _Query, fact: str, parts: Sequence[str]) -> str:
    """Return a local for the value that a fact has, or else the default."""
    relation = query.relation
    function = relation.default_function
    stored = f"{fact}[{len(query.args)}]"
    if function is None:
        value = fn.code.fresh("t")
        default = fn.code.constant(relation.default)
        fn.line(f"{value} = {default} if {fact} is None else {stored}")
        return value
    name = fn.code.constant(relation.name)
    index = f"({name}, {''.join(f'{p}, ' for p in parts)})"
    form = f"as_value({{}}) if {fact} is None else {stored}"
    return registered(fn, function, index, form)


def _note_look_up(fn: FunctionWriter, query: _Query, must_exist: bool) -> None:
    size, relation = len(query.args), query.relation
    last = query.known[-1] is not None
    fn.code.note(
        query.formula,
        AccessPath.VALUE,
        by=tuple(range(1, size)),
        tested=(size,) if last else (),
        binds=_binds(fn, query),
        default=None if must_exist else relation.default_function or relation.default,
    )


def _scan(fn: FunctionWriter, query: _Query) -> None:
    """Write a scan of the smallest index that a known argument selects."""
    places = _worth_an_index(query)
    rest = tuple(at for at in query.places if at not in places or len(places) > 1)
    ways = (AccessPath.ALL, AccessPath.INDEX, AccessPath.SMALLEST)
    fn.code.note(
        query.formula,
        ways[min(len(places), 2)],
        by=places,
        tested=rest,
        binds=_binds(fn, query),
    )
    fact = fn.code.fresh("f")
    fn.search(f"for {fact} in {_candidates(fn, query, places)}:")
    size = len(query.args)
    if query.relation.most is None:
        fn.skip_unless(f"len({fact}) == {size + 1}")
    for at in rest:
        fn.skip_if(f"{fact}[{at}] != {query.known[at - 1]}")
    for at, (arg, value) in enumerate(zip(query.args, query.known, strict=True), 1):
        if value is None:
            match(fn, arg, f"{fact}[{at}]")
    _aged(fn, fact, query)


def _worth_an_index(query: _Query) -> tuple[int, ...]:
    """Return the places of known arguments that select an index.

    A truth value of a property selects few facts: it counts only by itself.
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


def _candidates(fn: FunctionWriter, query: _Query, places: Sequence[int]) -> str:
    """Return the expression for the facts to scan: the shortest of several indexes."""
    name, code = query.relation.name, fn.code
    if not places:
        return code.stamps(name)
    found = [f"{code.bucket_of(name, at)}({query.known[at - 1]}, ())" for at in places]
    if query.may_be_external:
        place = query.args[-1]
        external = f"ctx.facts_at({query.known[-1]})"
        if isinstance(place, nodes.Const):
            return external
        word = code.constant("external")
        return f"{found[0]} if {query.known[-1]} != {word} else {external}"
    if len(found) == 1:
        return found[0]
    if len(found) > 2:
        return f"min({', '.join(found)}, key=len)"
    one, two = (code.fresh("b") for _ in found)
    fn.line(f"{one} = {found[0]}")
    fn.line(f"{two} = {found[1]}")
    return f"{one} if len({one}) <= len({two}) else {two}"


def _binds(fn: FunctionWriter, query: _Query) -> tuple[str, ...]:
    """Return the variables that a pattern gives a value."""
    terms: Iterable[nodes.Term] = (*query.args, *([query.age] if query.age else ()))
    names = (t.name for t in terms if isinstance(t, nodes.Var) and not t.anonymous)
    return tuple(dict.fromkeys(name for name in names if name not in fn.bound))


def _asks_age(
    fn: FunctionWriter, age: nodes.Term, args: tuple[nodes.Term, ...] = ()
) -> bool:
    """Return whether an age is an unbound variable that no argument will bind."""
    if not isinstance(age, nodes.Var) or age.name in fn.bound:
        return False
    return age.anonymous or age not in args


def _limit(fn: FunctionWriter, age: nodes.Term) -> str:
    """Return an expression for the bound age limit of a `believe`."""
    limit = bound_value(fn, age)
    if isinstance(age, nodes.Const) and isinstance(age.value, int | float):
        return str(limit)
    what = fn.code.constant("the age of a `believe` is not a number")
    fn.line(f"if type({limit}) not in NUMBERS:")
    fn.line(f"    ctx.fault({fn.where}, {what})")
    fn.line(f"    {fn.skip}")
    return str(limit)


def _young(fn: FunctionWriter, query: _Query, fact: str, limit: str) -> str:
    """Return the expression for whether a fact is younger than a limit."""
    stamps = fn.code.stamps(query.relation.name)
    return f"ctx.young({stamps}[{fact}], {limit})"


def _aged(fn: FunctionWriter, fact: str, query: _Query) -> None:
    age = query.age
    if age is None:
        return
    stamps = fn.code.stamps(query.relation.name)
    if _asks_age(fn, age):
        stamp = fn.code.fresh("t")
        fn.line(f"{stamp} = {stamps}[{fact}]")
        fn.skip_if(f"{stamp} < 0")
        match(fn, age, f"ctx.age({stamp})")
    else:
        limit = _limit(fn, age)
        fn.skip_unless(_young(fn, query, fact, limit))
