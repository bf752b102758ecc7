"""The primitives of the eye (T B.1) and their data about items (T B.2)."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.base.values import Atom, Fact
from rapc.world import OKAY, Reply
from rapc.worlds.truck.machines import doing
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import EXTERNAL, TruckItem
from rapc.worlds.truck.weather import overlooked, sky

CANT_FIND = Reply("eye-cant-find")


def eye_scan(scene: Scene, place: Atom) -> Reply:
    """Report all items outside, on the truck or in a container.

    Items sensed there since the truck arrived, and missing now, are reported first. A
    scan outside also reports roads and sky.
    """
    spot = scene.spot(place)
    if spot is None:
        return CANT_FIND
    around = (*_roads(scene), *sky(scene)) if spot == EXTERNAL else ()
    return Reply(OKAY, (*_gone(scene, spot), *_seen(scene, spot), *around))


def eye_examine(scene: Scene, place: Atom, thing: Atom) -> Reply:
    """Examine an item: report its colour or its contents."""
    spot, item = scene.spot(place), scene.item(thing)
    if spot is None or item is None or item.place != scene.true_place(spot):
        return CANT_FIND
    return Reply(OKAY, (*_looks(scene, item), *contents(scene, item)))


def eye_monitor(scene: Scene, kind: Atom) -> Reply:
    """Start watching for items of a class that appear outside."""
    if str(kind) not in scene.state.monitored:
        scene.state.monitored.append(str(kind))
    return Reply(OKAY)


def eye_unmonitor(scene: Scene, kind: Atom) -> Reply:
    """Stop watching for items of a class."""
    if str(kind) in scene.state.monitored:
        scene.state.monitored.remove(str(kind))
    return Reply(OKAY)


def notice(scene: Scene) -> Iterator[Fact]:
    """Yield data for newly sensed items outside, of the classes watched for."""
    if not scene.state.monitored:
        return
    for item in scene.items_at(scene.state.truck.place):
        known = scene.state.sighted.get(item.name) == EXTERNAL
        watched = item.kind in scene.state.monitored
        if watched and not known and not overlooked(scene, item):
            yield ("object-seen", EXTERNAL, scene.sight(item, EXTERNAL), item.kind)


def contents(scene: Scene, item: TruckItem) -> Iterator[Fact]:
    """Yield the data about an item's contents and its activity."""
    name, kind = scene.sensor_name(item), scene.kind(item)
    if kind.rounds:
        yield ("shots-left", name, item.amount)
    elif item.liquid is not None:
        yield ("vessel", name, item.liquid, item.amount)
        yield ("capacity", name, kind.capacity)
    if kind.holds:
        yield ("holds", name, kind.holds)
    if kind.machine is not None:
        yield ("machine", name, doing(scene, item))


def _looks(scene: Scene, item: TruckItem) -> Iterator[Fact]:
    if item.color is not None:
        name = scene.sensor_name(item)
        yield ("size", name, scene.kind(item).size)
        yield ("color", name, item.color)


def _gone(scene: Scene, spot: str) -> Iterator[Fact]:
    state, place = scene.state, scene.true_place(spot)
    if not scene.settings.scan_tells_gone:
        return
    for name in [n for n, seen in state.sighted.items() if seen == spot]:
        item = state.items.get(name)
        if item is None or item.place != place:
            del state.sighted[name]
            yield ("object-gone", scene.called(spot), state.names.pop(name, name))


def _seen(scene: Scene, spot: str) -> Iterator[Fact]:
    called = scene.called(spot)
    for item in scene.items_at(scene.true_place(spot)):
        if spot != EXTERNAL or not overlooked(scene, item):
            yield ("object-seen", called, scene.sight(item, spot), item.kind)


def _roads(scene: Scene) -> Iterator[Fact]:
    for leg in scene.map.legs(scene.state.truck.place):
        yield ("road-seen", leg.direction, leg.road.name)
