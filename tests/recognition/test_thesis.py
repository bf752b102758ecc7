"""The worked examples of T 2.3, number by number, told to both memories.

Items have the numbers of T where it gives them. Figures 2.4 and the two-layer removal
show names only; the properties here are chosen so that nothing more is recognised.
"""

from __future__ import annotations

from typing import cast

import pytest

from .pictures import Side
from .sides import ByHand, UnderTest
from .story import DEPOT, Looked, Seen, Story, items, tally


@pytest.fixture(params=[UnderTest, ByHand])
def side(request: pytest.FixtureRequest) -> Side:
    """Each of the two memories."""
    return cast(Side, request.param(DEPOT))


# --- figure 2.3: two boxes in the warehouse -----------------------------------------


def two_boxes(side: Side) -> Story:
    """A big red box and a small red one with bars; later two that are empty."""
    story = Story(side, "box")
    big = {"color": "red", "size": "big", "is-empty": "true"}
    story.see("warehouse", {"12": big, "17": {"color": "red", "size": "small"}})
    story.look("17", "contains", "bars", "true")
    story.leave()
    assert story.see("warehouse", {"45": {}, "46": {}}) == []
    return story


def test_two_boxes_score_10_with_both_until_a_size_scores_20(side: Side) -> None:
    story = two_boxes(side)
    assert story.look("45", "is-empty", "true") == []
    assert story.look("46", "is-empty", "true") == []
    assert story.look("45", "size", "big") == [
        ("@12", "@45", 20, 10),
        ("@17", "@46", 10, None),
    ]
    assert story.set("warehouse").layers == ()
    assert story.set("warehouse").size == 2


def test_the_small_red_box_is_empty_once_merged(side: Side) -> None:
    story = two_boxes(side)
    story.look("46", "is-empty", "true")
    story.look("45", "size", "big")
    small = {"color": "red", "size": "small", "is-empty": "true"}
    assert story.name("@46") == "@17"
    assert story.values("@46") == small
    assert story.values("@45") == {"color": "red", "size": "big", "is-empty": "true"}
    stamps = side.picture().facts
    assert stamps["color", "@17", "red"] == 1
    assert stamps["is-empty", "@17", "true"] == 5


# --- 2.3.1: layers --------------------------------------------------------------------


def test_red_and_blue_wait_beside_full_and_empty(side: Side) -> None:
    story = Story(side, "drum")
    story.see("warehouse", {"1": {"color": "red"}, "2": {"color": "blue"}})
    story.leave()
    seen = {"3": {"content": "full"}, "4": {"content": "empty"}}
    assert story.see("warehouse", seen) == []
    assert story.leave() == []
    first, second = story.set("warehouse").layers
    assert (items(first), items(second)) == ({"@1", "@2"}, {"@3", "@4"})
    assert story.set("warehouse").size == 2
    assert story.see("warehouse", {"5": {"color": "red"}, "6": {}}) == [
        ("@1", "@5", 20, 10),
        ("@2", "@6", 10, None),
    ]
    assert story.look("5", "content", "full") == [
        ("@1", "@3", 20, 10),
        ("@2", "@4", 10, None),
    ]
    assert story.values("@6") == {"color": "blue", "content": "empty"}
    assert story.set("warehouse").layers == ()


# --- 2.3: the fuel depot --------------------------------------------------------------


def test_the_papers_are_in_the_drum_that_is_left(side: Side) -> None:
    story = Story(side, "drum")
    empty = {"is-empty": "true"}
    story.see("depot", {"1": {"is-empty": "false"}, "2": empty, "3": empty})
    story.look("3", "contains", "papers", "true")
    assert story.values("@3") == {"contains papers": "true"}
    story.leave()
    assert story.see("depot", {"4": {}, "5": {}, "6": {}}) == []
    assert story.look("4", "is-empty", "false") == [("@1", "@4", 20, 10)]
    assert story.look("5", "is-empty", "true") == [
        ("@2", "@5", 20, 10),
        ("@3", "@6", 10, None),
    ]
    assert story.values("@6") == {"contains papers": "true"}


