"""The delivery truck as a world: an adapter between the port and the scene.

The physics is in `scene`, `arms`, `movement`, `eye` and `demons`. The handlers in
`handlers` know nothing of the physics.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.base.values import Atom, Fact, Number, number
from rapc.world import Datum, Kit, Message, Picture, Reply, Time, World
from rapc.worlds.maps import MapError, shipped_map
from rapc.worlds.states import reading_state
from rapc.worlds.truck import eye
from rapc.worlds.truck.demons import check_demons, pass_time, summon
from rapc.worlds.truck.handlers import HANDLERS
from rapc.worlds.truck.kinds import KINDS
from rapc.worlds.truck.map import Lying, Map
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.options import (
    TruckSettings,
    adjustable,
    adjusted,
    as_made,
    describe_options,
    read_settings,
)
from rapc.worlds.truck.orders import read_orders
from rapc.worlds.truck.picture import Layout, lay_out, picture_of
from rapc.worlds.truck.primitives import OFFER, PRIMITIVES, time_of
from rapc.worlds.truck.routes import SOLVED_RAP, plan_route
from rapc.worlds.truck.scene import Scene, check_items, tidy
from rapc.worlds.truck.state import ARMS, Delivery, Encounter, Order, Truck, TruckState


class Saved(msgspec.Struct, frozen=True):
    """The data that `save` writes; `restore` refuses a state with other options."""

    settings: TruckSettings
    state: TruckState
    rng: Stream
    chance: dict[str, Stream]


class TruckWorld(World):
    """A delivery truck among quarries and factories.

    The world follows [T 6.1, appendix B].

    Raises:
        ValueError: for an option out of range, or an invalid map or order.
    """

    name = "truck"
    kit = Kit(
        OFFER,
        HANDLERS,
        describe_options(),
        solvers={SOLVED_RAP: plan_route},
    )

    def __init__(self, rng: random.Random, options: Mapping[str, Atom | bool]) -> None:
        settings = read_settings(options)
        if settings.fuel > settings.fuel_capacity:
            raise ValueError("`fuel` is more than `fuel-capacity`")
        try:
            ground = read_map(settings.map or shipped_map("truck", "default"))
        except MapError as error:
            raise ValueError(f"`map`: {error}") from error
        truck = Truck(ground.start, ground.heading, number(settings.fuel))
        self._scene = Scene(ground, settings, rng, TruckState(truck))
        #: The map's layout; computed for the first picture.
        self._layout: Layout | None = None
        for lying in _at_first(ground, settings.quarry_rocks):
            for _ in range(lying.count):
                self._place(lying)
        self._scene.state.orders.extend(read_orders(settings.orders, ground))
        summon(self._scene)
        self._scene.state.pending += (
            ("new-location", truck.place),
            ("heading", truck.heading),
            ("speed", truck.speed),
            ("fuel-level", truck.fuel),
            ("clock", 0),
        )

    def _place(self, lying: Lying) -> None:
        item = self._scene.make(lying.kind, lying.place, lying.color)
        if self._scene.kind(item).rounds:
            item.amount = self._scene.settings.gun_rounds
        item.broken = lying.broken

    def facts(self) -> Iterable[Fact]:
        """Return the map and the truck's own body; no items."""
        scene = self._scene
        yield from scene.map.facts()
        for place, size in scene.capacities.items():
            yield ("arm-capacity" if place in ARMS else "bay-capacity", place, size)
        yield ("bay-capacity", "weapon-bay", KINDS["gun"].size)
        yield ("bay-capacity", "fuel-bay", scene.settings.fuel_capacity)
        for arm in ARMS:
            yield ("arm-place", arm, scene.state.truck.arms[arm].place)
        yield ("truck-status", "ready")

    def now(self) -> Time:
        """The time of the clock."""
        return self._scene.state.now

    def perform(self, ticket: int, request: Fact) -> Reply:
        """Carry out a request: let its time pass, then apply its effect.

        Raises:
            ValueError: for an unknown primitive or a wrong number of arguments.
        """
        name, *arguments = request
        primitive = PRIMITIVES.get(str(name))
        if primitive is None or len(primitive.takes) != len(arguments):
            raise ValueError(f"the truck has no primitive `{name}` of that form")
        scene = self._scene
        pass_time(scene, tidy(scene.state.now + time_of(scene.settings, str(name))))
        reply = primitive.act(scene, *arguments)
        noticed = () if primitive.by_eye else tuple(eye.notice(scene))
        return Reply(reply.result, (*reply.data, *noticed, ("clock", scene.state.now)))

    def usual_time(self, request: Fact) -> Time:
        """Return the duration by the options, trips excluded; 0 if unknown."""
        name = str(request[0])
        return time_of(self._scene.settings, name) if name in PRIMITIVES else 0

    def next_time(self) -> Time | None:
        """Return the present while gauge data wait to be sent, else None."""
        return self._scene.state.now if self._scene.state.pending else None

    def advance(self, to: Time) -> None:
        """Advance the clock; demons that are due act."""
        pass_time(self._scene, to)

    def messages(self) -> Sequence[Message]:
        """Return the gauge data after the start, then nothing."""
        pending = self._scene.state.pending
        if not pending:
            return ()
        found = tuple(Datum(content) for content in pending)
        pending.clear()
        return found

    def ended(self) -> str | None:
        """The reason for the end of the run, with the place; None while it goes on."""
        return self._scene.state.ended

    def truth(self) -> Mapping[str, list[Fact]]:
        """Return the state of the truck, and the places of items with sensor names.

        A rock that a factory has taken in is at the factory.
        """
        scene, state, truck = self._scene, self._scene.state, self._scene.state.truck
        named = {
            name: sensor
            for name, item in state.items.items()
            if (sensor := scene.sensor_name(item))
        }
        places = [
            (state.names.get(each.item, each.item), each.factory)
            for each in state.deliveries
        ]
        for name, sensor in named.items():
            place = state.items[name].place
            places.append((sensor, named.get(place, place)))
        return {
            "truck-location": [("truck-location", truck.place)],
            "truck-heading": [("truck-heading", truck.heading)],
            "truck-speed": [("truck-speed", truck.speed)],
            "truck-fuel": [("truck-fuel", truck.fuel)],
            "arm-place": [("arm-place", arm, truck.arms[arm].place) for arm in ARMS],
            "location": [("location", *each) for each in places],
        }

    def picture(self) -> Picture:
        """Return the map, with all items on the map and on the truck."""
        if self._layout is None:
            self._layout = lay_out(self._scene.map)
        return picture_of(self._scene, self._layout)

    def save(self) -> bytes:
        """Return the state of world and random streams, as JSON."""
        scene = self._scene
        chance = {name: stream_state(rng) for name, rng in scene.chance.items()}
        saved = Saved(scene.settings, scene.state, stream_state(scene.rng), chance)
        return msgspec.json.encode(saved)

    def restore(self, state: bytes) -> None:
        """Restore a saved state.

        Raises:
            ValueError: if the state is invalid or from a truck with other options.
        """
        scene = self._scene
        with reading_state("a truck world"):
            saved = msgspec.json.decode(state, type=Saved)
        if as_made(saved.settings, scene.settings) != scene.settings:
            raise ValueError("the state is that of a truck world with other options")
        with reading_state("a truck world"):
            rng = stream_in(saved.rng)
            chance = {name: stream_in(saved.chance[name]) for name in scene.chance}
            check_items(scene, saved.state)
            check_demons(scene, saved.state)
        scene.rng, scene.chance, scene.state = rng, chance, saved.state
        scene.settings = saved.settings

    def adjustable(self) -> Mapping[str, Atom | bool]:
        """Return the options that may change in a run."""
        return adjustable(self._scene.settings)

    def adjust(self, name: str, value: Atom | bool) -> None:
        """Set an option to a new value; raise ValueError if it is out of range."""
        self._scene.settings = adjusted(self._scene.settings, name, value)

    @property
    def deliveries(self) -> tuple[Delivery, ...]:
        """Return the world's log of rocks put down at a factory, in order."""
        return tuple(self._scene.state.deliveries)

    @property
    def encounters(self) -> tuple[Encounter, ...]:
        """Return the world's log of meetings with enemies, in order."""
        return tuple(msgspec.structs.replace(e) for e in self._scene.state.encounters)

    def figures(self) -> dict[str, Number]:
        """Return true figures: rocks delivered to factories, meetings with troops.

        `shot` counts the meetings that ended with no troops left; `fuel` is the amount
        left in the fuel bay.
        """
        met = self._scene.state.encounters
        return {
            "delivered": len(self._scene.state.deliveries),
            "encounters": len(met),
            "shot": sum(encounter.how == "shot" for encounter in met),
            "fuel": self._scene.state.truck.fuel,
        }

    @property
    def orders(self) -> tuple[Order, ...]:
        """Return the orders of the option `orders`, with their deliveries."""
        return tuple(msgspec.structs.replace(o) for o in self._scene.state.orders)

    @property
    def state(self) -> TruckState:
        """Return a copy of the complete truth, for tests; hidden from the robot."""
        return msgspec.json.decode(
            msgspec.json.encode(self._scene.state), type=TruckState
        )


def _at_first(ground: Map, stock: int) -> Iterator[Lying]:
    """Yield the items at the start; each quarry has `stock` rocks.

    With a stock of 0 the map also sets the number of rocks at quarries.
    """
    quarries = [each for each in ground.places if stock and each.kind == "quarry"]
    names = {quarry.name for quarry in quarries}
    yield from (Lying("rock", each.name, stock, each.color) for each in quarries)
    for lying in ground.items:
        if lying.kind != "rock" or lying.place not in names:
            yield lying
