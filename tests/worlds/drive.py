"""A truck on a small map, driven by hand: what the tests of its physics share."""

from __future__ import annotations

import json
import random
from collections.abc import Mapping, Sequence
from typing import Any

from rapc.base.values import Atom, Fact, Text
from rapc.world import Reply
from rapc.worlds.truck import TruckWorld

PLACES = [
    {"name": "depot", "kind": "depot"},
    {"name": "quarry-1", "kind": "quarry", "color": "red"},
    {"name": "factory-1", "kind": "factory"},
    {"name": "warehouse", "kind": "warehouse"},
    {"name": "zone-1", "kind": "zone"},
]
ROADS = [
    {"name": "road-1", "from": "depot", "direction": "north", "to": "zone-1"},
    {"name": "road-2", "from": "zone-1", "direction": "east", "to": "quarry-1"},
    {"name": "road-3", "from": "zone-1", "direction": "west", "to": "factory-1"},
    {"name": "road-4", "from": "zone-1", "direction": "north", "to": "warehouse"},
]

STILL: dict[str, Atom | bool] = {
    "quarry-interval": 0,
    "warehouse-interval": 0,
    "depot-interval": 0,
    "factory-interval": 1_000_000,
    "gun-rounds": 15,
    "enemy-interval": 0,
    "fuel": 30,
    "lasting-names": True,
}
"""Options with which nothing happens but what the truck does; names last."""


def map_text(
    items: Sequence[Mapping[str, Any]] = (), start: str = "depot", **road: Any
) -> str:
    """A map of five places about `zone-1`; `road` changes all its roads."""
    roads = [{"time": 30, "fuel": 1, **each, **road} for each in ROADS]
    return json.dumps(
        {"start": start, "places": PLACES, "roads": roads, "items": list(items)}
    )


def rock(place: str = "depot", count: int = 1, color: str = "red") -> dict[str, Any]:
    """Rocks for `map_text`."""
    return {"kind": "rock", "place": place, "count": count, "color": color}


def thing(kind: str, place: str = "depot", count: int = 1) -> dict[str, Any]:
    """Other items for `map_text`."""
    return {"kind": kind, "place": place, "count": count}


class Driver:
    """A truck world and short ways to ask it for things."""

    def __init__(
        self,
        items: Sequence[Mapping[str, Any]] = (),
        start: str = "depot",
        seed: int = 0,
        **options: Atom | bool,
    ) -> None:
        given: dict[str, Atom | bool] = {**STILL, "arm1-drops": 0, "arm2-drops": 0}
        given["map"] = Text(map_text(items, start))
        given.update({name.replace("_", "-"): v for name, v in options.items()})
        self.world = TruckWorld(random.Random(f"{seed}:world"), given)

    def ask(self, request: str) -> Reply:
        """The reply to a request in words."""
        return self.world.perform(0, tuple(request.split()))

    def do(self, *requests: str) -> str:
        """The result of the last of some requests; those before must succeed."""
        for request in requests[:-1]:
            assert self.ask(request).result == "okay", request
        return self.ask(requests[-1]).result

    def data(self, request: str) -> tuple[Fact, ...]:
        """The data that come with a request, the clock left out."""
        reply = self.ask(request)
        assert reply.data[-1] == ("clock", self.world.now())
        return reply.data[:-1]

    def place(self, item: str) -> str:
        """Where an item truly is."""
        return self.world.state.items[item].place

    def drive(self, *directions: str) -> str:
        """Trips in some directions; the result of the last."""
        trips = [r for d in directions for r in (f"truck-turn {d}", "truck-move")]
        return self.do(*trips)


WORKSHOP: dict[str, Any] = {
    "crate": {"size": 15, "holds": 14, "indistinct": True},
    "tool-box": {"size": 11, "holds": 8},
    "jug": {"size": 3, "capacity": 4, "liquid": "water", "full": False},
    "tank": {"size": 400, "capacity": 50, "liquid": "water", "fixed": True},
    "ice": {"size": 1},
    "ice-machine": {
        "size": 200,
        "capacity": 10,
        "liquid": "water",
        "full": False,
        "fixed": True,
        "machine": {"makes": "ice", "every": 12, "uses": 2},
    },
    "wrench": {"size": 2, "mends": ["ice-machine"]},
    "bandage": {"size": 1},
    "kit": {"size": 4},
    "assembler": {
        "size": 20,
        "holds": 10,
        "machine": {"makes": "kit", "every": 5, "needs": {"bandage": 2, "ice": 1}},
    },
}
"""Kinds for maps with containers and machines."""


def workshop(*items: Mapping[str, Any], start: str = "depot", **more: Any) -> Driver:
    """A driver on the small map with the kinds above and some items."""
    kinds = {**WORKSHOP, **more.pop("kinds", {})}
    ground = {**json.loads(map_text(items, start)), "kinds": kinds}
    return Driver(map=Text(json.dumps(ground)), **more)
