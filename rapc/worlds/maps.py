"""The maps that come with worlds, and the exception for invalid maps.

The default map of the truck follows the text of T 6.1: quarries to the right, factories
to the left, six zones between them; the warehouse above, the depot below. A road takes
about 32 time units and 0.6 of fuel. A journey from a quarry to its factory and back is
six roads: about 200 units and 3.8 of fuel. The zones are empty at the start: other
agents disperse the products of the quarries (T 6.1.2).
"""

from __future__ import annotations

from pathlib import Path


class MapError(ValueError):
    """An error for a text that is not a map or contradicts itself, in one line."""


def map_names(world: str) -> list[str]:
    """Return the names of the maps that come with a world, sorted."""
    return sorted(_maps(world))


def _maps(world: str) -> dict[str, Path]:
    folder = Path(__file__).parent / world / "maps"
    return {file.stem: file for file in folder.iterdir()}


def shipped_map(world: str, name: str) -> str:
    """Return the text of a map that comes with a world.

    Raises:
        MapError: for an unknown name.
    """
    found = _maps(world).get(name)
    if found is not None:
        return found.read_text(encoding="utf-8")
    known = ", ".join(f"`{one}`" for one in map_names(world))
    raise MapError(f"unknown map `{name}`; there are {known}")
