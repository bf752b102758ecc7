"""The maps that docs/reference/hallway.md shows and describes."""

from __future__ import annotations

from rapc.worlds.hallway.map_text import named_map, read_map
from tests.docs.pages import blocks, page


def test_map_of_the_page_is_valid() -> None:
    [shown] = blocks(page("reference/hallway"), "toml")
    made = read_map(shown.text)
    assert [space.name for space in made.space] == ["lab", "hall"]
    assert made.landmark[0].charger


def test_default_map_is_as_described() -> None:
    map = named_map("default")
    assert (len(map.space), len(map.person)) == (17, 6)
    assert sum(doorway.door for doorway in map.doorway) == 8
    assert sum(s.kind == "room" and s.floors == (1,) for s in map.space) == 9
