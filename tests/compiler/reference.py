"""What formulas mean, written plainly: a list of facts, no indexes, no compiling.

The meaning is that of [L 2]. Tests ask this and the compiled queries the same
questions of the same memory, and compare the answers and their order.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Atom, Fact, number
from rapc.ir import nodes

Env = Mapping[str, Value]

EXTERNAL = nodes.Const("external")


class Nothing(Exception):
    """A term without a value: unbound, or ill-typed."""


@dataclass
class Mind:
    """All that formulas can ask about.

    `facts` stand in the order of their last assertion; `properties` says how many
    arguments each property has and what its default is, `propositions` the same
    without a default; `items` whether each introduced item is accessible.
    """

    properties: Mapping[str, tuple[int, str]]
    propositions: Mapping[str, int]
    now: float = 0
    facts: dict[Fact, float] = field(default_factory=dict)
    items: dict[str, bool] = field(default_factory=dict)
    kinds: dict[str, str] = field(default_factory=dict)
    place: Atom | None = None
    tried: tuple[object, ...] = ()
    results: Mapping[object, str] = field(default_factory=dict)
    last_result: str | None = None

    def add(self, fact: Fact) -> None:
        """Assert a fact; a property has one value, and comes last in order."""
        if fact[0] in self.properties:
            self.drop([f for f in self.facts if f[:-1] == fact[:-1]])
        self.drop([fact])
        self.facts[fact] = self.now

    def drop(self, facts: list[Fact]) -> None:
        """Take facts out, if they are there."""
        for fact in facts:
            self.facts.pop(fact, None)

    def erase(self, prefix: Fact) -> None:
        """Take out every fact that starts so."""
        self.drop([f for f in self.facts if f[: len(prefix)] == prefix])

    def default(self, name: str) -> Atom:
        """A property's default; `zero` is the one that a function gives."""
        default = self.properties[name][1]
        return 0 if default == "zero" else default


def solutions(mind: Mind, env: Env, formula: nodes.Formula) -> Iterator[Env]:
    """The environments in which a formula holds, in order."""
    match formula:
        case nodes.Truth(value):
            if value:
                yield env
        case nodes.And(parts):
            if not parts:
                yield env
                return
            for first in solutions(mind, env, parts[0]):
                yield from solutions(mind, first, nodes.And(parts[1:]))
        case nodes.Or(parts):
            for part in parts:
                yield from solutions(mind, env, part)
        case nodes.Not(part):
            if next(solutions(mind, env, part), None) is None:
                yield env
        case _:
            try:
                yield from _tests(mind, env, formula)
            except Nothing:
                return


def _tests(mind: Mind, env: Env, formula: nodes.Formula) -> Iterator[Env]:
    match formula:
        case nodes.Compare(op, left, right):
            if _compare(op, value(mind, env, left), value(mind, env, right)):
                yield env
        case nodes.Is(variable, term):
            yield from matched(mind, env, variable, value(mind, env, term))
        case nodes.SetTest(test, args):
            of, *thing = [value(mind, env, arg) for arg in args]
            if not isinstance(of, SetResource):
                raise Nothing
            members = list(of.members)
            if thing[0] in members if test == "member" else not members:
                yield env
        case nodes.HistoryTest(query, args):
            yield from _history(mind, env, query, args)
        case nodes.SensorName(item, known):
            yield from _sensor_name(mind, env, item, known)
        case nodes.Count(kind, place, size):
            yield from _count(mind, env, kind, place, size)
        case nodes.Believe(pattern, age):
            yield from _believe(mind, env, pattern, age)
        case nodes.Proposition():
            yield from _pattern(mind, env, formula)
        case _:
            raise AssertionError(formula)


def _history(
    mind: Mind, env: Env, query: str, args: tuple[nodes.Term, ...]
) -> Iterator[Env]:
    if query == "method-tried":
        if value(mind, env, args[0]) in mind.tried:
            yield env
        return
    result = mind.last_result
    if query == "result-with-method":
        result = mind.results.get(value(mind, env, args[0]))
    if result is not None:
        yield from matched(mind, env, args[-1], result)


def _sensor_name(
    mind: Mind, env: Env, item: nodes.Term, known: nodes.Term
) -> Iterator[Env]:
    if _open(env, item):
        for name, accessible in mind.items.items():
            if accessible:
                for bound in matched(mind, env, item, name):
                    yield from matched(mind, bound, known, "true")
        return
    accessible = mind.items.get(str(value(mind, env, item)), True)
    yield from matched(mind, env, known, "true" if accessible else "false")


def _count(
    mind: Mind, env: Env, kind: nodes.Term, place: nodes.Term, size: nodes.Term
) -> Iterator[Env]:
    what, where = value(mind, env, kind), value(mind, env, place)
    facts = [_shown(mind, f) if where == "external" else f for f in mind.facts]
    there = [f[1] for f in facts if f[0] == "location" and f[2] == where]
    count = sum(mind.kinds.get(str(item)) == what for item in there)
    yield from matched(mind, env, size, count)


def value(mind: Mind, env: Env, term: nodes.Term) -> Value:
    """A term's value. Raises Nothing where it has none."""
    if isinstance(term, nodes.Const):
        return term.value
    if isinstance(term, nodes.Var):
        if term.name in env:
            return env[term.name]
        raise Nothing
    return _call(term.function, [value(mind, env, arg) for arg in term.args])


