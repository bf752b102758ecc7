"""Orders and deliveries as counted by the world (T 6.1.3), hidden from the robot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.values import Number, number
from rapc.worlds.truck.kinds import Color
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Delivery, Order, TruckItem, TruckState


def read_orders(text: str, ground: Map) -> Iterator[Order]:
    """Yield the orders of the option `orders`: rows of time, colour, rocks and factory.

    Raises:
        ValueError: if the text is not JSON or does not match the map.
    """
    if not text:
        return
    try:
        rows = msgspec.json.decode(
            text.encode(), type=list[tuple[Number, Color, int, str]]
        )
    except UNREADABLE as error:
        raise ValueError(f"`orders`: {flaw(error)}") from error
    for time, color, rocks, factory in rows:
        place = ground.place(factory)
        if place is None or place.kind != "factory":
            raise ValueError(f"`orders`: `{factory}` is no factory")
        if rocks < 1 or time < 0:
            raise ValueError("`orders`: an order of no rocks, or before the start")
        yield Order(number(time), cast(str, color), rocks, factory)


def deliver(scene: Scene, item: TruckItem) -> None:
    """Log a rock put down at a factory; the rock counts once for one order.

    With a `factory-interval` of 0 the factory consumes the rock on arrival (T 6.4.1).
    Then the time at which an order is filled is the time of T's reports (T 6.3.1).
    """
    state, place = scene.state, scene.map.place(item.place)
    if place is None or place.kind != "factory" or item.color is None:
        return
    made = Delivery(state.now, item.name, item.color, place.name)
    again = any(
        (d.item, d.factory) == (item.name, place.name) for d in state.deliveries
    )
    state.deliveries.append(made)
    if not again:
        _count(state, made)
    if scene.settings.factory_interval == 0:
        scene.remove(item)


def _count(state: TruckState, made: Delivery) -> None:
    """Count a delivery for the first open order of this colour and factory."""
    for order in state.orders:
        wanted = (order.color, order.factory) == (made.color, made.factory)
        if wanted and order.filled is None and order.time <= state.now:
            order.received += 1
            order.filled = state.now if order.received == order.rocks else None
            return
