"""The courier's world: its offer and its port.

Not here: the events in the hospital, see `rapc.worlds.courier.hospital`.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping

from rapc.base.values import Atom, Fact
from rapc.world import (
    OKAY,
    Gauge,
    Kit,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Spot,
    Thing,
)
from rapc.worlds.courier import building, robot
from rapc.worlds.courier.building import CORRIDOR, ROOMS
from rapc.worlds.courier.handlers import HANDLERS, way
from rapc.worlds.courier.hospital import Hospital
from rapc.worlds.courier.robot import FULL

_OPTIONS = (
    Option("battery", "integer", 70, "of 100", "initial charge of the battery"),
    Option("tray", "integer", 3, "parcels", "capacity of the tray"),
    Option("blocked", "integer", 15, "%", "drives that end before a blocked door"),
    Option("sold-out", "integer", 10, "%", "visits to a store that is sold out"),
    Option("absent", "integer", 20, "%", "rings that no nurse answers"),
    Option(
        "calls", "integer", 150, "time units", "average time between calls; 0: no calls"
    ),
)

_OFFER = Offer(
    primitives={
        "drive": (1, (OKAY, "blocked", "battery-empty")),
        "take-on": (2, (OKAY, "sold-out", "not-here", "tray-full", "robot-left")),
        "ring": (0, (OKAY, "not-here")),
        "hand-over": (2, (OKAY, "nobody-there", "not-aboard")),
        "dock": (0, (OKAY, "not-here")),
        "help": (1, (OKAY, "not-here", "not-called", "robot-left")),
    },
    data={"position": 2, "battery": 1, "call": 1},
    events={":nurse": 1},
    not_atomic=("drive", "take-on", "help"),
    arguments={
        "drive": ("room",),
        "take-on": ("goods", "ward"),
        "hand-over": ("goods", "ward"),
        "help": ("ward",),
        "position": ("room", "along"),
        "battery": ("level",),
        "call": ("ward",),
        ":nurse": ("ward",),
    },
)


class CourierWorld(Hospital):
    """A courier robot in a hospital, with one battery and one pair of wheels.

    Raises:
        ValueError: for an option out of range.
    """

    name = "courier"
    kit = Kit(_OFFER, HANDLERS, _OPTIONS, functions={"way": way})

    def __init__(self, rng: random.Random, options: Mapping[str, Atom | bool]) -> None:
        chosen = {
            option.name: int(str(options.get(option.name, option.default)))
            for option in _OPTIONS
        }
        for option in _OPTIONS:
            value = chosen[option.name]
            if value < 0 or (option.unit in {"%", "of 100"} and value > FULL):
                raise ValueError(f"`{option.name}` is out of range")
        super().__init__(rng, chosen)

    # --- the port -----------------------------------------------------------------

    def facts(self) -> Iterable[Fact]:
        """Return the building: its rooms, and the goods of the stores."""
        return building.building_facts()

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Start an action that takes time, or carry out an atomic action.

        Raises:
            ValueError: for an unknown primitive or a wrong number of arguments.
        """
        name, *arguments = (str(part) for part in request)
        if _OFFER.primitives.get(name, (-1,))[0] != len(arguments):
            raise ValueError(f"the courier has no primitive `{name}` of that form")
        act = getattr(self, name.replace("-", "_"))
        answer: Reply | Refused | None = act(ticket, *arguments)
        return answer

    def truth(self) -> Mapping[str, list[Fact]]:
        """Return the place of the robot, its charge, its tray and the calls."""
        state = self._state
        return {
            "robot-at": [("robot-at", state.room)],
            "docked": [("docked",)] if state.docked else [],
            "on-tray": [("on-tray", *each) for each in state.tray],
            "delivered": [("delivered", o.goods, o.ward) for o in state.deliveries],
            "call": [("call", ward) for ward in state.calls],
        }

    def picture(self) -> Picture:
        """Return the corridor with its rooms, the tray, and the waiting people."""
        state = self._state
        spots = [
            Spot(
                room,
                at=(along / 2, 0 if kind == "ward" else 2),
                note="calls" if room in state.calls else "",
            )
            for room, (along, kind) in ROOMS.items()
        ]
        tray = tuple(Thing(goods, ward) for goods, ward in state.tray)
        gauges = (
            Gauge("at", state.room, ("robot-at",)),
            Gauge("battery", robot.charge(state), ("battery",)),
        )
        corridor = Spot(CORRIDOR, at=(state.along / 2, 1))
        return Picture(
            state.room, (*spots, corridor, Spot("tray", tray)), gauges=gauges
        )
