"""The courier's world as libraries and the interpreter see it.

What happens in it is in `rapc.worlds.courier.hospital`.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping, Sequence

import msgspec

from rapc.base.values import Atom, Fact
from rapc.world import (
    OKAY,
    Datum,
    Finished,
    Gauge,
    Kit,
    Message,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Signal,
    Spot,
    Thing,
    Time,
    World,
)
from rapc.worlds.courier import building, robot
from rapc.worlds.courier.building import CORRIDOR, ROOMS
from rapc.worlds.courier.handlers import HANDLERS, way
from rapc.worlds.courier.hospital import Hospital
from rapc.worlds.courier.robot import FULL
from rapc.worlds.courier.state import HospitalState, Sent

_OPTIONS = (
    Option("battery", "integer", 70, "of 100", "what the battery holds at first"),
    Option("tray", "integer", 3, "parcels", "what the tray holds"),
    Option("blocked", "integer", 15, "%", "drives that end before a blocked door"),
    Option("sold-out", "integer", 10, "%", "stores that have nothing left just then"),
    Option("absent", "integer", 20, "%", "times that nobody comes when it rings"),
    Option("calls", "integer", 150, "time units", "between calls, about; 0: none"),
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


class CourierWorld(World):
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
        self._hospital = Hospital(rng, chosen)

    # --- the port -----------------------------------------------------------------

    def facts(self) -> Iterable[Fact]:
        """The building: rooms, and what the stores give out."""
        return building.building_facts()

    def now(self) -> Time:
        """The clock."""
        return self._hospital.state.now

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Begin what takes its time, or do what the robot does alone.

        Raises:
            ValueError: for a primitive or a number of arguments not on offer.
        """
        name, *arguments = (str(part) for part in request)
        if (
            name not in _OFFER.primitives
            or len(arguments) != _OFFER.primitives[name][0]
        ):
            raise ValueError(f"the courier has no primitive `{name}` of that form")
        hospital = self._hospital
        acts: Mapping[str, Callable[..., Reply | Refused | None]] = {
            "drive": hospital.drive,
            "take-on": hospital.take_on,
            "ring": hospital.ring,
            "hand-over": hospital.hand_over,
            "dock": hospital.dock,
            "help": hospital.help,
        }
        return acts[name](ticket, *arguments)

    def cancel(self, ticket: int) -> None:
        """Stop where the robot is, or leave off what was to be done."""
        self._hospital.leave_off(ticket)

    def next_time(self) -> Time | None:
        """The next thing to be sent, or now if something waits to be taken in.

        A nurse for whom the robot is not there sends nothing. What could bring it there
        before she comes sends something, and this is asked again.
        """
        return self._hospital.next_time()

    def advance(self, to: Time) -> None:
        """Move the clock on; what is due until then happens, one after the other."""
        self._hospital.advance(to)

    def messages(self) -> Sequence[Message]:
        """Return what was sent since this was last asked."""
        state = self._hospital.state
        sent, state.sent = state.sent, []
        return [_message(one) for one in sent]

    def ended(self) -> str | None:
        """Return why the run is over: the battery is empty; None while it is not."""
        return self._hospital.state.ended

    def picture(self) -> Picture:
        """The corridor with its rooms, the tray, and who waits where."""
        state = self._hospital.state
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

    def save(self) -> bytes:
        """The state of world and random stream, as JSON."""
        return self._hospital.save()

    def restore(self, state: bytes) -> None:
        """Take up a saved state.

        Raises:
            ValueError: if it is none, or one of a courier's world with other options.
        """
        self._hospital.restore(state)

    @property
    def state(self) -> HospitalState:
        """A copy of the whole truth, for tests; the robot has no part in it."""
        whole = msgspec.json.encode(self._hospital.state)
        return msgspec.json.decode(whole, type=HospitalState)


def _message(sent: Sent) -> Message:
    """Return what was sent, as the port has it."""
    if sent.ticket is not None:
        return Finished(sent.ticket, Reply(str(sent.content[0]), sent.data))
    if str(sent.content[0]).startswith(":"):
        return Signal(sent.content)
    return Datum(sent.content)
