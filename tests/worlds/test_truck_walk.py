"""Random requests in a world where everything goes on: what holds whatever happens."""

from __future__ import annotations

import json
import random
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.worlds.truck import TruckWorld
from tests.effort import examples

from .wanderer import HARDEST, LONG, MORTAL, Wanderer, check


def wanderer(seed: int, **options: float) -> Wanderer:
    given = {**HARDEST, **{n.replace("_", "-"): v for n, v in options.items()}}
    world = TruckWorld(random.Random(f"{seed}:world"), given)
    world.messages()
    return Wanderer(world, random.Random(seed))


@given(st.integers(0, 10**9), st.integers(1, 60))
@examples(60)
def test_items_never_vanish_or_double(seed: int, steps: int) -> None:
    one = wanderer(seed)
    for _ in range(steps):
        before = one.world.state.items
        one.step()
        after = one.world.state
        check(after)
        for name, item in before.items():
            assert name in after.items or item.kind in MORTAL


def test_a_long_walk_meets_all_there_is_and_stays_consistent() -> None:
    met: Counter[tuple[str, str]] = Counter()
    for seed in range(40):
        one = wanderer(seed, **LONG)
        for _ in range(800):
            request, reply = one.step()
            met[str(request[0]), reply.result] += 1
        check(one.world.state)
    missing = [
        (name, result)
        for name, (_, results) in one.world.kit.offer.primitives.items()
        for result in results
        if not met[name, result]
    ]
    assert missing == []


@pytest.mark.slow
def test_a_thousand_walks_through_the_hardest_world_end_as_walks_do() -> None:
    ends: Counter[str] = Counter()
    for seed in range(1000):
        one = wanderer(seed)
        for _ in range(40):
            one.step()
        check(one.world.state)
        ended = one.world.ended() or "none"
        ends[ended.partition(" at ")[0].partition(" on ")[0]] += 1
    assert set(ends) == {"none", "captured", "mishap", "out of fuel"}


@given(st.integers(0, 10**9), st.integers(0, 40), st.integers(1, 40))
@examples(30)
def test_a_saved_world_goes_on_as_if_nothing_had_been(
    seed: int, before: int, after: int
) -> None:
    one = wanderer(seed)
    for _ in range(before):
        one.step()
    saved = one.world.save()
    history = [one.step() for _ in range(after)]
    end = one.world.save()
    for world in (one.world, TruckWorld(random.Random(99), HARDEST)):
        world.restore(saved)
        assert world.save() == saved
        for request, reply in history:
            assert world.perform(0, request) == reply
        assert world.save() == end


def test_saved_state_is_plain_json() -> None:
    state = json.loads(wanderer(1).world.save())
    assert state["state"]["truck"]["place"] == "depot"


def test_a_state_of_other_options_or_none_is_refused() -> None:
    world = wanderer(0).world
    before = world.save()
    with pytest.raises(ValueError, match="with other options"):
        world.restore(TruckWorld(random.Random(0), {}).save())
    told = json.loads(before)
    short = {**told, "rng": [3, [1, 2], None]}
    fewer = {**told, "chance": {"shuffle": told["rng"]}}
    broken = [b"", b"{}", b"[1]", before[:-5]]
    for state in (*broken, *(json.dumps(each).encode() for each in (short, fewer))):
        with pytest.raises(ValueError, match="no state of a truck world"):
            world.restore(state)
    assert world.save() == before
