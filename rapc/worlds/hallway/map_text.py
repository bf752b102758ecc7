"""Maps as TOML texts: parsing, with validation by `map_checks`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

import msgspec

from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_checks import check_map
from rapc.worlds.maps import MapError, shipped_map

_PLACE = re.compile(r"(?P<said>.*) - at `\$(?P<path>.*)`", re.DOTALL)
_FIELD = re.compile(
    r"Object (?P<fault>missing required|contains unknown) field `(?P<key>.*)`",
    re.DOTALL,
)
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")


def named_map(name: str) -> Map:
    """Return a map that comes with rapc.

    Raises:
        MapError: for an unknown name.
    """
    return read_map(shipped_map("hallway", name))


def read_map(text: str) -> Map:
    """Return the map in a TOML text.

    Raises:
        MapError: if the text is not a map, with line or key; or if the map contradicts
            itself.
    """
    try:
        raw = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise MapError(f"no TOML: {error}") from error
    try:
        made = msgspec.convert(raw, Map)
    except msgspec.ValidationError as error:
        raise MapError(_placed(str(error), raw)) from error
    check_map(made)
    return made


def _placed(told: str, raw: Mapping[str, Any]) -> str:
    """Return the message of msgspec for a text, with the position in words.

    `$.doorway[3].at` becomes `at` of the doorway `office-door`, or of doorway 4.
    """
    found = _PLACE.fullmatch(told)
    said, path = (told, "") if found is None else (found["said"], found["path"])
    steps: list[str | int] = [word or int(at) for word, at in _STEP.findall(path)]
    field = _FIELD.fullmatch(said)
    if field is not None:
        steps.append(field["key"])
        said = "missing" if field["fault"] == "missing required" else "unknown key"
    said = said[:1].lower() + said[1:]
    match steps:
        case [str(kind), int(at), *rest]:
            entry = raw[kind][at]
            name = entry.get("name") if isinstance(entry, dict) else None
            owner = f"{kind} {at + 1}" if name is None else f"the {kind} `{name}`"
            key = f"`{rest[0]}` of " if rest else ""
            return f"{key}{owner}: {said}"
        case [str(key), *_]:
            return f"`{key}`: {said}"
    return said
