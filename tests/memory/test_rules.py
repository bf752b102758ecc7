"""Memory beyond the examples of T: comparators, stamps, forgetting."""

from __future__ import annotations

import pytest

from rapc import events
from rapc.errors import FactError
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.memory.recognition.scoring import DescribedItem

from .sightings import DRUMS, WORDS, bench, leave, merges, names, see, the_set, values

VETO = DRUMS + "(declare-class-comparator drum (veto color) (score size 30))\n"


def test_a_vetoing_property_keeps_descriptions_apart() -> None:
    memory = bench(VETO)
    (red,) = see(memory, "drum", "depot", {"color": "red"})
    leave(memory)
    (blue,) = see(memory, "drum", "depot", {"color": "blue"})
    assert memory.name(blue) != red
    assert merges(memory) == []
    memory.assert_fact("color", blue, "red")
    assert memory.name(blue) == red


def test_weights_say_what_a_shared_property_counts() -> None:
    memory = bench(VETO)
    big, _ = see(memory, "drum", "depot", {"size": 9}, {"content": "full"})
    leave(memory)
    new, _ = see(memory, "drum", "depot", {"size": 9}, {})
    assert new == big
    assert merges(memory)[0][2:] == (40, 10)


def test_a_comparator_in_python_compares_by_name_and_place() -> None:
    asked: list[tuple[str, object]] = []

    def by_mark(one: DescribedItem, other: DescribedItem) -> int:
        asked.append((one.kind, one.place))
        return 50 if one.properties == other.properties else 0

    text = WORDS + "(declare-indistinct-class drum by-mark)\n"
    memory = bench(text, comparators={"by-mark": by_mark})
    old = see(memory, "drum", "depot", {"mark": "x"}, {"mark": "y"})
    leave(memory)
    new = see(memory, "drum", "depot", {"mark": "y"}, {"mark": "x"})
    assert new == [old[1], old[0]]
    assert set(asked) == {("drum", "depot")}
    assert {score for _, _, score, _ in merges(memory)} == {50}


def test_comparator_of_three_arguments_sees_memory_and_ages() -> None:
    def by_news(one: DescribedItem, other: DescribedItem, memory: MemoryView) -> int:
        age = memory.age("shuffled", "depot")
        return 50 if age is None or age > 5 else 0

    text = WORDS + (
        "(declare-memory-proposition shuffled (?place))\n"
        "(declare-indistinct-class drum by-news)\n"
    )
    for shuffled, same in (("never", True), ("before", True), ("just now", False)):
        memory = bench(text, comparators={"by-news": by_news})
        (old,) = see(memory, "drum", "depot", {"mark": "x"})
        if shuffled == "before":
            memory.assert_fact("shuffled", "depot")
        leave(memory)  # takes 10 time units
        if shuffled == "just now":
            memory.assert_fact("shuffled", "depot")
        (new,) = see(memory, "drum", "depot", {"mark": "x"})
        assert (new == old) == same


def test_a_comparator_for_a_place_goes_before_that_of_the_class() -> None:
    memory = bench(VETO + "(declare-class-comparator drum painter (ignore color))\n")
    (red,) = see(memory, "drum", "painter", {"color": "red"})
    leave(memory)
    (blue,) = see(memory, "drum", "painter", {"color": "blue"})
    assert blue == red
    assert memory.memory.value("color", red) == "blue"


def test_the_newest_value_stays_with_its_stamp() -> None:
    memory = bench(DRUMS)
    (old,) = see(memory, "drum", "depot", {"color": "red", "size": "big"})
    leave(memory)
    (new,) = see(memory, "drum", "depot", {"color": "blue"})
    assert new == old
    (only,) = the_set(memory, "drum", "depot").local
    assert only.properties == {("color",): ("blue", 10), ("size",): ("big", 0)}


def test_both_names_are_one_item_in_every_fact() -> None:
    memory = bench(DRUMS)
    (box,) = see(memory, "box", "depot", {})
    (old,) = see(memory, "drum", "depot", {"mark": "x"})
    leave(memory)
    with memory.batch():
        new = memory.introduce("again", "drum", "depot")
        memory.assert_fact("near", box, new)
        memory.assert_fact("contains", box, new, "true")
    assert memory.name(new) == old != new
    assert memory.memory.query("near", box, None) == [("near", box, old)]
    assert memory.memory.value("contains", box, new) == "true"
    memory.assert_fact("lid", new, "on")
    assert memory.memory.value("lid", old) == "on"