# --- figure 2.4: a cascade through three layers ---------------------------------------


def figure_2_4(side: Side) -> Story:
    """34, 56, 23; then 34, 65, 78; then 78 and two others; now 65, 94 and 95."""
    story = Story(side, "drum")
    red, blue = {"color": "red"}, {"color": "blue"}
    story.see("warehouse", {"34": {"mark": "cross"}, "56": red, "23": blue})
    story.leave()
    full, empty = {"content": "full"}, {"content": "empty"}
    seen: Seen = {"34b": {"mark": "cross"}, "65": full, "78": empty}
    assert story.see("warehouse", seen) == [("@34", "@34b", 20, 10)]
    story.leave()
    seen = {"78b": empty, "81": {"size": 1}, "82": {"size": 2}}
    assert story.see("warehouse", seen) == [("@78", "@78b", 20, 10)]
    story.leave()
    seen = {"65b": full, "94": {}, "95": {}}
    assert story.see("warehouse", seen) == [("@65", "@65b", 20, 10)]
    return story


def test_figure_2_4_is_at_rest(side: Side) -> None:
    now = figure_2_4(side).set("warehouse")
    assert items(now.local) == {"@65", "@94", "@95"}
    assert [items(layer) for layer in now.layers] == [
        {"@34", "@56", "@23"},
        {"@34", "@65", "@78"},
        {"@78", "@81", "@82"},
    ]


def test_one_property_cascades_and_a_layer_goes(side: Side) -> None:
    story = figure_2_4(side)
    assert story.look("95", "content", "empty") == [
        ("@78", "@95", 20, 10),
        ("@34", "@94", 10, None),
    ]
    now = story.set("warehouse")
    assert items(now.local) == {"@34", "@65", "@78"}
    assert [items(layer) for layer in now.layers] == [
        {"@34", "@56", "@23"},
        {"@78", "@81", "@82"},
    ]


def test_what_follows_leaves_one_layer_and_then_none(side: Side) -> None:
    story = figure_2_4(side)
    story.look("95", "content", "empty")
    assert story.look("94", "size", 1) == [
        ("@34", "@81", 20, 10),
        ("@65", "@82", 10, None),
    ]
    now = story.set("warehouse")
    assert [items(layer) for layer in now.layers] == [{"@34", "@56", "@23"}]
    assert story.look("65", "color", "blue") == [
        ("@23", "@65", 20, 10),
        ("@56", "@78", 10, None),
    ]
    assert story.set("warehouse").layers == ()
    assert story.values("@82") == {"color": "blue", "content": "full", "size": 2}


# --- 2.3.3: moving an item out of a set -----------------------------------------------


def test_the_sack_of_boxes_of_figure_2_5(side: Side) -> None:
    story = Story(side, "box")
    big, small = {"color": "red", "size": "big"}, {"color": "red", "size": "small"}
    story.see("sack", {"34": big, "37": big, "42": small})
    story.leave()
    assert story.see("sack", {"93": {"color": "red"}}) == []
    story.do(("move", "@93", "bay"))
    (left,) = story.set("sack").layers
    assert items(left) == {"@37", "@42"}
    assert story.values("@37") == big
    assert story.values("@42") == {"color": "red", "size": "unknown"}
    assert story.name("@93") == "@34"
    assert story.values("@93") == {"color": "red", "size": "unknown"}
    assert items(story.set("bay").local) == {"@34"}
    stamps = side.picture().facts
    assert stamps["size", "@42", "unknown"] is None
    assert stamps["color", "@42", "red"] == 1


