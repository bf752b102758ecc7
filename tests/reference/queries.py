"""Formulas as recursive generators over the list of facts [L 2].

Solutions are dictionaries of bindings, made anew at each step; nothing is cleverer
than walking the formula.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

from rapc.base.resources import Value
from rapc.base.values import number
from rapc.ir import nodes
from rapc.world import Time
from tests.reference.memory import Memory, is_short
from tests.reference.searching import FREE, Before, GivenUp, is_own, spelled_out
from tests.reference.terms import OWN, Bindings, Fault, Functions, Terms, members


class History(Protocol):
    """What a task remembers of its methods."""

    last_result: str | None
    tried: dict[object, None]
    results: dict[object, str]


class Known(NamedTuple):
    """A part of a pattern that has a value."""

    value: Value


class Faulted(NamedTuple):
    """What was unbound or ill-typed, and the queries around it, innermost first."""

    within: str
    message: str


_EXPANSIONS = itertools.count(1)

Slot = Known | nodes.Var
"""A part of a pattern: a value, or a variable that may have one by now."""


class Asker(Terms):
    """Everything a query depends on but its bindings.

    `timers` collects the times at which what a `believe` saw goes stale; `faults`
    what was unbound or ill-typed. `steps` is how often it may go back in vain.
    """

    def __init__(
        self,
        memory: Memory,
        functions: Functions,
        history: History | None,
        steps: int,
    ) -> None:
        super().__init__(memory, functions)
        self.history = history
        self.steps = steps
        self.left = steps
        self.queries = memory.library.queries
        self.faults: list[Faulted] = []
        self.timers: list[Time] = []

    # --- formulas -----------------------------------------------------------------

    def first(self, formula: nodes.Formula, env: Bindings) -> Bindings | None:
        """The first solution of a whole question, or None; it may be given up."""
        self.left = self.steps
        try:
            return next(self.solutions(formula, env, Before(frozenset(env), 0)), None)
        except GivenUp:
            told = f"given up after {self.steps} steps back: see `rapc.query-steps`"
            self.faults.append(Faulted("", told))
            return None

    def every(self, formula: nodes.Formula, env: Bindings) -> Iterator[Bindings]:
        """All solutions of a whole question; it may be given up."""
        self.left = self.steps
        try:
            yield from self.solutions(formula, env, Before(frozenset(env), 0))
        except GivenUp:
            told = f"given up after {self.steps} steps back: see `rapc.query-steps`"
            self.faults.append(Faulted("", told))

    def solutions(
        self, formula: nodes.Formula, env: Bindings, before: Before
    ) -> Iterator[Bindings]:
        """All solutions in order; a part that faults has none, the fault is kept."""
        try:
            match formula:
                case nodes.And(parts):
                    yield from self.all_of(parts, env, before)
                case nodes.Or(parts):
                    for part in parts:
                        yield from self.solutions(part, env, before)
                case nodes.Not(part):
                    if next(self.solutions(part, env, before), None) is None:
                        yield env
                case nodes.Truth() | nodes.Compare() | nodes.SetTest():
                    if self.holds(formula, env):
                        yield env
                case nodes.Proposition(name, args) if name in self.queries:
                    yield from self.named(self.queries[name], args, env, before)
                case _:
                    yield from self.facts(formula, env)
            if before.searches >= FREE and before.search(self.memory.library, formula):
                self.left -= 1
                if self.left < 0:
                    raise GivenUp
        except Fault as fault:
            self.faults.append(Faulted("", str(fault)))

    def all_of(
        self, parts: Sequence[nodes.Formula], env: Bindings, before: Before
    ) -> Iterator[Bindings]:
        """Left to right, with full backtracking."""
        if not parts:
            yield env
            return
        behind = before.behind(self.memory.library, parts[0])
        for found in self.solutions(parts[0], env, before):
            yield from self.all_of(parts[1:], found, behind)

    def holds(
        self, test: nodes.Truth | nodes.Compare | nodes.SetTest, env: Bindings
    ) -> bool:
        """A test that binds nothing."""
        if isinstance(test, nodes.Truth):
            return test.value
        if isinstance(test, nodes.Compare):
            return compare(
                test.op, self.term(test.left, env), self.term(test.right, env)
            )
        values = [self.term(arg, env) for arg in test.args]
        found = members(values[0])
        return values[1] in found if test.test == "member" else not found

    def facts(self, formula: nodes.Formula, env: Bindings) -> Iterator[Bindings]:
        """What memory, a declared function or the task's past has to say."""
        match formula:
            case nodes.Proposition(name, args) if name in self.memory.library.functions:
                values = [self.term(arg, env) for arg in args]
                if self.functions[name](self.memory, *values):
                    yield env
            case nodes.Proposition():
                yield from self.pattern(formula, env)
            case nodes.Believe(pattern, age):
                yield from self.believe(pattern, age, env)
            case nodes.Is(variable, term):
                known = self.has_value(variable, env)
                slot = Known(self.term(variable, env)) if known else variable
                assert isinstance(slot, Known | nodes.Var)
                value = self.term(term, env)
                found = self.unify([slot], (value,), env)
                if found is not None:
                    yield found
            case nodes.HistoryTest():
                yield from self.past(formula, env)
            case nodes.SensorName(item, value):
                # every plain symbol is its own sensor name; nothing was introduced
                if self.has_value(item, env):
                    self.term(item, env)
                    if self.term(value, env) == "true":
                        yield env
            case _:
                raise AssertionError(f"not in sections 1 to 6: {formula}")

    # --- named queries ------------------------------------------------------------

    def named(
        self,
        query: nodes.DefineQuery,
        args: Sequence[nodes.Term],
        env: Bindings,
        before: Before,
    ) -> Iterator[Bindings]:
        """The formula of a query with terms put in; its own variables stay its own."""
        mark = f"{OWN}{next(_EXPANSIONS)}"
        solutions = self.solutions(spelled_out(query, args, mark), env, before)
        while True:
            known = len(self.faults)
            try:
                found = next(solutions, None)
            finally:
                within = f"`{query.name}` in "
                self.faults[known:] = [
                    Faulted(f.within + within, f.message) for f in self.faults[known:]
                ]
            if found is None:
                return
            yield {n: v for n, v in found.items() if not is_own(n, mark)}

    # --- propositions -------------------------------------------------------------

    def has_value(self, term: nodes.Term, env: Bindings) -> bool:
        """Whether a term is no variable, or one with a value."""
        return not isinstance(term, nodes.Var) or term.name in env

    def slots(self, pattern: nodes.Proposition, env: Bindings) -> list[Slot]:
        """A pattern in its whole form, with what has a value put in."""
        terms = list(pattern.args)
        if is_short(self.memory.library, pattern.name, len(terms)):
            terms.append(nodes.Const("true"))
        found: list[Slot] = [Known(pattern.name)]
        for term in terms:
            if isinstance(term, nodes.Var) and term.name not in env:
                found.append(term)
            else:
                found.append(Known(self.term(term, env)))
        return found

    def unify(
        self, slots: Sequence[Slot], values: Sequence[Value], env: Bindings
    ) -> Bindings | None:
        """The bindings under which slots and values are the same, or None."""
        if len(slots) != len(values):
            return None
        found = dict(env)
        for slot, value in zip(slots, values, strict=True):
            if isinstance(slot, Known):
                wanted = slot.value
            elif slot.anonymous:
                continue
            else:
                wanted = found.setdefault(slot.name, value)
            if wanted != value:
                return None
        return found

    def pattern(self, pattern: nodes.Proposition, env: Bindings) -> Iterator[Bindings]:
        """A proposition; for a property with its default (T 2.2.2's steps)."""
        slots = self.slots(pattern, env)
        direct = False
        for entry in list(self.memory.entries):
            found = self.unify(slots, entry.fact, env)
            if found is not None:
                direct = True
                yield found
        if not direct:
            yield from self.default(pattern.name, slots, env)

    def default(
        self, name: str, slots: Sequence[Slot], env: Bindings
    ) -> Iterator[Bindings]:
        """What holds of a property where no fact has its index."""
        declared = self.memory.library.properties.get(name)
        if declared is None:
            return
        for entry in self.memory.entries:
            if self.unify(slots[:-1], entry.fact[:-1], env) is not None:
                return
        index = tuple(slot.value for slot in slots[:-1] if isinstance(slot, Known))
        if len(index) < len(slots) - 1:
            return
        value = declared.default
        if value in self.memory.library.functions:
            value = self.functions[str(value)](self.memory, index)
        found = self.unify(slots[-1:], (value,), env)
        if found is not None:
            yield found

    # --- believe ------------------------------------------------------------------

    def believe(
        self, pattern: nodes.Proposition, age: nodes.Term, env: Bindings
    ) -> Iterator[Bindings]:
        """A fact younger than an age; or, with the age unbound, how old one is.

        The proposition comes first: a variable that it binds is a bound age.
        """
        slots = self.slots(pattern, env)
        known = {*env, *(slot.name for slot in slots if isinstance(slot, nodes.Var))}
        asked = isinstance(age, nodes.Var) and (age.anonymous or age.name not in known)
        direct = False
        for entry in list(self.memory.entries):
            found = self.unify(slots, entry.fact, env)
            if found is None:
                continue
            if asked and isinstance(age, nodes.Var):
                old = number(self.memory.now - entry.stamp)
                found = self.unify([age], (old,), found)
            elif not self.young(entry.stamp, age, found):
                found = None
            if found is not None:
                direct = True
                yield found
        if not direct and not asked:
            for found in self.default(pattern.name, slots, env):
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
            if isinstance(value, int | float):
                return value
            raise Fault("the age of a `believe` is not a number")
        except Fault as fault:
            self.faults.append(Faulted("", str(fault)))
            return None

    # --- the task's past ----------------------------------------------------------

    def past(self, formula: nodes.HistoryTest, env: Bindings) -> Iterator[Bindings]:
        """`method-tried`, `last-result` and `result-with-method`."""
        if self.history is None:
            return  # it is asked by a rule of no RAP
        if formula.query == "method-tried":
            if self.term(formula.args[0], env) in self.history.tried:
                yield env
            return
        result = self.history.last_result
        if formula.query == "result-with-method":
            result = self.history.results.get(self.term(formula.args[0], env))
        wanted = formula.args[-1]
        slot = Known(self.term(wanted, env)) if self.has_value(wanted, env) else wanted
        if result is not None:
            assert isinstance(slot, Known | nodes.Var)
            found = self.unify([slot], (result,), env)
            if found is not None:
                yield found


def compare(op: str, left: Value, right: Value) -> bool:
    """`= n=` compare anything; the others fail on anything but two numbers."""
    if op in ("=", "n="):
        return (left == right) == (op == "=")
    if not (isinstance(left, int | float) and isinstance(right, int | float)):
        return False
    if op in ("<", ">"):
        return left < right if op == "<" else left > right
    return left <= right if op == "<=" else left >= right
