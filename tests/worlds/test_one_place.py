"""What worlds share stands in one module each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

RAPC = Path(__file__).parents[2] / "rapc"


@pytest.mark.parametrize(
    ("what", "folder", "place"),
    [
        ("class MapError", "", "worlds/maps.py"),
        (r"\biterdir\(", "worlds", "worlds/maps.py"),
        ('"northeast"', "", "base/pictures.py"),
        (r"heappush|deque\(", "worlds", "worlds/ways.py"),
        (r"nodes\.Method\(|nodes\.Step\(", "worlds", "worlds/ways.py"),
        ("TopologicalSorter|without a delay", "worlds", "worlds/skills/network.py"),
        ("both write", "worlds", "worlds/skills/network.py"),
        (r"\bVertex\(", "worlds", "worlds/skills/network.py"),
        (r"\.usual_time\(request\)", "worlds", "worlds/faults.py"),
        ("in OPTIONAL", "", "world.py"),
        ("no state of {", "", "worlds/states.py"),
    ],
)
def test_a_mechanism_of_worlds_stands_in_one_module(
    what: str, folder: str, place: str
) -> None:
    found = {
        path.relative_to(RAPC).as_posix()
        for path in (RAPC / folder).rglob("*.py")
        if re.search(what, path.read_text(encoding="utf-8"))
    }
    assert found == {place}
