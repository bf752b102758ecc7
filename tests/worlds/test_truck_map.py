"""Maps and options: what is accepted, and how the rest is refused."""

from __future__ import annotations

import json
import random
from typing import Any

import pytest

from rapc.base.values import Text
from rapc.worlds.maps import MapError, shipped_map
from rapc.worlds.truck import TruckWorld
from rapc.worlds.truck.map import opposite
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.options import TruckSettings, describe_options, read_settings

from .drive import PLACES, ROADS, map_text, rock, thing


def changed(**parts: Any) -> str:
    return json.dumps({**json.loads(map_text()), **parts})


def road(**parts: Any) -> list[dict[str, Any]]:
    return [{**ROADS[0], "time": 30, "fuel": 1, **parts}]


BOX = {"box": {"size": 12, "holds": 11}}


def kinds(**more: Any) -> str:
    return changed(kinds=more)


def tank(**parts: Any) -> dict[str, Any]:
    return {"size": 9, "capacity": 5, "liquid": "tea", **parts}


def mill(**parts: Any) -> dict[str, Any]:
    return {"size": 90, "machine": {"makes": "gun-tool", "every": 5, **parts}}


def sectors(*spots: list[str]) -> str:
    rows = [{"name": f"s{n}", "spots": s} for n, s in enumerate(spots, 1) if s]
    return changed(sectors=rows or [{"name": "s1"}])


def test_default_map_has_all_places_of_the_thesis() -> None:
    made = read_map(shipped_map("truck", "default"))
    kinds = [place.kind for place in made.places]
    counts = {kind: kinds.count(kind) for kind in kinds}
    assert counts == {
        "factory": 3,
        "zone": 6,
        "quarry": 3,
        "warehouse": 1,
        "depot": 1,
    }
    assert {place.color for place in made.places} == {None, "red", "blue", "yellow"}
    for place in made.places:
        assert any(True for _ in made.legs(place.name)), place.name


def test_the_default_map_lies_as_its_directions_say() -> None:
    """Walking the roads by their directions gives every place one spot on a plane."""
    made = read_map(shipped_map("truck", "default"))
    north = {"north": 1, "northeast": 1, "northwest": 1}
    north |= {"south": -1, "southeast": -1, "southwest": -1}
    heights: dict[str, int] = {}
    rows = {"1": 2, "2": 2, "3": 1, "4": 1, "5": 0, "6": 0}
    for place in made.places:
        if place.kind == "zone":
            heights[place.name] = rows[place.name[-1]]
        elif place.kind in ("quarry", "factory"):
            heights[place.name] = 3 - int(place.name[-1])
    heights |= {"warehouse": 3, "depot": -1}
    for way in made.roads:
        rise = heights[way.b] - heights[way.a]
        assert rise == north.get(way.direction, 0), way.name


