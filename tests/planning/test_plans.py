"""Plans of random models: valid in each order, and found where a search finds one."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from itertools import islice, product
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rapc
from rapc.base import values
from rapc.library.operators import Model
from rapc.planning.sketch import Sketch
from rapc.planning.solver import Solution, solve

Fact = tuple[str, ...]
Literals = list[tuple[bool, Fact]]
Row = tuple[list[str], Literals, Literals]
"""The inputs, conditions and effects of an operator."""

MOST_ORDERS = 5040
"""The number of orders of a net that are tried: all of one with 7 steps."""

OBJECTS = ("a", "b", "c")
PREDICATES = {"p0": 0, "p1": 1, "p2": 1, "p3": 2, "q": 1}
"""The predicates with their numbers of arguments; `q` is a property."""


@st.composite
def literal(draw: st.DrawFn, variables: Sequence[str]) -> tuple[bool, Fact]:
    name = draw(st.sampled_from(sorted(PREDICATES)))
    terms = st.sampled_from([*variables, *OBJECTS])
    args = [draw(terms) for _ in range(PREDICATES[name])]
    return draw(st.integers(0, 3)) > 0, (name, *args)


def literals(variables: Sequence[str], most: int) -> st.SearchStrategy[Literals]:
    return st.lists(literal(variables), max_size=most)


@st.composite
def operator(draw: st.DrawFn) -> Row:
    inputs = ["?x", "?y"][: draw(st.integers(0, 2))]
    needs = draw(literals(inputs, 3))
    effects = draw(literals(inputs, 3).filter(bool))
    used = used_in(needs, effects)
    return [one for one in inputs if one in used], needs, effects


def used_in(*found: Literals) -> set[str]:
    """Return the terms of literals; an operator with other inputs is left out."""
    return {term for row in found for _, fact in row for term in fact}


def written(found: tuple[bool, Fact]) -> str:
    text = f"({' '.join(found[1])})"
    return text if found[0] else f"(not {text})"


class Strips:
    """A random model as a library, and as rules for a search of its own."""

    def __init__(
        self, operators: Sequence[Row], facts: set[Fact], goal: Literals
    ) -> None:
        self.facts, self.goal = facts, goal
        self.actions: list[tuple[Fact, Literals, Literals]] = []
        forms = [
            f"(declare-kind object ({' '.join(OBJECTS)}))",
            "(declare-memory-proposition p0 ())",
            "(declare-memory-proposition p1 ((?a object)) :at-most 2)",
            "(declare-memory-proposition p2 ((?a object)))",
            "(declare-memory-proposition p3 ((?a object) (?b object)))",
            "(declare-memory-property q ((?value object)) a)",
        ]
        for at, (inputs, needs, effects) in enumerate(operators):
            args = " ".join(f"({one} object)" for one in inputs)
            told = " ".join(map(written, effects))
            asked = " ".join(map(written, needs))
            forms.append(
                f"(define-rap (o{at} {args}) (preconditions (and {asked})) "
                f"(effects {told}))"
            )
            for chosen in product(OBJECTS, repeat=len(inputs)):
                bound = dict(zip(inputs, chosen, strict=True))

                rows = [
                    [(h, tuple([bound.get(a, a) for a in f])) for h, f in row]
                    for row in (needs, effects)
                ]
                self.actions.append(((f"o{at}", *chosen), rows[0], rows[1]))
        asked = " ".join(map(written, goal))
        forms.append(f"(define-rap (job) (succeed (and {asked})) (plan))")
        self.program = rapc.loads("\n".join(forms), check=False).program

    def plan(self) -> Solution:
        program = self.program
        model = Model(program.library, program.signatures)
        goal = model.goal(program.library.raps["job"], {})
        facts: dict[values.Fact, None] = dict.fromkeys(sorted(self.facts))
        return solve(model, facts, goal, limit=20000)

    def shortest(self, most: int) -> int | None:
        """Return the length of the shortest plan, if it has at most so many steps."""
        start = frozenset(self.facts)
        seen = {start}
        queue = deque([(start, 0)])
        while queue:
            state, depth = queue.popleft()
            if holds(state, self.goal):
                return depth
            if depth == most:
                continue
            for _, needs, effects in self.actions:
                if holds(state, needs):
                    after = changed(state, effects)
                    if after not in seen and allowed(state, after):
                        seen.add(after)
                        queue.append((after, depth + 1))
        return None


def holds(state: frozenset[Fact], wanted: Sequence[tuple[bool, Fact]]) -> bool:
    valued = any(fact[0] == "q" for fact in state)
    known = state if valued else state | {("q", "a")}
    return all((fact in known) is present for present, fact in wanted)


def changed(
    state: frozenset[Fact], effects: Sequence[tuple[bool, Fact]]
) -> frozenset[Fact]:
    added = [fact for present, fact in effects if present]
    erased = {fact for present, fact in effects if not present} - set(added)
    if any(fact[0] == "q" for fact in added):
        erased |= {fact for fact in state if fact[0] == "q"}
    return (state - erased) | set(added)


def allowed(state: frozenset[Fact], after: frozenset[Fact]) -> bool:
    """Return whether there are not too many facts of `p1`."""
    before, now = (sum(f[0] == "p1" for f in one) for one in (state, after))
    return now <= max(2, before)


def orders(made: Sketch) -> Iterator[list[int]]:
    """Yield each order that the net of a plan allows."""
    before: dict[int, set[int]] = {at: set() for at in range(len(made.actions))}
    for first, second in made.order:
        before[second].add(first)

    def rest(done: list[int]) -> Iterator[list[int]]:
        if len(done) == len(before):
            yield done
        for at, earlier in before.items():
            if at not in done and earlier <= set(done):
                yield from rest([*done, at])

    return rest([])


def one_value(effects: Sequence[tuple[bool, Fact]]) -> bool:
    """Return whether a property gets one value at most, and none is erased."""
    values = [row for row in effects if row[1][0] == "q"]
    return len(values) <= 1 and all(present for present, _ in values)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(operator().filter(lambda one: one_value(one[2])), min_size=1, max_size=6),
    st.sets(
        literal(()).map(lambda one: one[1]).filter(lambda f: f[0] != "q"), max_size=6
    ),
    literals((), 3),
)
def test_plan_of_random_model_holds_in_each_order(
    operators: list[Row], facts: set[Fact], goal: Literals
) -> None:
    checked(Strips(operators, facts, goal))


def checked(strips: Strips) -> int | None:
    """Check the plan of a model, in each order; return its steps, None without one."""
    found = strips.plan()
    shortest = strips.shortest(5)
    if shortest is not None:
        assert found.outcome == "solved"
    if found.sketch is None:
        return None
    rows: dict[values.Fact, tuple[Literals, Literals]] = {
        goal: (needs, effects) for goal, needs, effects in strips.actions
    }
    steps = [rows[action.goal] for action in found.sketch.actions]
    for order in islice(orders(found.sketch), MOST_ORDERS):
        state = frozenset(strips.facts)
        for at in order:
            needs, effects = steps[at]
            assert holds(state, needs)
            before, state = state, changed(state, effects)
            assert allowed(before, state)
        assert holds(state, strips.goal)
    return len(steps)


def drawn(seed: int) -> Strips:
    """Return a random model; its goal is what some random steps have changed."""
    dice = Random(seed)

    def row(variables: Sequence[str], most: int, positive: float) -> Literals:
        found = []
        for _ in range(dice.randint(1, most)):
            name = dice.choice(sorted(PREDICATES))
            terms = [*variables, *variables, *OBJECTS]
            args = [dice.choice(terms) for _ in range(PREDICATES[name])]
            found.append((dice.random() < positive, (name, *args)))
        return found

    operators: list[Row] = []
    while len(operators) < 6:
        inputs = ["?x", "?y"][: dice.randint(0, 2)]
        needs, effects = row(inputs, 3, 0.8), row(inputs, 3, 0.6)
        if one_value(effects) and used_in(needs, effects).issuperset(inputs):
            operators.append((inputs, needs, effects))
    facts = {fact for _, fact in row((), 3, 1) if fact[0] != "q"}
    state = begun = frozenset(facts)
    actions = Strips(operators, facts, []).actions
    for _ in range(8):
        possible = [effects for _, needs, effects in actions if holds(state, needs)]
        if possible:
            state = changed(state, dice.choice(possible))
    told = sorted(state ^ begun)
    goal = [(fact in state, fact) for fact in told if fact[0] != "q" or fact in state]
    return Strips(operators, facts, dice.sample(goal, min(3, len(goal))))


def lengths(seeds: range) -> Counter[int | None]:
    """Return how many of random models have plans of each length."""
    return Counter([checked(drawn(seed)) for seed in seeds])


def test_plans_of_drawn_models_hold_in_each_order() -> None:
    found = lengths(range(300))
    assert sum(n for steps, n in found.items() if steps and steps > 1) > 60


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_plans_of_many_drawn_models_hold_in_each_order() -> None:
    found = lengths(range(1000, 21_000))
    assert sum(n for steps, n in found.items() if steps and steps > 1) > 3000
