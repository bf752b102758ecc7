"""The truck's handlers: changes of memory by results and data (T 3.3.2, B.3).

The result handler is called first, then one handler for each datum. The handlers use
knowledge about the robot's body and the world's rules that a maker of the truck would
have, and no state of the simulator. stdlib/truck/world.rap declares their facts.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.base.values import Atom, Fact
from rapc.world import OKAY, DatumHandler, HandlerMemory, Handlers, ResultHandler

_ARMS = ("arm1", "arm2")
_ON_BOARD = ("bay1", "bay2", "weapon-bay", "fuel-bay", "folded", *_ARMS)
_DISTINCT = ("gun", "gun-tool")


def _spot(memory: HandlerMemory, place: Atom) -> Atom:
    """Return a place as the truck names it: `external` for the truck's own place."""
    return "external" if place == memory.place else place


def _true_place(memory: HandlerMemory, place: Atom) -> Atom:
    """Return a place as memory names it for items: the truck's place for `external`."""
    here = memory.place
    return here if place == "external" and here is not None else place


def _arm_place(memory: HandlerMemory, arm: Atom) -> Atom:
    return memory.value("arm-place", arm) or "unknown"


def _nest(memory: HandlerMemory, arm: Atom) -> tuple[Atom, ...]:
    """Return the known containers of an arm, innermost first, then its place."""
    place = _true_place(memory, _arm_place(memory, arm))
    at = [fact[2] for fact in memory.query("arm-at", arm, None)]
    nest: list[Atom] = [item for item in at if memory.value("holds", item) is not None]
    around = memory.value("location", at[0]) if at else None
    while around is not None and around not in ("unknown", place, *nest):
        nest.append(around)
        around = memory.value("location", around)
    return (*nest, place)


def _not_there(memory: HandlerMemory, item: Atom, *places: Atom) -> None:
    """Remove an item from memory if its believed place is one of `places`."""
    believed = memory.value("location", item)
    if believed in [_true_place(memory, place) for place in places]:
        for arm in _ARMS:
            memory.erase("arm-at", arm, item)
        memory.lose(str(item))


# --- arms ------------------------------------------------------------------------