def test_containers_that_turn_out_to_be_one_merge_what_is_in_them() -> None:
    memory = bench(WORDS + "".join(f"(declare-indistinct-class {c})" for c in _KINDS))
    (old,) = see(memory, "box", "depot", {"mark": "x"})
    see(memory, "drum", old, {"color": "red"}, first=5)
    leave(memory)
    new, _ = see(memory, "box", "depot", {}, {"mark": "z"})
    (inside,) = see(memory, "drum", new, {"color": "red"}, first=5)
    assert memory.name(new) == new
    memory.assert_fact("mark", new, "x")
    assert memory.name(new) == old
    (drum,) = the_set(memory, "drum", old).local
    assert drum.name == memory.name(inside) != inside
    assert memory.memory.value("location", inside) == old


_KINDS = ("box", "drum")


def test_an_item_lost_is_forgotten_when_the_robot_next_moves() -> None:
    memory = bench(DRUMS)
    (drum,) = see(memory, "drum", "depot", {"color": "red"})
    memory.lose(drum)
    assert memory.memory.value("location", drum) == "unknown"
    assert memory.memory.value("color", drum) == "red"
    leave(memory)
    assert memory.memory.value("location", drum) is None
    assert memory.sets() == ()
    with pytest.raises(FactError):
        memory.move(drum, "bay")


def test_a_set_keeps_as_many_layers_as_it_may() -> None:
    memory = bench(DRUMS, max_layers=2)
    for at in range(4):
        see(memory, "drum", "depot", {"mark": f"{at}a"}, {"mark": f"{at}b"})
        leave(memory)
    found = the_set(memory, "drum", "depot")
    marks = [[values(d)["mark"] for d in layer] for layer in found.layers]
    assert marks == [["2a", "2b"], ["3a", "3b"]]
    assert len(memory.memory.query("mark", None, None)) == 4


def test_a_visit_that_taught_nothing_leaves_no_layer() -> None:
    memory = bench(DRUMS)
    old = see(memory, "drum", "depot", {"color": "red"}, {"color": "blue"})
    leave(memory)
    for _ in range(3):
        see(memory, "drum", "depot", {"color": "blue"}, {"color": "red"})
        leave(memory)
        (layer,) = the_set(memory, "drum", "depot").layers
        assert names(layer) in (old, old[::-1])


def test_an_items_place_and_class_are_not_set_by_hand() -> None:
    memory = bench(DRUMS)
    (drum,) = see(memory, "drum", "depot", {})
    for fact in (("location", drum, "bay"), ("class", drum, "drum", "false")):
        with pytest.raises(FactError):
            memory.assert_fact(*fact)
        with pytest.raises(FactError):
            memory.erase(*fact[:2])
    with pytest.raises(FactError):
        memory.erase("location")
    memory.assert_fact("class", drum, "vessel", "true")
    assert values(the_set(memory, "drum", "depot").local[0]) == {"class": "true"}


def test_an_empty_box_holds_nothing_whichever_is_said_first() -> None:
    memory = bench(WORDS)
    memory.assert_fact("contains", "b", "bars", "true")
    memory.assert_fact("is-empty", "b", "true")
    assert memory.memory.query("contains", None, None, None) == []
    memory.assert_fact("contains", "b", "bars", "true")
    assert memory.memory.value("is-empty", "b") is None
    memory.assert_fact("contains", "b", "nuts", "false")
    memory.assert_fact("is-empty", "b", "false")
    assert memory.memory.value("contains", "b", "bars") == "true"


def test_what_is_seen_again_somewhere_else_has_moved() -> None:
    memory = bench(DRUMS)
    drum = memory.introduce("s", "drum", "depot")
    assert memory.introduce("s", "drum", "bay") == drum
    assert memory.count("drum", "depot") == 0
    assert memory.count("drum", "bay") == 1
    assert [type(e).__name__ for e in memory.events if "Item" in type(e).__name__] == [
        "ItemIntroduced",
        "ItemMoved",
    ]


@pytest.mark.parametrize("kind", ["drum", "gun"])
def test_moving_an_item_to_its_own_place_emits_no_event(kind: str) -> None:
    memory = bench(DRUMS)
    item = memory.introduce("s", kind, "depot")
    memory.move(item, "depot")
    assert [e for e in memory.events if isinstance(e, events.ItemMoved)] == []
    memory.move(item, "bay")
    memory.move(item, "bay")
    moved = [e.location for e in memory.events if isinstance(e, events.ItemMoved)]
    assert moved == ["bay"]


def test_the_trace_says_what_left_a_set_and_how_well_it_matched() -> None:
    memory = bench(DRUMS)
    old = see(memory, "drum", "depot", {"color": "red"}, {"color": "blue"})
    leave(memory)
    (new,) = see(memory, "drum", "depot", {})
    memory.move(new, "bay")
    (moved,) = [e for e in memory.events if isinstance(e, events.ItemMoved)]
    assert (moved.item, moved.with_, moved.score, moved.rival) == (old[0], new, 10, 10)
