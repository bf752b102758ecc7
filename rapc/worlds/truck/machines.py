"""Items that act by themselves once they are switched on (T 1.4.2, B.1).

What a kind of machine does is declared on the map; see `kinds.Machine`. A machine that
runs has a demon of its own, wherever it stands or is carried.
"""

from __future__ import annotations

from rapc.base.values import Number, number
from rapc.worlds.truck.kinds import TruckMachine
from rapc.worlds.truck.scene import Scene
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
    state = scene.state
    if running(scene, item):
        state.demons = [
            d for d in state.demons if (d.job, d.place) != ("machine", item.name)
        ]
        return
    due = number(round(state.now + machine.every, 2))
    state.demons.append(Demon("machine", item.name, due))


def work(scene: Scene, demon: Demon) -> Number | None:
    """Do one round of a machine's work; switch it off if it cannot go on."""
    item = scene.state.items.get(demon.place)
    machine = scene.kind(item).machine if item is not None else None
    if item is None or machine is None:
        return None
    if machine.daylight and dark(scene, scene.root(item)):
        return machine.every
    used = _used(scene, item, machine)
    if used is None or item.amount < machine.uses:
        return None
    if not _room(scene, item.place, machine.makes):
        return None
    item.amount = number(round(item.amount - machine.uses, 2))
    for each in used:
        scene.remove(each)
    scene.make(machine.makes, item.place)
    wear = scene.settings.wear
    item.broken = bool(wear) and 100 * scene.chance["wear"].random() < wear
    return None if item.broken else machine.every


def _room(scene: Scene, place: str, kind: str) -> bool:
    if place in scene.map.spots():
        return not scene.crowded(place)
    return scene.room(place, kind)


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
