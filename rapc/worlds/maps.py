"""The maps that come with worlds, and the exception for maps that cannot be used.

The default map of the truck is that of T 6.1, as near as its text describes it:
quarries to the right, factories to the left, six zones between them; the warehouse
above, the depot below. A road takes about 32 time units and 0.6 of fuel: a journey from
a quarry to its factory and back, six roads, some 200 units and 3.8 of fuel. In the
zones lies nothing at first: others disperse what the quarries make (T 6.1.2).
"""

from __future__ import annotations

from pathlib import Path


class MapError(ValueError):
    """A text that is no map, or a map that contradicts itself; one line."""


def map_names(world: str) -> list[str]:
    """Return the names of the maps that come with a world, sorted."""
    return sorted(_maps(world))


def _maps(world: str) -> dict[str, Path]:
    folder = Path(__file__).parent / world / "maps"
    return {file.stem: file for file in folder.iterdir()}


def shipped_map(world: str, name: str) -> str:
    """Return the text of a map that comes with a world.

    Raises:
        MapError: if none has that name.
    """
    found = _maps(world).get(name)
    if found is not None:
        return found.read_text(encoding="utf-8")
    known = ", ".join(f"`{one}`" for one in map_names(world))
    raise MapError(f"no map is called `{name}`; there are {known}")
