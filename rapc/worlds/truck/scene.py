"""The ground truth of the truck world, and the physics that all primitives share.

What single primitives do is in `arms`, `movement` and `eye`; what happens without
the truck in `demons`. Nothing here is told to the robot unless one of them does.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

from rapc.base.values import Number, number
from rapc.worlds.truck.kinds import ENEMY, KINDS, Kind
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.options import TruckSettings
from rapc.worlds.truck.state import (
    ARMS,
    BAYS,
    EXTERNAL,
    FOLDED,
    Arm,
    Demon,
    TruckItem,
    TruckState,
)

STREAMS = ("shuffle", "enemies", "weapon", "weather", "dark", "wear")
"""The random streams beside the world's first one."""


def tidy(amount: Number) -> Number:
    """Return a time or an amount to two digits."""
    return number(round(amount, 2))


class Scene:
    """A map, settings and random streams, with the state that they act on.

    What came into the world later has a stream of its own in `chance`, so that one
    can be switched on without the others' luck changing.
    """

    def __init__(
        self,
        ground: Map,
        settings: TruckSettings,
        rng: random.Random,
        state: TruckState,
    ) -> None:
        self.map = ground
        self.kinds = {**KINDS, **ground.kinds}
        self.sectors = {
            spot: sector for sector in ground.sectors for spot in sector.spots
        }
        self.settings = settings
        self.rng = rng
        root = _glance(rng)
        self.chance = {name: random.Random(f"{root}:{name}") for name in STREAMS}
        self.state = state
        #: The sizes of what arms and cargo bays can hold.
        self.capacities: dict[str, Number] = {
            "arm1": settings.arm1_capacity,
            "arm2": settings.arm2_capacity,
            "bay1": settings.bay1_capacity,
            "bay2": settings.bay2_capacity,
        }

    # --- items -----------------------------------------------------------------

    def make(self, kind: str, place: str, color: str | None = None) -> TruckItem:
        """A new item, full if it can hold something, named after its kind."""
        made = self.state.made
        made[kind] = made.get(kind, 0) + 1
        what = self.kinds[kind]
        item = TruckItem(
            name=f"{kind}-{made[kind]}",
            kind=kind,
            place=place,
            color=color,
            liquid=what.liquid or what.rounds,
            amount=what.capacity if what.full else 0,
        )
        self.state.items[item.name] = item
        return item

    def remove(self, item: TruckItem) -> None:
        """An item leaves the world for good, with what it contains."""
        for inside in list(self.items_at(item.name)) if self.kind(item).holds else ():
            self.remove(inside)
        self.put(item, "gone")
        del self.state.items[item.name]
        self.state.gone += 1

    def put(self, item: TruckItem, place: str) -> None:
        """Put an item elsewhere; no arm is at it, or in it, any more."""
        for arm in self.state.truck.arms.values():
            if arm.at is not None and self.reaches(arm, item):
                arm.at = None
        item.place = place

    def items_at(self, place: str) -> Iterator[TruckItem]:
        """The items at a place, in the order in which they were made."""
        return (item for item in self.state.items.values() if item.place == place)

    def root(self, item: TruckItem) -> str:
        """Return where an item is, on map or truck, whatever it is contained in."""
        items, place = self.state.items, item.place
        while place in items:
            place = items[place].place
        return place

    def reaches(self, arm: Arm, item: TruckItem) -> bool:
        """Whether an arm is at an item, or at something inside it."""
        items, name = self.state.items, arm.at
        while name is not None and name != item.name:
            inner = items.get(name)
            name = inner.place if inner is not None else None
        return name is not None

    def kind(self, item: TruckItem) -> Kind:
        """Return what an item has in common with others of its kind."""
        return self.kinds[item.kind]

    # --- places ----------------------------------------------------------------

    def spot(self, place: object) -> str | None:
        """Return what the truck calls a place within reach of its eye, or None.

        The place where the truck stands and `external` are one. A container goes by
        its true name.
        """
        if place in (EXTERNAL, self.state.truck.place):
            return EXTERNAL
        if isinstance(place, str) and place in (*BAYS, *ARMS):
            return place
        item = self.item(place)
        return item.name if item is not None and self.kind(item).holds else None

    def true_place(self, spot: str) -> str:
        """The place of the items at a spot: for `external`, where the truck is."""
        return self.state.truck.place if spot == EXTERNAL else spot

    def called(self, spot: str) -> str:
        """Return what data call a spot: a container by its sensor name."""
        item = self.state.items.get(spot)
        return spot if item is None else self.sensor_name(item)

    def where(self, arm: Arm) -> tuple[str, ...]:
        """Return what an arm is in, innermost first: containers, then a true place."""
        items, nest = self.state.items, []
        item = items[arm.at] if arm.at is not None else None
        if item is not None and not self.kind(item).holds:
            item = items.get(item.place)
        while item is not None:
            nest.append(item.name)
            item = items.get(item.place)
        return (*nest, self.true_place(arm.place))

    def room(self, place: str, kind: str) -> bool:
        """Whether a true place has room for one more item of a kind.

        Outside there is no end of it; that producers and the demon stop at
        `item-limit` is their affair.
        """
        container = self.state.items.get(place)
        if container is not None:
            capacity: Number = self.kind(container).holds
        elif place in self.capacities:
            capacity = self.capacities[place]
        elif place == "weapon-bay" and self.kinds[kind].rounds:
            capacity = KINDS["gun"].size
        else:
            return place not in (*BAYS, FOLDED)
        size = self.kinds[kind].size
        return size + sum(self.kind(i).size for i in self.items_at(place)) <= capacity

    def crowded(self, place: str) -> bool:
        """Whether so much lies at a place of the map that no more may be made there."""
        lying = sum(item.kind != ENEMY for item in self.items_at(place))
        return lying > self.settings.item_limit

    # --- what a request means --------------------------------------------------

    def arm(self, name: object) -> Arm | None:
        """The arm of a name, or None."""
        return self.state.truck.arms.get(str(name))

    def item(self, sensor_name: object) -> TruckItem | None:
        """The item of a sensor name within reach of arms or eye, or None."""
        name = str(sensor_name)
        if not self.settings.lasting_names:
            name = next((n for n, s in self.state.names.items() if s == name), name)
        item = self.state.items.get(name)
        if item is None or self.sensor_name(item) != str(sensor_name):
            return None
        within = (self.state.truck.place, *BAYS, *ARMS)
        return item if self.root(item) in within else None

    def held(self, arm: object, sensor_name: object) -> TruckItem | None:
        """The item of a sensor name if that arm holds it, or None."""
        item = self.item(sensor_name) if arm in ARMS else None
        return item if item is not None and item.place == arm else None

    def at(self, arm: object) -> TruckItem | None:
        """The item that an arm is at, or None."""
        found = self.arm(arm)
        name = found.at if found is not None else None
        return self.state.items[name] if name is not None else None

    def sensor_name(self, item: TruckItem) -> str:
        """An item's sensor name; without lasting names, its own for this visit."""
        if self.settings.lasting_names or not self.kind(item).indistinct:
            return item.name
        return self.state.names.get(item.name, "")

    def sight(self, item: TruckItem, spot: str) -> str:
        """The truck senses an item somewhere: its sensor name, new at first sight."""
        state = self.state
        state.sighted[item.name] = spot
        if not self.sensor_name(item):
            state.named += 1
            state.names[item.name] = f"{item.kind}-s{state.named}"
        return self.sensor_name(item)

    # --- demons and the end ----------------------------------------------------

    def expect(self, job: str, place: str, wait: Number) -> None:
        """Put a demon with a job at a place into the state, to act after a wait."""
        self.state.demons.append(Demon(job, place, tidy(self.state.now + wait)))

    def dismiss(self, place: str, *jobs: str) -> None:
        """Take the demons with these jobs at a place out of the state."""
        demons = self.state.demons
        self.state.demons = [d for d in demons if d.job not in jobs or d.place != place]

    def end(self, why: str) -> None:
        """End the run for a reason, unless it has ended for another one before."""
        if self.state.ended is None:
            self.state.ended = why

    # --- chance ----------------------------------------------------------------

    def vary(self, nominal: Number, per_cent: Number, stream: str = "") -> Number:
        """A number about a nominal one, evenly spread, to two digits."""
        spread, rng = per_cent / 100, self.chance[stream] if stream else self.rng
        return tidy(nominal * rng.uniform(1 - spread, 1 + spread))


def _glance(rng: random.Random) -> int:
    """Return what a stream would give next; it is left as it was."""
    copy = random.Random()
    copy.setstate(rng.getstate())
    return copy.getrandbits(64)


def check_items(scene: Scene, state: TruckState) -> None:
    """See that items and arms of a saved state are somewhere. Raises ValueError."""
    items, truck = state.items, state.truck
    spots = {*scene.map.spots(), *BAYS, *ARMS}
    for name, item in items.items():
        if item.name != name or item.kind not in scene.kinds:
            raise ValueError(f"the item `{name}`")
        inside = {name}
        while item.place in items and item.place not in inside:
            inside.add(item.place)
            item = items[item.place]  # noqa: PLW2901  # what it is in
        if item.place not in spots:
            raise ValueError(f"`{name}` is nowhere")
    held = {arm.at for arm in truck.arms.values()} - {None}
    if truck.arms.keys() != {*ARMS} or not held <= items.keys():
        raise ValueError("the arms")
    if truck.place not in spots:
        raise ValueError("the truck is nowhere")
