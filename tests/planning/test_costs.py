"""Plans with computed costs: the order of their steps, and limits of facts."""

from __future__ import annotations

import re
from itertools import pairwise, permutations
from random import Random

import pytest

import rapc
from bench.plans import compared

LINE = """(declare-memory-property along ((?place number)) 0)
(declare-memory-proposition lies ((?thing symbol) (?place number)))
(declare-memory-proposition wanted ((?thing symbol) (?place number)))
(declare-memory-proposition aboard ((?thing symbol)) :at-most {most})
(declare-memory-proposition brought ((?thing symbol)))
(define-rap (load (?thing symbol))
  (preconditions (and (along ?here) (lies ?thing ?place)))
  (effects (aboard ?thing) (not (lies ?thing ?)) (along ?place))
  (duration (* (- ?here ?place) (- ?here ?place))))
(define-rap (unload (?thing symbol))
  (preconditions (and (along ?here) (aboard ?thing) (wanted ?thing ?place)))
  (effects (brought ?thing) (not (aboard ?thing)) (along ?place))
  (duration (* (- ?here ?place) (- ?here ?place))))
"""
"""Things on a line; a way costs the square of its length."""


def cheapest(places: dict[str, tuple[int, int]], most: int) -> int:
    """Return the cost of the cheapest order, found by trying all."""
    steps = [(kind, thing) for thing in places for kind in (0, 1)]
    found = []
    for order in permutations(steps):
        done, load, fits = set[tuple[int, str]](), 0, True
        for kind, thing in order:
            load += 1 - 2 * kind
            fits = fits and load <= most and (not kind or (0, thing) in done)
            done.add((kind, thing))
        if fits:
            stops = [0, *[places[thing][kind] for kind, thing in order]]
            found.append(sum((one - other) ** 2 for one, other in pairwise(stops)))
    return min(found)


@pytest.mark.parametrize("seed", range(8))
def test_order_of_the_steps_is_the_cheapest_that_the_limit_allows(seed: int) -> None:
    dice = Random(seed)
    things = ("a", "b", "c")
    places = {thing: (dice.randint(0, 9), dice.randint(0, 9)) for thing in things}
    most = 1 + seed % 3
    facts = [("lies", thing, place) for thing, (place, _) in places.items()]
    facts += [("wanted", thing, place) for thing, (_, place) in places.items()]
    library = rapc.loads(LINE.format(most=most), check=False)
    goal = f"(and {' '.join(f'(brought {thing})' for thing in things)})"
    plan = rapc.plan(library, goal, facts=facts)
    assert plan.cost == cheapest(places, most)
    assert f"cost {plan.cost}" in plan.summary
    load = 0
    for step, following in pairwise(plan.steps):
        load += 1 if step.goal.startswith("(load") else -1
        assert load <= most
        assert following.tag in (*step.before, *[link.step for link in step.links])


def test_deliveries_by_a_plan_take_less_time_than_by_orders() -> None:
    said = compared(range(90_000, 90_010))
    found = re.search(r"([0-9.]+) \+- .* in 10 and 10 of 10 runs$", said)
    assert found is not None
    assert float(found[1]) < 0.95
