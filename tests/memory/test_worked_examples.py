"""The worked examples of T 2.3, followed number by number."""

from __future__ import annotations

from collections import Counter

from tests.memory.bench import MemoryBench

from .sightings import BOXES, DRUMS, WORDS, bench, leave, merges, names, see, the_set
from .sightings import values as of

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


def _figure_2_4() -> tuple[MemoryBench, dict[str, str]]:
    """Three visits to three drums, each with one drum known from the visit before."""
    memory = bench(DRUMS)
    d34, d56, d23 = see(
        memory, "drum", "depot", {"color": "red"}, {"color": "blue"}, {"color": "green"}
    )
    leave(memory)
    again, d65, d78 = see(
        memory, "drum", "depot", {"color": "red"}, {"size": "big"}, {"size": "small"}
    )
    assert again == d34
    leave(memory)
    again, d41, d42 = see(
        memory,
        "drum",
        "depot",
        {"size": "small"},
        {"content": "full"},
        {"content": "empty"},
    )
    assert again == d78
    leave(memory)
    again, d94, d95 = see(memory, "drum", "depot", {"size": "big"}, {}, {})
    assert again == d65
    items = {"34": d34, "56": d56, "23": d23, "65": d65, "78": d78}
    return memory, {**items, "41": d41, "42": d42, "94": d94, "95": d95}


def test_figure_2_4_waits_in_three_layers() -> None:
    memory, d = _figure_2_4()
    found = the_set(memory, "drum", "depot")
    assert names(found.local) == [d["65"], d["94"], d["95"]]
    assert [set(names(layer)) for layer in found.layers] == [
        {d["34"], d["56"], d["23"]},
        {d["34"], d["65"], d["78"]},
        {d["78"], d["41"], d["42"]},
    ]


def test_one_property_cascades_through_the_layers_of_figure_2_4() -> None:
    memory, d = _figure_2_4()
    memory.assert_fact("size", d["95"], "small")
    assert memory.name(d["95"]) == d["78"]
    assert memory.name(d["94"]) == d["34"]
    found = the_set(memory, "drum", "depot")
    assert set(names(found.local)) == {d["65"], d["34"], d["78"]}
    assert [set(names(layer)) for layer in found.layers] == [
        {d["34"], d["56"], d["23"]},
        {d["78"], d["41"], d["42"]},
    ]


def test_an_item_leaves_two_layers_by_the_one_description_in_both() -> None:
    memory = bench(DRUMS)
    d24, d23, d25, extra = see(
        memory,
        "drum",
        "depot",
        {"color": "red"},
        {"color": "red"},
        {"color": "blue"},
        {"mark": "star"},
    )
    leave(memory)
    again, d36, d37, other = see(
        memory,
        "drum",
        "depot",
        {"color": "red"},
        {"size": "big"},
        {"size": "big"},
        {"lid": "on"},
    )
    assert again == d24
    leave(memory)
    (d45,) = see(memory, "drum", "depot", {})
    memory.move(d45, "bay")
    assert memory.name(d45) == d24
    found = the_set(memory, "drum", "depot")
    assert [set(names(layer)) for layer in found.layers] == [
        {d23, d25, extra},
        {d36, d37, other},
    ]
    kept = {d.name: of(d) for layer in found.layers for d in layer}
    assert kept[d23] == {"color": "red"}
    assert kept[d37] == {"size": "big"}
    for name in (d25, d36, extra, other):
        assert set(kept[name].values()) == {"unknown"}
    (moved,) = the_set(memory, "drum", "bay").local
    assert set(of(moved).values()) == {"unknown"}
