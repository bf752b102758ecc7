"""The truck world's options: a typed row each, with unit, default and meaning.

The simulator uses `TruckSettings`; `rapc worlds truck` and `--set` use the same rows as
`rapc.world.Option`. T leaves some values open, durations above all. Their defaults
reproduce his basic experiment in a still world (T table 6.2), with the rocks that
`chapter6.toml` sets.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Annotated, get_args, get_type_hints

import msgspec
from msgspec import Meta
from msgspec.structs import replace

from rapc.base.values import Atom, Number, Text
from rapc.world import Option

_TIME = "time units"


def _row(unit: str, doc: str, most: Number = 1_000_000) -> Meta:
    extra = {"unit": unit, "most": most, "changes": False}
    return Meta(description=doc, extra=extra)


def _now(unit: str, doc: str, most: Number = 1_000_000) -> Meta:
    """Describe an option that is read at each use and may change in a run."""
    return Meta(description=doc, extra={"unit": unit, "most": most, "changes": True})


class TruckSettings(msgspec.Struct, frozen=True, rename="kebab"):
    """Values of the options: numbers from 0 to the maximum of their row."""

    map: Annotated[str, _row("", "map as JSON in place of the default map")] = ""
    orders: Annotated[
        str, _row("", "orders to count, as JSON: [[time, colour, rocks, factory]]")
    ] = ""
    lasting_names: Annotated[
        bool, _row("", "sensor names of rocks, drums and boxes outlast a move")
    ] = False

    scan_tells_gone: Annotated[
        bool, _now("", "a scan reports what was there and is gone")
    ] = True

    arm1_capacity: Annotated[Number, _row("size", "what arm1 can hold")] = 8
    arm2_capacity: Annotated[Number, _row("size", "what arm2 can hold")] = 15
    arm1_drops: Annotated[Number, _now("%", "grasps that arm1 drops", 100)] = 15
    arm2_drops: Annotated[Number, _now("%", "grasps that arm2 drops", 100)] = 50
    bay1_capacity: Annotated[Number, _row("size", "what bay1 can hold")] = 20
    bay2_capacity: Annotated[Number, _row("size", "what bay2 can hold")] = 100
    fuel_capacity: Annotated[Number, _row("fuel", "what the fuel bay can hold")] = 30
    fuel: Annotated[Number, _row("fuel", "in the fuel bay at the start")] = 22
    fuel_use: Annotated[Number, _now("factor", "on what a road burns; 0: none")] = 1
    fuel_spread: Annotated[Number, _now("%", "a trip burns more or less", 100)] = 20
    road_time: Annotated[Number, _now("factor", "on what a trip down a road takes")] = 1
    time_spread: Annotated[Number, _now("%", "a trip takes more or less", 90)] = 20

    arm_move_time: Annotated[Number, _now(_TIME, "for arm-move")] = 1
    arm_grasp_time: Annotated[Number, _now(_TIME, "for arm-grasp")] = 2.5
    arm_ungrasp_time: Annotated[Number, _now(_TIME, "for arm-ungrasp")] = 0.5
    arm_pour_time: Annotated[Number, _now(_TIME, "for arm-pour")] = 4
    arm_ladle_time: Annotated[Number, _now(_TIME, "for arm-ladle")] = 4
    arm_toggle_time: Annotated[Number, _now(_TIME, "for arm-toggle")] = 7
    arm_examine_time: Annotated[Number, _now(_TIME, "for arm-examine")] = 0.4
    truck_turn_time: Annotated[Number, _now(_TIME, "for truck-turn")] = 1
    truck_speed_time: Annotated[Number, _now(_TIME, "for truck-speed")] = 1
    truck_move_time: Annotated[Number, _now(_TIME, "for truck-move, trip aside")] = 1
    eye_examine_time: Annotated[Number, _now(_TIME, "for eye-examine")] = 0.5
    eye_scan_time: Annotated[Number, _now(_TIME, "for eye-scan")] = 2
    eye_monitor_time: Annotated[Number, _now(_TIME, "for eye-(un)monitor")] = 1

    quarry_rocks: Annotated[
        int, _row("rocks", "at each quarry at the start; 0: the map's", 10_000)
    ] = 0
    quarry_interval: Annotated[Number, _row(_TIME, "a quarry's rocks; 0: none")] = 300
    warehouse_interval: Annotated[Number, _row(_TIME, "a warehouse's boxes")] = 400
    depot_interval: Annotated[Number, _row(_TIME, "a depot's drums")] = 120
    factory_interval: Annotated[
        Number, _row(_TIME, "until a factory takes a rock in; 0: at once")
    ] = 0
    item_limit: Annotated[int, _now("items", "none is put there, none made above")] = 10

    shuffle_interval: Annotated[Number, _row(_TIME, "between shuffles; 0: none")] = 0
    shuffle_efficiency: Annotated[
        Number, _now("%", "an item lying about is moved by a shuffle", 100)
    ] = 40
    shuffle_until: Annotated[
        Number, _now(_TIME, "when shuffling stops for good; 0: never")
    ] = 0
    shuffle_tools: Annotated[bool, _now("", "guns and gun tools are shuffled too")] = (
        False
    )

    enemy_interval: Annotated[
        Number, _row(_TIME, "between enemies' coming; 0: none")
    ] = 600
    enemy_stay: Annotated[
        Number, _now(_TIME, "where the truck is not, then they move on")
    ] = 200
    enemy_units: Annotated[int, _row("units", "no more come at a time", 100)] = 6
    enemy_sectors: Annotated[
        str, _row("", "where they come, as names, with commas; none: the zones")
    ] = ""
    road_troops: Annotated[bool, _row("", "they come to the roads there, too")] = False
    capture_time: Annotated[
        Number, _now(_TIME, "with enemies, half the trucks are captured; 0: never")
    ] = 450
    gun_rounds: Annotated[int, _row("rounds", "in a gun at the start", 15)] = 0
    gun_burst: Annotated[int, _now("rounds", "a gun fires at most when toggled")] = 3
    gun_hits: Annotated[
        Number, _now("%", "rounds that drive one enemy unit off", 100)
    ] = 60

    wear: Annotated[
        Number, _now("%", "rounds of work in which a machine breaks", 100)
    ] = 0

    rain: Annotated[Number, _row("%", "of the time it rains in a sector", 100)] = 0
    weather_interval: Annotated[
        Number, _row(_TIME, "between changes of a sector's weather")
    ] = 300
    rain_time: Annotated[Number, _now("factor", "on a trip's time in the rain")] = 1.25
    rain_fuel: Annotated[Number, _now("factor", "on a trip's fuel in the rain")] = 1.1
    day_length: Annotated[
        Number, _now(_TIME, "from dawn to dawn; 0: it is always day")
    ] = 0
    night: Annotated[Number, _now("%", "of a day that is dark, at its end", 100)] = 40
    dark_time: Annotated[Number, _now("factor", "on a trip's time in the dark")] = 1.2
    dark_misses: Annotated[
        Number, _now("%", "items outside that the eye overlooks in the dark", 100)
    ] = 30


def adjustable(settings: TruckSettings) -> dict[str, Atom | bool]:
    """Return the options that may change in a run, with values."""
    return {
        row.option.name: getattr(settings, row.field) for row in _rows() if row.changes
    }


def as_made(settings: TruckSettings, given: TruckSettings) -> TruckSettings:
    """Return `settings`, with the options that may change in a run from `given`."""
    changes = [row.field for row in _rows() if row.changes]
    return replace(settings, **{name: getattr(given, name) for name in changes})


def adjusted(settings: TruckSettings, name: str, value: Atom | bool) -> TruckSettings:
    """Return settings with a new value for an option.

    Raises:
        ValueError: for a value out of range or of the wrong kind.
    """
    return read_settings({**msgspec.to_builtins(settings), name: value})


def read_settings(options: Mapping[str, Atom | bool]) -> TruckSettings:
    """Return settings from option values, with defaults for missing options.

    Raises:
        ValueError: for an option out of range or of the wrong kind.
    """
    plain = {k: v.value if isinstance(v, Text) else v for k, v in options.items()}
    try:
        settings = msgspec.convert(plain, TruckSettings)
    except msgspec.ValidationError as error:
        raise ValueError(str(error).replace("`$.", "`").lower()) from error
    for row in _rows():
        name, value = row.option.name, getattr(settings, row.field)
        if not isinstance(value, str) and not 0 <= value <= row.most:
            raise ValueError(f"`{name}` must be between 0 and {row.most}")
        if name.endswith("-interval") and 0 < value < 1:
            raise ValueError(f"`{name}` must be 0 or at least 1")
    if settings.rain > 0 and settings.weather_interval < 1:
        raise ValueError("with `rain`, `weather-interval` must be at least 1")
    return settings


def describe_options() -> tuple[Option, ...]:
    """Return all options in their listed order."""
    return tuple(row.option for row in _rows())


class _Row(msgspec.Struct, frozen=True):
    """An option, its field, its maximum, and whether the option may change."""

    option: Option
    field: str
    most: Number
    changes: bool


@cache
def _rows() -> tuple[_Row, ...]:
    """Return a row for each option; cached, because reading annotations is slow."""
    hints, rows = get_type_hints(TruckSettings, include_extras=True), []
    kinds = {bool: "flag", str: "text", int: "integer"}
    for field in msgspec.structs.fields(TruckSettings):
        base, meta = get_args(hints[field.name])
        default, kind = field.default, kinds.get(base, "number")
        value = Text(default) if isinstance(default, str) else default
        unit, doc = meta.extra["unit"], meta.description
        option = Option(field.encode_name, kind, value, unit, doc)
        rows.append(_Row(option, field.name, meta.extra["most"], meta.extra["changes"]))
    return tuple(rows)
