"""The courier's handlers of results and data, and its function for distances."""

from __future__ import annotations

from rapc.base.values import Atom, Fact
from rapc.world import HandlerMemory, Handlers
from rapc.worlds.courier import building
from rapc.worlds.courier.building import CORRIDOR


def _driven(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.assert_fact("robot-at", request[1] if result == "okay" else CORRIDOR)
    memory.erase("docked")


def _taken_on(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, goods, ward = request
    if result == "okay":
        memory.assert_fact("on-tray", goods, ward)
    elif result == "sold-out" and memory.value("robot-at") is not None:
        memory.assert_fact("sold-out", memory.value("robot-at") or "", goods)


def _handed_over(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, goods, ward = request
    if result == "okay":
        memory.erase("on-tray", goods, ward)
        memory.assert_fact("delivered", goods, ward)


def _docked(memory: HandlerMemory, request: Fact, result: str) -> None:
    if result == "okay":
        memory.assert_fact("docked")


def _helped(memory: HandlerMemory, request: Fact, result: str) -> None:
    if result in {"okay", "not-called"}:
        memory.erase("call", request[1])


def _position(memory: HandlerMemory, datum: Fact) -> None:
    _, place, along = datum
    memory.assert_fact("robot-at", place)
    memory.assert_fact("robot-along", along)
    memory.erase("docked")


def _noted(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact(*datum)


def way(memory: HandlerMemory, from_: Atom, to: Atom) -> int | None:
    """Return the distance between two rooms; `corridor` is the robot's position in it.

    Return None if one of the two is not a room, or if memory lacks the robot's
    position.
    """
    if to not in building.ROOMS:
        return None
    if from_ == to:
        return 0
    if from_ == CORRIDOR:
        along, depth = memory.value("robot-along"), 0
    else:
        along, depth = building.ROOMS.get(str(from_), (None, ""))[0], building.DEPTH
    if not isinstance(along, int):
        return None
    return building.way_to_room(along, depth, str(to))


HANDLERS = Handlers(
    results={
        "drive": _driven,
        "take-on": _taken_on,
        "hand-over": _handed_over,
        "dock": _docked,
        "help": _helped,
    },
    data={"position": _position, "battery": _noted, "call": _noted},
)
