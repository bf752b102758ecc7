"""Formulas as recursive generators over the list of facts (semantics 2).

Solutions are dictionaries of bindings, made anew at each step; nothing is cleverer
than walking the formula.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol

from rapc.ir import nodes
from rapc.resources import Counter, SetResource, Value
from rapc.runtime.world import Time
from rapc.terms import Text, format_atom, is_number, number
from tests.reference.memory import Memory

Bindings = Mapping[str, Value]

Functions = Mapping[str, Callable[..., Any]]


class Fault(Exception):
    """A term that is unbound or of the wrong kind; the message says which."""


class History(Protocol):
    """What a task remembers of its methods."""

    last_result: str | None
    tried: dict[object, None]
    results: dict[object, str]


class Asker:
    """Everything a query depends on but its bindings.

    `timers` collects the times at which what a `believe` saw goes stale; `aged` says
    whether an age was asked for; `faults` what was unbound or ill-typed.
    """

    def __init__(
        self, memory: Memory, functions: Functions, history: History | None
    ) -> None:
        self.memory = memory
        self.functions = functions
        self.history = history
        self.faults: list[str] = []
        self.timers: list[Time] = []
        self.aged = False

    # --- terms ----------------------------------------------------------------------

    def term(self, term: nodes.Term, env: Bindings) -> Value:
        """The value of a term. Raises Fault if it has none."""
        if isinstance(term, nodes.Const):
            return term.value
        if isinstance(term, nodes.Var):
            if term.name not in env:
                raise Fault(f"{term.name} is not bound")
            return env[term.name]
        values = [self.term(arg, env) for arg in term.args]
        if term.function == "value":
            if not isinstance(values[0], Counter):
                raise Fault(f"`{format_atom(values[0])}` is not a counter")
            return values[0].value
        if term.function == "size-of":
            if not isinstance(values[0], SetResource):
                raise Fault(f"`{format_atom(values[0])}` is not a set")
            return len(values[0].members)
        if term.function in ("+", "-", "*", "/"):
            return self.arithmetic(term.function, values)
        return self.call(term.function, values)

    def arithmetic(self, sign: str, values: list[Value]) -> Value:
        """`+ - * /` from left to right."""
        numbers: list[int | float] = []
        for value in values:
            if not isinstance(value, int | float):
                raise Fault(f"`{format_atom(value)}` is not a number")
            numbers.append(value)
        total, *rest = numbers
        if not rest:
            return number(-total)
        for each in rest:
            if sign == "+":
                total = total + each
            elif sign == "-":
                total = total - each
            elif sign == "*":
                total = total * each
            elif each == 0:
                raise Fault("division by zero")
            else:
                total = number(total / each)
        return number(total)

    def call(self, name: str, values: list[Value]) -> Value:
        """What a declared function returns."""
        result = self.functions[name](self.memory, *values)
        if isinstance(result, bool):
            return "true" if result else "false"
        if isinstance(result, float):
            return number(result)
        if not isinstance(result, str | int | Text):
            raise Fault(f"`{name}` returns {type(result).__name__}")
        return result

    # --- formulas -----------------------------------------------------------------------

    def first(self, formula: nodes.Formula, env: Bindings) -> Bindings | None:
        """The first solution, or None."""
        return next(self.solutions(formula, env), None)

    def solutions(self, formula: nodes.Formula, env: Bindings) -> Iterator[Bindings]:
        """All solutions in order. A part that faults has none, and the fault is kept."""
        try:
            yield from self.ask(formula, env)
        except Fault as fault:
            self.faults.append(str(fault))

    def ask(self, formula: nodes.Formula, env: Bindings) -> Iterator[Bindings]:
        """The solutions of one formula."""
        match formula:
            case nodes.Truth(value):
                if value:
                    yield env
            case nodes.And(parts):
                yield from self.all_of(parts, env)
            case nodes.Or(parts):
                for part in parts:
                    yield from self.solutions(part, env)
            case nodes.Not(part):
                if self.first(part, env) is None:
                    yield env
            case nodes.Compare(op, left, right):
                if self.compare(op, self.term(left, env), self.term(right, env)):
                    yield env
            case nodes.SetTest(test, args):
                if self.set_test(test, [self.term(arg, env) for arg in args]):
                    yield env
            case nodes.Pattern(name) if name in self.memory.library.functions:
                values = [self.term(arg, env) for arg in formula.args]
                if self.functions[name](self.memory, *values) not in (False, "false"):
                    yield env
            case nodes.Pattern():
                yield from self.pattern(formula, env)
            case nodes.Believe(pattern, age):
                yield from self.believe(pattern, age, env)
            case nodes.History():
                yield from self.past(formula, env)
            case nodes.SensorName(item, value):
                yield from self.sensor_name(item, value, env)
            case _:
                raise AssertionError(f"not in sections 1 to 6: {formula}")

    def all_of(
        self, parts: tuple[nodes.Formula, ...], env: Bindings
    ) -> Iterator[Bindings]:
        """Left to right, with full backtracking."""
        if not parts:
            yield env
            return
        for found in self.solutions(parts[0], env):
            yield from self.all_of(parts[1:], found)

    def compare(self, op: str, left: Value, right: Value) -> bool:
        """`= n=` compare anything; the others fail on anything but two numbers."""
        if op in ("=", "n="):
            return (left == right) == (op == "=")
        if not (isinstance(left, int | float) and isinstance(right, int | float)):
            return False
        if op == "<":
            return left < right
        if op == ">":
            return left > right
        return left <= right if op == "<=" else left >= right

    def set_test(self, test: str, values: list[Value]) -> bool:
        """`member` and `empty`."""
        if not isinstance(values[0], SetResource):
            raise Fault(f"`{format_atom(values[0])}` is not a set")
        return (
            values[1] in values[0].members
            if test == "member"
            else not values[0].members
        )

    # --- propositions ---------------------------------------------------------------------

    def ready(self, pattern: nodes.Pattern, env: Bindings) -> list[Value | str | None]:
        """The arguments of a pattern: values; None for what may match anything.

        The name of a property is followed by `true` where it is one argument short.
        A variable that is not bound is left to `unify`.
        """
        declared = self.memory.library.properties.get(pattern.name)
        terms = list(pattern.args)
        if declared is not None and declared.args is not None and terms:
            if len(terms) == len(declared.args) - 1:
                terms.append(nodes.Const("true"))
        slots: list[Any] = [nodes.Const(pattern.name)]
        for term in terms:
            if isinstance(term, nodes.Call):
                slots.append(("value", self.term(term, env)))
            else:
                slots.append(term)
        return slots

    def unify(self, slots: list[Any], fact: tuple[Any, ...], env: Bindings) -> Any:
        """The bindings under which slots and fact are the same, or None."""
        if len(slots) != len(fact):
            return None
        found = dict(env)
        for slot, value in zip(slots, fact, strict=True):
            if isinstance(slot, tuple):
                wanted: Any = slot[1]
            elif isinstance(slot, nodes.Const):
                wanted = slot.value
            elif slot.anonymous:
                continue
            else:
                wanted = found.setdefault(slot.name, value)
            if wanted != value:
                return None
        return found

    def pattern(self, pattern: nodes.Pattern, env: Bindings) -> Iterator[Bindings]:
        """A proposition; for a property with its default (T 2.2.2's steps)."""
        slots = self.ready(pattern, env)
        direct = False
        for entry in list(self.memory.entries):
            found = self.unify(slots, entry.fact, env)
            if found is not None:
                direct = True
                yield found
        if not direct:
            yield from self.default(slots, env)

    def default(self, slots: list[Any], env: Bindings) -> Iterator[Bindings]:
        """What holds of a property where no fact has its index."""
        declared = self.memory.library.properties.get(slots[0].value)
        if declared is None:
            return
        for entry in self.memory.entries:
            if self.unify(slots[:-1], entry.fact[:-1], env) is not None:
                return
        index: list[Any] = []
        for slot in slots[:-1]:
            if isinstance(slot, nodes.Var):
                if slot.anonymous or slot.name not in env:
                    return
                index.append(env[slot.name])
            else:
                index.append(slot[1] if isinstance(slot, tuple) else slot.value)
        value: Any = declared.default
        if value not in ("unknown", "true", "false"):
            value = self.functions[value](self.memory, tuple(index))
        found = self.unify([slots[-1]], (value,), env)
        if found is not None:
            yield found

    def believe(
        self, pattern: nodes.Pattern, age: nodes.Term, env: Bindings
    ) -> Iterator[Bindings]:
        """A fact younger than an age; or, with the age unbound, how old one is.

        The proposition comes first: a variable that it binds is a bound age.
        """
        slots = self.ready(pattern, env)
        known = {*env, *(slot.name for slot in slots if isinstance(slot, nodes.Var))}
        asked = isinstance(age, nodes.Var) and (age.anonymous or age.name not in known)
        self.aged = self.aged or asked
        direct = False
        for entry in list(self.memory.entries):
            found = self.unify(slots, entry.fact, env)
            if found is None:
                continue
            if asked:
                old = number(self.memory.now - entry.stamp)
                found = self.unify([age], (old,), found)
            elif not self.young(entry.stamp, age, found):
                found = None
            if found is not None:
                direct = True
                yield found
        if not direct and not asked:
            for found in self.default(slots, env):
                if self.limit(age, found) is not None:
                    yield found

    def young(self, stamp: Time, age: nodes.Term, env: Bindings) -> bool:
        """Whether a fact is younger than an age; notes when it no longer is."""
        limit = self.limit(age, env)
        if limit is None or self.memory.now - stamp >= limit:
            return False
        self.timers.append(number(stamp + limit))
        return True

    def limit(self, age: nodes.Term, env: Bindings) -> int | float | None:
        """The age of a `believe`; None, with a fault, if it is no number."""
        try:
            value = self.term(age, env)
        except Fault as fault:
            self.faults.append(str(fault))
            return None
        if isinstance(value, int | float):
            return value
        self.faults.append("the age of a `believe` is not a number")
        return None

    # --- the rest ------------------------------------------------------------------------

    def past(self, formula: nodes.History, env: Bindings) -> Iterator[Bindings]:
        """`method-tried`, `last-result` and `result-with-method`."""
        assert self.history is not None
        if formula.query == "last-result":
            result = self.history.last_result
        else:
            name = self.term(formula.args[0], env)
            if formula.query == "method-tried":
                if name in self.history.tried:
                    yield env
                return
            result = self.history.results.get(name)
        if result is not None:
            slot = formula.args[-1]
            if isinstance(slot, nodes.Call):
                slot = nodes.Const(self.term(slot, env))  # type: ignore[arg-type]
            found = self.unify([slot], (result,), env)
            if found is not None:
                yield found

    def sensor_name(
        self, item: nodes.Term, value: nodes.Term, env: Bindings
    ) -> Iterator[Bindings]:
        """Every plain symbol is its own sensor name; nothing was introduced."""
        if isinstance(item, nodes.Var) and (item.anonymous or item.name not in env):
            return
        if self.term(value, env) == "true":
            yield env


def is_time(value: object) -> bool:
    """Whether a value can be a time."""
    return is_number(value)