def _call(function: str, args: list[Value]) -> Value:
    if function == "size-of":
        if isinstance(args[0], SetResource):
            return len(args[0].members)
        raise Nothing
    if function == "value":
        if isinstance(args[0], Counter):
            return args[0].value
        raise Nothing
    if function == "next-to":
        return f"{args[0]}'"
    numbers = [arg for arg in args if isinstance(arg, int | float)]
    if len(numbers) < len(args) or not numbers:
        raise Nothing
    result = numbers[0]
    for other in numbers[1:]:
        if function == "/" and other == 0:
            raise Nothing
        if function == "/":
            result = result / other
        else:
            result = {
                "+": result + other,
                "-": result - other,
                "*": result * other,
            }[function]
    if function == "-" and len(numbers) == 1:
        result = -result
    return number(result)


def _compare(op: str, left: Value, right: Value) -> bool:
    if op == "=":
        return left == right
    if op == "n=":
        return left != right
    if not isinstance(left, int | float) or not isinstance(right, int | float):
        return False
    return {
        "<": left < right,
        ">": left > right,
        "<=": left <= right,
        ">=": left >= right,
    }[op]


def matched(mind: Mind, env: Env, term: nodes.Term, found: Value) -> Iterator[Env]:
    """The environment, if need be with a new binding, in which a term is a value."""
    if not _open(env, term):
        if value(mind, env, term) == found:
            yield env
    elif isinstance(term, nodes.Var) and not term.anonymous:
        yield {**env, term.name: found}
    else:
        yield env


def _open(env: Env, term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and (term.anonymous or term.name not in env)


def _pattern(mind: Mind, env: Env, pattern: nodes.Proposition) -> Iterator[Env]:
    if pattern.name == "odd":
        given = value(mind, env, pattern.args[0])
        if isinstance(given, int) and given % 2:
            yield env
        return
    for bound, _ in _stored(mind, env, pattern):
        yield bound
    yield from _by_default(mind, env, pattern)


def _stored(
    mind: Mind, env: Env, pattern: nodes.Proposition
) -> Iterator[tuple[Env, float]]:
    """Each fact that matches, with its stamp: oldest assertion first."""
    args = _arguments(mind, env, pattern)
    for fact, stamp in list(mind.facts.items()):
        shown = _shown(mind, fact) if args[-1:] == (EXTERNAL,) else fact
        if shown[0] == pattern.name and len(shown) == len(args) + 1:
            for bound in _all_matched(mind, env, args, shown[1:]):
                yield bound, stamp


def _arguments(
    mind: Mind, env: Env, pattern: nodes.Proposition
) -> tuple[nodes.Term, ...]:
    """The arguments with the computed ones computed and a short form made full."""
    args = tuple(
        nodes.Const(value(mind, env, arg))  # type: ignore[arg-type]
        if isinstance(arg, nodes.Call)
        or (isinstance(arg, nodes.Var) and not _open(env, arg))
        else arg
        for arg in pattern.args
    )
    arity, _ = mind.properties.get(pattern.name, (0, ""))
    if len(args) == arity - 1 > 0:
        args = (*args, nodes.Const("true"))
    return args


def _shown(mind: Mind, fact: Fact) -> Fact:
    """A fact as one who asks for `external` sees it."""
    here = fact[0] == "location" and fact[-1] == mind.place
    return (*fact[:-1], "external") if here and fact[1] in mind.items else fact


def _all_matched(
    mind: Mind, env: Env, args: tuple[nodes.Term, ...], values: Fact
) -> Iterator[Env]:
    if not args:
        yield env
        return
    for bound in matched(mind, env, args[0], values[0]):
        yield from _all_matched(mind, bound, args[1:], values[1:])


def _by_default(mind: Mind, env: Env, pattern: nodes.Proposition) -> Iterator[Env]:
    """A property's default, where its index is known and has no fact."""
    if pattern.name not in mind.properties:
        return
    *index, last = _arguments(mind, env, pattern)
    if any(_open(env, arg) for arg in index):
        return
    start = (pattern.name, *(value(mind, env, arg) for arg in index))
    if not any(fact[:-1] == start for fact in mind.facts):
        yield from matched(mind, env, last, mind.default(pattern.name))


def _believe(
    mind: Mind, env: Env, pattern: nodes.Proposition, age: nodes.Term
) -> Iterator[Env]:
    for bound, stamp in _stored(mind, env, pattern):
        if _open(bound, age):
            yield from matched(mind, bound, age, number(mind.now - stamp))
        elif mind.now - stamp < _limit(mind, bound, age):
            yield bound
    for bound in _by_default(mind, env, pattern):
        if not _open(bound, age) and _limit(mind, bound, age) > NEVER:
            yield bound


NEVER = float("-inf")


def _limit(mind: Mind, env: Env, age: nodes.Term) -> float:
    """The age that a belief may have; an ill-typed one lets none pass."""
    try:
        limit = value(mind, env, age)
    except Nothing:
        return NEVER
    return limit if isinstance(limit, int | float) else NEVER
