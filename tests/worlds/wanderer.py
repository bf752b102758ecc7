"""A robot without a mind, in a world where everything that can go on goes on.

It asks at random for things, about what the sensors have told it: so it gets far, and
into each other's way comes all that a truck can do and suffer.
"""

from __future__ import annotations

import json
import random

from rapc.base.pictures import DIRECTIONS
from rapc.base.values import Atom, Fact, Text
from rapc.world import Reply
from rapc.worlds.truck import TruckWorld
from rapc.worlds.truck.kinds import ENEMY, KINDS
from rapc.worlds.truck.primitives import OFFER
from rapc.worlds.truck.state import ARMS, BAYS, TruckState

from .drive import WORKSHOP, map_text, rock, thing

ITEMS = [
    rock(count=3),
    rock("zone-1"),
    rock("road-1"),
    rock("factory-1"),
    thing("fuel-drum", count=2),
    thing("ammo-box"),
    thing("gun"),
    thing("gun-tool"),
    thing("crate", count=2),
    thing("tool-box", "crate-1"),
    thing("jug", "tool-box-1"),
    thing("jug", count=4),
    thing("tank"),
    thing("tank", "zone-1", count=2),
    thing("ice-machine"),
    {**thing("ice-machine"), "broken": True},
    thing("wrench"),
    thing("assembler"),
    thing("bandage", count=4),
    thing("bandage", "assembler-1", count=3),
]
LAND = json.dumps(
    {
        **json.loads(map_text(ITEMS, mishap=0.05, mud=0.01)),
        "kinds": WORKSHOP,
        "sectors": [
            {"name": "south", "spots": ["depot", "road-1", "zone-1"]},
            {"name": "north", "spots": ["warehouse", "road-4"], "dark": True},
        ],
    }
)
HARDEST: dict[str, Atom | bool] = {
    "map": Text(LAND),
    "quarry-interval": 5,
    "warehouse-interval": 7,
    "depot-interval": 4,
    "factory-interval": 6,
    "item-limit": 6,
    "shuffle-interval": 8,
    "shuffle-efficiency": 100,
    "shuffle-tools": True,
    "enemy-interval": 20,
    "enemy-stay": 30,
    "enemy-sectors": Text("south,north"),
    "capture-time": 40,
    "wear": 30,
    "rain": 50,
    "weather-interval": 20,
    "day-length": 80,
    "fuel": 3,
}
"""Options with which everything goes on at once, and fast."""

LONG: dict[str, float] = {
    "fuel_use": 0,
    "capture_time": 0,
    "shuffle_efficiency": 5,
    "quarry_interval": 60,
    "warehouse_interval": 60,
    "depot_interval": 20,
}
"""What of them is changed for long walks: calmer, and the truck lasts."""

MORTAL = frozenset({"rock", "fuel-drum", ENEMY, "bandage", "ice"})
"""Kinds whose items somebody may take away or use up."""

HOLDS = {name: kind["holds"] for name, kind in WORKSHOP.items() if "holds" in kind}
SIZES = {name: kind.size for name, kind in KINDS.items()} | {
    name: kind["size"] for name, kind in WORKSHOP.items()
}
CAPACITIES = {name: kind.capacity for name, kind in KINDS.items()} | {
    name: kind.get("capacity", 0) for name, kind in WORKSHOP.items()
}
ROOM = {"arm1": 8, "arm2": 15, "bay1": 20, "bay2": 100, "weapon-bay": 10}
PLACES = ("depot", "quarry-1", "factory-1", "warehouse", "zone-1")
ROADS = ("road-1", "road-2", "road-3", "road-4")


