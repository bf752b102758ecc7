"""The smallest collection, against a search through all of them."""

from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.runtime.memory.recognition import departure as leaving
from rapc.runtime.memory.recognition.scoring import (
    DescribedItem,
    default_comparator,
    python_comparator,
)
from rapc.runtime.memory.recognition.sets import (
    Description,
    ExpectationSet,
    View,
)
from tests.effort import examples

Rows = list[tuple[int, int]]


def _set(rows: Rows, layers: int) -> ExpectationSet:
    """A set whose descriptions each have a mark and stand in some layers, as bits."""
    found = ExpectationSet("drum", "depot")
    for _ in range(layers):
        found.new_layer(len(found.layers) + 1)
    for number, (mark, stands) in enumerate(rows, 1):
        name = f"item-{number}" if mark else ""
        description = Description(number, name, "", "drum")
        if mark:
            description.learn(("mark",), mark)
        for at, layer in enumerate(found.layers):
            if stands >> at & 1:
                found.add(layer, description)
    return found


def _least(
    served: list[View], groups: list[set[Description]], among: set[Description]
) -> tuple[int, int] | None:
    """The size of the smallest collection, and of what leaves; by trying all."""
    members = sorted(among, key=lambda d: d.number)
    for size in range(len(members) + 1):
        least = [
            len(out)
            for chosen in combinations(members, size)
            if all(group.intersection(chosen) for group in groups)
            for number in range(size + 1)
            for out in combinations(chosen, number)
            if all(sum(d.mask & v.bit > 0 for d in out) == 1 for v in served)
        ]
        if least:
            return size, min(least)
    return None


@examples(300)
@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(1, 7)), max_size=7),
    st.integers(0, 3),
)
def test_the_collection_is_the_smallest_and_the_fewest_leave(
    rows: Rows, mark: int
) -> None:
    of = _set(rows, 3)
    item = Description(99, "item-99", "s", "drum")
    if mark:
        item.learn(("mark",), mark)
    served, found = leaving.collect(of, item, default_comparator())
    groups = [set(group) for _, grouped in found for group in grouped]
    expected = _least(served, groups, set().union(*groups))
    expected = expected or _least(served, groups, set(of.members()))
    chosen = leaving.smallest(served, found)
    if chosen is None:
        assert expected is None
        return
    assert (len(chosen.members), len(chosen.leaving)) == expected
    assert set(chosen.leaving) <= set(chosen.members)


@pytest.mark.parametrize("empty_first", [True, False])
def test_score_of_a_group_is_the_same_for_empty_and_real_members(
    empty_first: bool,
) -> None:
    def compare(one: DescribedItem, other: DescribedItem) -> int:
        return 10 if one.properties or other.properties else 14

    of = _set([(1, 1)], 1)
    empty, real = Description(2, "", "", "drum"), Description(3, "item-3", "", "drum")
    for member in (empty, real) if empty_first else (real, empty):
        of.add(of.layers[0], member)
    item = Description(99, "item-99", "s", "drum")
    _, found = leaving.collect(of, item, python_comparator("compare", compare))
    assert found == [(14, [[empty, real] if empty_first else [real, empty]])]


def test_many_groups_are_hit_greedily_and_each_layer_loses_one() -> None:
    rows = [(number + 1, 1 << number % 2) for number in range(40)]
    of = _set(rows, 2)
    served, found = leaving.collect(
        of, Description(99, "i", "s", "drum"), default_comparator()
    )
    chosen = leaving.smallest(served, found)
    assert chosen is not None
    assert len(chosen.members) == 40
    assert sorted(d.number for d in chosen.leaving) == [1, 2]
