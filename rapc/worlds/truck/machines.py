"""Items that work by themselves when switched on (T 1.4.2, B.1).

The map declares the work of each kind of machine; see `kinds.TruckMachine`. A running
machine has its own demon, at every place and also when carried.
"""

from __future__ import annotations

from rapc.base.values import Number
from rapc.worlds.truck.kinds import TruckMachine
from rapc.worlds.truck.scene import Scene, tidy
from rapc.worlds.truck.state import Demon, TruckItem
from rapc.worlds.truck.weather import dark


def running(scene: Scene, item: TruckItem) -> bool:
    """Return whether a machine is switched on."""
    return any((d.job, d.place) == ("machine", item.name) for d in scene.state.demons)


def doing(scene: Scene, item: TruckItem) -> str:
    """Return the state of a machine: `running`, `idle` or `broken`."""
    if item.broken:
        return "broken"
    return "running" if running(scene, item) else "idle"


def switch(scene: Scene, item: TruckItem, machine: TruckMachine) -> None:
    """Switch a machine on, or off if it is on."""
    if running(scene, item):
        scene.dismiss(item.name, "machine")
    else:
        scene.expect("machine", item.name, machine.every)


def work(scene: Scene, demon: Demon) -> Number | None:
    """Do a round of a machine's work; switch off a machine that cannot continue."""
    item = scene.state.items.get(demon.place)
    machine = scene.kind(item).machine if item is not None else None
    if item is None or machine is None:
        return None
    if machine.daylight and dark(scene, scene.root(item)):
        return machine.every
    used = _used(scene, item, machine)
    if item.place in scene.map.spots():
        has_room = not scene.crowded(item.place)
    else:
        has_room = scene.room(item.place, machine.makes)
    if used is None or item.amount < machine.uses or not has_room:
        return None
    item.amount = tidy(item.amount - machine.uses)
    for each in used:
        scene.remove(each)
    scene.make(machine.makes, item.place)
    wear = scene.settings.wear
    item.broken = bool(wear) and 100 * scene.chance["wear"].random() < wear
    return None if item.broken else machine.every


def _used(
    scene: Scene, item: TruckItem, machine: TruckMachine
) -> list[TruckItem] | None:
    """Return the items that one round consumes; None if items are missing."""
    used: list[TruckItem] = []
    for kind, count in machine.needs.items():
        inside = [each for each in scene.items_at(item.name) if each.kind == kind]
        if len(inside) < count:
            return None
        used += inside[:count]
    return used