def _arm_move(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, target = request
    if result != OKAY:
        _not_there(memory, target, *_nest(memory, arm))
        return
    memory.erase("arm-at", arm)
    memory.erase("arm-interference")
    spot = _spot(memory, target)
    if spot == "external" or spot in _ON_BOARD:
        memory.assert_fact("arm-place", arm, spot)
    else:
        memory.assert_fact("arm-at", arm, target)


def _arm_grasp(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, item = request
    if result == OKAY:
        place = memory.value("location", item)
        if place is not None:
            memory.erase("too-full-for", place)
        memory.erase("arm-at", arm)
        if place is not None and memory.query("class", place, None, None):
            memory.assert_fact("arm-at", arm, place)
        memory.assert_fact("arm-holding", arm, item)
        memory.move(str(item), arm)
    elif result == "arm-too-full":
        full = memory.query("arm-holding", arm, None)
        memory.assert_fact("too-full-for" if full else "too-small-for", arm, item)
    elif result == "arm-not-at":
        memory.erase("arm-at", arm, item)
    elif result == "arm-cant-grasp":
        memory.assert_fact("tool-needed", item, "gun-tool")
    elif result == "arm-interference":
        memory.assert_fact("arm-interference", item)


def _arm_ungrasp(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, item = request
    place = _nest(memory, arm)[0]
    if result == OKAY:
        memory.erase("arm-holding", arm, item)
        memory.erase("too-full-for", arm)
        memory.assert_fact("arm-at", arm, item)
        memory.move(str(item), place)
    elif result == "container-full":
        memory.assert_fact("too-full-for", place, item)
    else:
        _not_holding(memory, arm, item)


def _arm_pour(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, vessel = request
    if result == "arm-not-holding":
        _not_holding(memory, arm, vessel)
    elif result == "arm-not-at":
        memory.erase("arm-at", arm)
    else:
        others = [fact[2] for fact in memory.query("arm-at", arm, None)]
        for item in (vessel, *others):
            memory.erase("examined-since-pour", item)
            memory.assert_fact("quantity-held", item, "unknown")


def _arm_toggle(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, item = request
    if result == OKAY:
        memory.erase("examined-since-toggle", item)
        memory.erase("machine-state", item)
        memory.assert_fact("quantity-held", item, "unknown")
    elif result == "arm-not-at":
        memory.erase("arm-at", arm, item)


def _arm_examine(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, arm, item = request
    if result == OKAY:
        _examined(memory, "arm-examined", item)
    else:
        memory.erase("arm-at", arm, item)


def _not_holding(memory: HandlerMemory, arm: Atom, item: Atom) -> None:
    memory.erase("arm-holding", arm, item)
    _not_there(memory, item, arm)


# --- eye and truck ---------------------------------------------------------------


def _eye_scan(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Remove items that are known but not seen, except rocks at a factory.

    A factory takes in rocks, and the eye does not see these rocks afterwards. So the
    scan of a factory's yard is incomplete.
    """
    if result != OKAY:
        return
    spot = _spot(memory, request[1])
    place = _true_place(memory, spot)
    memory.assert_fact("eye-scanned", spot)
    memory.assert_fact("scanned-since-move", spot)
    if spot == "external":
        memory.erase("direction", "external")
    if spot in _ARMS:
        memory.erase("arm-holding", spot)
    if not memory.query("place", place, "factory"):
        memory.fix_cardinality(place)


def _eye_examine(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, place, item = request
    if result == OKAY:
        _examined(memory, "eye-examined", item)
    else:
        _not_there(memory, item, place)


def _examined(memory: HandlerMemory, how: str, item: Atom) -> None:
    memory.assert_fact(how, item)
    for since in ("move", "toggle", "pour"):
        memory.assert_fact(f"examined-since-{since}", item)


def _eye_monitor(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.assert_fact("monitoring", request[1])


def _eye_unmonitor(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.erase("monitoring", request[1])


def _truck_move(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Do nothing: a successful trip sends the datum `new-location`."""
    if result == "truck-mishap":
        memory.assert_fact("truck-status", "mishap")
        memory.expire()


# --- data ------------------------------------------------------------------------


def _object_seen(memory: HandlerMemory, datum: Fact) -> None:
    _, place, item, kind = datum
    name = memory.introduce(str(item), str(kind), _true_place(memory, place))
    if place in _ARMS:
        memory.assert_fact("arm-holding", place, name)


def _object_gone(memory: HandlerMemory, datum: Fact) -> None:
    _, place, item = datum
    _not_there(memory, item, place)


def _road_seen(memory: HandlerMemory, datum: Fact) -> None:
    _, direction, road = datum
    memory.assert_fact("direction", "external", road, direction)


def _new_location(memory: HandlerMemory, datum: Fact) -> None:
    """Remove items without a permanent name, except the items aboard (T 6.2.2)."""
    facts = [f for kind in _DISTINCT for f in memory.query("class", None, kind, "true")]
    memory.expire()
    memory.arrive(datum[1])
    for _, item, kind, _ in facts:
        place = memory.value("location", item)
        if place in _ON_BOARD:
            memory.introduce(str(item), str(kind), place)
    memory.assert_fact("truck-location", datum[1])
    memory.assert_fact("time-arrived", memory.now)
    for stale in ("scanned-since-move", "examined-since-move", "direction"):
        memory.erase(stale)


def _vessel(memory: HandlerMemory, datum: Fact) -> None:
    _, item, liquid, amount = datum
    memory.assert_fact("class", item, "vessel", "true")
    memory.assert_fact("liquid-held", item, liquid)
    memory.assert_fact("quantity-held", item, amount)


def _shots_left(memory: HandlerMemory, datum: Fact) -> None:
    """Note the rounds of a weapon, and that a weapon requires the gun tool."""
    _, item, rounds = datum
    memory.assert_fact("class", item, "weapon", "true")
    memory.assert_fact("tool-needed", item, "gun-tool")
    memory.assert_fact("liquid-held", item, "ammo")
    memory.assert_fact("quantity-held", item, rounds)


def _property(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact(*datum)


def _called(name: str) -> DatumHandler:
    """Return a handler that asserts a datum under the name used in memory."""

    def read(memory: HandlerMemory, datum: Fact) -> None:
        memory.assert_fact(name, *datum[1:])

    return read


_RESULTS: Mapping[str, ResultHandler] = {
    "arm-move": _arm_move,
    "arm-grasp": _arm_grasp,
    "arm-ungrasp": _arm_ungrasp,
    "arm-pour": _arm_pour,
    "arm-ladle": _arm_pour,
    "arm-toggle": _arm_toggle,
    "arm-examine": _arm_examine,
    "eye-scan": _eye_scan,
    "eye-examine": _eye_examine,
    "eye-monitor": _eye_monitor,
    "eye-unmonitor": _eye_unmonitor,
    "truck-move": _truck_move,
}

_DATA: Mapping[str, DatumHandler] = {
    "object-seen": _object_seen,
    "object-gone": _object_gone,
    "road-seen": _road_seen,
    "new-location": _new_location,
    "vessel": _vessel,
    "shots-left": _shots_left,
    "capacity": _property,
    "holds": _property,
    "machine": _called("machine-state"),
    "weather": _property,
    "light": _property,
    "color": _property,
    "size": _property,
    "heading": _called("truck-heading"),
    "speed": _called("truck-speed"),
    "fuel-level": _called("truck-fuel"),
    "clock": _called("truck-time"),
}

HANDLERS = Handlers(_RESULTS, _DATA)
"""The handlers of the truck; turning and speed change memory by data only."""