def test_ten_blue_drums_of_which_one_is_taken_unseen(side: Side) -> None:
    story = Story(side, "drum")
    drums = {
        str(at): {"color": "blue", "content": "full" if at < 5 else "empty"}
        for at in range(10)
    }
    story.see("box", drums)
    story.leave()
    story.see("box", {"taken-0": {}})
    story.do(("move", "@taken-0", "bay"))
    (left,) = story.set("box").layers
    blue = ("blue", "unknown")
    four = {("blue", "full"): 4, ("blue", "empty"): 4, blue: 1}
    assert tally(left, "color", "content") == four
    assert tally(story.set("bay").local, "color", "content") == {blue: 1}
    for at in range(1, 5):
        story.see("box", {f"taken-{at}": {}})
        story.do(("move", f"@taken-{at}", "bay"))
    (left,) = story.set("box").layers
    assert tally(left, "color", "content") == {blue: 5}
    assert tally(story.set("bay").local, "color", "content") == {blue: 5}


def test_an_item_leaves_two_layers_by_the_one_that_stands_in_both(side: Side) -> None:
    story = Story(side, "drum")
    one: Looked = {"color": "red", "size": 1}
    two: Looked = {"color": "red", "size": 2}
    full: Looked = {"color": "red", "content": "full"}
    first = {"24": one, "23": one, "25": two, "26": {"content": "full"}}
    story.see("dock", first)
    story.leave()
    seen = {"24b": one, "36": full, "37": full, "38": {"color": "green"}}
    assert story.see("dock", seen) == [("@24", "@24b", 30, 20)]
    story.leave()
    assert story.see("dock", {"45": {"color": "red"}}) == []
    assert story.do(("move", "@45", "bay")) == []
    layers = [items(layer) for layer in story.set("dock").layers]
    assert layers == [{"@23", "@25", "@26"}, {"@36", "@37", "@38"}]
    assert story.values("@23") == one
    assert story.values("@37") == full
    unsure = {"color": "red", "size": "unknown", "content": "unknown"}
    assert story.values("@25") == unsure
    assert story.values("@36") == unsure
    assert story.name("@45") == "@24"
    assert story.values("@45") == unsure


# --- 2.3.3: how many there are --------------------------------------------------------


def test_a_count_goes_up_with_each_item_that_was_not_expected(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}, "2": {"color": "blue"}})
    story.leave()
    story.see("dock", {"3": {}, "4": {}})
    assert story.set("dock").size == 2
    story.see("dock", {"5": {}})
    assert story.set("dock").size == 3
    assert items(story.set("dock").layers[0]) == {"@1", "@2", None}
    assert story.look("3", "color", "red") == [("@1", "@3", 20, 10)]
    assert story.look("4", "color", "blue") == [("@2", "@4", 20, 10)]
    assert story.set("dock").layers == ()
    assert items(story.set("dock").local) == {"@1", "@2", "@5"}


def test_a_count_goes_down_once_all_there_is_has_been_seen(side: Side) -> None:
    story = Story(side, "drum")
    story.see("dock", {"1": {"color": "red"}, "2": {"color": "blue"}})
    story.leave()
    seen = ("introduce", "3", "drum", "dock"), ("assert", "color", "@3", "red")
    assert story.do(("fix", "dock"), *seen) == [("@1", "@3", 20, 10)]
    assert story.set("dock").size == 1
    assert side.picture().facts["location", "@2", "unknown"] == 3
    story.leave()
    assert not any("@2" in fact for fact in side.picture().facts)


def test_a_count_goes_down_without_knowing_which_is_gone(side: Side) -> None:
    story = Story(side, "drum")
    red: Looked = {"color": "red", "size": 1}
    blue: Looked = {"color": "blue", "size": 1}
    story.see("dock", {"1": red, "2": blue})
    story.leave()
    story.see("dock", {"3": {}})
    assert story.do(("fix", "dock")) == [("@2", "@3", 10, None)]
    assert story.set("dock").size == 1
    assert story.values("@3") == {"color": "unknown", "size": 1}
