"""The ground truth of the truck world, and the physics that all primitives share.

The effects of single primitives are in `arms`, `movement` and `eye`; changes without
the truck are in `demons`. The robot learns of this module's state only through their
data.
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
"""The random streams beside the main stream of the world."""


def tidy(amount: Number) -> Number:
    """Return a time or an amount rounded to two decimals."""
    return number(round(amount, 2))


class Scene:
    """A map, settings and random streams, with the state that they act on.

    Each later feature of the world has its own stream in `chance`. So switching a
    feature on does not change the random numbers of the others.
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
        #: The capacities of arms and cargo bays.
        self.capacities: dict[str, Number] = {
            "arm1": settings.arm1_capacity,
            "arm2": settings.arm2_capacity,
            "bay1": settings.bay1_capacity,
            "bay2": settings.bay2_capacity,
        }

    # --- items -----------------------------------------------------------------

    def make(self, kind: str, place: str, color: str | None = None) -> TruckItem:
        """Make an item, named after its kind, with the kind's initial contents."""
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
        """Remove an item from the world, with its contents."""
        for inside in list(self.items_at(item.name)) if self.kind(item).holds else ():
            self.remove(inside)
        self.put(item, "gone")
        del self.state.items[item.name]
        self.state.gone += 1

    def put(self, item: TruckItem, place: str) -> None:
        """Put an item at a place; arms at or in the item lose contact."""
        for arm in self.state.truck.arms.values():
            if arm.at is not None and self.reaches(arm, item):
                arm.at = None
        item.place = place

    def items_at(self, place: str) -> Iterator[TruckItem]:
        """Yield the items at a place, in the order of their creation."""
        return (item for item in self.state.items.values() if item.place == place)

    def root(self, item: TruckItem) -> str:
        """Return the position of an item on map or truck, outside all containers."""
        items, place = self.state.items, item.place
        while place in items:
            place = items[place].place
        return place

    def reaches(self, arm: Arm, item: TruckItem) -> bool:
        """Return whether an arm is at an item or at its contents."""
        items, name = self.state.items, arm.at
        while name is not None and name != item.name:
            inner = items.get(name)
            name = inner.place if inner is not None else None
        return name is not None

    def kind(self, item: TruckItem) -> Kind:
        """Return the kind of an item."""
        return self.kinds[item.kind]

    # --- places ----------------------------------------------------------------

    def spot(self, place: object) -> str | None:
        """Return the truck's name of a place within reach of its eye, or None.

        The truck's own place is `external`. A container has its true name.
        """
        if place in (EXTERNAL, self.state.truck.place):
            return EXTERNAL
        if isinstance(place, str) and place in (*BAYS, *ARMS):
            return place
        item = self.item(place)
        return item.name if item is not None and self.kind(item).holds else None

    def true_place(self, spot: str) -> str:
        """Return the place of items at a spot: for `external`, the truck's place."""
        return self.state.truck.place if spot == EXTERNAL else spot

    def called(self, spot: str) -> str:
        """Return the name of a spot in data: for a container, its sensor name."""
        item = self.state.items.get(spot)
        return spot if item is None else self.sensor_name(item)

    def where(self, arm: Arm) -> tuple[str, ...]:
        """Return an arm's position: containers, innermost first, then a true place."""
        items, nest = self.state.items, []
        item = items[arm.at] if arm.at is not None else None
        if item is not None and not self.kind(item).holds:
            item = items.get(item.place)
        while item is not None:
            nest.append(item.name)
            item = items.get(item.place)
        return (*nest, self.true_place(arm.place))

    def room(self, place: str, kind: str) -> bool:
        """Return whether a true place has room for one more item of a kind.

        Outside there is no limit; producers and the shuffling demon apply `item-limit`
        themselves.
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
        """Return whether a place of the map has reached the limit for new items."""
        lying = sum(item.kind != ENEMY for item in self.items_at(place))
        return lying > self.settings.item_limit

    # --- arguments of a request ------------------------------------------------

    def arm(self, name: object) -> Arm | None:
        """Return the arm of this name, or None."""
        return self.state.truck.arms.get(str(name))

    def item(self, sensor_name: object) -> TruckItem | None:
        """Return the item of a sensor name within reach of arms or eye, or None."""
        name = str(sensor_name)
        if not self.settings.lasting_names:
            name = next((n for n, s in self.state.names.items() if s == name), name)
        item = self.state.items.get(name)
        if item is None or self.sensor_name(item) != str(sensor_name):
            return None
        within = (self.state.truck.place, *BAYS, *ARMS)
        return item if self.root(item) in within else None

    def held(self, arm: object, sensor_name: object) -> TruckItem | None:
        """Return the item of a sensor name if the arm holds it, or None."""
        item = self.item(sensor_name) if arm in ARMS else None
        return item if item is not None and item.place == arm else None

    def at(self, arm: object) -> TruckItem | None:
        """Return the item that an arm is at, or None."""
        found = self.arm(arm)
        name = found.at if found is not None else None
        return self.state.items[name] if name is not None else None

    def sensor_name(self, item: TruckItem) -> str:
        """Return an item's sensor name: permanent, or valid for this visit."""
        if self.settings.lasting_names or not self.kind(item).indistinct:
            return item.name
        return self.state.names.get(item.name, "")

    def sight(self, item: TruckItem, spot: str) -> str:
        """Note that the truck senses an item at a spot; return its sensor name."""
        state = self.state
        state.sighted[item.name] = spot
        if not self.sensor_name(item):
            state.named += 1
            state.names[item.name] = f"{item.kind}-s{state.named}"
        return self.sensor_name(item)

    # --- demons and the end ----------------------------------------------------

    def expect(self, job: str, place: str, wait: Number) -> None:
        """Add a demon with a job at a place, which acts after a wait."""
        self.state.demons.append(Demon(job, place, tidy(self.state.now + wait)))

    def dismiss(self, place: str, *jobs: str) -> None:
        """Remove the demons with these jobs at a place."""
        demons = self.state.demons
        self.state.demons = [d for d in demons if d.job not in jobs or d.place != place]

    def end(self, why: str) -> None:
        """End the run for a reason, unless the run has already ended."""
        if self.state.ended is None:
            self.state.ended = why

    # --- chance ----------------------------------------------------------------

    def vary(self, nominal: Number, per_cent: Number, stream: str = "") -> Number:
        """Return a random number about a nominal value, uniform, to two decimals."""
        spread, rng = per_cent / 100, self.chance[stream] if stream else self.rng
        return tidy(nominal * rng.uniform(1 - spread, 1 + spread))


def _glance(rng: random.Random) -> int:
    """Return the next value of a stream without advancing the stream."""
    copy = random.Random()
    copy.setstate(rng.getstate())
    return copy.getrandbits(64)


def check_items(scene: Scene, state: TruckState) -> None:
    """Validate the places of items and arms in a saved state; raise ValueError."""
    items, truck = state.items, state.truck
    spots = {*scene.map.spots(), *BAYS, *ARMS}
    for name, item in items.items():
        if item.name != name or item.kind not in scene.kinds:
            raise ValueError(f"the item `{name}`")
        inside = {name}
        while item.place in items and item.place not in inside:
            inside.add(item.place)
            item = items[item.place]  # noqa: PLW2901  # its container
        if item.place not in spots:
            raise ValueError(f"`{name}` is nowhere")
    held = {arm.at for arm in truck.arms.values()} - {None}
    if truck.arms.keys() != {*ARMS} or not held <= items.keys():
        raise ValueError("the arms")
    if truck.place not in spots:
        raise ValueError("the truck is nowhere")
