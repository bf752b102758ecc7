"""What holds of all expectation sets after every batch, whatever happens (T 2.3)."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from hypothesis import HealthCheck, given
from hypothesis import strategies as st

from rapc import events
from rapc.base.values import Atom
from rapc.runtime.memory.recognition.scoring import DescribedItem
from tests.effort import examples, thorough
from tests.memory.bench import MemoryBench

from .walking import TEXT, Step, Walk

STEPS = 250 if thorough() else 80

_ONE = st.integers(0, 99)


def _walks(steps: int) -> st.SearchStrategy[list[Step]]:
    """Walks of so many steps."""
    return st.lists(st.tuples(_ONE, _ONE, _ONE), min_size=steps, max_size=steps)


@examples(40, share=20, suppress_health_check=list(HealthCheck))
@given(_walks(STEPS))
def test_sets_stay_sound_through_ten_thousand_steps(steps: list[Step]) -> None:
    walk = Walk()
    for step in steps:
        apart = _pairs(walk.memory)
        walk.step(step)
        walk.check()
        for pair in apart:
            one, other = (walk.memory.name(name) for name in pair)
            assert one != other, "two members of one view were merged"


def _pairs(memory: MemoryBench) -> set[tuple[str, str]]:
    """All pairs of names that stand together in a view."""
    found: set[tuple[str, str]] = set()
    for each in memory.sets():
        for view in (each.local, *each.layers):
            members = [d.name for d in view if d.name]
            found.update((a, b) for a in members for b in members if a < b)
    return found


@examples(25, suppress_health_check=list(HealthCheck))
@given(_walks(80))
def test_a_merge_keeps_the_newest_value_of_each_property(steps: list[Step]) -> None:
    walk = Walk()
    walk.memory.events.clear()
    for step in steps:
        before = _known(walk.memory)
        walk.memory.events.clear()
        walk.step(step)
        quiet = not 65 <= step[0] < 90
        merged = [e for e in walk.memory.events if isinstance(e, events.ItemMerged)]
        now = _known(walk.memory)
        for event in merged if quiet else []:
            for name in (event.item, event.with_ or ""):
                kept = now.get(walk.memory.name(name), {})
                for index, (_, stamp) in before.get(name, {}).items():
                    assert index in kept
                    assert kept[index][1] >= stamp


def _known(memory: MemoryBench) -> dict[str, Mapping[Atom, tuple[Atom, float]]]:
    """By name, each property's value and stamp."""
    return {
        d.name: {
            index[0]: (value, -1 if stamp is None else stamp)
            for index, (value, stamp) in d.properties.items()
        }
        for each in memory.sets()
        for view in (each.local, *each.layers)
        for d in view
        if d.name is not None
    }


def test_the_outcome_does_not_depend_on_the_order_of_sets_and_dictionaries() -> None:
    outcomes = []
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-m", "tests.memory.walking"],
            env={**os.environ, "PYTHONHASHSEED": seed},
            cwd=Path(__file__).parents[2],
            capture_output=True,
            check=True,
            text=True,
        )
        outcomes.append(done.stdout)
    assert "ItemMerged" in outcomes[0]
    assert outcomes[0] == outcomes[1]


@examples(25, suppress_health_check=list(HealthCheck))
@given(_walks(80))
def test_only_what_leaves_a_set_makes_properties_unknown(steps: list[Step]) -> None:
    walk = Walk()
    for step in steps:
        before = _unmeasured(walk.memory)
        walk.step(step)
        if not 70 <= step[0] < 90:
            assert _unmeasured(walk.memory) <= before


PLAIN = TEXT.replace("drum)", "drum by-ten)", 1)


def _by_ten(one: DescribedItem, other: DescribedItem) -> int:
    shared = [i for i, v in one.properties.items() if other.properties.get(i) == v]
    return 10 + 10 * len(shared)


@examples(25, suppress_health_check=list(HealthCheck))
@given(_walks(100))
def test_comparing_only_what_shares_something_changes_nothing(
    steps: list[Step],
) -> None:
    fast, slow = Walk(), Walk(PLAIN, comparators={"by-ten": _by_ten})
    for step in steps:
        fast.step(step)
        slow.step(step)
        assert fast.memory.sets() == slow.memory.sets()


def _unmeasured(memory: MemoryBench) -> int:
    """How many properties are unknown without anybody having said so."""
    known = _known(memory).values()
    return sum(stamp == -1 for each in known for _, stamp in each.values())
