"""The memory that recognises and the plain one agree, and both keep what must hold."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.effort import first

from . import invariants
from .crowded_walks import WORLD, Walk
from .departing_walks import MARKED, Visits
from .pictures import Operation, Picture, Side, Told
from .sides import ByHand, UnderTest

WALKS = range(120)
STEPS = 100
DEPARTURES = range(900)
SLICES = 30

DIGEST = "from tests.recognition import test_agreement as t; print(t.digest(range(8)))"


def expected_items(picture: Picture) -> list[str]:
    """The items that some layer holds."""
    layers = [layer for found in picture.sets.values() for layer in found.layers]
    return sorted({each.item for layer in layers for each in layer if each.item})


def by_set(told: list[Told]) -> list[Told]:
    """Events in order, but each set's by themselves: sets have no order."""
    return sorted(told, key=lambda each: (each.kind, each.place))


def walk(seed: int, *sides: Side) -> Iterator[list[Operation]]:
    """Lead memories on one walk: each batch, after it was carried out."""
    way = Walk(seed)
    for time, batch in way.steps(STEPS):
        for side in sides:
            side.run(time, batch)
        way.expected = expected_items(sides[0].picture())
        yield batch


def compare(batch: list[Operation], tested: Side, plain: Side, where: str) -> Picture:
    """Hold both memories against each other after a batch; return what they hold."""
    one, other = tested.picture(), plain.picture()
    where = f"{where}: {batch}"
    assert one.sets == other.sets, where
    assert one.facts == other.facts, where
    assert one.names == other.names, where
    assert one.sensors == other.sensors, where
    assert by_set(tested.told()) == by_set(plain.told()), where
    return one


@pytest.mark.parametrize("part", first(1, range(SLICES), 10))
def test_both_memories_see_the_same_and_what_must_hold_holds(part: int) -> None:
    for seed in WALKS[part::SLICES]:
        tested, plain = UnderTest(WORLD), ByHand(WORLD)
        before = tested.picture()
        for step, batch in enumerate(walk(seed, tested, plain)):
            after = compare(batch, tested, plain, f"walk {seed}, step {step}")
            invariants.check(before, after, batch)
            before = after


@pytest.mark.parametrize("part", first(1, range(SLICES), 10))
def test_both_memories_agree_on_items_that_leave_contradicting_layers(
    part: int,
) -> None:
    for seed in DEPARTURES[part::SLICES]:
        tested, plain = UnderTest(MARKED), ByHand(MARKED)
        before = tested.picture()
        for step, batch in enumerate(Visits(seed).batches()):
            for side in (tested, plain):
                side.run(step, batch)
            after = compare(batch, tested, plain, f"visits {seed}, step {step}")
            invariants.layers_are_equally_large(after)
            invariants.a_layer_stays_apart(before, after)
            before = after


def digest(seeds: range) -> str:
    """What some walks come to, facts and events in their order, in a few letters."""
    found = hashlib.sha256()
    for seed in seeds:
        sides = UnderTest(WORLD), ByHand(WORLD)
        for _ in walk(seed, *sides):
            for side in sides:
                found.update(repr((side.picture(), side.told())).encode())
    return found.hexdigest()


@pytest.mark.slow
def test_the_order_of_dictionaries_does_not_matter() -> None:
    outcomes = {
        subprocess.run(
            [sys.executable, "-c", DIGEST],
            cwd=Path(__file__).parents[2],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outcomes) == 1
    assert outcomes.pop().strip() == digest(range(8))
