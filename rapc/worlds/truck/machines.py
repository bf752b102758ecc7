"""Items that act by themselves once they are switched on (T 1.4.2, B.1).

What a kind of machine does is declared on the map; see `kinds.Machine`. A machine that
runs has a demon of its own, wherever it stands or is carried.
"""

from __future__ import annotations

from rapc.base.values import Number
from rapc.worlds.truck.kinds import TruckMachine
from rapc.worlds.truck.scene import Scene, tidy
from rapc.worlds.truck.state import Demon, TruckItem
from rapc.worlds.truck.weather import dark


def running(scene: Scene, item: TruckItem) -> bool:
    """Whether a machine is switched on."""
    return any((d.job, d.place) == ("machine", item.name) for d in scene.state.demons)


def doing(scene: Scene, item: TruckItem) -> str:
    """Return what a machine is: `running`, `idle` or `broken`."""
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
    """Do one round of a machine's work; switch it off if it cannot go on."""
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
    """The items in a machine that one round uses up; None if some are missing."""
    used: list[TruckItem] = []
    for kind, count in machine.needs.items():
        inside = [each for each in scene.items_at(item.name) if each.kind == kind]
        if len(inside) < count:
            return None
        used += inside[:count]
    return used