class Wanderer:
    """Asks a world at random, by the sensor names it was told since the last trip."""

    def __init__(self, world: TruckWorld, dice: random.Random) -> None:
        self.world = world
        self.dice = dice
        self.names: list[str] = ["gun-1", "nothing"]
        self.plan: list[Fact] = []

    def request(self) -> Fact:
        """The next step of what was begun, or any step of something else."""
        if not self.plan or self.dice.random() < 0.1:
            self.plan = self.begin()
            if self.dice.random() < 0.3:
                self.plan = [self.dice.choice(self.plan)]
        return self.plan.pop(0)

    def begin(self) -> list[Fact]:
        """Steps that a truck takes one after the other."""
        dice = self.dice
        arm, other = dice.sample(ARMS, 2)
        item, second = dice.choice(self.names), dice.choice(self.names)
        spot = dice.choice(["external", "external", "folded", *BAYS, *ARMS, second])
        place = dice.choice([*["external"] * 4, *BAYS])
        act = dice.choice(["arm-pour", "arm-ladle", "arm-toggle", "arm-examine"])
        watch = dice.choice(["eye-monitor", "eye-unmonitor"])
        take: list[Fact] = [
            ("arm-move", arm, place),
            ("arm-move", arm, item),
            ("arm-grasp", arm, item),
        ]
        go: list[Fact] = [
            ("arm-move", arm, "folded"),
            ("arm-move", other, "folded"),
            ("truck-turn", dice.choice([*DIRECTIONS[::2], "up"])),
            ("truck-move",),
        ]
        put: list[Fact] = [("arm-move", arm, spot), ("arm-ungrasp", arm, item)]
        use: list[Fact] = [("arm-move", arm, second), (act, arm, item)]
        fill: list[Fact] = [("arm-ladle", arm, item), ("arm-pour", arm, item)]
        quarrel: list[Fact] = [("arm-move", other, place), ("arm-move", other, item)]
        look: list[Fact] = [("eye-scan", spot), ("eye-examine", spot, item)]
        errands: list[list[Fact]] = [
            go,
            [*take, *put],
            [*take, ("arm-move", arm, place), *use, *put],
            [*take, ("arm-move", arm, second), *fill],
            [*take[:2], (act, arm, item)],
            [*take[:2], *quarrel, take[2], ("arm-grasp", other, item)],
            look,
            [("eye-scan", "external")],
            [("truck-speed", dice.choice(["slow", "medium", "fast", "wild"]))],
            [(watch, dice.choice(["rock", "fuel-drum", ENEMY]))],
        ]
        return dice.choice(errands)

    def step(self) -> tuple[Fact, Reply]:
        """Ask once, see that the answer is a proper one, and learn from it."""
        request = self.request()
        before = self.world.now()
        reply = self.world.perform(0, request)
        assert reply.result in OFFER.primitives[str(request[0])][1]
        assert self.world.now() >= before
        for datum in reply.data:
            assert OFFER.data[str(datum[0])] == len(datum) - 1
        self.learn(reply)
        return request, reply

    def learn(self, reply: Reply) -> None:
        """Keep in mind the last dozen names, and forget all when somewhere else."""
        for name, *rest in reply.data:
            if name == "new-location":
                self.names = ["gun-1"]
            elif name == "object-seen" and rest[1] not in self.names:
                self.names = [*self.names[-11:], str(rest[1])]


def check(state: TruckState) -> None:
    """What holds of every state of that world."""
    items = state.items
    assert sum(state.made.values()) == len(items) + state.gone
    inside: dict[str, int] = {}
    for name, item in items.items():
        assert name == item.name
        assert 0 <= item.amount <= CAPACITIES[item.kind]
        inside[item.place] = inside.get(item.place, 0) + SIZES[item.kind]
        holder = items.get(item.place)
        if holder is not None:
            assert SIZES[item.kind] < SIZES[holder.kind]
        else:
            assert item.place in (*PLACES, *ROADS, *ROOM)
        if item.kind == ENEMY:
            assert item.place in PLACES
            assert item.place not in ("warehouse", "depot")
    for place, size in inside.items():
        if place in items:
            assert size <= HOLDS[items[place].kind]
        else:
            assert size <= ROOM.get(place, 100_000)
    for arm in state.truck.arms.values():
        if arm.at is not None:
            assert _root(state, arm.at) in (
                state.truck.place if arm.place == "external" else arm.place,
            )
    assert 0 <= state.truck.fuel <= 30
    assert state.truck.place in (*PLACES, *ROADS)


def _root(state: TruckState, name: str) -> str:
    while name in state.items:
        name = state.items[name].place
    return name
