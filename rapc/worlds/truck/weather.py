"""Rain and darkness over the sectors of the map, and their effects (T 1.4.2).

Rain in a sector makes its roads slower, raises fuel use, and makes muddy roads
dangerous. Night comes to all sectors, and some sectors are always dark. In the dark,
trips take longer and the eye misses items outside. With weather or darkness, a scan
outside reports the sky.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.base.values import Fact, Number
from rapc.worlds.truck.map import Road
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Demon, TruckItem


def change_weather(scene: Scene, demon: Demon) -> Number:
    """Change the weather of a sector to rain or sun; return its duration."""
    settings, rng = scene.settings, scene.chance["weather"]
    rained = [name for name in scene.state.raining if name != demon.place]
    rains = rng.uniform(0, 100) < settings.rain
    scene.state.raining = [*rained, demon.place] if rains else rained
    return scene.vary(settings.weather_interval, 50, "weather")


def raining(scene: Scene, spot: str) -> bool:
    """Return whether rain falls at a place or on a road."""
    sector = scene.sectors.get(spot)
    return sector is not None and sector.name in scene.state.raining


def dark(scene: Scene, spot: str) -> bool:
    """Return whether a place or a road is dark."""
    day, sector = scene.settings.day_length, scene.sectors.get(spot)
    if sector is not None and sector.dark:
        return True
    return day > 0 and scene.state.now % day >= day * (1 - scene.settings.night / 100)


def sky(scene: Scene) -> Iterator[Fact]:
    """Yield the data about the sky at the truck, if this world has weather."""
    place, settings = scene.state.truck.place, scene.settings
    if settings.rain > 0:
        yield ("weather", place, "rain" if raining(scene, place) else "dry")
    if settings.day_length > 0 or any(s.dark for s in scene.map.sectors):
        yield ("light", place, "night" if dark(scene, place) else "day")


def hardships(scene: Scene, road: Road) -> tuple[Number, Number, Number]:
    """Return the factors on time and fuel of a trip along a road, and the mud risk."""
    settings = scene.settings
    time, fuel, mud = 1.0, 1.0, 0.0
    if raining(scene, road.name):
        time, fuel, mud = settings.rain_time, settings.rain_fuel, road.mud
    if dark(scene, road.name):
        time *= settings.dark_time
    return time, fuel, mud


def overlooked(scene: Scene, item: TruckItem) -> bool:
    """Return whether the eye misses an item outside that is not sensed yet."""
    if item.name in scene.state.sighted or not dark(scene, item.place):
        return False
    return scene.chance["dark"].uniform(0, 100) < scene.settings.dark_misses
