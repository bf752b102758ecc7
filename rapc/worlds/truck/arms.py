"""The primitives of the arms (T B.1): effects and failures.

The position of an arm is outside, a bay, or folded. At that position the arm may be at
one item. If that item is a container or lies in a container, the arm is in the
container. Held items move with the arm. The truck has no other arms: a request for an
unknown arm fails.
"""

from __future__ import annotations

from rapc.base.values import Atom, Fact, Number, number
from rapc.world import OKAY, Reply
from rapc.worlds.truck.enemies import fire
from rapc.worlds.truck.eye import contents
from rapc.worlds.truck.machines import switch
from rapc.worlds.truck.orders import deliver
from rapc.worlds.truck.scene import Scene, tidy
from rapc.worlds.truck.state import ARMS, BAYS, EXTERNAL, FOLDED, Arm, TruckItem

NOT_AT = Reply("arm-not-at")
NOT_HOLDING = Reply("arm-not-holding")


def arm_move(scene: Scene, name: Atom, place: Atom) -> Reply:
    """Move an arm to a position, or to an item at or near the arm's position."""
    arm = scene.arm(name)
    if arm is None:
        return Reply("arm-cant-find")
    spot = scene.spot(place)
    if spot in (EXTERNAL, *BAYS) or place == FOLDED:
        arm.place, arm.at = spot or FOLDED, None
        return Reply(OKAY)
    item = scene.item(place)
    if item is None or item.place not in scene.where(arm):
        return Reply("arm-cant-find")
    arm.at = item.name
    return Reply(OKAY)


def arm_grasp(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Pick up the item that the arm is at."""
    arm, item = scene.arm(name), scene.item(thing)
    if arm is None or item is None or arm.at != item.name:
        return NOT_AT
    others = (each for each in scene.state.truck.arms.values() if each is not arm)
    if any(scene.reaches(other, item) for other in others):
        return Reply("arm-interference")
    tool = scene.kind(item).tool
    if tool and all(held.kind != tool for held in scene.items_at(str(name))):
        return Reply("arm-cant-grasp")
    if not scene.room(str(name), item.kind):
        return Reply("arm-too-full")
    if scene.rng.uniform(0, 100) < _drops(scene, name):
        return Reply("arm-dropped")
    container = scene.state.items.get(item.place)
    scene.put(item, str(name))
    arm.at = container.name if container is not None else None
    scene.sight(item, str(name))
    return Reply(OKAY)


def arm_ungrasp(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Put a held item down where the arm is; the arm is at the item afterwards.

    In a container the eye reports the item as seen, because the robot may not know the
    containers.
    """
    arm, item = scene.arm(name), scene.held(name, thing)
    if arm is None or item is None:
        return NOT_HOLDING
    place = scene.where(arm)[0]
    if not scene.room(place, item.kind):
        return Reply("container-full")
    scene.put(item, place)
    arm.at = item.name
    deliver(scene, item)
    if item.name not in scene.state.items:
        return Reply(OKAY)
    if place not in scene.state.items:
        scene.sight(item, arm.place)
        return Reply(OKAY)
    seen = ("object-seen", scene.called(place), scene.sight(item, place), item.kind)
    return Reply(OKAY, (seen,))


def arm_pour(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Pour a held vessel into the item that the arm is at; a rest stays in the vessel.

    Liquid that nothing at the position can take is spilt.
    """
    arm, vessel = scene.arm(name), _held_vessel(scene, name, thing)
    if arm is None or vessel is None:
        return NOT_HOLDING
    target = scene.at(name)
    if target is not None and _takes(scene, target, vessel.liquid):
        room = scene.kind(target).capacity - target.amount
        flow = min(vessel.amount, room)
        target.liquid, target.amount = vessel.liquid, number(target.amount + flow)
    elif _over_fuel_bay(arm) and vessel.liquid == "fuel":
        truck = scene.state.truck
        flow = max(0, min(vessel.amount, scene.settings.fuel_capacity - truck.fuel))
        truck.fuel = tidy(truck.fuel + flow)
    else:
        flow = vessel.amount
    vessel.amount = tidy(vessel.amount - flow)
    return Reply(OKAY, _fuel(scene))


def arm_ladle(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Fill a held vessel from the vessel or the fuel bay that the arm is at."""
    arm, vessel = scene.arm(name), _held_vessel(scene, name, thing)
    if arm is None or vessel is None:
        return NOT_HOLDING
    truck, source = scene.state.truck, scene.at(name)
    room = scene.kind(vessel).capacity - vessel.amount
    if source is not None and scene.kind(source).liquid and source.amount > 0:
        if not _takes(scene, vessel, source.liquid):
            return NOT_AT
        flow = min(source.amount, room)
        source.amount = tidy(source.amount - flow)
        vessel.liquid = source.liquid
    elif _over_fuel_bay(arm) and truck.fuel > 0 and _takes(scene, vessel, "fuel"):
        flow = min(truck.fuel, room)
        truck.fuel = tidy(truck.fuel - flow)
        vessel.liquid = "fuel"
    else:
        return NOT_AT
    vessel.amount = tidy(vessel.amount + flow)
    return Reply(OKAY, _fuel(scene))


def arm_toggle(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Switch a machine on or off; a gun in its bay fires at enemies.

    An arm that holds the matching repair item mends a broken machine instead. A broken
    machine cannot be switched (T B.1).
    """
    item = scene.item(thing)
    if item is None or item is not scene.at(name):
        return NOT_AT
    kind = scene.kind(item)
    if item.broken and not _mends(scene, name, item):
        return Reply("arm-cant-toggle")
    if item.broken:
        item.broken = False
    elif kind.machine is not None:
        switch(scene, item, kind.machine)
    elif kind.rounds and item.place == "weapon-bay":
        fire(scene, item)
    else:
        return Reply("arm-cant-toggle")
    return Reply(OKAY)


def _mends(scene: Scene, name: Atom, broken: TruckItem) -> bool:
    """Return whether an arm holds an item that mends a broken item."""
    held = scene.items_at(str(name))
    return any(broken.kind in scene.kind(tool).mends for tool in held)


def arm_examine(scene: Scene, name: Atom, thing: Atom) -> Reply:
    """Report the contents and the size of an item that the arm is at or holds."""
    item = scene.item(thing)
    if item is None or item not in (scene.at(name), scene.held(name, thing)):
        return NOT_AT
    size: Fact = ("size", scene.sensor_name(item), scene.kind(item).size)
    return Reply(OKAY, (*contents(scene, item), size))


def _drops(scene: Scene, name: Atom) -> Number:
    settings = scene.settings
    return settings.arm1_drops if name == ARMS[0] else settings.arm2_drops


def _held_vessel(scene: Scene, name: Atom, thing: Atom) -> TruckItem | None:
    item = scene.held(name, thing)
    return item if item is not None and scene.kind(item).liquid else None


def _takes(scene: Scene, item: TruckItem, liquid: str | None) -> bool:
    """Return whether a liquid may flow into an item; an empty vessel takes any."""
    kind = scene.kind(item)
    if kind.rounds or kind.machine is not None:
        return liquid == (kind.rounds or kind.liquid)
    return bool(kind.liquid) and (item.amount == 0 or liquid == item.liquid)


def _over_fuel_bay(arm: Arm) -> bool:
    return arm.place == "fuel-bay" and arm.at is None


def _fuel(scene: Scene) -> tuple[Fact, ...]:
    return (("fuel-level", scene.state.truck.fuel),)
