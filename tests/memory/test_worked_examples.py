"""The worked examples of T 2.3, followed number by number."""

from __future__ import annotations

from collections import Counter

from rapc.runtime.memory.bench import MemoryBench

from .driving import BOXES, DRUMS, WORDS, bench, leave, merges, names, see, the_set
from .driving import values as of

WAREHOUSE = WORDS + (
    "(declare-indistinct-class box)\n"
    "(declare-class-comparator box warehouse (ignore is-empty))\n"
)


def _two_boxes() -> tuple[MemoryBench, list[str], list[str]]:
    """Figure 2.3-b: a big red box and a small one with bars; later two empty ones."""
    memory = bench(WAREHOUSE)
    big, small = see(
        memory,
        "box",
        "warehouse",
        {"color": "red", "size": "big", "is-empty": "true"},
        {"color": "red", "size": "small"},
    )
    memory.assert_fact("contains", small, "bars", "true")
    leave(memory)
    new = see(memory, "box", "warehouse", {}, {})
    for name in new:
        memory.assert_fact("is-empty", name, "true")
    return memory, [big, small], new


def test_two_boxes_wait_at_score_10_and_are_told_apart_at_20() -> None:
    memory, (big, small), (one, two) = _two_boxes()
    assert merges(memory) == []
    memory.assert_fact("size", one, "big")
    assert merges(memory) == [(big, one, 20, 10), (small, two, 10, 0)]
    memory.assert_fact("size", two, "small")
    assert memory.memory.value("size", two) == "small"
    assert memory.name(two) == small
    assert len(merges(memory)) == 2
    assert the_set(memory, "box", "warehouse").layers == ()


def test_a_small_red_empty_box_has_lost_its_bars_in_the_merge() -> None:
    memory, (big, small), (one, _) = _two_boxes()
    memory.assert_fact("size", one, "big")
    local = {d.name: d for d in the_set(memory, "box", "warehouse").local}
    assert of(local[small]) == {"color": "red", "size": "small", "is-empty": "true"}
    assert local[small].sensor == "s10-2"
    assert local[small].properties["color",] == ("red", 0)
    assert local[small].properties["is-empty",] == ("true", 10)
    assert local[big].sensor == "s10-1"
    assert memory.memory.value("contains", small, "bars") is None


def _red_blue_full_empty() -> tuple[MemoryBench, list[str]]:
    memory = bench(DRUMS)
    first = see(memory, "drum", "depot", {"color": "red"}, {"color": "blue"})
    leave(memory)
    second = see(memory, "drum", "depot", {"content": "full"}, {"content": "empty"})
    leave(memory)
    return memory, [*first, *second]


def test_red_and_blue_stand_in_another_layer_than_full_and_empty() -> None:
    memory, (red, blue, full, empty) = _red_blue_full_empty()
    layers = the_set(memory, "drum", "depot").layers
    assert [names(layer) for layer in layers] == [[red, blue], [full, empty]]
    assert merges(memory) == []


def test_a_full_red_drum_tells_both_pairs_apart() -> None:
    memory, (red, blue, full, empty) = _red_blue_full_empty()
    new = see(memory, "drum", "depot", {}, {})
    assert merges(memory) == []
    with memory.batch():
        memory.assert_fact("color", new[0], "red")
        memory.assert_fact("content", new[0], "full")
    assert {memory.name(n) for n in (red, full, new[0])} == {red}
    assert {memory.name(n) for n in (blue, empty, new[1])} == {blue}
    found = the_set(memory, "drum", "depot")
    assert found.layers == ()
    assert [of(d) for d in found.local] == [
        {"color": "red", "content": "full"},
        {"color": "blue", "content": "empty"},
    ]


def test_ten_blue_drums_and_one_taken_unseen() -> None:
    memory = bench(DRUMS)
    full = {"color": "blue", "content": "full"}
    empty = {"color": "blue", "content": "empty"}
    see(memory, "drum", "box", *[full] * 5, *[empty] * 5)
    leave(memory)
    (taken,) = see(memory, "drum", "box", {})
    memory.move(taken, "bay")
    left = the_set(memory, "drum", "box")
    assert left.size == 9
    (layer,) = left.layers
    assert Counter(str(of(d)["content"]) for d in layer) == {
        "full": 4,
        "empty": 4,
        "unknown": 1,
    }
    (unsure,) = [d for d in layer if of(d)["content"] == "unknown"]
    assert unsure.properties["content",] == ("unknown", None)
    assert unsure.properties["color",] == ("blue", 0)
    (moved,) = the_set(memory, "drum", "bay").local
    assert of(moved) == {"color": "blue", "content": "unknown"}
    assert moved.sensor == "s10-1"
    for _ in range(4):
        memory.time += 10
        (taken,) = see(memory, "drum", "box", {})
        memory.move(taken, "bay")
    (layer,) = the_set(memory, "drum", "box").layers
    assert Counter(str(of(d)["content"]) for d in layer) == {"unknown": 5}
    assert {of(d)["color"] for d in layer} == {"blue"}


def test_a_box_taken_out_of_a_sack_leaves_one_big_and_one_of_unknown_size() -> None:
    memory = bench(BOXES)
    big = {"color": "red", "size": "big"}
    old = see(memory, "box", "sack", big, big, {"color": "red", "size": "small"})
    leave(memory)
    (peeked,) = see(memory, "box", "sack", {"color": "red"})
    memory.move(peeked, "dock")
    (layer,) = the_set(memory, "box", "sack").layers
    assert sorted(str(of(d)["size"]) for d in layer) == ["big", "unknown"]
    assert {of(d)["color"] for d in layer} == {"red"}
    (moved,) = the_set(memory, "box", "dock").local
    assert moved.name == memory.name(peeked) == old[0]
    assert of(moved) == {"color": "red", "size": "unknown"}


def test_counts_go_up_with_what_is_seen_and_down_when_all_is_seen() -> None:
    memory = bench(DRUMS)
    see(memory, "drum", "depot", {"color": "red"}, {"color": "blue"})
    leave(memory)
    see(memory, "drum", "depot", {}, {}, {})
    assert memory.count("drum", "depot") == 3
    (layer,) = the_set(memory, "drum", "depot").layers
    assert names(layer)[2] is None
    leave(memory)
    with memory.batch():
        memory.fix_cardinality("depot")
        see(memory, "drum", "depot", {})
        assert memory.count("drum", "depot") == 3
    assert memory.count("drum", "depot") == 1
    assert all(len(layer) == 1 for layer in the_set(memory, "drum", "depot").layers)


def test_the_papers_are_in_the_drum_that_is_left() -> None:
    memory = bench(DRUMS)
    drums = see(
        memory,
        "drum",
        "depot",
        {"content": "empty"},
        {"content": "full"},
        {"content": "empty"},
    )
    with memory.batch():
        memory.assert_fact("contains", drums[2], "papers", "true")
        memory.assert_fact("content", drums[2], "papers")
    leave(memory)
    new = see(memory, "drum", "depot", {}, {}, {})
    memory.assert_fact("content", new[0], "full")
    memory.assert_fact("content", new[1], "empty")
    assert memory.name(new[0]) == drums[1]
    assert memory.name(new[1]) == drums[0]
    assert memory.name(new[2]) == drums[2]
    assert memory.memory.value("contains", new[2], "papers") == "true"
