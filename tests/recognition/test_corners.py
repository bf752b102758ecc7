"""Corners of section 7 that T does not walk into, shown on both memories."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import pytest

from rapc.base.values import Fact

from .pictures import Side, Told
from .plain_parts import Comparator, Known
from .sides import ByHand, UnderTest
from .story import DEPOT, Looked, Seen, Story, items


@pytest.fixture(params=[UnderTest, ByHand])
def side(request: pytest.FixtureRequest) -> Side:
    """Each of the two memories."""
    return cast(Side, request.param(DEPOT))


def _alike_in_two_layers(side: Side) -> Story:
    """See 1 in both layers; 6 is like 1 in the first layer, and like 4 in the second.

    Where 6 then is moved, 1 alone stands once in each layer.
    """
    story = Story(side, "drum")
    known: Looked = {"color": "red", "mark": "cross"}
    like: Looked = {"color": "red", "content": "full"}
    near: Looked = {"mark": "cross", "size": 1}
    story.see("dock", {"1": known, "2": near, "3": {"size": 2}})
    story.leave()
    seen: Seen = {"1b": known, "4": like, "5": {"is-empty": "false"}}
    assert story.see("dock", seen) == [("@1", "@1b", 30, 20)]
    story.leave()
    assert story.see("dock", {"6": like, "7": like}) == []
    return story


def test_item_leaves_by_the_member_that_stands_once_in_each_layer(side: Side) -> None:
    story = _alike_in_two_layers(side)
    side.run(9, [("move", "@6", "bay")])
    moved, *merged = side.told()
    assert moved == Told("moved", "@1", "6", "drum", "bay", "@6", 20, 30)
    assert [(each.item, each.other) for each in merged] == [("@4", "@7")]
    assert story.name("@6") == "@1"
    assert story.values("@6") == {"color": "red", "mark": "unknown", "content": "full"}
    assert story.values("@4") == {"color": "red", "mark": "unknown", "content": "full"}
    first, second = story.set("dock").layers
    assert (items(first), items(second)) == ({"@2", "@3"}, {"@4", "@5"})


def test_items_seen_side_by_side_stay_two_after_another_leaves(side: Side) -> None:
    story = _alike_in_two_layers(side)
    story.do(("move", "@6", "bay"))
    assert len({story.name(item) for item in ("@1", "@2", "@3")}) == 3


def test_members_that_are_no_candidates_complete_a_departure(side: Side) -> None:
    story = Story(side, "drum")
    first: Looked = {"color": "red", "size": 1}
    second: Looked = {"color": "blue", "size": 1, "content": "full"}
    story.see("paint-shop", {"1": first, "2": {"color": "green"}})
    story.leave()
    story.see("paint-shop", {"1b": first, "3": second})
    story.leave()
    story.see("paint-shop", {"3b": second, "4": {"color": "black"}})
    story.leave()
    like: Looked = {"size": 1, "content": "full"}
    assert story.see("paint-shop", {"5": like, "6": like}) == []
    # 1 is the best in the first layer and 3 in the others; 3 and 1 stand side by side.
    side.run(9, [("move", "@5", "bay")])
    moved, *merged = side.told()
    assert moved == Told("moved", "@1", "5", "drum", "bay", "@5", 20, 30)
    assert (story.name("@5"), story.name("@4")) == ("@1", "@1")
    assert [(e.item, e.other) for e in merged] == [("@3", "@6"), ("@2", "@3")]
    assert story.values("@6") == {"color": "green", "size": 1, "content": "full"}
    assert story.set("paint-shop").size == 1


def test_layers_that_contradict_each_other_lose_an_item_wholly(side: Side) -> None:
    story = Story(side, "drum")
    seen = {"1": "red", "2": "blue"}, {"2b": "blue", "3": "green"}
    for view in (*seen, {"1b": "red", "3b": "green"}):
        story.see("paint-shop", {label: {"color": c} for label, c in view.items()})
        story.leave()
    layers = [items(layer) for layer in story.set("paint-shop").layers]
    assert layers == [{"@1", "@2"}, {"@2", "@3"}, {"@1", "@3"}]
    story.see("paint-shop", {"4": {}})
    story.do(("move", "@4", "bay"))
    assert story.name("@4") == "@4"
    assert {each.item for each in story.set("paint-shop").layers[0]} == {"@3"}
    assert story.set("paint-shop").size == 1
    assert story.values("@3") == {"color": "green"}


def _little_known(one: Known, other: Known) -> int:
    """Score two of which nothing is known above all others."""
    return 10 if one or other else 14


@pytest.mark.parametrize("kind", [UnderTest, ByHand])
def test_comparator_scores_an_empty_description_by_no_properties(
    kind: type[UnderTest] | type[ByHand],
) -> None:
    in_python = Comparator(function=_little_known)
    declared = replace(DEPOT, comparators={("drum", None): in_python})
    story = Story(kind(declared), "drum")
    story.see("dock", {"1": {"color": "red"}})
    story.leave()
    # 3 is the one of which the first visit says nothing: so 2 is 1.
    assert story.see("dock", {"2": {"size": 1}, "3": {}}) == [("@1", "@2", 10, None)]


@pytest.mark.parametrize("names", ["abx", "axb", "bax", "bxa", "xab", "xba"])
def test_exclusion_holds_in_whatever_order_items_turn_out_to_be_one(
    side: Side, names: str
) -> None:
    story = Story(side, "drum")
    facts: dict[str, Fact] = {
        "a": ("contains", "nuts", "true"),
        "b": ("is-empty", "true"),
        "x": ("is-empty", "false"),
    }
    for visit, name in enumerate("abx", 1):
        story.see("dock", {str(visit): {}, f"{visit}0": {"mark": visit, "size": visit}})
        story.look(str(visit), *facts[name])
        story.leave()
    one = {name: f"@{visit}" for visit, name in enumerate("abx", 1)}
    assert len({story.name(label) for label in one.values()}) == 3
    for name in names:
        story.look(one[name][1:], "color", "red")
    assert len({story.name(label) for label in one.values()}) == 1
    assert story.values("@1") == {"color": "red", "is-empty": "false"}


def test_a_moved_item_keeps_what_is_known_of_itself(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red", "size": 1}})
    story.see("dock", {"2": {"color": "green", "size": 1}})
    story.leave()
    story.see("dock", {"3": {"color": "blue", "size": 1}, "4": {"size": 1}})
    story.look("1", "size", 2)
    story.look("2", "size", 2)
    story.do(("move", "@3", "bay"))
    assert story.name("@3") == "@1"
    assert story.values("@3") == {"color": "blue", "size": 1}
    assert story.values("@2") == {"color": "unknown", "size": 2}


def test_containers_that_are_one_hold_together_what_each_held(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}, "2": {"color": "blue"}}, kind="box")
    story.see("@1", {"3": {"size": 1}, "4": {"size": 2}})
    story.leave()
    story.see("dock", {"5": {}, "6": {}}, kind="box")
    story.see("@5", {"7": {"size": 2}})
    assert items(story.set("@5").local) == {"@7"}
    story.look("5", "color", "red")
    held = story.set("@1")
    assert (items(held.local), items(held.layers[0])) == ({"@4"}, {"@3", "@4"})
    assert story.name("@7") == "@4"
    assert side.picture().facts["location", "@4", "@1"] == 5


def test_layers_of_containers_that_are_one_stand_oldest_first(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}, "2": {"color": "blue"}}, kind="box")
    story.leave()
    story.see("dock", {"5": {"size": 1}, "6": {"size": 2}}, kind="box")
    story.see("@5", {"7": {"size": 3}, "8": {"size": 4}})
    story.leave()
    story.see("@1", {"3": {"size": 1}, "4": {"size": 2}})
    story.leave()
    merged = story.look("5", "color", "red")
    assert merged == [("@1", "@5", 20, 10), ("@2", "@6", 10, None)]
    layers = [items(layer) for layer in story.set("@1").layers]
    assert layers == [{"@7", "@8"}, {"@3", "@4"}]


def test_what_was_in_a_forgotten_box_does_not_come_back(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}}, kind="box")
    story.see("@1", {"2": {"size": 1}, "3": {"size": 2}})
    story.do(("assert", "contains", "@2", "@3", "true"))
    story.leave()
    story.see("@1", {"4": {}, "5": {}})
    story.do(("lose", "@1"), ("expire",))
    assert side.picture().sets == {}
    assert side.picture().facts == {}
    assert story.see("dock", {"6": {"size": 1}}) == []


def test_a_count_is_of_the_place_that_its_name_turns_out_to_be(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}}, kind="box")
    story.see("@1", {"2": {"size": 1}})
    story.leave()
    story.do(("introduce", "3", "box", "dock"), ("fix", "@3"))
    assert story.name("@3") == "@1"
    assert ("drum", "@1") not in side.picture().sets
    assert side.picture().facts["location", "@2", "unknown"] == 4


def test_an_item_like_none_is_of_no_group_that_holds_another(side: Side) -> None:
    story = Story(side, "drum")
    red: Looked = {"color": "red"}
    story.see("paint-shop", {"1": red, "2": red, "3": {"color": "blue"}})
    story.leave()
    seen: Seen = {"1b": red, "4": {"color": "green"}, "5": {}}
    assert story.see("paint-shop", seen) == [("@1", "@1b", 20, None)]
    assert story.leave() == []
    # 1 and 2 are alike, and 4 is not 1: so 4 is taken for 3.
    assert story.do(("lose", "@4")) == [("@2", "@5", 10, None)]
    assert story.name("@4") == "@3"
    assert story.values("@4") == {"color": "green"}
    assert story.values("@2") == red
    assert [items(layer) for layer in story.set("paint-shop").layers] == [{"@1", "@2"}]