def test_opposites_are_half_a_turn_apart() -> None:
    assert opposite("north") == "south"
    assert opposite(opposite("southwest")) == "southwest"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "cannot be read: input data was truncated"),
        ("[1]", "cannot be read: expected `object`, got `array`"),
        ('{"start": "depot"}', "missing required field `places`"),
        (changed(colour="red"), "unknown field `colour`"),
        (changed(start="dpot"), "the start is `dpot`, which is unknown; did you mean"),
        (changed(heading="up"), "invalid enum value 'up'"),
        (changed(roads=road(to="moon")), "an end of `road-1` is `moon`"),
        (changed(roads=road(to="depot")), "`road-1` leads from `depot` to itself"),
        (changed(roads=road(time=0)), "`road-1` must take time"),
        (changed(roads=road(fuel=-1)), "`road-1` must take time, and no less fuel"),
        (changed(roads=road(mishap=2)), "`road-1`: the chance of a mishap"),
        (changed(roads=road(name="bay1")), "`bay1` cannot be the name"),
        (changed(roads=road(name="zone-1")), "`zone-1` stands for two"),
        (
            changed(roads=[*road(), *road(name="road-9")]),
            "both lead north from `depot`",
        ),
        (changed(places=[*PLACES, {"name": "Q", "kind": "zone"}]), "matching regex"),
        (changed(items=[rock("nowhere")]), "the place of a `rock` is `nowhere`"),
        (changed(items=[thing("drum")]), "an item's kind is `drum`"),
        (
            changed(items=[thing("rock")]),
            "`rock` at `depot`: rocks alone have a colour",
        ),
        (
            changed(places=[*PLACES, {"name": "q", "kind": "quarry"}]),
            "`q`: quarries alone have",
        ),
        (changed(roads=road(mud=-1)), "`road-1`: the chance of a mishap"),
        (changed(places=[*PLACES, {"name": "rock-7", "kind": "zone"}]), "`rock-7`"),
        (changed(places=[*PLACES, {"name": "gun-s1", "kind": "zone"}]), "`gun-s1`"),
        (kinds(east={}), "missing required field `size`"),
        (kinds(east={"size": 1}), "`east` cannot be the name of a kind"),
        (kinds(rock={"size": 1}), "`rock` cannot be the name of a kind"),
        (kinds(box={"size": 4, "holds": 4}), "`box` cannot hold as much as it is"),
        (kinds(jug={"size": 4, "capacity": 4}), "a capacity goes with a liquid"),
        (kinds(jug={"size": 4, "liquid": "tea"}), "a capacity goes with a liquid"),
        (kinds(jug=tank(rounds="ammo")), "`jug` is a vessel or a weapon"),
        (kinds(saw={"size": 4, "tool": "gun"}), "`saw` can only need a `gun-tool`"),
        (kinds(mill=mill(makes="flour")), "what a `mill` makes or needs is `flour`"),
        (kinds(mill=mill(makes="rock")), "a `mill` cannot make a `rock`"),
        (kinds(mill=mill(makes="enemy-unit")), "cannot make a `enemy-unit`"),
        (kinds(mill=mill(every=0)), "a `mill` cannot work every 0 time units"),
        (kinds(mill=mill(uses=3)), "uses up a liquid that it cannot contain"),
        (kinds(mill=mill(needs={"gun": 1})), "a `mill` cannot hold what it needs"),
        (kinds(key={"size": 1, "mends": ["mil"]}), "what a `key` mends is `mil`"),
        (
            kinds(key={"size": 1, "mends": ["gun"]}),
            "repairs machines, and `gun` is not",
        ),
        (changed(items=[{**thing("gun"), "broken": True}]), "be broken, not a `gun`"),
        (
            changed(items=[thing("gun-tool", "box-1"), thing("box")], kinds=BOX),
            "the place of a `gun-tool` is `box-1`",
        ),
        (
            changed(items=[thing("box"), thing("gun-tool", "box-1", 3)], kinds=BOX),
            "`box-1` cannot hold all that lies in it",
        ),
        (sectors([]), "missing required field"),
        (sectors(["zone-1"], ["zone-1"]), "`zone-1` is in two sectors"),
        (sectors(["zone-9"]), "part of the sector `s1` is `zone-9`"),
        (
            changed(sectors=[{"name": "s", "spots": []}] * 2),
            "`s` stands for two sectors",
        ),
    ],
)
def test_invalid_map_is_refused(text: str, message: str) -> None:
    with pytest.raises(MapError, match=r"[^\n]+") as caught:
        read_map(text)
    assert message in str(caught.value)


def test_a_world_says_which_option_is_to_blame() -> None:
    with pytest.raises(ValueError, match=r"^`map`: cannot be read"):
        TruckWorld(random.Random(0), {"map": Text("{")})
    with pytest.raises(ValueError, match=r"^`orders`: `zone-1` is no factory"):
        TruckWorld(random.Random(0), {"orders": Text('[[0, "red", 4, "zone-1"]]')})
    with pytest.raises(ValueError, match=r"^`orders`: "):
        TruckWorld(random.Random(0), {"orders": Text('[[0, "green", 4, "depot"]]')})
    with pytest.raises(ValueError, match="`fuel` is more than `fuel-capacity`"):
        TruckWorld(random.Random(0), {"fuel": 31})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"arm1-drops": 101}, "`arm1-drops` must be between 0 and 100"),
        ({"quarry-interval": -1}, "`quarry-interval` must be between 0 and"),
        ({"depot-interval": 0.5}, "`depot-interval` must be 0 or at least 1"),
        ({"item-limit": "many"}, "expected `int`, got `str` - at `item-limit`"),
    ],
)
def test_an_option_out_of_range_is_refused(options: Any, message: str) -> None:
    with pytest.raises(ValueError, match=r"[^\n]+") as caught:
        read_settings(options)
    assert message in str(caught.value)


def test_every_option_is_described_once_with_its_default() -> None:
    described = {option.name: option for option in describe_options()}
    assert len(described) == len(TruckSettings.__struct_fields__)
    assert described["arm2-capacity"].default == 15
    assert described["arm2-capacity"].unit == "size"
    assert described["item-limit"].kind == "integer"
    assert described["map"].default == Text("")
    assert all(option.doc for option in described.values())
    defaults = {name: option.default for name, option in described.items()}
    assert read_settings(defaults) == TruckSettings()
